//! The emulated engine controller and its throttle body on this host: the same code, called in the
//! order in which the board's interrupts call it.

use firmware::app::ecu::Ecu;
use firmware::app::ecu::calibration::Calibration;
use firmware::app::ecu::loopback::{COMMANDS, Command, Controller, Emulation, Wires};
use firmware::app::ecu::schedule::{Pedal, Report, Schedule, Trial};
use firmware::app::timing::PLANT_PERIOD;
use firmware::app::wiring::Wiring;
use firmware::app::work::{ControlWork, PlantWork};
use heapless::spsc::{Consumer, Queue};
use model_core::plant::throttle::{Settings, Throttle};

/// Controller and throttle body.
pub struct EcuOnHost {
    /// Work of the plant interrupt.
    pub emulation: Emulation,
    /// Work of the control interrupt.
    pub controller: Controller,
    /// What is on the wires.
    pub wires: &'static Wires,
    /// The wires of every board.
    pub wiring: &'static Wiring,
    reports: Consumer<'static, Report>,
}

/// What the board keeps in statics is leaked: a few kilobytes.
fn leak<T: Default>() -> &'static mut T {
    Box::leak(Box::default())
}

impl EcuOnHost {
    /// Key off, before the first trial. What the controller is told is the calibration, what it is
    /// joined to the throttle body of the settings.
    ///
    /// # Panics
    /// If a number is out of its range.
    pub fn new(
        calibration: Calibration,
        settings: &Settings,
        supply: f32,
        trials: &'static [Trial],
        pedal: Pedal,
    ) -> Self {
        let wires: &'static Wires = leak();
        let wiring: &'static Wiring = leak();
        let (mut commands, commanded) = leak::<Queue<Command, COMMANDS>>().split();
        let (reporter, reports) = leak::<Queue<Report, 4>>().split();
        let throttle = Throttle::build(settings, PLANT_PERIOD).expect("a throttle in its ranges");
        let body = Box::leak(Box::new(throttle));
        let room = commands.enqueue(Command::Supply(supply)).is_ok();
        assert!(room, "nothing else is in the queue");
        Self {
            emulation: Emulation::new(body, commanded, wires, wiring),
            controller: Controller::new(
                Ecu::new(calibration),
                Schedule::new(trials, pedal),
                commands,
                reporter,
                (wires, wiring),
            ),
            wires,
            wiring,
            reports,
        }
    }

    /// One plant tick, with the control step that it asks for.
    pub fn tick(&mut self) {
        if self.emulation.tick() {
            self.controller.step();
        }
    }

    /// Goes on to the next report.
    pub fn next_report(&mut self) -> Report {
        loop {
            self.tick();
            if let Some(report) = self.reports.dequeue() {
                return report;
            }
        }
    }
}
