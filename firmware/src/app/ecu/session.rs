//! The trials on a board, and what they log.

use embassy_time::Timer;
use heapless::spsc::{Consumer, Queue};
use model_core::plant::throttle::Throttle;
use static_cell::{ConstStaticCell, StaticCell};

use super::Ecu;
use super::calibration::Calibration;
use super::code::Code;
use super::loopback::{self, COMMANDS, Command, Controller, Emulation, Wires};
use super::schedule::{PEDAL, Report, Schedule, TRIALS};
use crate::app::machine::THROTTLE;
use crate::app::timing::{PLANT_PERIOD, RECORD_PERIOD_MS};
use crate::app::wiring::Wiring;
use crate::board::Board;

/// Reports under way at a time.
const REPORTS: usize = 4;

static WIRING: Wiring = Wiring::new();
static WIRES: Wires = Wires::new();
static COMMAND_QUEUE: ConstStaticCell<Queue<Command, COMMANDS>> =
    ConstStaticCell::new(Queue::new());
static REPORT_QUEUE: ConstStaticCell<Queue<Report, REPORTS>> = ConstStaticCell::new(Queue::new());
static BODY: StaticCell<Throttle> = StaticCell::new();
static EMULATION: StaticCell<Emulation> = StaticCell::new();
static CONTROLLER: StaticCell<Controller> = StaticCell::new();

/// What logs.
pub struct Trials {
    reports: Consumer<'static, Report>,
}

/// Joins throttle body and controller, and gives them to the board.
///
/// # Panics
/// If it is called twice, or the throttle's numbers are out of their ranges.
pub fn start(board: &mut impl Board) -> Trials {
    let settings = loopback::complementary(THROTTLE.plant, loopback::SEED);
    let (commands, commanded) = COMMAND_QUEUE.take().split();
    let (reporter, reports) = REPORT_QUEUE.take().split();
    let throttle = Throttle::build(&settings, PLANT_PERIOD);
    let body = BODY.init(defmt::unwrap!(throttle, "throttle"));
    let calibration = defmt::unwrap!(Calibration::new(&THROTTLE, &settings.tracks), "calibration");
    let emulation = EMULATION.init(Emulation::new(body, commanded, &WIRES, &WIRING));
    let controller = CONTROLLER.init(Controller::new(
        Ecu::new(calibration),
        Schedule::new(&TRIALS, PEDAL),
        commands,
        reporter,
        (&WIRES, &WIRING),
    ));
    board.start(emulation, Some(controller), &WIRING);
    Trials { reports }
}

impl Trials {
    /// Logs the trials to the last. True if each fault was found by its code in time, nothing was
    /// found where nothing was, and no deadline was missed.
    pub async fn run(&mut self) -> bool {
        let mut sound = true;
        for _ in 0..TRIALS.len() {
            let report = loop {
                if let Some(report) = self.reports.dequeue() {
                    break report;
                }
                Timer::after_millis(RECORD_PERIOD_MS).await;
            };
            log(&report);
            sound &= report.sound;
        }
        if let Some(fault) = WIRING.fault() {
            defmt::error!("fault: {}; the bridge is off", fault);
            sound = false;
        }
        if WIRES.refused() > 0 {
            defmt::error!("commands refused: {=u32}", WIRES.refused());
            sound = false;
        }
        defmt::info!("end trials={=usize}", TRIALS.len());
        let missed = WIRING.missed();
        defmt::info!(
            "deadlines ticks={=u32} missed={=u32}",
            WIRING.ticks(),
            missed
        );
        sound && missed == 0
    }
}

fn log(report: &Report) {
    let name = TRIALS[report.trial].name;
    match &report.learned {
        Some(learned) => {
            let [closed, open] = learned.first_track_millivolts();
            let [from_closed, from_open] = learned.returns;
            defmt::info!(
                "learned trial={=str} closed_mv={=u16} open_mv={=u16} limp_home_permille={=u16} from_closed_ms={=u32} from_open_ms={=u32}",
                name,
                closed,
                open,
                learned.limp_home_permille(),
                from_closed,
                from_open
            );
        }
        None => defmt::error!("not learned trial={=str}", name),
    }
    let code = report.code.map_or("none", Code::name);
    if report.sound {
        defmt::info!(
            "found trial={=str} code={=str} after_ms={=u32} wires={=u64:016x}",
            name,
            code,
            report.steps,
            report.wires
        );
    } else {
        defmt::error!(
            "not as expected: trial={=str} code={=str} after_ms={=u32}",
            name,
            code,
            report.steps
        );
    }
}
