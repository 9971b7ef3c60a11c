//! One run of the profile, from the statics that the interrupts share to the outcome.

use heapless::spsc::Queue;
use model_core::plant::actuator::Actuator;
use static_cell::{ConstStaticCell, StaticCell};

use super::control::Control;
use super::emulate::Emulation;
use super::machine::{ACTUATOR, POSITION_LOOP};
use super::record::{self, Outcome, Progress, Recorder, Sample};
use super::timing::{CONTROL_PERIOD, PLANT_PERIOD, QUEUED_SAMPLES};
use super::wiring::Wiring;
use crate::board::Board;

static WIRING: Wiring = Wiring::new();
static PROGRESS: Progress = Progress::new();
static SAMPLES: ConstStaticCell<Queue<Sample, QUEUED_SAMPLES>> = ConstStaticCell::new(Queue::new());
static EMULATION: StaticCell<Emulation> = StaticCell::new();
static CONTROL: StaticCell<Control> = StaticCell::new();

/// Runs the profile on the emulated actuator and logs it.
///
/// # Panics
/// If it is called twice, or if a constant of [`machine`](super::machine) is out of its range.
pub async fn run(board: &mut impl Board) -> Outcome {
    let actuator = defmt::unwrap!(Actuator::build(&ACTUATOR, PLANT_PERIOD));
    let pid = defmt::unwrap!(POSITION_LOOP.build(CONTROL_PERIOD));
    let (producer, consumer) = SAMPLES.take().split();
    let emulation = EMULATION.init(Emulation::new(actuator, &WIRING));
    let control = CONTROL.init(Control::new(
        pid,
        &WIRING,
        Recorder::new(producer, &PROGRESS),
    ));
    board.start(emulation, control, &WIRING);
    record::record(consumer, &PROGRESS, &WIRING).await
}
