//! The independent watchdog: it starts the processor anew unless it is fed.
//!
//! It runs from its own oscillator, of 17 to 47 kHz, and once started it cannot be stopped. The plant
//! interrupt feeds it when a control step has vouched for the program and all its tasks, see
//! [`Wiring::take_vouched`](crate::app::wiring::Wiring::take_vouched).

use embassy_stm32::Peri;
use embassy_stm32::pac;
use embassy_stm32::pac::iwdg::vals::{Key, Pr};
use embassy_stm32::peripherals::IWDG;

/// Counts of about a millisecond, 0.68 to 1.9, that it waits: 20 control steps. At worst the bridge drives
/// for 38 ms without its program.
const RUNNING: u16 = 20;

/// The same while flash is erased: the most there is, at least 2.8 s. An erase takes 0.8 s at worst.
const STALLED: u16 = 0xfff;

/// Takes it and starts it.
pub fn start(_watchdog: Peri<'static, IWDG>) {
    // A probe that halts the processor halts it too.
    pac::DBGMCU
        .apb1fzr()
        .modify(|register| register.set_iwdg(true));
    pac::IWDG
        .kr()
        .write(|register| register.set_key(Key::START));
    set_wait(RUNNING);
}

/// Begins anew to wait.
pub fn feed() {
    pac::IWDG
        .kr()
        .write(|register| register.set_key(Key::RESET));
}

/// Waits as long as an erase of flash takes, or again as usual.
pub fn stall(stalled: bool) {
    set_wait(if stalled { STALLED } else { RUNNING });
}

fn set_wait(counts: u16) {
    let watchdog = pac::IWDG;
    watchdog
        .kr()
        .write(|register| register.set_key(Key::ENABLE));
    watchdog
        .pr()
        .write(|register| register.set_pr(Pr::DIVIDE_BY32));
    watchdog.rlr().write(|register| register.set_rl(counts));
    // Its oscillator takes both over within five of its periods. Should it not run, nothing waits for it.
    for _ in 0..100_000 {
        let status = watchdog.sr().read();
        if !status.pvu() && !status.rvu() {
            break;
        }
    }
    feed();
}
