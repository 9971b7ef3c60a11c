//! Key-on: limp-home position, closed stop, return by the spring, open stop, return by the spring.

use super::data::{Body, SPREAD, TOLERANCE};
use super::diagnosis::Code;
use super::{PERIOD, Seen};

/// By how much a plate that is still may seem to move, of the stroke: eight times the tracks' noise of 5 mV of 4 V.
pub const MOVED: f64 = 0.01;

/// Readings that a place is the mean of.
pub const READINGS: u32 = 64;

/// How long a plate has to be still to have come to its place, s: longer than where it turns back.
const STILL: f64 = 0.1;

/// Longest that a leg may take, s.
const LONGEST: f64 = 1.0;

/// What was learned, V.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Learned {
    /// Each track at the closed and at the open stop.
    pub ends: [[f64; 2]; 2],
    /// Each track at limp-home: before anything was driven, behind the closed stop, behind the open one.
    pub limp_home: [[f64; 2]; 3],
}

/// What a step of it comes to.
pub enum Progress {
    /// A voltage; none: the bridge off.
    Drive(Option<f64>),
    Done(Learned),
    Failed(Code),
}

/// The legs, by their number.
#[derive(Debug, Default)]
pub struct Learning {
    leg: usize,
    steps: u32,
    sum: [f64; 2],
    readings: u32,
    places: Vec<[f64; 2]>,
}

/// Where a leg ends.
#[derive(Debug, Clone, Copy, PartialEq)]
enum End {
    LimpHome,
    Closed,
    Open,
}

const LEGS: [End; 5] = [
    End::LimpHome,
    End::Closed,
    End::LimpHome,
    End::Open,
    End::LimpHome,
];

impl Learning {
    pub fn step(&mut self, seen: &Seen, body: &Body) -> Progress {
        self.steps += 1;
        let end = LEGS[self.leg];
        if f64::from(self.steps) * PERIOD > LONGEST {
            return Progress::Failed(match end {
                End::LimpHome => Code::SpringReturn,
                End::Closed | End::Open => Code::NotLearned,
            });
        }
        let still = (STILL / PERIOD) as u32;
        let lies = seen.still >= still && self.steps >= still && is_near(end, seen.share, body);
        if !lies {
            (self.sum, self.readings) = ([0.0; 2], 0);
            return Progress::Drive(voltage(end, body));
        }
        for (sum, track) in self.sum.iter_mut().zip(seen.tracks) {
            *sum += track;
        }
        self.readings += 1;
        if self.readings == READINGS {
            self.places
                .push(self.sum.map(|sum| sum / f64::from(READINGS)));
            let places = std::mem::take(&mut self.places);
            if let [rest, closed, behind_closed, open, behind_open] = places[..] {
                return Progress::Done(Learned {
                    ends: [0, 1].map(|side| [closed[side], open[side]]),
                    limp_home: [rest, behind_closed, behind_open],
                });
            }
            *self = Self {
                leg: self.leg + 1,
                places,
                ..Self::default()
            };
        }
        Progress::Drive(voltage(LEGS[self.leg], body))
    }
}

/// Whether the plate is where a leg may end: both tracks' tolerance off.
fn is_near(end: End, share: f64, body: &Body) -> bool {
    let nominal = match end {
        End::LimpHome => body.limp_home(),
        End::Closed => 0.0,
        End::Open => 1.0,
    };
    (share - nominal).abs() < 2.0 * TOLERANCE
}

/// What takes the plate to a stop against all that holds it, however far that is off.
fn voltage(end: End, body: &Body) -> Option<f64> {
    let torque = match end {
        End::LimpHome => return None,
        End::Closed => body.spring_torque(0.0) - body.breakaway,
        End::Open => body.spring_torque(1.0) + body.breakaway,
    };
    Some((1.0 + SPREAD) * body.volts(torque))
}
