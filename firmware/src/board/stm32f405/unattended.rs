//! What runs to its end without anybody: experiments on emulated actuators, trials, replays, computations.

use cortex_m::peripheral::DWT;
use embassy_executor::Executor;
use embassy_stm32::Peri;
use embassy_stm32::peripherals::TIM7;
use embassy_time::Timer;
use static_cell::StaticCell;

use super::safety::Safety;
use super::tracks::Tracks;
use super::vector::{self, Edge};
use super::{Chip, PERIOD_CYCLES, core_coupled, end, stack, ticker};
use crate::app::ecu;
use crate::app::ecu::session::Trials;
use crate::app::experiment::Experiment;
use crate::app::playback::{self, Player};
use crate::app::session::{self, Records, Session};
use crate::app::timing::RECORD_PERIOD_MS;
use crate::app::wiring::Wiring;
use crate::app::work::{ControlWork, PlantWork};
use crate::board::{Board, Work, tape_flash};

/// The board as what it runs sees it. The actuators are emulated, so the bridge is never enabled.
struct Unattended {
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

impl Board for Unattended {
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

/// What every image begins with: the board in its safe state, unless the start before ended in a fault.
fn begin() -> Unattended {
    let (chip, pins) = defmt::unwrap!(Chip::take());
    let tracks = Tracks::new(pins.tracks);
    let safety = Safety::new(pins.safety.bridge_enable, pins.safety.brake_release);
    if end::cause().is_some() {
        end::exit(false)
    }
    Unattended {
        chip,
        idle: Some((pins.plant_timer, tracks)),
        _safety: safety,
    }
}

/// Runs the experiments, with the recording's executor above the session's and both below the control
/// step, logs how long the interrupts took and whether everything was in order, and ends in the safe state.
///
/// # Panics
/// If it is called twice.
pub fn run(experiments: &'static [Experiment]) -> ! {
    static EXECUTOR: StaticCell<Executor> = StaticCell::new();
    stack::paint();
    let mut board = begin();
    let above = board.chip.start_tasks();
    EXECUTOR.init(Executor::new()).run(|below| {
        let (session, records) = session::start(&mut board, core_coupled::memory());
        above.spawn(defmt::unwrap!(record(records)));
        below.spawn(defmt::unwrap!(perform(session, experiments)));
    })
}

/// Runs the trials of the emulated engine controller, and ends as [`run`] does.
///
/// # Panics
/// If it is called twice.
pub fn run_trials() -> ! {
    static EXECUTOR: StaticCell<Executor> = StaticCell::new();
    let mut board = begin();
    EXECUTOR.init(Executor::new()).run(|spawner| {
        let trials = ecu::session::start(&mut board);
        spawner.spawn(defmt::unwrap!(try_out(trials)));
    })
}

/// Plays the recorded drive behind the program, and ends as [`run`] does; not in order where there is
/// nothing to play.
///
/// # Panics
/// If it is called twice.
pub fn play() -> ! {
    static EXECUTOR: StaticCell<Executor> = StaticCell::new();
    let mut board = begin();
    EXECUTOR.init(Executor::new()).run(|spawner| {
        match playback::start(&mut board, tape_flash::bytes()) {
            Some(player) => spawner.spawn(defmt::unwrap!(log_replay(player))),
            None => end::exit(false),
        }
    })
}

/// Does work that nothing interrupts, and ends as [`run`] does.
///
/// # Panics
/// If it is called twice.
pub fn compute(work: fn() -> bool) -> ! {
    let _board = begin();
    end::exit(work())
}

/// A count of core cycles; it wraps every 25 s.
#[inline(always)]
pub fn cycles() -> u32 {
    DWT::cycle_count()
}

#[embassy_executor::task]
async fn record(records: Records) -> ! {
    session::record(records).await
}

#[embassy_executor::task]
async fn perform(mut session: Session, experiments: &'static [Experiment]) {
    let sound = session.run::<Unattended>(experiments).await;
    defmt::info!("stack used={=u32} of={=u32}", stack::used(), stack::room());
    end(sound).await
}

#[embassy_executor::task]
async fn try_out(mut trials: Trials) {
    let sound = trials.run().await;
    end(sound).await
}

#[embassy_executor::task]
async fn log_replay(player: Player) {
    let sound = player.run().await;
    end(sound).await
}

/// Ends once a probe has had the time to fetch the log.
async fn end(sound: bool) {
    super::log_loads();
    Timer::after_millis(RECORD_PERIOD_MS).await;
    end::exit(sound)
}
