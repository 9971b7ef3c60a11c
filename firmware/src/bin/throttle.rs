//! The image that is a throttle body for an engine controller.
#![no_std]
#![no_main]

use firmware::board::stm32f405::throttle;

#[cortex_m_rt::entry]
fn main() -> ! {
    throttle::run()
}
