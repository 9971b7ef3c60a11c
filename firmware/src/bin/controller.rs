//! The image that drives a real brushed-DC actuator.
#![no_std]
#![no_main]

use firmware::board::stm32f405::controller;

#[cortex_m_rt::entry]
fn main() -> ! {
    controller::run()
}
