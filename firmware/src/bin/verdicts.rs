//! The image that traces a log of each kind of verdict.
#![no_std]
#![no_main]

use firmware::app::verdicts::VERDICTS;
use firmware::board::stm32f405::unattended;

#[cortex_m_rt::entry]
fn main() -> ! {
    unattended::run(&VERDICTS)
}
