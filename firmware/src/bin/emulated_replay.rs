//! Plays the recorded drive behind the program on the emulated board.
#![no_std]
#![no_main]

use firmware::board::emulated;

#[cortex_m_rt::entry]
fn main() -> ! {
    emulated::play(emulated::exit)
}
