//! The clocks: 168 MHz from the crystal; from the internal oscillator where that does not swing, so that the console
//! can say so. The drive is not armed then: the oscillator may be 8 % off (DS8626, table 42).

use embassy_stm32::time::Hertz;
use embassy_stm32::{Config, Peripherals, pac, rcc};

/// The crystal, and what divides its frequency to 2 MHz.
const CRYSTAL: (Hertz, rcc::PllPreDiv) = if cfg!(feature = "crystal-12mhz") {
    (Hertz(12_000_000), rcc::PllPreDiv::DIV6)
} else {
    (Hertz(8_000_000), rcc::PllPreDiv::DIV4)
};

/// Core clock, Hz.
pub const CORE_CLOCK: u32 = 168_000_000;

/// How often the crystal is looked at before it is given up. A look takes at least five cycles of the 16 MHz that
/// the processor starts with: 50 ms in all, of the 2 that a crystal takes (DS8626, table 40).
const LOOKS: u32 = 160_000;

/// Starts the clocks.
pub fn start() -> Peripherals {
    let on_crystal = is_swinging();
    let peripherals = embassy_stm32::init(configuration(on_crystal));
    // From now on an end of the crystal is an exception, and a break of TIM1's outputs: RM0090, section 7.2.7.
    pac::RCC
        .cr()
        .modify(|register| register.set_csson(on_crystal));
    peripherals
}

/// Whether the clocks come from the crystal.
pub fn is_from_crystal() -> bool {
    pac::RCC.pllcfgr().read().pllsrc() == pac::rcc::vals::Pllsrc::HSE
}

fn is_swinging() -> bool {
    pac::RCC.cr().modify(|register| register.set_hseon(true));
    (0..LOOKS).any(|_| pac::RCC.cr().read().hserdy())
}

/// 2 MHz · 168 / 2 for the core, / 7 = 48 MHz for what needs that; timers at 84 and 168 MHz.
fn configuration(on_crystal: bool) -> Config {
    let (freq, of_crystal) = CRYSTAL;
    let mut config = Config::default();
    config.rcc.hsi = !on_crystal;
    config.rcc.hse = on_crystal.then_some(rcc::Hse {
        freq,
        mode: rcc::HseMode::Oscillator,
    });
    let (source, prediv) = if on_crystal {
        (rcc::PllSource::HSE, of_crystal)
    } else {
        (rcc::PllSource::HSI, rcc::PllPreDiv::DIV8)
    };
    config.rcc.pll_src = source;
    config.rcc.pll = Some(rcc::Pll {
        prediv,
        mul: rcc::PllMul::MUL168,
        divp: Some(rcc::PllPDiv::DIV2),
        divq: Some(rcc::PllQDiv::DIV7),
        divr: None,
    });
    config.rcc.sys = rcc::Sysclk::PLL1_P;
    config.rcc.ahb_pre = rcc::AHBPrescaler::DIV1;
    config.rcc.apb1_pre = rcc::APBPrescaler::DIV4;
    config.rcc.apb2_pre = rcc::APBPrescaler::DIV2;
    // The cycle counter, and a probe that reads the log, go on while the core sleeps.
    config.enable_debug_during_sleep = true;
    config
}
