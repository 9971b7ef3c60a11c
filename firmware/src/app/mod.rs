//! What every board runs. Three levels of urgency share the processor:
//!
//! 1. [`emulate`]: the plant, 20 kHz, in the most urgent interrupt;
//! 2. [`control`]: the position loop, 1 kHz, in the next interrupt;
//! 3. tasks: [`record`] logs what the loop saw.
//!
//! [`wiring`] joins plant and drive and holds the fault latch. `run` puts them together.

pub mod control;
pub mod emulate;
pub mod machine;
pub mod profile;
pub mod record;
#[cfg(feature = "tasks")]
pub mod run;
pub mod timing;
pub mod wiring;
