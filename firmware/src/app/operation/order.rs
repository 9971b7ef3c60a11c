//! What the plant interrupt of an image is told.

use heapless::spsc::{Consumer, Producer};
use model_core::plant::throttle::Throttle;

use super::actuator::Numbers;
use super::calibration::Calibration;
use crate::app::conversion::Converters;
use crate::app::ecu::loopback::Command;

/// For the plant interrupt.
pub enum Order {
    /// For a real actuator: its numbers.
    Actuator(Numbers),
    /// For an emulated throttle body: its sensors, and what its outputs are off by.
    Calibrate(Converters, Calibration),
    /// For an emulated throttle body, by the console.
    Body(Command),
    /// Another body in its place, which begins at its limp-home position.
    Replace(&'static mut Throttle),
}

/// Orders under way at a time.
pub const ORDERS: usize = 8;

/// The interrupt's ends: what it is told, and where a body goes that was replaced.
pub struct Receiver {
    /// What it is told.
    pub orders: Consumer<'static, Order>,
    /// Where a body goes that was replaced; one fits.
    pub replaced: Producer<'static, &'static mut Throttle>,
}

/// The console's ends.
pub struct Sender {
    /// What is told.
    pub orders: Producer<'static, Order>,
    /// Where a body comes from that was replaced.
    pub replaced: Consumer<'static, &'static mut Throttle>,
}
