//! The image in which everything goes wrong that may; what it has to say is in the log next to this file.
#![no_std]
#![no_main]

use firmware::app::failures::FAILURES;
use firmware::board::stm32f405::unattended;

#[cortex_m_rt::entry]
fn main() -> ! {
    unattended::run(&FAILURES)
}
