//! The image for a board with an STM32F405RG.
#![no_std]
#![no_main]

use firmware::app::demonstration::DEMONSTRATION;
use firmware::board::stm32f405::demonstration;

#[cortex_m_rt::entry]
fn main() -> ! {
    demonstration::run(&DEMONSTRATION)
}
