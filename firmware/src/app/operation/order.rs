//! What the plant interrupt of an image is told.

use heapless::spsc::{Consumer, Producer};
use model_core::plant::throttle::Throttle;

use super::calibration::Calibration;
use crate::app::ecu::loopback::Command;

/// For the plant interrupt.
pub enum Order {
    /// What its outputs are off by.
    Calibrate(Calibration),
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
