//! The image for a board with an STM32F405RG.
#![no_std]
#![no_main]

use firmware::app;
use firmware::board::stm32f405::{self, PERIOD_CYCLES, Stm32f405};

#[cortex_m_rt::entry]
fn main() -> ! {
    let board = defmt::unwrap!(Stm32f405::take());
    stm32f405::run(|_, urgent| urgent.spawn(defmt::unwrap!(run(board))))
}

#[embassy_executor::task]
async fn run(mut board: Stm32f405) {
    let outcome = app::run::run(&mut board).await;
    let load = board.plant_load();
    defmt::info!(
        "plant interrupt worst_cycles={=u32} mean_cycles={=u32} period_cycles={=u32}",
        load.worst(),
        load.mean(),
        PERIOD_CYCLES
    );
    board.exit(outcome)
}
