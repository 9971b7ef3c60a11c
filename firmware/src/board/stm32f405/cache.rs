//! The accelerator between the flash and the core: RM0090, section 3.5.2. embassy leaves it off, and then
//! each fetch that is not the next one waits for the flash five cycles long.

use embassy_stm32::pac;

/// What revision A of the chip calls itself: an STM32F20x (errata sheet ES0182, "MCU device ID is incorrect"). Its
/// prefetch does not work either ("ART accelerator prefetch queue instruction is not supported").
const REVISION_A: u16 = 0x411;

/// Switches both caches on, and the prefetch where it works.
pub fn enable() {
    let prefetch = pac::DBGMCU.idcode().read().dev_id() != REVISION_A;
    pac::FLASH.acr().modify(|register| {
        register.set_prften(prefetch);
        register.set_icen(true);
        register.set_dcen(true);
    });
}

/// Empties the data cache, which otherwise gives back what a sector held before it was erased (section
/// 3.6.3). embassy does so on chips with two banks alone. What is programmed goes into the cache too
/// (section 3.6.4), and no instruction lies where the program erases.
pub fn forget_data() {
    // It is reset only while it is off.
    pac::FLASH.acr().modify(|register| register.set_dcen(false));
    pac::FLASH.acr().modify(|register| register.set_dcrst(true));
    pac::FLASH.acr().modify(|register| {
        register.set_dcrst(false);
        register.set_dcen(true);
    });
}
