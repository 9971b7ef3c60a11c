//! The digital-to-analogue converter: RM0090, chapter 14.
//!
//! Modelled: both channels without a trigger, by any of the 12-bit registers, right-aligned; a channel
//! that is not enabled puts out nothing. Not modelled: triggers, waves, DMA, left-aligned and 8-bit
//! registers, settling time, the output buffers' 0.2 V.

use rigless::device::{Device, DeviceContext, RegisterFile};
use rigless::soc::stm32f427::generated::dac::Register;

const CODE: u64 = 0xfff;
/// Where a register of both channels has the second one.
const SECOND: u32 = 16;

/// The converter.
#[derive(Debug, Default)]
pub struct Dac {
    /// Codes of both channels, 0 to 4095.
    codes: [u16; 2],
    enabled: [bool; 2],
    /// Writes of an output since the chip was made.
    pub writes: u64,
}

impl Dac {
    /// What the two channels put out, in codes of 12 bits; 0 where one is not enabled.
    pub fn outputs(&self) -> [u16; 2] {
        let output = |channel: usize| {
            if self.enabled[channel] {
                self.codes[channel]
            } else {
                0
            }
        };
        [output(0), output(1)]
    }
}

impl Device for Dac {
    type Register = Register;

    fn write(
        &mut self,
        register: Register,
        value: u64,
        registers: &mut RegisterFile,
        _context: &mut DeviceContext<'_>,
    ) {
        // Masked to 12 bits, they fit.
        let code = |value: u64| (value & CODE) as u16;
        match register {
            Register::Cr => {
                self.enabled = [value & 1 != 0, value >> SECOND & 1 != 0];
                return;
            }
            Register::Dhr12rd => self.codes = [code(value), code(value >> SECOND)],
            Register::Dhr12r1 => self.codes[0] = code(value),
            Register::Dhr12r2 => self.codes[1] = code(value),
            _ => return,
        }
        self.writes += 1;
        for (output, code) in [Register::Dor1, Register::Dor2].into_iter().zip(self.codes) {
            registers.set(output, code.into());
        }
    }

    fn reset(&mut self) {
        *self = Self {
            writes: self.writes,
            ..Self::default()
        };
    }
}
