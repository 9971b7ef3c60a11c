//! The image for a board with an STM32F405RG.
#![no_std]
#![no_main]

use firmware::app::demonstration::DEMONSTRATION;
use firmware::board::stm32f405;

#[cortex_m_rt::entry]
fn main() -> ! {
    stm32f405::run(&DEMONSTRATION)
}
