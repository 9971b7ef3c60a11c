//! The processor's own supply, which is watched in two steps: a warning while the program still works, then a reset.
//!
//! The voltage detector (RM0090, section 5.2.3) compares the supply with 2.93 V, 3.03 V on its way up, and is read in each
//! plant tick: below it, [`Fault::BrownOut`](crate::app::fault::Fault::BrownOut) is latched and nothing is saved. 3.3 V less 5 % is above both.
//! The brown-out reset (section 5.2.2) holds the processor in reset below 2.83 V, its highest level. At 168 MHz with five wait
//! states the flash is specified from 2.7 V on (table 10), as is programming by words (section 3.6.2). The levels are those of
//! the data sheet DS8626, typical ones, of `PLS` 6 and `VBOR3`.
//!
//! A chip comes without the brown-out reset, and then a supply that sags ends in a power-on reset at 1.7 V or in none. Its level is
//! an option byte, so it is programmed at the first start, and never again while it is there.

use embassy_stm32::pac;

/// `PLS`: 2.93 V.
const DETECTED: u8 = 6;

/// `BOR_LEV`: 2.83 V.
const RESET_BELOW: u8 = 0;

/// `FLASH_OPTKEYR`, one after the other.
const OPTION_KEYS: [u32; 2] = [0x0819_2a3b, 0x4c5d_6e7f];

/// Looks for the end of programming, some tens of milliseconds, this often at most: some seconds.
const LONGEST_PROGRAMMING: u32 = 50_000_000;

/// Switches the detector on, and has the brown-out reset at its level from the next reset on.
///
/// To be called once, before anything is driven.
pub fn watch() {
    pac::RCC
        .apb1enr()
        .modify(|register| register.set_pwren(true));
    pac::PWR.cr1().modify(|register| {
        register.set_pls(DETECTED);
        register.set_pvde(true);
    });
    // What is programmed with too little voltage may be neither old nor new.
    if pac::FLASH.optcr().read().bor_lev() == RESET_BELOW || is_low() {
        return;
    }
    program_reset_level();
    if pac::FLASH.optcr().read().bor_lev() != RESET_BELOW {
        defmt::warn!("the level of the brown-out reset cannot be set");
    }
}

/// Whether the processor's supply is below the detector's voltage.
pub fn is_low() -> bool {
    pac::PWR.csr1().read().pvdo()
}

/// RM0090, section 3.7.2; all other option bytes stay as they are.
fn program_reset_level() {
    let flash = pac::FLASH;
    wait();
    for key in OPTION_KEYS {
        flash.optkeyr().write_value(key);
    }
    flash
        .optcr()
        .modify(|register| register.set_bor_lev(RESET_BELOW));
    flash.optcr().modify(|register| register.set_optstrt(true));
    wait();
    flash.optcr().modify(|register| register.set_optlock(true));
}

fn wait() {
    for _ in 0..LONGEST_PROGRAMMING {
        if !pac::FLASH.sr().read().bsy() {
            return;
        }
    }
}
