//! Plant, friction, control and identification of electromechanical actuators.
//!
//! `no_std`, no allocation, no `unsafe`, `f32` in SI units. The crate knows no hardware, no
//! files and no clock: the firmware and the host call the same functions and get the same bits.
#![no_std]

pub mod control;
pub mod effect;
pub mod gap;
pub mod identify;
pub mod numeric;
pub mod plant;
pub mod signal;
pub mod unit;
