//! The image that plays the recorded drive behind the program.
#![no_std]
#![no_main]

use firmware::board::stm32f405::unattended;

#[cortex_m_rt::entry]
fn main() -> ! {
    unattended::play()
}
