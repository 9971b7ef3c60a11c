//! The image for the emulated board in which everything goes wrong that may.
#![no_std]
#![no_main]

use firmware::app::failures::FAILURES;
use firmware::board::emulated;

#[cortex_m_rt::entry]
fn main() -> ! {
    // Hardly anything is sound here; what is expected is in the log next to this file.
    emulated::run(&FAILURES, |_| emulated::exit(true))
}
