//! The image for the emulated board.
#![no_std]
#![no_main]

use firmware::app::demonstration::DEMONSTRATION;
use firmware::app::record::Recording;
use firmware::app::session::{self, Session};
use firmware::board::emulated::{self, Emulated};

#[cortex_m_rt::entry]
fn main() -> ! {
    let board = defmt::unwrap!(Emulated::take());
    emulated::run(board, |board, above, below| {
        let (session, recording) = session::start(board);
        above.spawn(defmt::unwrap!(record(recording)));
        below.spawn(defmt::unwrap!(run(session)));
    })
}

#[embassy_executor::task]
async fn record(recording: Recording) -> ! {
    session::record(recording).await
}

#[embassy_executor::task]
async fn run(mut session: Session) {
    let sound = session.run::<Emulated>(&DEMONSTRATION).await;
    emulated::exit(sound)
}
