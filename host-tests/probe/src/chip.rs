//! The chip's RAM by the probe's access port.
//!
//! A `Session` of probe-rs halts the core when it begins and when it ends, to clear breakpoints: a drive would let go. So there is
//! none here: the debug port is powered and the access port to the bus is used, which asks nothing of the core. What keeps the bus
//! awake while the core sleeps (`DBG_SLEEP`), the images set themselves.

use std::error::Error;
use std::ops::Range;

use probe_rs::architecture::arm::dp::DpAddress;
use probe_rs::architecture::arm::memory::ArmMemoryInterface;
use probe_rs::architecture::arm::sequences::DefaultArmSequence;
use probe_rs::architecture::arm::{ArmDebugInterface, ArmError, FullyQualifiedApAddress};
use probe_rs::probe::{Probe, WireProtocol};
use rtt::Memory;

use crate::choice::reason;

/// The RAM of an STM32F405, where the rings are looked for: its core-coupled memory is not at the access port's bus.
pub const RAM: Range<u32> = 0x2000_0000..0x2002_0000;

/// The access port to the bus (AHB-AP) of a Cortex-M4: RM0090, section 38.7.
const BUS: u8 = 0;

/// Clock of the debug port, kHz. Some probes begin with 400 kHz, which is little for a console at full pace.
const CLOCK_KHZ: u32 = 2000;

/// Powers the debug port of the chip at this probe, over two wires. The chip is not reset and its core not halted.
///
/// # Errors
/// A chip that does not answer.
pub fn attach(mut probe: Probe) -> Result<Box<dyn ArmDebugInterface>, Box<dyn Error>> {
    probe.select_protocol(WireProtocol::Swd)?;
    // A probe that has no such clock keeps its own.
    let _ = probe.set_speed(CLOCK_KHZ);
    probe.attach_to_unspecified()?;
    let interface = probe.try_into_arm_debug_interface(DefaultArmSequence::create());
    let mut interface = interface.map_err(|(_, error)| error)?;
    interface.select_debug_port(DpAddress::Default)?;
    Ok(interface)
}

/// The memory of a chip that runs.
pub struct Bus<'i>(Box<dyn ArmMemoryInterface + 'i>);

impl<'i> Bus<'i> {
    /// By the access port to the bus.
    ///
    /// # Errors
    /// A chip that has none there.
    pub fn of(interface: &'i mut dyn ArmDebugInterface) -> Result<Self, ArmError> {
        let port = FullyQualifiedApAddress::v1_with_default_dp(BUS);
        interface.memory_interface(&port).map(Self)
    }
}

impl Memory for Bus<'_> {
    type Error = ArmError;

    fn read(&mut self, address: u32, bytes: &mut [u8]) -> Result<(), ArmError> {
        self.0.read(address.into(), bytes)
    }

    fn write(&mut self, address: u32, bytes: &[u8]) -> Result<(), ArmError> {
        self.0.write(address.into(), bytes)?;
        self.0.flush()
    }
}

/// What is said of a chip that does not answer.
pub fn unanswered(error: impl Into<Box<dyn Error>>) -> String {
    format!(
        "the chip does not answer the probe ({}): see that the board has power and that SWDIO, SWCLK and ground are joined",
        reason(&*error.into())
    )
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use rtt::Channel;

    use super::*;
    use crate::simulated::{Chip, Simulated};

    const BLOCK: u32 = RAM.start + 0x8A4;
    const UP: u32 = BLOCK + 24 + 24;
    const DOWN: u32 = BLOCK + 24 + 3 * 24;

    /// A chip whose console has said a text that goes round the end of its ring, on an odd address.
    fn chip() -> Chip {
        let mut chip = Chip::new();
        chip.put(BLOCK, b"SEGGER RTT\0\0\0\0\0\0");
        for (address, word) in [
            (BLOCK + 16, 2),
            (BLOCK + 20, 2),
            (UP + 4, RAM.start + 0x1001),
            (UP + 8, 13),
            (UP + 12, 3),
            (UP + 16, 9),
            (DOWN + 4, RAM.end - 11),
            (DOWN + 8, 11),
            (DOWN + 12, 7),
            (DOWN + 16, 7),
        ] {
            chip.put_word(address, word);
        }
        chip.put(RAM.start + 0x1001 + 9, b"talk");
        chip.put(RAM.start + 0x1001, b"ing");
        chip
    }

    /// By all of probe-rs but the drivers of real probes.
    #[test]
    fn a_console_is_heard_and_typed_at_and_nothing_but_the_ram_is_touched() {
        let chip = Arc::new(Mutex::new(chip()));
        let probe = Probe::new(Simulated(chip.clone()));
        let mut port = attach(probe).unwrap();
        let mut bus = Bus::of(&mut *port).unwrap();
        let mut console = Channel::new(RAM, 1);
        assert!(console.find(&mut bus).unwrap());
        let mut typed = b"status\r".to_vec();
        assert_eq!(console.exchange(&mut bus, &mut typed).unwrap(), b"talking");
        assert!(typed.is_empty());
        drop(bus);
        assert!(chip.lock().unwrap().is_debugged());
        drop(port);
        let chip = chip.lock().unwrap();
        assert!(!chip.is_debugged());
        assert_eq!(chip.disturbed, [""; 0]);
        let ring = &chip.ram[chip.ram.len() - 11..];
        assert_eq!([&ring[7..], &ring[..3]].concat(), b"status\r");
        assert_eq!(chip.word(DOWN + 12), 3);
        assert_eq!(chip.word(UP + 16), 3);
    }
}
