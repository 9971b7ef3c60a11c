//! Plays the recorded drive behind the program on the emulated board.
#![no_std]
#![no_main]

use firmware::app::playback::{self, Player};
use firmware::board::emulated::{self, Emulated};
use firmware::board::tape_flash;

#[cortex_m_rt::entry]
fn main() -> ! {
    let board = defmt::unwrap!(Emulated::take());
    emulated::run(board, |board, _, below| {
        match playback::start(board, tape_flash::bytes()) {
            Some(player) => below.spawn(defmt::unwrap!(play(player))),
            None => emulated::exit(false),
        }
    })
}

#[embassy_executor::task]
async fn play(player: Player) {
    emulated::exit(player.run().await)
}
