//! Test signals, each a function of the tick: nothing accumulates, nothing drifts.
//!
//! `Parameters` in SI are built for a period into a signal, and `at(tick)` is its value `tick`
//! periods after its start. The period is the `f32` that was given: 1e-4 s is held to 2.5e-8 of
//! itself, which is the only error of time itself. Values and offsets have the unit of whatever the
//! signal drives.

pub mod aprts;
pub mod growing_triangle;
pub mod ramp;
pub mod sine;
pub mod step;
pub mod sweep;
mod time;
pub mod triangle;
