//! The image for the emulated board that traces a log of each kind of verdict.
#![no_std]
#![no_main]

use firmware::app::verdicts::VERDICTS;
use firmware::board::emulated;

#[cortex_m_rt::entry]
fn main() -> ! {
    emulated::run(&VERDICTS, emulated::exit)
}
