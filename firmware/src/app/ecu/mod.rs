//! A small engine controller's throttle control, emulated: what the emulated throttle body is
//! exercised by.
//!
//! It knows what a real one does: two tracks, a motor current and a supply, in counts of its
//! converters, every millisecond; and it answers with a duty, brake or freewheel. At key-on it learns
//! the stops and tests the spring ([`learning`]), then it follows the pedal by the position loop and
//! judges ([`diagnosis`]) what it sees ([`observation`]). The first [`code`] stays until key-off, and
//! takes the plate to limp-home: the bridge freewheels. [`loopback`] joins it to the throttle body,
//! [`schedule`] injects fault after fault and `session` logs what comes of it.

pub mod calibration;
pub mod code;
pub mod diagnosis;
pub mod learning;
pub mod loopback;
pub mod observation;
pub mod schedule;
#[cfg(feature = "tasks")]
pub mod session;

use model_core::control::pid;
use model_core::plant::bridge::Bridge;

use calibration::{Calibration, DUTY, Ends};
use code::Code;
use diagnosis::Diagnosis;
use learning::{Learned, Learning, Progress};
use observation::{Observation, Readings};

/// What the driver asks for.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Demand {
    /// The key.
    pub key_on: bool,
    /// Opening, of the stroke; taken into 0.03 to 0.97.
    pub pedal: f32,
}

/// What the controller is doing.
#[derive(Debug, Clone, PartialEq)]
enum Phase {
    /// Key off: the plate comes down under brake for so many control steps.
    Off(u32),
    Learning(Learning),
    Following,
    /// With a code: without power.
    LimpHome,
}

/// Control steps under brake after key-off, in which the plate comes down softly.
const SOFT_STEPS: u32 = 50;

/// Where the pedal may put the plate, of the stroke: off the stops.
const PEDAL: [f32; 2] = [0.03, 0.97];

/// Least distance from the pedal's position for a plate that is still to be stuck, of the stroke.
const AWAY: f32 = 0.04;

/// The controller.
#[derive(Debug, Clone, PartialEq)]
pub struct Ecu {
    calibration: Calibration,
    phase: Phase,
    ends: [Ends; 2],
    learned: Option<Learned>,
    code: Option<Code>,
    seen: Observation,
    diagnosis: Diagnosis,
    position_loop: pid::State,
    /// What the bridge was told last.
    bridge: Bridge,
}

impl Ecu {
    /// Key off.
    pub fn new(calibration: Calibration) -> Self {
        Self {
            ends: calibration.ends,
            calibration,
            phase: Phase::Off(SOFT_STEPS),
            learned: None,
            code: None,
            seen: Observation::default(),
            diagnosis: Diagnosis::default(),
            position_loop: pid::State::default(),
            bridge: Bridge::Freewheel,
        }
    }

    /// What was learned since key-on.
    pub fn learned(&self) -> Option<&Learned> {
        self.learned.as_ref()
    }

    /// The code since key-on.
    pub fn code(&self) -> Option<Code> {
        self.code
    }

    /// One control step: readings in, bridge out.
    pub fn step(&mut self, readings: &Readings, demand: &Demand) -> Bridge {
        match (demand.key_on, &self.phase) {
            (true, Phase::Off(_)) => self.key_on(),
            (false, Phase::Off(_)) | (true, _) => {}
            (false, _) => self.phase = Phase::Off(0),
        }
        let stood = self.bridge.voltage(1.0);
        self.seen
            .take(readings, &self.ends, stood, &self.calibration);
        self.bridge = match &mut self.phase {
            Phase::Off(steps) if *steps < SOFT_STEPS => {
                *steps += 1;
                Bridge::Brake
            }
            Phase::Off(_) | Phase::LimpHome => Bridge::Freewheel,
            Phase::Learning(_) => self.learn(),
            Phase::Following => self.follow(demand.pedal),
        };
        self.bridge
    }

    fn key_on(&mut self) {
        *self = Self {
            phase: Phase::Learning(Learning::default()),
            ..Self::new(self.calibration)
        };
    }

    /// Takes a code, and the plate to limp-home.
    fn fail(&mut self, code: Code) -> Bridge {
        self.code = Some(code);
        self.phase = Phase::LimpHome;
        Bridge::Freewheel
    }

    fn learn(&mut self) -> Bridge {
        let Phase::Learning(learning) = &mut self.phase else {
            return Bridge::Freewheel;
        };
        let stalled = !learning.at_stop(&self.seen);
        let code = self
            .diagnosis
            .judge(&self.seen, &self.calibration, stalled, false);
        if let Some(code) = code {
            return self.fail(code);
        }
        match learning.advance(&self.seen, &self.calibration) {
            Progress::Drive(voltage) => {
                voltage.map_or(Bridge::Freewheel, |volts| self.drive(volts))
            }
            Progress::Failed(code) => self.fail(code),
            Progress::Done(learned) => {
                self.ends = learned.ends;
                self.learned = Some(learned);
                self.phase = Phase::Following;
                self.seen.rescale();
                Bridge::Freewheel
            }
        }
    }

    fn follow(&mut self, pedal: f32) -> Bridge {
        let position = self.seen.positions[0];
        let asked = pedal.clamp(PEDAL[0], PEDAL[1]);
        let surely = self.seen.voltage.is_some_and(|voltage| {
            voltage > self.calibration.opening || voltage < self.calibration.closing
        });
        let stalled = surely && (asked - position).abs() > AWAY;
        let code = self
            .diagnosis
            .judge(&self.seen, &self.calibration, stalled, true);
        if let Some(code) = code {
            return self.fail(code);
        }
        let step = self
            .calibration
            .position_loop
            .step(&mut self.position_loop, asked, position);
        // The readings are counts and finite: a refusal is the pedal's, which is not a number.
        step.map_or(Bridge::Freewheel, |volts| self.drive(volts))
    }

    /// The duty for a voltage at the supply of now, in counts of the bridge's timer.
    fn drive(&self, volts: f32) -> Bridge {
        // Below 6 V a bridge is not driven.
        let share = if self.seen.supply < 6.0 {
            None
        } else {
            DUTY.counts(volts / self.seen.supply)
        };
        share.map_or(Bridge::Freewheel, |counts| Bridge::Drive {
            duty: DUTY.value(counts),
        })
    }
}
