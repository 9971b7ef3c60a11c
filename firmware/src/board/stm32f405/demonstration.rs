//! The image that runs experiments on emulated actuators and ends.

use embassy_executor::Executor;
use embassy_stm32::Peri;
use embassy_stm32::peripherals::TIM7;
use static_cell::StaticCell;

use super::safety::Safety;
use super::tracks::Tracks;
use super::vector::{self, Edge};
use super::{Chip, PERIOD_CYCLES, core_coupled, end, ticker};
use crate::app::experiment::Experiment;
use crate::app::session::{self, Records, Session};
use crate::app::wiring::Wiring;
use crate::app::work::{ControlWork, PlantWork};
use crate::board::{Board, Work};

/// The board as the experiments see it. Their actuators are emulated, so the bridge is never enabled.
struct Demonstration {
    chip: Chip,
    /// What moves to the plant interrupt when it starts.
    idle: Option<(Peri<'static, TIM7>, Tracks)>,
    _safety: Safety,
}

/// What the plant interrupt reads and writes.
struct TracksEdge {
    tracks: Tracks,
    wiring: &'static Wiring,
}

impl Edge for TracksEdge {
    fn read(&mut self) {
        ticker::acknowledge();
    }

    fn write(&mut self) {
        self.tracks.set(self.wiring.tracks());
    }
}

impl Board for Demonstration {
    const WORK: &'static str = "cycles";

    fn start(
        &mut self,
        plant: &'static mut dyn PlantWork,
        control: Option<&'static mut dyn ControlWork>,
        wiring: &'static Wiring,
    ) {
        static EDGE: StaticCell<TracksEdge> = StaticCell::new();
        let (timer, tracks) = defmt::unwrap!(self.idle.take(), "started twice");
        self.chip.start_control(control);
        let edge = EDGE.init(TracksEdge { tracks, wiring });
        vector::set(plant, wiring, edge, PERIOD_CYCLES);
        ticker::start(timer);
    }

    fn work() -> Work {
        super::work()
    }
}

/// Runs the experiments, with the recording's executor above the session's and both below the control
/// step, logs how long the interrupts took and ends in the safe state. A debug probe is told whether
/// everything was in order.
///
/// # Panics
/// If it is called twice.
pub fn run(experiments: &'static [Experiment]) -> ! {
    static EXECUTOR: StaticCell<Executor> = StaticCell::new();
    let (chip, pins) = defmt::unwrap!(Chip::take());
    let tracks = Tracks::new(pins.tracks);
    let safety = Safety::new(pins.safety.bridge_enable, pins.safety.brake_release);
    if end::cause().is_some() {
        end::exit(false)
    }
    let mut board = Demonstration {
        chip,
        idle: Some((pins.plant_timer, tracks)),
        _safety: safety,
    };
    let above = board.chip.start_tasks();
    EXECUTOR.init(Executor::new()).run(|below| {
        let (session, records) = session::start(&mut board, core_coupled::memory());
        above.spawn(defmt::unwrap!(record(records)));
        below.spawn(defmt::unwrap!(perform(session, experiments)));
    })
}

#[embassy_executor::task]
async fn record(records: Records) -> ! {
    session::record(records).await
}

#[embassy_executor::task]
async fn perform(mut session: Session, experiments: &'static [Experiment]) {
    let sound = session.run::<Demonstration>(experiments).await;
    super::log_loads();
    end::exit(sound)
}
