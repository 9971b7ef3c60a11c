//! Worlds drawn at random: a machine, what it has beyond its machine file, whoever drives it, its sensors and
//! its logger, all from a seed and an index.
//!
//! Other than the benches of this crate, no two worlds are alike: inertias over four decades, friction of one
//! to eighty per cent of what the motor has, rates from 50 Hz to 20 kHz, and each effect in a law out of a
//! family. The plant shares no line with [`crate::Plant`]: masses stick exactly, reversals and end stops are
//! located within a step, backlash and elastic shafts have an inertia and friction behind them.
//!
//! ```
//! use rig::world::World;
//!
//! let (world, [log, other]) = World::draw(1, 0);
//! assert_eq!(log.time.len(), world.rows);
//! assert_ne!(log.position, other.position);
//! assert!(world.to_toml().contains("[mechanics]"));
//! ```

mod control;
mod declaration;
mod dice;
mod draw;
mod forces;
mod friction;
mod laws;
mod machine;
mod motion;
mod needs;
mod parts;
mod plant;
mod record;
mod scales;
mod sensor;
mod shapes;
mod sins;
mod strength;
#[cfg(test)]
mod tests;

pub use control::{Drive, DriveKind};
pub use draw::{Kind, World};
pub use laws::{Joint, Law};
pub use machine::{Declaration, InputKind, Machine, Side};
pub use motion::{Motion, Move};
pub use plant::{Plant, State};
pub use record::{Record, Scene, play};
pub use sensor::Quality;
pub use shapes::{Along, Course, Fall, Ripple, Saturation};
pub use sins::{InputRow, Sins};
pub use strength::{CATALOGUE, OUTSIDE};
