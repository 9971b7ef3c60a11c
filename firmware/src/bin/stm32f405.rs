//! The image that runs an actuator of each kind in its loop, and what it makes of their logs.
#![no_std]
#![no_main]

use firmware::app::demonstration::DEMONSTRATION;
use firmware::board::stm32f405::unattended;

#[cortex_m_rt::entry]
fn main() -> ! {
    unattended::run(&DEMONSTRATION)
}
