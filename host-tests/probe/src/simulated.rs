//! A probe that has a chip's debug port at its wires, for the tests: the registers of an STM32F405's debug port and of its access
//! port to the bus, as ARM's IHI 0031 (ADIv5) has them, with the RAM behind them and nothing else.

use std::sync::{Arc, Mutex};

use probe_rs::CoreStatus;
use probe_rs::architecture::arm::dp::DpRegisterAddress;
use probe_rs::architecture::arm::sequences::ArmDebugSequence;
use probe_rs::architecture::arm::{
    ArmCommunicationInterface, ArmDebugInterface, ArmError, DapProbe, RawDapAccess, RegisterAddress,
};
use probe_rs::probe::{DebugProbe, DebugProbeError, WireProtocol};

use crate::chip::RAM;

/// What the port identifies itself by: RM0090, sections 38.8.3 and 38.7.
const DEBUG_PORT: u32 = 0x2BA0_1477;
const BUS_PORT: u32 = 0x2477_0011;

/// Behind the debug port.
#[derive(Debug)]
pub struct Chip {
    pub ram: Vec<u8>,
    /// What was done that a drive would notice, or that is not there.
    pub disturbed: Vec<String>,
    power: u32,
    select: u32,
    status: u32,
    address: u32,
}

impl Chip {
    pub fn new() -> Self {
        Self {
            ram: vec![0; RAM.len()],
            disturbed: Vec::new(),
            power: 0,
            select: 0,
            status: 0,
            address: 0,
        }
    }

    /// Whether somebody asks for the power of the debug port.
    pub fn is_debugged(&self) -> bool {
        self.power != 0
    }

    pub fn put(&mut self, address: u32, bytes: &[u8]) {
        let at = (address - RAM.start) as usize;
        self.ram[at..at + bytes.len()].copy_from_slice(bytes);
    }

    pub fn put_word(&mut self, address: u32, word: u32) {
        self.put(address, &word.to_le_bytes());
    }

    pub fn word(&self, address: u32) -> u32 {
        let at = (address - RAM.start) as usize;
        u32::from_le_bytes(self.ram[at..at + 4].try_into().unwrap())
    }

    /// The register of an access port that `lowest` means in the bank that is selected.
    fn bus_register(&mut self, lowest: u8) -> u8 {
        if self.select >> 24 != 0 {
            self.disturbed
                .push(format!("access port {}", self.select >> 24));
        }
        self.select as u8 & 0xF0 | lowest & 0xC
    }

    /// The bytes that an access to the bus takes, in a word's lanes; steps on to the next ones.
    fn lanes(&mut self) -> Option<(usize, u32, usize)> {
        let count = 1 << (self.status & 3);
        let address = self.address;
        if self.status & 0x30 != 0 {
            self.address += count;
        }
        if RAM.contains(&address) {
            return Some((
                (address - RAM.start) as usize,
                8 * (address % 4),
                count as usize,
            ));
        }
        self.disturbed.push(format!("address {address:#x}"));
        None
    }

    fn read(&mut self, register: RegisterAddress) -> u32 {
        match register {
            RegisterAddress::DpRegister(DpRegisterAddress { address, .. }) => match address {
                0x0 => DEBUG_PORT,
                // Each domain has its power as soon as it is asked for.
                0x4 => self.power | (self.power & 0x5000_0000) << 1,
                _ => 0,
            },
            RegisterAddress::ApRegister(lowest) => match self.bus_register(lowest) {
                0x00 => self.status | 0x40,
                0x04 => self.address,
                0x0C => self.lanes().map_or(0, |(at, shift, count)| {
                    let bytes = self.ram[at..at + count].iter().rev();
                    bytes.fold(0, |word, &byte| word << 8 | u32::from(byte)) << shift
                }),
                0xFC => BUS_PORT,
                _ => 0,
            },
        }
    }

