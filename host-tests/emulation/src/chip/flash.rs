//! The flash that keeps what is written: RM0090, chapter 3.
//!
//! The interface's registers, keys, locks, errors and the time of an erase are rigless's model. Added is
//! the array: an erase sets its sector to ones, a store with `PG` clears bits and never sets one (section
//! 3.6.4), takes 16 µs (the STM32F405's data sheet, DS8626, table 40, "word programming time"), and is an
//! error without `PG` (`PGSERR`) or with another width than `PSIZE` (`PGPERR`). An erase that a reset or the
//! end of power interrupts leaves the first half of its sector erased and the second as it was, one of
//! the states that section 3.6 leaves open. Not modelled: words torn within their 16 µs, read protection,
//! the option bytes as memory.

use rigless::device::{Device, DeviceContext, RegisterFile};
use rigless::soc::Width;
use rigless::soc::stm32f427::generated::flash::{Register, cr, sr};
use rigless::soc::stm32f427::peripherals::flash::Flash as Interface;
use rigless::time::{EventId, VirtualNanos};

use super::description::{FLASH_BASE, SECTOR_SIZES};

/// Time that a word takes, ns.
const PROGRAMMING_TIME: u64 = 16_000;

/// Widths by `PSIZE`.
const PARALLELISM: [Width; 4] = [Width::W8, Width::W16, Width::W32, Width::W64];

/// An erased word.
const ERASED: u64 = 0xffff_ffff;

/// A token that no request is answered by: what is answered is of no interest.
const NOBODY: u64 = u64::MAX;

/// A store whose word is being read.
#[derive(Debug, Clone, Copy)]
struct Programming {
    address: u64,
    width: Width,
    value: u64,
}

/// The flash.
#[derive(Debug)]
pub struct Flash {
    interface: Interface,
    was_busy: bool,
    /// Second half of the sector that is being erased.
    erasing: Option<(u64, u64)>,
    programming: Option<Programming>,
    programmed: Option<EventId>,
    /// Sectors erased and words programmed since the chip was made.
    pub erases: u64,
    /// Words programmed since the chip was made.
    pub words: u64,
    /// Stores that tried to set a bit that is zero: the program forgot an erase.
    pub set_bits: u64,
}

impl Flash {
    /// The array behind an interface.
    pub fn new(interface: Interface) -> Self {
        Self {
            interface,
            was_busy: false,
            erasing: None,
            programming: None,
            programmed: None,
            erases: 0,
            words: 0,
            set_bits: 0,
        }
    }

    /// As after a reset.
    pub fn restarted(&self, interface: Interface) -> Self {
        Self {
            erases: self.erases,
            words: self.words,
            set_bits: self.set_bits,
            ..Self::new(interface)
        }
    }

    /// Whether an operation is under way, for which the core waits: it runs from the one bank there is.
    pub fn is_busy(registers: &RegisterFile) -> bool {
        sr::BSY.is_set(registers.get(Register::Sr))
    }

    /// Operations since the chip was made.
    pub fn operations(&self) -> u64 {
        self.erases + self.words
    }

    /// Starts the array's part of an erase that the interface has just begun.
    fn erase(&mut self, registers: &RegisterFile, context: &mut DeviceContext<'_>) {
        let control = registers.get(Register::Cr);
        let (base, size) = if cr::MER.is_set(control) {
            (FLASH_BASE, SECTOR_SIZES.iter().sum())
        } else {
            let number = usize::try_from(cr::SNB.get(control)).unwrap_or(usize::MAX);
            match SECTOR_SIZES.get(number) {
                Some(size) => (
                    FLASH_BASE + SECTOR_SIZES[..number].iter().sum::<u64>(),
                    *size,
                ),
                None => return,
            }
        };
        self.erases += 1;
        let half = size / 2;
        clear(base, half, context);
        self.erasing = Some((base + half, half));
    }

    fn begin_programming(&mut self, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        let status = sr::BSY.set(registers.get(Register::Sr), 1);
        registers.set(Register::Sr, status);
        let end = VirtualNanos(context.now().0 + PROGRAMMING_TIME);
        self.programmed = Some(context.schedule(end));
    }
}

fn clear(base: u64, size: u64, context: &mut DeviceContext<'_>) {
    for address in (base..base + size).step_by(4) {
        context.program(address, Width::W32, ERASED, NOBODY);
    }
}

impl Device for Flash {
    type Register = Register;

    fn read(
        &mut self,
        register: Register,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) -> Option<u64> {
        self.interface.read(register, registers, context)
    }

    fn write(
        &mut self,
        register: Register,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        self.interface.write(register, value, registers, context);
        let busy = Self::is_busy(registers);
        if register == Register::Cr && busy && !self.was_busy {
            self.erase(registers, context);
        }
        self.was_busy = busy;
    }

    fn write_region(
        &mut self,
        address: u64,
        width: Width,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) -> bool {
        let control = registers.get(Register::Cr);
        let status = registers.get(Register::Sr);
        let parallelism = usize::try_from(cr::PSIZE.get(control)).unwrap_or_default();
        let error = if cr::LOCK.is_set(control) || !cr::PG.is_set(control) {
            Some(sr::PGSERR)
        } else if PARALLELISM.get(parallelism) != Some(&width) {
            Some(sr::PGPERR)
        } else {
            None
        };
        if let Some(error) = error {
            registers.set(Register::Sr, error.set(status, 1));
            return true;
        }
        self.words += 1;
        self.programming = Some(Programming {
            address,
            width,
            value,
        });
        self.begin_programming(registers, context);
        self.was_busy = true;
        context.read_from(address, width, address);
        true
    }

    fn on_access(
        &mut self,
        token: u64,
        found: u64,
        _registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        if let Some(store) = self.programming.filter(|store| store.address == token) {
            self.programming = None;
            self.set_bits += u64::from(store.value & !found & store.width.mask() != 0);
            context.program(store.address, store.width, store.value & found, NOBODY);
        }
    }

    fn on_event(
        &mut self,
        event: EventId,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        if self.programmed == Some(event) {
            self.programmed = None;
            let status = sr::BSY.set(registers.get(Register::Sr), 0);
            registers.set(Register::Sr, status);
        } else {
            self.interface.on_event(event, registers, context);
        }
        let busy = Self::is_busy(registers);
        if !busy && let Some((base, size)) = self.erasing.take() {
            clear(base, size, context);
        }
        self.was_busy = busy;
    }

    fn on_clock(&mut self, hz: u64, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.interface.on_clock(hz, registers, context);
    }
}
