//! Plant, friction, control and identification of electromechanical actuators.
//!
//! `no_std`, no allocation, no `unsafe`, `f32` in SI units. The crate knows no hardware, no
//! files and no clock: the firmware and the host call the same functions and get the same bits.
//!
//! Bits stay the same because a result depends on `+ − × ÷`, comparisons and square roots alone,
//! which IEEE 754 rounds in one way, in an order that the source fixes; all else is `libm` or
//! `micromath` by full name, one code for every machine. Not to be used: `std`'s float methods,
//! fused operations, the sign of a zero out of `f32::min` and `f32::max`, the payload of a NaN.
//! `f64`, software on the chip, is for constructors and for sums over windows. `cargo hil test`
//! compares all of it on the emulated target.
//!
//! | to | begin at |
//! |---|---|
//! | step an actuator | [`plant::actuator::Actuator`], made of [`plant::parameters::Parameters`] |
//! | step many at once | [`plant::batch`] |
//! | step a throttle body, or the paper's actuator and test bench | [`plant::throttle`], [`plant::ema`], [`plant::bench`] |
//! | control a position | [`control::pid`] |
//! | estimate friction from a log | [`identify::friction`], with [`identify::annealing`] or [`identify::golden_section`] |
//! | see what effects there are | [`effect::Id`] |
//! | find the effect that a log lacks | [`gap::lengths::trace`], with the logs in [`gap::replay::Data`] |
//!
//! Examples: `examples/step_a_plant.rs`, `examples/effect_of_ones_own.rs` and `examples/refit_friction.rs`.
#![no_std]

pub mod control;
pub mod effect;
pub mod gap;
pub mod identify;
pub mod numeric;
pub mod plant;
pub mod signal;
pub mod unit;
