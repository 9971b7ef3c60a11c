//! The image in which an engine controller tries out a throttle body.
#![no_std]
#![no_main]

use firmware::board::stm32f405::unattended;

#[cortex_m_rt::entry]
fn main() -> ! {
    unattended::run_trials()
}
