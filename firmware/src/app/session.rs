//! One experiment after the other, from its numbers to what is made of its log.
//!
//! Two tasks. [`record`] runs on an executor below the control interrupt; [`Session::run`] below that
//! one, and while it computes, the plant, its loop and the recording go on.

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::mutex::Mutex;
use embassy_sync::signal::Signal;
use embassy_time::Timer;
use heapless::spsc::{Producer, Queue};
use static_cell::{ConstStaticCell, StaticCell};

use super::control::{self, Control};
use super::emulate::{self, Emulation};
use super::evaluate;
use super::experiment::{Experiment, Failure};
use super::memory::Memory;
use super::record::{Outcome, Progress, Recorder, Recording, Sample, log_sample};
use super::timing::{CONTROL_PERIOD_US, PLANT_PERIOD_US, QUEUED_SAMPLES, RECORD_PERIOD_MS};
use super::wiring::Wiring;
use crate::board::Board;

static WIRING: Wiring = Wiring::new();
static PROGRESS: Progress = Progress::new();
static SAMPLES: ConstStaticCell<Queue<Sample, QUEUED_SAMPLES>> = ConstStaticCell::new(Queue::new());
// One setup is under way at a time, and one place of a ring stays empty.
static PLANTS: ConstStaticCell<Queue<emulate::Setup, 2>> = ConstStaticCell::new(Queue::new());
static CONTROLLERS: ConstStaticCell<Queue<control::Setup, 2>> = ConstStaticCell::new(Queue::new());
static EMULATION: StaticCell<Emulation> = StaticCell::new();
static CONTROL: StaticCell<Control> = StaticCell::new();

/// Locked by the recording while it lasts, and then by the evaluation.
type Shared = Mutex<CriticalSectionRawMutex, &'static mut Memory>;
static MEMORY: StaticCell<Shared> = StaticCell::new();
static TO_RECORD: Signal<CriticalSectionRawMutex, &'static Experiment> = Signal::new();
static RECORDED: Signal<CriticalSectionRawMutex, Outcome> = Signal::new();

/// What evaluates.
pub struct Session {
    plants: Producer<'static, emulate::Setup>,
    controllers: Producer<'static, control::Setup>,
    memory: &'static Shared,
}

/// What [`record`] needs.
pub struct Records {
    recording: Recording,
    memory: &'static Shared,
}

/// Joins the interrupts' work, gives it to the board, and gives back what is left for tasks: the
/// session, and what [`record`] needs. `memory`: where the board keeps its log.
///
/// # Panics
/// If it is called twice.
pub fn start(board: &mut impl Board, memory: &'static mut Memory) -> (Session, Records) {
    let (producer, consumer) = SAMPLES.take().split();
    let (plants, next_plant) = PLANTS.take().split();
    let (controllers, next_controller) = CONTROLLERS.take().split();
    let emulation = EMULATION.init(Emulation::new(next_plant, &WIRING));
    let recorder = Recorder::new(producer, &PROGRESS);
    let control = CONTROL.init(Control::new(next_controller, &WIRING, recorder));
    board.start(emulation, Some(control), &WIRING);
    let memory = &*MEMORY.init(Mutex::new(memory));
    let session = Session {
        plants,
        controllers,
        memory,
    };
    let recording = Recording::new(consumer, &PROGRESS, &WIRING);
    (session, Records { recording, memory })
}

/// The recording task.
pub async fn record(records: Records) -> ! {
    let Records {
        mut recording,
        memory,
    } = records;
    loop {
        let experiment = TO_RECORD.wait().await;
        let mut memory = memory.lock().await;
        memory.clear();
        // This task runs before the session hands the new plant over, so nothing new is in there.
        recording.discard();
        if let Some(Failure::Recording(milliseconds)) = experiment.failure {
            Timer::after_millis(milliseconds.into()).await;
        }
        let outcome = loop {
            let log = |sample: &Sample| log_sample(sample, &experiment.machine.converters);
            if let Some(outcome) = recording.drain(&mut memory, log) {
                break outcome;
            }
            Timer::after_millis(RECORD_PERIOD_MS).await;
        };
        drop(memory);
        RECORDED.signal(outcome);
    }
}

impl Session {
    /// Runs the experiments and logs them. True if every recording was whole, no fault was latched,
    /// every evaluation came to a result and no plant tick was missed, in an evaluation neither.
    pub async fn run<B: Board>(&mut self, experiments: &'static [Experiment]) -> bool {
        let mut sound = true;
        for experiment in experiments {
            sound &= self.perform::<B>(experiment).await;
            let ticks = WIRING.ticks();
            Timer::after_millis(1).await;
            defmt::info!("plant stepping={=bool}", WIRING.ticks() != ticks);
        }
        defmt::info!("end experiments={=usize}", experiments.len());
        let missed = WIRING.missed();
        defmt::info!(
            "deadlines ticks={=u32} missed={=u32}",
            WIRING.ticks(),
            missed
        );
        sound && missed == 0
    }

    async fn perform<B: Board>(&mut self, experiment: &'static Experiment) -> bool {
        defmt::info!(
            "experiment name={=str} plant_period_us={=u32} control_period_us={=u32} steps={=u32}",
            experiment.name,
            PLANT_PERIOD_US,
            CONTROL_PERIOD_US,
            experiment.steps
        );
        if !self.begin(experiment) {
            return false;
        }
        let outcome = RECORDED.wait().await;
        defmt::info!(
            "recorded samples={=u32} dropped={=u32}",
            outcome.samples,
            outcome.dropped
        );
        if outcome.dropped > 0 {
            defmt::warn!("queue full: {=u32} samples dropped", outcome.dropped);
        }
        if let Some(fault) = outcome.fault {
            defmt::error!("fault: {}; the bridge is off", fault);
        }
        let memory = self.memory.lock().await;
        let evaluated = evaluate::evaluate::<B>(experiment, &memory, &WIRING);
        outcome.is_success() && evaluated
    }

    /// Hands an experiment to the interrupts; false if it is refused. In a frame of its own: inlined, its
    /// setups would lie on the stack for as long as the log is evaluated.
    #[inline(never)]
    fn begin(&mut self, experiment: &'static Experiment) -> bool {
        let (plant, control) = match experiment.build() {
            Ok(setups) => setups,
            Err(refused) => {
                defmt::error!("refused: {}; the actuator before it goes on", refused);
                return false;
            }
        };
        for command in experiment.commands {
            defmt::info!(
                "command signal={=str} milliseconds={=u32}",
                command.signal.name(),
                command.milliseconds
            );
        }
        PROGRESS.ask();
        TO_RECORD.signal(experiment);
        // The controller first: it is taken when the plant has been. Both queues are empty, as the
        // experiment before has been recorded.
        let _ = self.controllers.enqueue(control);
        let _ = self.plants.enqueue(plant);
        true
    }
}
