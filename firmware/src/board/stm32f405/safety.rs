//! The outputs that hold an actuator or let it go.

use embassy_stm32::Peri;
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::peripherals::{PC8, PC9};

use crate::app::fault::output::{Brake, Bridge, Outputs};

/// Bridge enable and brake.
pub struct Safety {
    bridge_enable: Output<'static>,
    brake_release: Output<'static>,
}

impl Safety {
    /// Bridge off, brake on.
    pub fn new(bridge_enable: Peri<'static, PC8>, brake_release: Peri<'static, PC9>) -> Self {
        Self {
            bridge_enable: Output::new(bridge_enable, Level::Low, Speed::Low),
            brake_release: Output::new(brake_release, Level::Low, Speed::Low),
        }
    }

    /// As the fault latch has it.
    pub fn set(&mut self, outputs: &Outputs) {
        self.bridge_enable
            .set_level((outputs.bridge == Bridge::Driven).into());
        self.brake_release
            .set_level((outputs.brake == Brake::Released).into());
    }
}
