//! One trial after the other: key on, learn, follow the pedal, suffer a fault, be healed, key off.
//!
//! It runs in the control interrupt, counted in control steps, so that host and board see the same.

use model_core::plant::potentiometer::TrackFault;
use model_core::plant::throttle::{Fault, Side};

use super::code::Code;
use super::learning::Learned;
use super::loopback::Command;
use super::{Demand, Ecu};

/// One trial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// What it is called in the log.
    pub name: &'static str,
    /// The fault, and the code that it is to be found by; none: nothing is to be found.
    pub fault: Option<(Fault, Code)>,
    /// Control steps within which the code is due, or for which there must be none.
    pub within: u32,
}

/// How the pedal is moved: up and down on straight lines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pedal {
    /// Middle, of the stroke.
    pub middle: f32,
    /// To either side, of the stroke.
    pub amplitude: f32,
    /// Control steps up and down, above 1.
    pub period: u32,
}

impl Pedal {
    fn at(&self, step: u32) -> f32 {
        let phase = (step % self.period) as f32 / self.period as f32;
        // From the middle up, down to the other side and back.
        let triangle = if phase < 0.25 {
            4.0 * phase
        } else if phase < 0.75 {
            2.0 - 4.0 * phase
        } else {
            4.0 * phase - 4.0
        };
        self.middle + self.amplitude * triangle
    }
}

/// The pedal of [`TRIALS`].
pub const PEDAL: Pedal = Pedal {
    middle: 0.5,
    amplitude: 0.25,
    period: 800,
};

/// Control steps that the plate follows the pedal before a fault comes.
pub const HEALTHY: u32 = 250;

/// Control steps that the key is off between two trials.
const KEY_OFF: u32 = 20;

/// Control steps within which the throttle is learned.
const LEARNING: u32 = 4000;

const fn trial(name: &'static str, fault: Fault, code: Code, within: u32) -> Trial {
    Trial {
        name,
        fault: Some((fault, code)),
        within,
    }
}

const fn first(name: &'static str, fault: TrackFault, code: Code, within: u32) -> Trial {
    trial(name, Fault::Track(Side::First, fault), code, within)
}

const fn second(name: &'static str, fault: TrackFault, code: Code, within: u32) -> Trial {
    trial(name, Fault::Track(Side::Second, fault), code, within)
}

/// A sound throttle, and one with each fault.
pub const TRIALS: [Trial; 18] = [
    Trial {
        name: "none",
        fault: None,
        within: 3000,
    },
    first(
        "first_track_open",
        TrackFault::Open,
        Code::FirstTrackLow,
        25,
    ),
    first(
        "first_track_shorted_high",
        TrackFault::ShortedHigh,
        Code::FirstTrackHigh,
        25,
    ),
    first(
        "first_track_shorted_low",
        TrackFault::ShortedLow,
        Code::FirstTrackLow,
        25,
    ),
    first(
        "first_track_stuck",
        TrackFault::Stuck,
        Code::TracksDisagree,
        400,
    ),
    first(
        "first_track_offset",
        TrackFault::Offset(0.3),
        Code::TracksDisagree,
        40,
    ),
    first(
        "first_track_noisy",
        TrackFault::Noisy(0.05),
        Code::FirstTrackNoisy,
        100,
    ),
    second(
        "second_track_open",
        TrackFault::Open,
        Code::SecondTrackLow,
        25,
    ),
    second(
        "second_track_shorted_high",
        TrackFault::ShortedHigh,
        Code::SecondTrackHigh,
        25,
    ),
    second(
        "second_track_shorted_low",
        TrackFault::ShortedLow,
        Code::SecondTrackLow,
        25,
    ),
    second(
        "second_track_stuck",
        TrackFault::Stuck,
        Code::TracksDisagree,
        400,
    ),
    second(
        "second_track_offset",
        TrackFault::Offset(0.3),
        Code::TracksDisagree,
        40,
    ),
    second(
        "second_track_noisy",
        TrackFault::Noisy(0.05),
        Code::SecondTrackNoisy,
        100,
    ),
    trial("plate_jammed", Fault::PlateJammed, Code::PlateStuck, 1500),
    trial(
        "spring_broken",
        Fault::SpringBroken,
        Code::SpringReturn,
        3000,
    ),
    trial(
        "friction_raised",
        Fault::FrictionRaised(1.8),
        Code::FrictionHigh,
        3000,
    ),
    trial("motor_open", Fault::MotorOpen, Code::OpenLoad, 500),
    trial(
        "motor_shorted",
        Fault::MotorShorted(0.2),
        Code::ShortCircuit,
        100,
    ),
];

