//! The throttle's part of an engine control unit (ECU), in `f64`: what stands in for a user's own one at the wires
//! of the `throttle` image. It shares no code with the images.
//!
//! Each millisecond it converts the two position tracks, the motor's current and the supply, and answers with a
//! duty and a direction, or with the bridge off. At key-on it learns limp-home position, closed and open stop
//! ([`learning`]), then it follows the pedal, and it judges what it sees ([`diagnosis`]). What it finds keeps the
//! bridge off until it is cleared, as by a scan tool.

use std::collections::VecDeque;

use data::Body;
use diagnosis::{Code, Diagnosis};
use learning::{Learned, Learning};

pub mod data;
pub mod diagnosis;
pub mod learning;

/// Time of a step, s.
pub const PERIOD: f64 = 1e-3;

/// Time constants of the low-pass at each track's input, and of the two stages behind the current's PWM, s.
pub const TRACK_LOW_PASS: f64 = 0.2e-3;
pub const CURRENT_LOW_PASS: f64 = 0.15e-3;

/// Time constant of the filter of speed, and of all that is held against speed, s.
const FILTER: f64 = 4e-3;

/// Range of the pedal, of the stroke: off the stops.
const PEDAL: [f64; 2] = [0.05, 0.95];

/// What the converters of the ECU read, 12 bits each.
#[derive(Debug, Clone, Copy, Default)]
pub struct Readings {
    /// Of 5 V.
    pub tracks: [u16; 2],
    /// Of 3.3 V, 66 mV/A about the middle.
    pub current: u16,
    /// Of 20 V.
    pub supply: u16,
}

/// Voltage of a converter's full scale, and the nearest code.
pub fn convert(volts: f64, full_scale: f64) -> u16 {
    // Within 12 bits, it fits.
    (volts / full_scale * CODES).round().clamp(0.0, CODES) as u16
}

fn volts(code: u16, full_scale: f64) -> f64 {
    f64::from(code) / CODES * full_scale
}

const CODES: f64 = 4095.0;
pub const TRACK_FULL_SCALE: f64 = 5.0;
pub const CURRENT_FULL_SCALE: f64 = 3.3;
pub const SUPPLY_FULL_SCALE: f64 = 20.0;
const CURRENT_GAIN: f64 = 66e-3;

/// What it does with the bridge: a share of the supply; none: off.
pub type Command = Option<f64>;

/// What it makes of its readings.
#[derive(Debug, Clone, Copy, Default)]
pub struct Seen {
    /// Of the tracks, V.
    pub tracks: [f64; 2],
    /// Share of the stroke by each track.
    pub shares: [f64; 2],
    /// Their mean.
    pub share: f64,
    /// Filtered, rad/s.
    pub speed: f64,
    /// Its slope, rad/s².
    pub acceleration: f64,
    /// Filtered, A.
    pub current: f64,
    /// What the voltage that was commanded would drive through a sound winding, filtered the same way, A; none
    /// while the bridge was off.
    pub expected: Option<f64>,
    /// Voltage at the winding by then, V; 0 while the bridge is off.
    pub voltage: f64,
    pub supply: f64,
    /// Steps since the plate was seen to move.
    pub still: u32,
}

enum Phase {
    Off,
    Learning(Learning),
    Following,
    /// With a code: without power.
    LimpHome,
}

/// The controller.
pub struct Ecu {
    body: Body,
    phase: Phase,
    /// Voltages of each track at either stop, as they are known.
    ends: [[f64; 2]; 2],
    learned: Option<Learned>,
    code: Option<Code>,
    seen: Seen,
    diagnosis: Diagnosis,
    /// What was commanded and has not reached the winding yet, the newest last.
    under_way: VecDeque<Command>,
    /// Current that voltage alone would drive, before and behind the filter of speed, A.
    driven: [f64; 2],
    anchor: f64,
    /// Whether there were readings before.
    has_seen: bool,
    set_point: f64,
    integral: f64,
    /// Crossover of the position loop, rad/s.
    crossover: f64,
}

impl Ecu {
    /// Key off, for a PWM of so many hertz.
    pub fn new(body: Body, frequency: f64) -> Self {
        // A command waits half a period for the next one to begin, and the body has measured it one later.
        let way = 1.5 / frequency;
        // A half a radian of delay in all at the crossover leaves a phase margin of some 55°.
        let delay = way + 1.5 * PERIOD + TRACK_LOW_PASS + FILTER;
        let steps = (way / PERIOD).round() as usize + 1;
        Self {
            diagnosis: Diagnosis::new(&body, way),
            body,
            phase: Phase::Off,
            ends: data::SPAN,
            learned: None,
            code: None,
            seen: Seen::default(),
            under_way: VecDeque::from(vec![None; steps]),
            driven: [0.0; 2],
            anchor: 0.0,
            has_seen: false,
            set_point: 0.0,
            integral: 0.0,
            crossover: 0.5 / delay,
        }
    }

    pub fn turn_key_on(&mut self) {
        self.phase = Phase::Learning(Learning::default());
    }

    pub fn learned(&self) -> Option<&Learned> {
        self.learned.as_ref()
    }

    pub fn code(&self) -> Option<Code> {
        self.code
    }

    /// Forgets the code, and follows the pedal again.
    pub fn clear(&mut self) {
        self.code = None;
        self.diagnosis.clear();
        self.follow_from_here();
    }

