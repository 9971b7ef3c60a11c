//! The image for the emulated board.
#![no_std]
#![no_main]

use firmware::app;
use firmware::board::emulated::{self, Emulated};

#[cortex_m_rt::entry]
fn main() -> ! {
    emulated::run(|spawner| spawner.spawn(defmt::unwrap!(run())))
}

#[embassy_executor::task]
async fn run() {
    let mut board = defmt::unwrap!(Emulated::take());
    let outcome = app::run::run(&mut board).await;
    board.exit(outcome)
}
