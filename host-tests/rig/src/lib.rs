//! f64 plants that play the measured actuator in the tests.
//!
//! An [`Experiment`] puts a [`Machine`] with any [`Effect`]s under a position loop, or under a
//! prescribed input, and returns the [`Recording`] that a test bench would have logged:
//! quantised position, noisy current, input held from row to row. [`Machine::to_toml`] writes the
//! machine file that declares the same actuator *without* the effects; the distance between the
//! two is what `cargo hil gap` has to find.
//!
//! [`pmsm_bench`] plays a whole test bench instead: a servo drive under a PLC, a brake, an encoder
//! behind printed gears.
//!
//! The crate depends on nothing and shares no line with `model-core`, so that an error in the
//! core's equations cannot hide in its own test data. SI units throughout; for a rotary machine
//! position is in rad and load in N·m, for a linear one in m and N.
//!
//! ```
//! use rig::{Effect, EffectKind, Experiment, Machine, Trajectory};
//!
//! let machine = Machine::rotary_ema();
//! let offset = Effect::nominal(EffectKind::OffsetTorque, &machine);
//! let trajectory = Trajectory::sines(&machine);
//! let recording = Experiment::tracking(machine, trajectory)
//!     .with_effects(&[offset])
//!     .lasting(0.5)
//!     .run();
//! assert_eq!(recording.time.len(), 500);
//! ```

mod bench;
mod controller;
mod effect;
mod experiment;
mod machine;
mod plant;
pub mod pmsm_bench;
mod random;
mod recording;
mod servo;
mod trajectory;
pub mod world;

pub use bench::Bench;
pub use controller::{Pid, PidGains};
pub use effect::{Effect, EffectKind};
pub use experiment::{Excitation, Experiment, Noise};
pub use machine::{Coordinate, Machine, Motor, ReturnSpring, Stops};
pub use plant::{Plant, State};
pub use random::Random;
pub use recording::Recording;
pub use servo::{Servo, ServoSample};
pub use trajectory::{Move, Sine, Trajectory};
