//! The image for a board with an STM32F405RG.
#![no_std]
#![no_main]

use firmware::app::demonstration::DEMONSTRATION;
use firmware::app::record::Recording;
use firmware::app::session::{self, Session};
use firmware::board::interrupts;
use firmware::board::stm32f405::{self, PERIOD_CYCLES, Stm32f405};

#[cortex_m_rt::entry]
fn main() -> ! {
    let board = defmt::unwrap!(Stm32f405::take());
    stm32f405::run(board, |board, above, below| {
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
    let sound = session.run::<Stm32f405>(&DEMONSTRATION).await;
    let loads = interrupts::loads();
    defmt::info!(
        "load plant_worst_cycles={=u32} plant_mean_cycles={=u32} control_worst_cycles={=u32} control_mean_cycles={=u32} period_cycles={=u32}",
        loads.plant.worst(),
        loads.plant.mean(),
        loads.control.worst(),
        loads.control.mean(),
        PERIOD_CYCLES
    );
    Stm32f405::exit(sound)
}
