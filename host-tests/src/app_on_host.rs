//! The firmware's application on this host: the same code, called in the order in which the board's
//! interrupts call it.

use firmware::app::control::Control;
use firmware::app::emulate::Emulation;
use firmware::app::machine::{ACTUATOR, POSITION_LOOP};
use firmware::app::record::{Progress, Recorder, Sample};
use firmware::app::timing::{CONTROL_PERIOD, PLANT_PERIOD, QUEUED_SAMPLES};
use firmware::app::wiring::Wiring;
use heapless::spsc::{Consumer, Queue};
use model_core::plant::actuator::Actuator;

/// The interrupts' work, and the ends that the tasks hold.
pub struct AppOnHost {
    /// Work of the plant interrupt.
    pub emulation: Emulation,
    /// Work of the control interrupt.
    pub control: Control,
    /// The wires between them.
    pub wiring: &'static Wiring,
    /// What the recording task knows.
    pub progress: &'static Progress,
    /// What the recording task takes samples from.
    pub samples: Consumer<'static, Sample>,
}

impl AppOnHost {
    /// The application before its first tick. What a board keeps in statics is leaked: a few
    /// kilobytes.
    ///
    /// # Panics
    /// If the firmware's own constants are out of range.
    pub fn new() -> Self {
        let wiring: &'static Wiring = Box::leak(Box::default());
        let progress: &'static Progress = Box::leak(Box::default());
        let queue: &'static mut Queue<Sample, QUEUED_SAMPLES> = Box::leak(Box::default());
        let (producer, samples) = queue.split();
        let actuator = Actuator::build(&ACTUATOR, PLANT_PERIOD).expect("a valid actuator");
        let pid = POSITION_LOOP.build(CONTROL_PERIOD).expect("a valid PID");
        Self {
            emulation: Emulation::new(actuator, wiring),
            control: Control::new(pid, wiring, Recorder::new(producer, progress)),
            wiring,
            progress,
            samples,
        }
    }

    /// One plant tick, with the control step that it asks for.
    pub fn tick(&mut self) {
        if self.emulation.tick() {
            self.control.step();
        }
    }

    /// Runs the profile to its end, or to a fault, and returns its samples.
    pub fn run(mut self) -> Vec<Sample> {
        let mut recorded = Vec::new();
        while !self.progress.finished() && self.wiring.fault().is_none() {
            self.tick();
            while let Some(sample) = self.samples.dequeue() {
                recorded.push(sample);
            }
        }
        recorded
    }
}

impl Default for AppOnHost {
    fn default() -> Self {
        Self::new()
    }
}
