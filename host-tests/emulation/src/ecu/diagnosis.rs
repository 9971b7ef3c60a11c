//! What is judged in every step.
//!
//! | test | fails | for longer than |
//! |---|---|---|
//! | range | a track half way from its span to a rail | a contact bounces |
//! | noise | a track's second differences, of which a fast plate's and the sound noise's are below a bound | a quarter of a window |
//! | agreement | tracks apart by both tolerances and noise | range takes, and a contact bounces |
//! | short, open circuit | current more, or less, than the voltage explains by more than the spread | the filters settle |
//! | plate | still, with a voltage that moves it at any spread | a sound plate needs |
//! | friction, spring | in least squares over motion both ways, off by more than the spread, or missing by half | two windows |
//!
//! Those that use position or speed are not judged while a track is suspect.

use super::data::{Body, NOISE, SPAN, SPREAD, TOLERANCE};
use super::{FILTER, PERIOD, Seen, TRACK_LOW_PASS};

/// What it says is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Code {
    FirstTrackLow,
    FirstTrackHigh,
    FirstTrackNoisy,
    SecondTrackLow,
    SecondTrackHigh,
    SecondTrackNoisy,
    TracksDisagree,
    PlateStuck,
    SpringReturn,
    FrictionHigh,
    OpenLoad,
    ShortCircuit,
    NotLearned,
}

/// How long a contact bounces, s.
const BOUNCE: f64 = 0.01;

/// Second differences that are looked back on, and how many of them make a track noisy.
const WINDOW: u32 = 64;
const NOISY: u32 = WINDOW / 4;

/// Steps of motion each way that friction and spring are estimated from.
const MOTION: u32 = 80;

/// Speed at which the plate slides, rad/s: eight times what noise makes of it standing still.
const SLIDES: f64 = 1.0;

/// Time from one value of a track to the next, s: the low-pass takes noise away that changes as fast.
const UPDATE: f64 = 50e-6;

/// A condition that has to hold for some steps in a row.
#[derive(Debug, Default, Clone, Copy)]
struct Debounced(u32);

impl Debounced {
    fn after(&mut self, time: f64, holds: bool) -> bool {
        self.0 = if holds { self.0 + 1 } else { 0 };
        f64::from(self.0) * PERIOD > time
    }
}

/// The tests.
#[derive(Debug, Default)]
pub struct Diagnosis {
    low: [Debounced; 2],
    high: [Debounced; 2],
    disagree: Debounced,
    short: Debounced,
    open: Debounced,
    stuck: Debounced,
    /// Tracks one and two steps ago, and for how many steps they are there.
    before: [[f64; 2]; 2],
    steps: u32,
    /// Whether each of the last second differences was large, the newest in the lowest bit.
    bends: [u64; 2],
    motion: Motion,
    /// Steps for which currents are not compared: a command is under way.
    settling: f64,
    /// Time that currents need to follow a command, s.
    settled: f64,
    /// Second difference that no sound track has, V.
    bend: f64,
    /// Time in which a sound plate has surely moved, s.
    moves: f64,
    /// Voltage that moves any sound plate, V.
    surely: f64,
}

impl Diagnosis {
    /// For a body, and the time that a command takes to it, s.
    pub fn new(body: &Body, way: f64) -> Self {
        // Independent readings: their second difference has 6 times the variance. Four times the rms, and what
        // the stall torque at 16 V does to the plate in two steps.
        let acceleration = 16.0 / body.resistance * body.torque_constant / body.inertia;
        let slope = (SPAN[0][1] - SPAN[0][0]) / body.stroke();
        let passed = 1.0 - (-UPDATE / TRACK_LOW_PASS).exp();
        let noise = NOISE * (passed / (2.0 - passed)).sqrt();
        let bend = 4.0 * 6_f64.sqrt() * noise + slope * acceleration * PERIOD.powi(2);
        let held = body.spring_torque(1.0) + body.breakaway;
        let surely = (1.0 + SPREAD) * body.volts(held);
        // From rest by MOVED with what is left of the torque; twice that, and the command's way.
        let left = SPREAD * held / body.inertia;
        let distance = super::learning::MOVED * body.stroke();
        let moves = 2.0 * (2.0 * distance / left).sqrt() + way + body.mechanical_time();
        Self {
            settled: way + PERIOD + 3.0 * FILTER,
            bend,
            moves,
            surely,
            ..Self::default()
        }
    }

    /// Forgets all that was seen.
    pub fn clear(&mut self) {
        *self = Self {
            settled: self.settled,
            bend: self.bend,
            moves: self.moves,
            surely: self.surely,
            ..Self::default()
        };
    }

    /// The first code that holds now.
    pub fn judge(&mut self, seen: &Seen, body: &Body) -> Option<Code> {
        self.tracks(seen)
            .or_else(|| self.currents(seen, body))
            .or_else(|| self.plate(seen))
            .or_else(|| {
                let is_suspect = self.is_suspect(seen);
                self.motion.judge(seen, body, is_suspect)
            })
    }

    fn apart(seen: &Seen) -> bool {
        let noise = 6.0 * 2_f64.sqrt() * NOISE / (SPAN[0][1] - SPAN[0][0]);
        (seen.shares[0] - seen.shares[1]).abs() > 2.0 * TOLERANCE + noise
    }

    /// Whether a track is or was off just now.
    fn is_suspect(&self, seen: &Seen) -> bool {
        let bent = self.bends.iter().any(|bends| *bends != 0);
        Self::apart(seen) || bent
    }

