//! The two position tracks, on the DAC.

use embassy_stm32::dac::{Dac, DualValue};
use embassy_stm32::mode::Blocking;
use embassy_stm32::pac;

use super::pins;

/// The converter with its two channels.
pub struct Tracks(Dac<'static, Blocking>);

impl Tracks {
    /// Both at 0 V, without the buffers, which leave 0.2 V at either end.
    pub fn new(pins: pins::Tracks) -> Self {
        let converter = Dac::new_blocking(pins.converter, pins.first, pins.second);
        pac::DAC1.cr().modify(|register| {
            register.set_boff(0, true);
            register.set_boff(1, true);
        });
        Self(converter)
    }

    /// Sets both at once.
    pub fn set(&mut self, [first, second]: [u16; 2]) {
        self.0.set(DualValue::Bit12Right(first, second));
    }
}