/// What a trial came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Report {
    /// Its number among the trials.
    pub trial: usize,
    /// What was learned at key-on.
    pub learned: Option<Learned>,
    /// The code.
    pub code: Option<Code>,
    /// Control steps from the fault, or from the end of learning, to the code or to the end.
    pub steps: u32,
    /// Whether the right code came in time, or rightly none.
    pub sound: bool,
    /// Digest of all that was on the wires since the last report.
    pub wires: u64,
}

/// What the schedule asks for in a control step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Next {
    /// Key and pedal.
    pub demand: Demand,
    /// For the throttle body.
    pub command: Option<Command>,
    /// For the log.
    pub report: Option<Report>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    KeyOff,
    Learning,
    Healthy,
    Faulty,
}

/// Where the trials are.
#[derive(Debug, Clone)]
pub struct Schedule {
    trials: &'static [Trial],
    pedal: Pedal,
    trial: usize,
    stage: Stage,
    /// Control steps in this stage.
    steps: u32,
    /// Control steps that the pedal has been moved.
    moved: u32,
}

impl Schedule {
    /// Before the first trial.
    pub const fn new(trials: &'static [Trial], pedal: Pedal) -> Self {
        Self {
            trials,
            pedal,
            trial: 0,
            stage: Stage::KeyOff,
            steps: 0,
            moved: 0,
        }
    }

    /// What comes next, before a control step of this controller. `wires` is the digest for a report.
    pub fn advance(&mut self, ecu: &Ecu, wires: u64) -> Next {
        let (mut command, mut report) = (None, None);
        self.steps += 1;
        if let Some(trial) = self.trials.get(self.trial) {
            match self.stage {
                Stage::KeyOff if self.steps > KEY_OFF => self.enter(Stage::Learning),
                Stage::Learning if ecu.learned().is_some() => {
                    self.moved = 0;
                    self.enter(if trial.fault.is_some() {
                        Stage::Healthy
                    } else {
                        Stage::Faulty
                    });
                }
                Stage::Healthy if ecu.code().is_none() && self.steps > HEALTHY => {
                    command = trial.fault.map(|(fault, _)| Command::Inject(fault));
                    self.enter(Stage::Faulty);
                }
                Stage::KeyOff => {}
                _ => {
                    let over = match self.stage {
                        Stage::Learning => self.steps > LEARNING,
                        Stage::Faulty => self.steps > trial.within,
                        Stage::Healthy | Stage::KeyOff => false,
                    };
                    if over || ecu.code().is_some() {
                        report = Some(self.end(trial, ecu, wires));
                        command = Some(Command::Heal);
                    }
                }
            }
        }
        self.moved = self.moved.saturating_add(1);
        Next {
            demand: Demand {
                key_on: self.stage != Stage::KeyOff,
                pedal: self.pedal.at(self.moved),
            },
            command,
            report,
        }
    }

    fn enter(&mut self, stage: Stage) {
        self.stage = stage;
        self.steps = 0;
    }

    /// Ends a trial, and with it the fault.
    fn end(&mut self, trial: &Trial, ecu: &Ecu, wires: u64) -> Report {
        let expected = trial.fault.map(|(_, code)| code);
        let report = Report {
            trial: self.trial,
            learned: ecu.learned().copied(),
            code: ecu.code(),
            // The controller's last step was the one before.
            steps: self.steps - 1,
            sound: self.stage == Stage::Faulty && ecu.code() == expected,
            wires,
        };
        self.trial += 1;
        self.enter(Stage::KeyOff);
        report
    }
}
