//! A board with nothing on it but the chip: what else there is at its wires is a harness's.

use std::collections::VecDeque;
use std::num::{NonZeroU32, NonZeroU64};

use rigless::chip::Timeline;
use rigless::chip::uart::Peer;
use rigless::machine::{Board as Machine, Target, armv7m};
use rigless::mcu::{Mcu, Operate};
use rigless::snapshot::Store;
use rigless::soc::Error;
use rigless::time::VirtualNanos;

use crate::chip::Stm32f405;

/// Clock of the core, Hz: RM0090, section 3.5.1.
pub const CORE_CLOCK: u64 = 168_000_000;

/// The terminal at USART1.
#[derive(Debug, Default)]
pub struct Terminal {
    /// What is still to be typed.
    pub typed: VecDeque<u8>,
    /// What came since it was last looked at.
    pub said: Vec<u8>,
}

impl Store for Terminal {}

impl Peer for Terminal {
    fn receive(&mut self, word: u16, _: &mut Timeline<'_, '_>) {
        // Frames of eight bits.
        self.said.push(word as u8);
    }

    fn transmit(&mut self, _: VirtualNanos) -> Option<u16> {
        self.typed.pop_front().map(u16::from)
    }
}

/// The board.
#[derive(Debug)]
pub struct Board {
    /// The chip.
    pub chip: Stm32f405,
    instructions_per_second: NonZeroU64,
}

impl Board {
    /// With a terminal at USART1. The core retires so many instructions a second: its clock over the
    /// cycles that an instruction takes on average.
    ///
    /// # Errors
    /// As [`Stm32f405::new`].
    pub fn new(instructions_per_second: NonZeroU64) -> Result<Self, Error> {
        let mut chip = Stm32f405::new()?;
        chip.part.usart[0].attach(Terminal::default());
        Ok(Self {
            chip,
            instructions_per_second,
        })
    }

    /// The terminal.
    pub fn terminal(&mut self) -> &mut Terminal {
        self.chip.part.usart[0]
            .chip_mut::<Terminal>()
            .expect("USART1 carries the terminal since the board was made")
    }
}

impl Store for Board {}

/// What a session calls the board and its one chip.
const NAME: &str = "stm32f405";

impl Machine for Board {
    fn name(&self) -> &'static str {
        NAME
    }

    fn target_names(&self) -> Vec<&'static str> {
        vec![NAME]
    }

    fn mcu(&mut self, target: usize) -> Option<&mut dyn Mcu> {
        (target == 0).then_some(&mut self.chip)
    }

    /// A Cortex-M4 with its floating-point unit, 4 priority bits and 8 protection regions: PM0214,
    /// sections 4.2 and 4.3.
    fn targets(&mut self) -> Vec<Target<'_>> {
        let lines = u32::from(Operate::cpu(&self.chip).interrupt_lines);
        let core = armv7m::Core {
            variant: armv7m::Variant::M4,
            clock_hz: NonZeroU64::new(CORE_CLOCK).expect("a clock runs"),
            interrupt_lines: NonZeroU32::new(lines).expect("the chip has interrupts"),
            priority_bits: 4,
            refclk_divider: NonZeroU32::new(8).expect("a divider divides"),
            instructions_per_second: self.instructions_per_second,
            boot: "flash",
        };
        let core = core.spec_with_parts(
            &rigless::cpu::armv7m::windows(Mcu::bus(&self.chip)),
            armv7m::Fpu::FpV4Sp,
            armv7m::MpuRegions::Eight,
        );
        vec![Target::new(NAME, &mut self.chip, core)]
    }
}
