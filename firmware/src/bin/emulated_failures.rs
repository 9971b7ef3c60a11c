//! The image for the emulated board in which everything goes wrong that may.
#![no_std]
#![no_main]

use firmware::app::failures::FAILURES;
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
    // Hardly anything is sound here; what is expected is in the log next to this file.
    let _ = session.run::<Emulated>(&FAILURES).await;
    emulated::exit(true)
}
