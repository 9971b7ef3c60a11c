//! What the controller does at key-on before it follows the pedal: it learns limp-home position,
//! closed stop and open stop, and sees whether the spring brings the plate back from both.

use model_core::plant::potentiometer::REFERENCE;

use super::calibration::{Calibration, Ends};
use super::code::Code;
use super::observation::Observation;

/// Control steps for which a plate must be still on its stop before its place is read.
const STILL_STEPS: u32 = 50;

/// The same where the spring brings it: longer than it seems to be still where it turns back.
const SPRING_STILL_STEPS: u32 = 150;

/// Readings that a place is the mean of.
const READINGS: u32 = 32;

/// Longest that a leg of the sweep may take, control steps.
const LEG_STEPS: u32 = 1500;

/// How far the limp-home position may be from its nominal place, and, after a return, from where it
/// was learned, of the stroke.
const LIMP_HOME: [f32; 2] = [0.04, 0.02];

/// How far a stop may be from its nominal place, of the reference: 0.2 V.
const STOP: f32 = 0.04;

/// Legs of the sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Leg {
    #[default]
    Settle,
    Close,
    ReturnFromClosed,
    Open,
    ReturnFromOpen,
}

/// What a sweep has learned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Learned {
    /// Both tracks at both stops.
    pub ends: [Ends; 2],
    /// Limp-home position, of the stroke.
    pub limp_home: f32,
    /// How long the spring took from the closed and from the open stop, control steps.
    pub returns: [u32; 2],
}

impl Learned {
    /// The first track at the closed and at the open stop, mV of 5 V, to the nearest.
    pub fn first_track_millivolts(&self) -> [u16; 2] {
        let Ends { closed, open } = self.ends[0];
        [closed, open].map(|share| (share * (1000.0 * REFERENCE) + 0.5) as u16)
    }

    /// Limp-home position, thousandths of the stroke, to the nearest.
    pub fn limp_home_permille(&self) -> u16 {
        (self.limp_home * 1000.0 + 0.5) as u16
    }
}

/// What a step of the sweep comes to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Progress {
    /// A voltage for the motor, V; none: the switches off.
    Drive(Option<f32>),
    /// It is over.
    Done(Learned),
    /// It cannot be ended.
    Failed(Code),
}

/// The sweep; the default at its beginning.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Learning {
    leg: Leg,
    steps: u32,
    sums: [f32; 2],
    readings: u32,
    closed: [f32; 2],
    open: [f32; 2],
    limp_home: [f32; 2],
    returns: [u32; 2],
}

impl Learning {
    /// One control step.
    pub fn advance(&mut self, seen: &Observation, calibration: &Calibration) -> Progress {
        self.steps += 1;
        if self.steps > LEG_STEPS {
            return Progress::Failed(match self.leg {
                Leg::Close | Leg::Open => Code::NotLearned,
                Leg::Settle | Leg::ReturnFromClosed | Leg::ReturnFromOpen => Code::SpringReturn,
            });
        }
        match self.place(seen) {
            Some(place) if self.is_end(place, calibration) => self.arrive(place, calibration),
            // Elsewhere it may be about to start: the leg's time decides.
            _ => Progress::Drive(self.voltage(calibration)),
        }
    }

    /// What a leg drives the motor with; none: the switches off.
    fn voltage(&self, calibration: &Calibration) -> Option<f32> {
        match self.leg {
            Leg::Close => Some(calibration.closing),
            Leg::Open => Some(calibration.opening),
            Leg::Settle | Leg::ReturnFromClosed | Leg::ReturnFromOpen => None,
        }
    }

    /// Whether the plate may lie there at the end of the leg.
    fn is_end(&self, place: [f32; 2], calibration: &Calibration) -> bool {
        let near = |end: fn(&Ends) -> f32| {
            let ends = calibration.ends.iter();
            place
                .iter()
                .zip(ends)
                .all(|(at, ends)| (at - end(ends)).abs() < STOP)
        };
        let nominal = &calibration.ends[0];
        let off = |from: f32| (nominal.position(place[0]) - from).abs();
        match self.leg {
            Leg::Settle => off(calibration.limp_home) < LIMP_HOME[0],
            Leg::Close => near(|ends| ends.closed),
            Leg::Open => near(|ends| ends.open),
            Leg::ReturnFromClosed | Leg::ReturnFromOpen => {
                off(nominal.position(self.limp_home[0])) < LIMP_HOME[1]
            }
        }
    }

    /// Whether the plate is at the end of a leg that drives it: it need not move there.
    pub fn at_stop(&self, seen: &Observation) -> bool {
        let position = seen.positions[0];
        match self.leg {
            Leg::Close => position < STOP,
            Leg::Open => position > 1.0 - STOP,
            Leg::Settle | Leg::ReturnFromClosed | Leg::ReturnFromOpen => true,
        }
    }

    /// Where the plate lies, once it has been still for long enough: shares of the reference.
    fn place(&mut self, seen: &Observation) -> Option<[f32; 2]> {
        let still = self.still_steps();
        if seen.still < still || self.steps < still {
            (self.sums, self.readings) = ([0.0; 2], 0);
            return None;
        }
        for (sum, share) in self.sums.iter_mut().zip(seen.shares) {
            *sum += share;
        }
        self.readings += 1;
        if self.readings < READINGS {
            return None;
        }
        let place = self.sums.map(|sum| sum / READINGS as f32);
        (self.sums, self.readings) = ([0.0; 2], 0);
        Some(place)
    }

    fn still_steps(&self) -> u32 {
        match self.leg {
            Leg::Close | Leg::Open => STILL_STEPS,
            Leg::Settle | Leg::ReturnFromClosed | Leg::ReturnFromOpen => SPRING_STILL_STEPS,
        }
    }

    /// Ends a leg at a place, and begins the next one.
    fn arrive(&mut self, place: [f32; 2], calibration: &Calibration) -> Progress {
        // The plate came to lie before it was seen to be still, and read.
        let took = self.steps.saturating_sub(self.still_steps() + READINGS);
        self.leg = match self.leg {
            Leg::Settle => {
                self.limp_home = place;
                Leg::Close
            }
            Leg::Close => {
                self.closed = place;
                Leg::ReturnFromClosed
            }
            Leg::ReturnFromClosed => {
                self.returns[0] = took;
                Leg::Open
            }
            Leg::Open => {
                self.open = place;
                Leg::ReturnFromOpen
            }
            Leg::ReturnFromOpen => {
                self.returns[1] = took;
                return Progress::Done(self.learned());
            }
        };
        (self.steps, self.sums, self.readings) = (0, [0.0; 2], 0);
        Progress::Drive(self.voltage(calibration))
    }

    fn learned(&self) -> Learned {
        let ends = [0, 1].map(|side| Ends {
            closed: self.closed[side],
            open: self.open[side],
        });
        Learned {
            ends,
            limp_home: ends[0].position(self.limp_home[0]),
            returns: self.returns,
        }
    }
}
