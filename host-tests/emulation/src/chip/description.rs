//! The STM32F405's memories, on the bus that rigless describes for the STM32F427.
//!
//! The two parts are described by the same reference manual, RM0090, and every block that the images
//! use is at the same address and has the same registers. What differs and matters to a program is the
//! memory: 1 MB of flash in one bank of twelve sectors (table 5) instead of 2 MB in two, and 128 KB of
//! SRAM beside the core-coupled 64 KB (section 2.3.1) instead of 192.

use std::mem;
use std::num::{NonZeroU32, NonZeroU64};

use rigless::soc::stm32f427::{self, CPU};
use rigless::soc::{Builder, Bus, Clock, EraseBlocks, Error, Gate, Region};

/// Where the flash begins.
pub const FLASH_BASE: u64 = 0x0800_0000;

/// Where the RAMs begin.
pub const SRAM_BASE: u64 = 0x2000_0000;
/// The one that only the core reaches.
pub const CORE_COUPLED_BASE: u64 = 0x1000_0000;

/// Sizes of the flash's sectors in their order, bytes: RM0090, table 5.
pub const SECTOR_SIZES: [u64; 12] = [
    16 << 10,
    16 << 10,
    16 << 10,
    16 << 10,
    64 << 10,
    128 << 10,
    128 << 10,
    128 << 10,
    128 << 10,
    128 << 10,
    128 << 10,
    128 << 10,
];

static SECTORS: [EraseBlocks; 3] = [
    blocks(16 << 10, 4),
    blocks(64 << 10, 1),
    blocks(128 << 10, 7),
];

const fn blocks(bytes: u64, count: u32) -> EraseBlocks {
    match (NonZeroU64::new(bytes), NonZeroU32::new(count)) {
        (Some(size), Some(count)) => EraseBlocks { size, count },
        _ => panic!("a sector has bytes"),
    }
}

/// RM0090, section 2.3.1 and table 5. A store into the flash reaches the model of its interface.
static MEMORY: [Region; 5] = [
    Region::flash("flash", FLASH_BASE, 1 << 20)
        .erased_in(&SECTORS)
        .erased_to(0xff)
        .programmed_by("FLASH"),
    Region::ram("ccm", CORE_COUPLED_BASE, 64 << 10),
    Region::system("system", 0x1fff_0000, 32 << 10),
    Region::ram("sram", SRAM_BASE, 128 << 10),
    Region::ram("backup_sram", 0x4002_4000, 4 << 10),
];

/// Where nothing is, from and to: an access is a bus fault. RM0090, section 2.3, table 1.
const RESERVED: [(u64, u64); 4] = [
    (FLASH_BASE + (1 << 20), CORE_COUPLED_BASE),
    (CORE_COUPLED_BASE + (64 << 10), 0x1fff_0000),
    (0x1fff_8000, SRAM_BASE),
    (SRAM_BASE + (128 << 10), 0x4000_0000),
];

/// What hears other instances' requests: as on the STM32F427, without the serial interfaces and the
/// clock that no image uses. ADC1 hears TIM1's trigger besides, see [`super::converter`].
const HEARERS: [&str; 7] = ["TIM1", "TIM8", "RCC", "C_ADC", "ADC1", "DMA1", "DMA2"];

/// Which bit of the clock controller resets which instance, of those that the images use: RM0090,
/// sections 6.3.5 to 6.3.9.
const RESET_BITS: [(&str, &str, &str); 17] = [
    ("GPIOA", "AHB1RSTR", "GPIOARST"),
    ("GPIOB", "AHB1RSTR", "GPIOBRST"),
    ("GPIOC", "AHB1RSTR", "GPIOCRST"),
    ("DMA1", "AHB1RSTR", "DMA1RST"),
    ("DMA2", "AHB1RSTR", "DMA2RST"),
    ("TIM2", "APB1RSTR", "TIM2RST"),
    ("TIM3", "APB1RSTR", "TIM3RST"),
    ("TIM4", "APB1RSTR", "TIM4RST"),
    ("TIM5", "APB1RSTR", "TIM5RST"),
    ("TIM7", "APB1RSTR", "TIM7RST"),
    ("DAC", "APB1RSTR", "DACRST"),
    ("TIM1", "APB2RSTR", "TIM1RST"),
    ("USART1", "APB2RSTR", "USART1RST"),
    ("ADC1", "APB2RSTR", "ADCRST"),
    ("ADC2", "APB2RSTR", "ADCRST"),
    ("ADC3", "APB2RSTR", "ADCRST"),
    ("C_ADC", "APB2RSTR", "ADCRST"),
];

/// The identity that a debugger reads: an STM32F405 of revision Z. RM0090, section 38.6.1.
const IDENTITY: u64 = 0x1001_6413;

/// The registers as rigless describes them, with the STM32F405's identity.
pub fn registers() -> Builder {
    stm32f427::builder().reset("DBG", "DBGMCU_IDCODE", IDENTITY)
}

/// The STM32F405's bus.
///
/// # Errors
/// A name that the description of the STM32F427 has not: it is another version of rigless.
pub fn bus() -> Result<Bus, Error> {
    let mut described = registers().build()?;
    let instances: Vec<_> = described.peripherals().copied().collect();
    let mut builder = Bus::builder(CPU, &MEMORY, instances.iter().copied());
    for instance in &instances {
        if let Some(clock) = described.clock_of(instance.name) {
            builder = builder.clocked_by(instance.name, clock);
        }
    }
    // The clock of the bus that TIM7 is on. rigless has no model of TIM7 and so no output for it alone;
    // TIM5 is every image's clock, so its output is there whenever TIM7 runs.
    if let Some(Clock { instance, output }) = described.clock_of("TIM5") {
        builder = builder.clocked_by("TIM7", Clock::output(instance, output));
    }
    for hearer in HEARERS {
        builder = builder.reads_requests(hearer);
    }
    for (instance, register, field) in RESET_BITS {
        builder = builder.reset_by(instance, Gate::by("RCC", register, field));
    }
    for (base, end) in RESERVED {
        builder = builder.aborts_in("reserved", base, end - base);
    }
    let mut bus = builder.build()?;
    // With every correction of the registers' reset values, fields and gates.
    exchange_registers(&mut bus, &mut described);
    Ok(bus)
}

/// Exchanges the registers of two buses that have the same instances.
pub fn exchange_registers(one: &mut Bus, other: &mut Bus) {
    for slot in 0..one.slots().len() {
        mem::swap(one.slot_mut(slot), other.slot_mut(slot));
    }
}