    /// Share of the stroke that it follows now.
    pub fn set_point(&self) -> f64 {
        self.set_point
    }

    /// Share of the stroke at which the plate is, as it reads it.
    pub fn share(&self) -> f64 {
        self.seen.share
    }

    /// The position loop's gain, V/rad: the controller's zero cancels the mechanical time constant.
    pub fn proportional(&self) -> f64 {
        let Body {
            resistance,
            torque_constant,
            ..
        } = self.body;
        self.crossover * self.body.damping() * resistance / torque_constant
    }

    fn follow_from_here(&mut self) {
        self.phase = Phase::Following;
        self.set_point = self.seen.share;
        self.integral = 0.0;
    }

    /// One step. The pedal is a share of the stroke.
    pub fn step(&mut self, readings: &Readings, pedal: f64) -> Command {
        self.see(readings);
        let command = if matches!(self.phase, Phase::Off | Phase::LimpHome) {
            None
        } else if let Some(code) = self.diagnosis.judge(&self.seen, &self.body) {
            self.fail(code)
        } else {
            self.drive(pedal)
        };
        self.under_way.push_back(command);
        command
    }

    fn drive(&mut self, pedal: f64) -> Command {
        let volts = match &mut self.phase {
            Phase::Off | Phase::LimpHome => return None,
            Phase::Learning(learning) => match learning.step(&self.seen, &self.body) {
                learning::Progress::Drive(volts) => volts?,
                learning::Progress::Failed(code) => return self.fail(code),
                learning::Progress::Done(learned) => {
                    self.ends = learned.ends;
                    self.learned = Some(learned);
                    self.follow_from_here();
                    return None;
                }
            },
            Phase::Following => self.follow(pedal),
        };
        Some((volts / self.seen.supply).clamp(-1.0, 1.0))
    }

    fn fail(&mut self, code: Code) -> Command {
        self.code = Some(code);
        self.phase = Phase::LimpHome;
        None
    }

    fn see(&mut self, readings: &Readings) {
        let share = 1.0 - (-PERIOD / FILTER).exp();
        let Self {
            body, seen, ends, ..
        } = self;
        let before = *seen;
        seen.tracks = readings.tracks.map(|code| volts(code, TRACK_FULL_SCALE));
        seen.supply = volts(readings.supply, SUPPLY_FULL_SCALE);
        seen.shares = [0, 1]
            .map(|side| (seen.tracks[side] - ends[side][0]) / (ends[side][1] - ends[side][0]));
        seen.share = 0.5 * (seen.shares[0] + seen.shares[1]);
        let current =
            (volts(readings.current, CURRENT_FULL_SCALE) - 0.5 * CURRENT_FULL_SCALE) / CURRENT_GAIN;
        let command = self.under_way.pop_front().flatten();
        seen.voltage = command.unwrap_or(0.0) * seen.supply;
        if !self.has_seen {
            self.has_seen = true;
            self.anchor = seen.share;
            return;
        }
        let speed = (seen.share - before.share) * body.stroke() / PERIOD;
        seen.speed += share * (speed - seen.speed);
        seen.acceleration = (seen.speed - before.speed) / PERIOD;
        seen.current += share * (current - seen.current);
        // What the voltage would drive alone, as it comes through winding, low-pass and filter; speed is behind
        // the filter already.
        let lag = body.inductance / body.resistance + 2.0 * CURRENT_LOW_PASS;
        let [winding, filtered] = &mut self.driven;
        *winding += (1.0 - (-PERIOD / lag).exp()) * (seen.voltage / body.resistance - *winding);
        *filtered += share * (*winding - *filtered);
        seen.expected =
            command.map(|_| *filtered - body.torque_constant * seen.speed / body.resistance);
        if (seen.share - self.anchor).abs() > learning::MOVED {
            self.anchor = seen.share;
            seen.still = 0;
        } else {
            seen.still = seen.still.saturating_add(1);
        }
    }

    /// A voltage that takes the plate towards the pedal.
    fn follow(&mut self, pedal: f64) -> f64 {
        let body = &self.body;
        let stroke = body.stroke();
        let asked = pedal.clamp(PEDAL[0], PEDAL[1]);
        // Half the speed that the supply leaves beyond what holds the plate.
        let held = body.volts(body.breakaway + body.spring_torque(1.0));
        let fastest = 0.5 * (self.seen.supply - held).max(0.0) / body.torque_constant / stroke;
        let before = self.set_point;
        let most = fastest * PERIOD;
        self.set_point += (asked - before).clamp(-most, most);
        let wanted = (self.set_point - before) * stroke / PERIOD;
        let error = (self.set_point - self.seen.share) * stroke;
        let friction = if wanted == 0.0 {
            0.0
        } else {
            body.coulomb.copysign(wanted)
        };
        let ahead = body.volts(body.spring_torque(self.set_point) + friction)
            + body.volts(body.damping() * wanted);
        let proportional = self.proportional();
        let derivative = proportional * body.mechanical_time();
        let volts =
            ahead + proportional * error + derivative * (wanted - self.seen.speed) + self.integral;
        // A decade below the crossover; not on what noise and the converters make of an error.
        if volts.abs() < self.seen.supply && error.abs() > learning::MOVED * stroke / 4.0 {
            self.integral += proportional * 0.1 * self.crossover * error * PERIOD;
        }
        volts
    }
}
