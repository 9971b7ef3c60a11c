//! The firmware's application on this host: the same code, called in the order in which the board's
//! interrupts and tasks call it.

use firmware::app::control::{self, Control};
use firmware::app::emulate::{self, Emulation};
use firmware::app::experiment::Experiment;
use firmware::app::memory::Memory;
use firmware::app::record::{Outcome, Progress, Recorder, Recording, Sample};
use firmware::app::timing::QUEUED_SAMPLES;
use firmware::app::wiring::Wiring;
use firmware::app::work::{ControlWork, PlantWork};
use heapless::spsc::{Producer, Queue};

/// The interrupts' work, and the ends that the tasks hold.
pub struct AppOnHost {
    /// Work of the plant interrupt.
    pub emulation: Emulation,
    /// Work of the control interrupt.
    pub control: Control,
    /// The wires between them.
    pub wiring: &'static Wiring,
    /// What the ends of the sample queue know.
    pub progress: &'static Progress,
    /// Work of the recording task.
    pub recording: Recording,
    /// What the recording keeps.
    pub memory: Box<Memory>,
    plants: Producer<'static, emulate::Setup>,
    controllers: Producer<'static, control::Setup>,
}

/// What the board keeps in statics is leaked: a few kilobytes.
fn leak<T: Default>() -> &'static mut T {
    Box::leak(Box::default())
}

impl AppOnHost {
    /// The application before its first experiment.
    pub fn new() -> Self {
        let wiring: &'static Wiring = leak();
        let progress: &'static Progress = leak();
        let (producer, consumer) = leak::<Queue<Sample, QUEUED_SAMPLES>>().split();
        let (plants, next_plant) = leak::<Queue<emulate::Setup, 2>>().split();
        let (controllers, next_controller) = leak::<Queue<control::Setup, 2>>().split();
        let recorder = Recorder::new(producer, progress);
        Self {
            emulation: Emulation::new(next_plant, wiring),
            control: Control::new(next_controller, wiring, recorder),
            wiring,
            progress,
            recording: Recording::new(consumer, progress, wiring),
            memory: Box::default(),
            plants,
            controllers,
        }
    }

    /// Hands an experiment to the interrupts. Its plant begins anew with the next tick.
    ///
    /// # Panics
    /// If a constant of the experiment is out of its range, or the one before has not begun.
    pub fn load(&mut self, experiment: &Experiment) {
        let (plant, control) = experiment.build().expect("an experiment within its ranges");
        self.memory.clear();
        self.progress.ask();
        self.recording.discard();
        let taken = self.controllers.enqueue(control).is_ok() && self.plants.enqueue(plant).is_ok();
        assert!(taken, "the experiment before has not begun");
    }

    /// One plant tick, with the control step that it asks for.
    pub fn tick(&mut self) {
        if self.emulation.tick() {
            self.control.step();
        }
    }

    /// Runs an experiment to its end, or to a fault: its samples, and how it ended. The memory keeps
    /// the last of them.
    pub fn run(&mut self, experiment: &Experiment) -> (Vec<Sample>, Outcome) {
        self.load(experiment);
        let mut recorded = Vec::new();
        loop {
            self.tick();
            let log = |sample: &Sample| recorded.push(*sample);
            if let Some(outcome) = self.recording.drain(&mut self.memory, log) {
                return (recorded, outcome);
            }
        }
    }
}

impl Default for AppOnHost {
    fn default() -> Self {
        Self::new()
    }
}