    fn write(&mut self, register: RegisterAddress, value: u32) {
        match register {
            RegisterAddress::DpRegister(DpRegisterAddress { address, .. }) => match address {
                0x4 => self.power = value & 0x5000_0000,
                0x8 => self.select = value,
                _ => (),
            },
            RegisterAddress::ApRegister(lowest) => match self.bus_register(lowest) {
                0x00 => self.status = value,
                0x04 => self.address = value,
                0x0C => {
                    if let Some((at, shift, count)) = self.lanes() {
                        let bytes = (value >> shift).to_le_bytes();
                        self.ram[at..at + count].copy_from_slice(&bytes[..count]);
                    }
                }
                other => self.disturbed.push(format!("register {other:#x}")),
            },
        }
    }
}

/// A probe at such a chip, which has every sequence on its wires done as it is told.
#[derive(Debug)]
pub struct Simulated(pub Arc<Mutex<Chip>>);

impl Simulated {
    fn disturb(&self, what: &str) {
        self.0.lock().unwrap().disturbed.push(what.to_owned());
    }
}

impl DebugProbe for Simulated {
    fn get_name(&self) -> &str {
        "simulated"
    }

    fn speed_khz(&self) -> u32 {
        400
    }

    fn set_speed(&mut self, speed_khz: u32) -> Result<u32, DebugProbeError> {
        Err(DebugProbeError::UnsupportedSpeed(speed_khz))
    }

    fn attach(&mut self) -> Result<(), DebugProbeError> {
        Ok(())
    }

    fn detach(&mut self) -> Result<(), probe_rs::Error> {
        Ok(())
    }

    fn target_reset(&mut self) -> Result<(), DebugProbeError> {
        self.disturb("reset");
        Ok(())
    }

    fn target_reset_assert(&mut self) -> Result<(), DebugProbeError> {
        self.disturb("reset");
        Ok(())
    }

    fn target_reset_deassert(&mut self) -> Result<(), DebugProbeError> {
        self.disturb("reset");
        Ok(())
    }

    fn select_protocol(&mut self, protocol: WireProtocol) -> Result<(), DebugProbeError> {
        match protocol {
            WireProtocol::Swd => Ok(()),
            other => Err(DebugProbeError::UnsupportedProtocol(other)),
        }
    }

    fn active_protocol(&self) -> Option<WireProtocol> {
        Some(WireProtocol::Swd)
    }

    fn has_arm_interface(&self) -> bool {
        true
    }

    fn try_get_arm_debug_interface<'probe>(
        self: Box<Self>,
        sequence: Arc<dyn ArmDebugSequence>,
    ) -> Result<Box<dyn ArmDebugInterface + 'probe>, (Box<dyn DebugProbe>, ArmError)> {
        Ok(ArmCommunicationInterface::create(self, sequence, false))
    }

    fn into_probe(self: Box<Self>) -> Box<dyn DebugProbe> {
        self
    }
}

impl RawDapAccess for Simulated {
    fn raw_read_register(&mut self, address: RegisterAddress) -> Result<u32, ArmError> {
        Ok(self.0.lock().unwrap().read(address))
    }

    fn raw_write_register(&mut self, address: RegisterAddress, value: u32) -> Result<(), ArmError> {
        self.0.lock().unwrap().write(address, value);
        Ok(())
    }

    fn jtag_sequence(&mut self, _: u8, _: bool, _: u64) -> Result<(), DebugProbeError> {
        Ok(())
    }

    fn swj_sequence(&mut self, _: u8, _: u64) -> Result<(), DebugProbeError> {
        Ok(())
    }

    fn swj_pins(&mut self, _: u32, _: u32, _: u32) -> Result<u32, DebugProbeError> {
        self.disturb("pins");
        Ok(0)
    }

    fn into_probe(self: Box<Self>) -> Box<dyn DebugProbe> {
        self
    }

    fn core_status_notification(&mut self, _: CoreStatus) -> Result<(), DebugProbeError> {
        Ok(())
    }
}

impl DapProbe for Simulated {}
