//! The console as a debug probe reaches it while the core runs: by the rings that the image has in its RAM (RTT), with the code
//! that runs at a real probe too.

use std::convert::Infallible;

use rigless::emulator;
use rigless::soc::Width;
use rtt::{Channel, Memory};

use crate::chip::description::SRAM_BASE;

/// Where the rings are looked for.
const SRAM_SIZE: u32 = 128 << 10;

/// Channel of the console, up and down.
const CONSOLE: u32 = 1;

/// A probe at a chip.
#[derive(Debug)]
pub struct Probe {
    console: Channel,
    /// What was typed and has found no room yet.
    typed: Vec<u8>,
}

impl Default for Probe {
    fn default() -> Self {
        let start = SRAM_BASE as u32;
        Self {
            console: Channel::new(start..start + SRAM_SIZE, CONSOLE),
            typed: Vec::new(),
        }
    }
}

impl Probe {
    /// Writes what was typed, as far as there is room for it, and reads what the console has said.
    pub fn exchange(
        &mut self,
        memory: &mut (impl emulator::Memory + ?Sized),
        typed: &[u8],
    ) -> Vec<u8> {
        self.typed.extend(typed);
        let Ok(heard) = self.console.exchange(&mut Bus(memory), &mut self.typed);
        heard
    }
}

/// The chip's memory as the probe's access port has it.
struct Bus<'m, M: ?Sized>(&'m mut M);

impl<M: emulator::Memory + ?Sized> Memory for Bus<'_, M> {
    type Error = Infallible;

    fn read(&mut self, address: u32, bytes: &mut [u8]) -> Result<(), Infallible> {
        for (place, byte) in (u64::from(address)..).zip(bytes) {
            // The probe asks for nothing outside of the RAM.
            *byte = self.0.read(place, Width::W8).unwrap_or(0) as u8;
        }
        Ok(())
    }

    fn write(&mut self, address: u32, bytes: &[u8]) -> Result<(), Infallible> {
        for (place, &byte) in (u64::from(address)..).zip(bytes) {
            // The core stands still meanwhile: it sees a word at once.
            let _ = self.0.write(place, Width::W8, byte.into());
        }
        Ok(())
    }
}
