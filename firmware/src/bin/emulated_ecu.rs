//! The image for the emulated board in which an engine controller tries out a throttle body.
#![no_std]
#![no_main]

use firmware::board::emulated;

#[cortex_m_rt::entry]
fn main() -> ! {
    emulated::run_trials(emulated::exit)
}
