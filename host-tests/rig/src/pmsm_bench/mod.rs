//! The test bench of the bench paper, with what its authors suspect it to have and their model lacks.
//!
//! A 1FK7060 servo motor turns a gearbox of 120 and, over a chain, the shaft of a disc brake. A pair
//! of printed gears behind the gearbox's output turns the encoder on which the position loop is
//! closed. Beyond the paper's model there are: a loss that makes the current high
//! ([`Loss`]), tooth elasticity and an encoder gear of its own inertia behind the backlash
//! ([`EncoderGear`]), brake torque that varies as the brake shaft turns ([`Brake`]), finite bandwidth,
//! noise and offset of the current loop ([`Sensors`]), a position loop at the pace of the PLC
//! ([`Control`]).
//!
//! Angles and speeds of the *motor shaft* and of the *slow shaft* (the gearbox's output) are told
//! apart by name. Currents are d-q currents in A rms: the root-mean-square of a phase current, the
//! convention of the motor's torque constant, so that torque = 1.91 N·m/A · i_q.
//!
//! ```
//! use rig::pmsm_bench::{Loss, Point, Program};
//!
//! let point = Point::ALL[4]; // low friction, high backlash
//! let bench = point.bench(Loss::load_dependent());
//! let recording = bench.run(&Program::paper_sine().lasting(0.1));
//! assert_eq!(recording.encoder_position.len(), 50);
//! ```

mod brake;
mod control;
mod current_loop;
mod encoder_gear;
mod loss;
mod motor;
mod plant;
mod points;
mod program;
mod recording;
mod run;
mod sensors;

pub use brake::{Brake, Harmonic};
pub use control::Control;
pub use encoder_gear::{Contact, EncoderGear};
pub use loss::Loss;
pub use motor::Motor;
pub use plant::{Plant, State};
pub use points::{BacklashLevel, FrictionLevel, Point, campaign};
pub use program::Program;
pub use recording::Recording;
pub use run::Bench;
pub use sensors::Sensors;

/// Reduction of the gearbox (Table 2.5).
pub const GEAR_RATIO: f64 = 120.0;

/// Turns of the encoder for one of the slow shaft: teeth of the gear pair (section 5.2).
pub const ENCODER_RATIO: f64 = 62.0 / 15.0;

/// Turns of the motor for one of the brake shaft: teeth of the sprockets (Table 2.8).
pub const CHAIN_RATIO: f64 = 34.0 / 23.0;

/// Lever of the load cell, m (section 5.1).
pub const LOAD_CELL_LEVER: f64 = 0.233;
