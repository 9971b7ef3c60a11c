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
    /// Erases since the data cache was last emptied: what it holds of their sectors is not theirs any more (section 3.6.3).
    pub unforgotten: u64,
}

/// `DCEN` and `DCRST` of `FLASH_ACR`: the cache is emptied while it is off (section 3.9.1).
const DATA_CACHE: u64 = 1 << 10;
const DATA_CACHE_RESET: u64 = 1 << 12;

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
            unforgotten: 0,
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
        self.unforgotten += 1;
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
        if register == Register::Acr && value & (DATA_CACHE | DATA_CACHE_RESET) == DATA_CACHE_RESET
        {
            self.unforgotten = 0;
        }
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

#[cfg(test)]
mod tests {
    use rigless::emulator::{Error, Memory};
    use rigless::mcu::Operate;

    use super::*;
    use crate::chip::Stm32f405;

    /// `FLASH_ACR`, `FLASH_KEYR`, `FLASH_SR`, `FLASH_CR`, and their bits: RM0090, section 3.9.
    const ACCESS_CONTROL: u64 = 0x4002_3c00;
    const KEYS: u64 = 0x4002_3c04;
    const STATUS: u64 = 0x4002_3c0c;
    const CONTROL: u64 = 0x4002_3c10;
    const PROGRAM: u64 = 1;
    const WORDS: u64 = 2 << 8;
    const ERASE_SECTOR_1: u64 = 1 << 1 | 1 << 3 | 1 << 16;
    const SEQUENCE_ERROR: u64 = 1 << 7;
    const PARALLELISM_ERROR: u64 = 1 << 6;
    const BUSY: u64 = 1 << 16;

    /// The second sector, and where the third begins.
    const SECTOR: u64 = FLASH_BASE + (16 << 10);
    const NEXT: u64 = FLASH_BASE + (32 << 10);

    /// The first 64 KB of the array.
    struct Array(Vec<u8>);

    impl Array {
        fn place(address: u64, width: Width) -> std::ops::Range<usize> {
            let place = (address - FLASH_BASE) as usize;
            place..place + width.bytes() as usize
        }

        fn word(&mut self, address: u64) -> u64 {
            self.read(address, Width::W32).unwrap()
        }
    }

    impl Memory for Array {
        fn read(&mut self, address: u64, width: Width) -> Result<u64, Error> {
            let bytes = self.0[Self::place(address, width)].iter().rev();
            Ok(bytes.fold(0, |value, byte| value << 8 | u64::from(*byte)))
        }

        fn write(&mut self, address: u64, width: Width, _: u64) -> Result<(), Error> {
            Err(Error::Memory { address, width })
        }

        fn program(&mut self, address: u64, width: Width, value: u64) -> Result<(), Error> {
            let place = Self::place(address, width);
            let size = place.len();
            self.0[place].copy_from_slice(&value.to_le_bytes()[..size]);
            Ok(())
        }
    }

    /// A chip whose flash is unlocked, at an instant.
    struct Bench(Stm32f405, Array, VirtualNanos);

    impl Bench {
        fn new() -> Self {
            let mut chip = Stm32f405::new().unwrap();
            for key in [0x4567_0123, 0xcdef_89ab] {
                chip.write(VirtualNanos(1), KEYS, Width::W32, key).unwrap();
            }
            Self(chip, Array(vec![0xff; 64 << 10]), VirtualNanos(1))
        }

        fn write(&mut self, address: u64, width: Width, value: u64) {
            self.0.write(self.2, address, width, value).unwrap();
            self.0.settle(&mut self.1).unwrap();
        }

        /// Waits for the end of what is under way, and gives how long that was, ns.
        fn finish(&mut self) -> u64 {
            let began = self.2.0;
            while self.status() & BUSY != 0 {
                self.2 = self.0.next_event().unwrap();
                self.0.advance_to(self.2);
                self.0.settle(&mut self.1).unwrap();
            }
            self.2.0 - began
        }

        fn status(&mut self) -> u64 {
            self.0.read(self.2, STATUS, Width::W32).unwrap()
        }
    }

    #[test]
    fn a_store_clears_bits_and_sets_none() {
        let mut bench = Bench::new();
        bench.write(CONTROL, Width::W32, PROGRAM | WORDS);
        bench.write(SECTOR, Width::W32, 0x0f0f_0f0f);
        assert_eq!(bench.finish(), PROGRAMMING_TIME);
        assert_eq!(bench.0.flash.set_bits, 0);
        bench.write(SECTOR, Width::W32, 0x00ff_00ff);
        bench.finish();
        assert_eq!(bench.1.word(SECTOR), 0x000f_000f);
        assert_eq!((bench.0.flash.words, bench.0.flash.set_bits), (2, 1));
    }

    #[test]
    fn a_store_that_was_not_asked_for_or_has_another_width_is_an_error() {
        let mut bench = Bench::new();
        bench.write(SECTOR, Width::W32, 0);
        assert_eq!(bench.status(), SEQUENCE_ERROR);
        bench.write(STATUS, Width::W32, SEQUENCE_ERROR);
        bench.write(CONTROL, Width::W32, PROGRAM | WORDS);
        bench.write(SECTOR, Width::W8, 0);
        assert_eq!(bench.status(), PARALLELISM_ERROR);
        assert_eq!(bench.1.word(SECTOR), ERASED);
        assert_eq!(bench.0.flash.words, 0);
    }

    #[test]
    fn an_erase_sets_the_first_half_of_its_sector_and_then_the_second_and_nothing_else() {
        let mut bench = Bench::new();
        bench.1.0.fill(0);
        bench.write(CONTROL, Width::W32, ERASE_SECTOR_1 | WORDS);
        let edges = |bench: &mut Bench| {
            [SECTOR - 4, SECTOR, SECTOR + (8 << 10), NEXT - 4, NEXT].map(|at| bench.1.word(at))
        };
        assert_eq!(edges(&mut bench), [0, ERASED, 0, 0, 0]);
        // DS8626, table 40: 250 ms, 500 at most, by words.
        let took = bench.finish();
        assert!((100_000_000..=500_000_000).contains(&took), "{took} ns");
        assert_eq!(edges(&mut bench), [0, ERASED, ERASED, ERASED, 0]);
        assert_eq!((bench.0.flash.erases, bench.0.flash.unforgotten), (1, 1));
        // While the cache is on, nothing comes of its reset.
        bench.write(ACCESS_CONTROL, Width::W32, DATA_CACHE | DATA_CACHE_RESET);
        assert_eq!(bench.0.flash.unforgotten, 1);
        bench.write(ACCESS_CONTROL, Width::W32, DATA_CACHE_RESET);
        assert_eq!(bench.0.flash.unforgotten, 0);
    }
}
