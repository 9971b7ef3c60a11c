//! The image for the emulated board.
#![no_std]
#![no_main]

use firmware::app::demonstration::DEMONSTRATION;
use firmware::board::emulated;

#[cortex_m_rt::entry]
fn main() -> ! {
    emulated::run(&DEMONSTRATION, emulated::exit)
}