    fn tracks(&mut self, seen: &Seen) -> Option<Code> {
        let [lowest, highest] = [0.5 * SPAN[0][0], 5.0 - 0.5 * (5.0 - SPAN[0][1])];
        let codes = [
            [
                Code::FirstTrackLow,
                Code::FirstTrackHigh,
                Code::FirstTrackNoisy,
            ],
            [
                Code::SecondTrackLow,
                Code::SecondTrackHigh,
                Code::SecondTrackNoisy,
            ],
        ];
        let mut found = None;
        for (side, [low, high, noisy]) in codes.into_iter().enumerate() {
            let track = seen.tracks[side];
            let [one, two] = self.before[side];
            let is_large = self.steps >= 2 && (track - 2.0 * one + two).abs() > self.bend;
            self.bends[side] = self.bends[side] << 1 | u64::from(is_large);
            self.before[side] = [track, one];
            let tests = [
                (self.low[side].after(BOUNCE, track < lowest), low),
                (self.high[side].after(BOUNCE, track > highest), high),
                (self.bends[side].count_ones() >= NOISY, noisy),
            ];
            found = found.or(tests.iter().find(|(fails, _)| *fails).map(|test| test.1));
        }
        self.steps += 1;
        let disagree = self.disagree.after(2.0 * BOUNCE, Self::apart(seen));
        found.or(disagree.then_some(Code::TracksDisagree))
    }

    fn currents(&mut self, seen: &Seen, body: &Body) -> Option<Code> {
        // Behind the bridge's switching on it takes the filters' time until currents compare.
        match seen.expected {
            None => self.settling = self.settled,
            Some(_) => self.settling -= PERIOD,
        }
        let judged = seen
            .expected
            .filter(|_| self.settling <= 0.0 && !self.is_suspect(seen));
        let expected = judged.unwrap_or(0.0);
        // A quarter of what breaks the plate away: it surely flows while the plate is driven.
        let certain = 0.25 * body.breakaway / body.torque_constant;
        let spread = SPREAD * expected.abs() + certain;
        let more = seen.current.abs() - expected.abs();
        let short = judged.is_some() && more > 2.0 * spread;
        let open = expected.abs() > 2.0 * certain && seen.current.abs() < 0.5 * certain;
        if self.short.after(self.settled, short) {
            Some(Code::ShortCircuit)
        } else {
            let is_open = self.open.after(self.settled, open);
            is_open.then_some(Code::OpenLoad)
        }
    }

    fn plate(&mut self, seen: &Seen) -> Option<Code> {
        let is_at_stop = (seen.voltage < 0.0 && seen.share < 2.0 * TOLERANCE)
            || (seen.voltage > 0.0 && seen.share > 1.0 - 2.0 * TOLERANCE);
        let is_pushed = seen.voltage.abs() > self.surely && !is_at_stop && !self.is_suspect(seen);
        // So long that it is pushed, and so long that it is still.
        let is_stuck =
            self.stuck.after(self.moves, is_pushed) && f64::from(seen.still) * PERIOD > self.moves;
        is_stuck.then_some(Code::PlateStuck)
    }
}

/// Torque that the motor gives beyond inertia and viscous friction, over motion: friction, whose sign is the
/// motion's, and a share of the spring's torque.
#[derive(Debug, Default)]
struct Motion {
    /// Steps opening and closing.
    steps: [u32; 2],
    /// Sums of spring torque squared, and times the motion's sign.
    squared: f64,
    crossed: f64,
    /// Sums of the torque times the motion's sign, and times the spring's torque.
    by_sign: f64,
    by_spring: f64,
    slides: bool,
    verdict: Option<Code>,
}

impl Motion {
    fn judge(&mut self, seen: &Seen, body: &Body, is_suspect: bool) -> Option<Code> {
        let slid = self.slides;
        // The preload turns its sign at limp-home.
        let is_near_rest = (seen.share - body.limp_home()).abs() < 4.0 * TOLERANCE;
        self.slides =
            seen.speed.abs() > SLIDES && !is_near_rest && !is_suspect && seen.expected.is_some();
        // The first step of a slide is the one in which noise took the speed over its bound.
        if !slid || !self.slides {
            return None;
        }
        let sign = 1_f64.copysign(seen.speed);
        let spring = body.spring_torque(seen.share);
        let torque = body.torque_constant * seen.current
            - body.inertia * seen.acceleration
            - body.viscous * seen.speed;
        self.steps[usize::from(sign < 0.0)] += 1;
        self.squared += spring * spring;
        self.crossed += sign * spring;
        self.by_sign += sign * torque;
        self.by_spring += spring * torque;
        if self.steps.iter().any(|steps| *steps < MOTION) {
            return None;
        }
        let count = f64::from(self.steps[0] + self.steps[1]);
        let determinant = count * self.squared - self.crossed.powi(2);
        let friction = (self.by_sign * self.squared - self.by_spring * self.crossed) / determinant;
        let share = (count * self.by_spring - self.crossed * self.by_sign) / determinant;
        let verdict = if share < 0.5 {
            Some(Code::SpringReturn)
        } else if friction > (1.0 + SPREAD) * body.coulomb {
            Some(Code::FrictionHigh)
        } else {
            None
        };
        let confirmed = verdict.filter(|_| verdict == self.verdict);
        *self = Self {
            slides: true,
            verdict,
            ..Self::default()
        };
        confirmed
    }
}
