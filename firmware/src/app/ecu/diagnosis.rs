//! What the controller judges in every step, and for how long before it says so.
//!
//! Each test has its own debounce: so many control steps in a row. The shorter ones come first where
//! one fault shows in several tests: a track at a rail is out of range before it disagrees.

use super::calibration::Calibration;
use super::code::Code;
use super::observation::Observation;
use crate::app::debounce::Debounce;

/// Range of a sound track, in shares of the reference: 0.25 to 4.75 V.
const RANGE: [f32; 2] = [0.05, 0.95];
const RANGE_STEPS: u32 = 20;

/// Most that the tracks may be apart, of the stroke.
const DISAGREEMENT: f32 = 0.05;
const DISAGREEMENT_STEPS: u32 = 30;

/// Most that a track's second difference may be on average, of the stroke.
const NOISE: f32 = 0.012;
const NOISE_STEPS: u32 = 40;

/// Current that a voltage must drive before its absence is one, and what counts as absent, A.
const OPEN: [f32; 2] = [0.6, 0.1];
const OPEN_STEPS: u32 = 30;

/// Current beyond what is explained, A.
const SHORT: f32 = 1.2;
const SHORT_STEPS: u32 = 10;

/// Control steps for which a plate that is surely driven may be still.
const STUCK_STEPS: u32 = 150;

/// The tests of every control step.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Diagnosis {
    low: [Debounce; 2],
    high: [Debounce; 2],
    noisy: [Debounce; 2],
    disagreeing: Debounce,
    open: Debounce,
    short: Debounce,
    stuck: Debounce,
    balance: Balance,
}

impl Diagnosis {
    /// The first code that holds now. `stalled`: a voltage stands at the motor that surely moves the
    /// plate, and no stop is in its way. `moving`: the plate is driven over its stroke, so that its
    /// balance of torques may be looked at.
    pub fn judge(
        &mut self,
        seen: &Observation,
        calibration: &Calibration,
        stalled: bool,
        moving: bool,
    ) -> Option<Code> {
        let mut code = None;
        let mut say = |bad: bool, said: Code| {
            if bad && code.is_none() {
                code = Some(said);
            }
        };
        for side in 0..2 {
            let [low, high, noisy] = [
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
            ][side];
            let share = seen.shares[side];
            say(self.low[side].after(RANGE_STEPS, share < RANGE[0]), low);
            say(self.high[side].after(RANGE_STEPS, share > RANGE[1]), high);
            let is_noisy = seen.noise[side] > NOISE;
            say(self.noisy[side].after(NOISE_STEPS, is_noisy), noisy);
        }
        let apart = (seen.positions[0] - seen.positions[1]).abs();
        let disagreeing = apart > DISAGREEMENT;
        say(
            self.disagreeing.after(DISAGREEMENT_STEPS, disagreeing),
            Code::TracksDisagree,
        );
        // With its switches off the bridge drives nothing, and the current is whatever it is.
        let (open, short) = seen.voltage.map_or((false, false), |voltage| {
            let explained =
                (voltage - calibration.back_emf * seen.velocity) / calibration.resistance;
            let open = explained.abs() > OPEN[0] && seen.current.abs() < OPEN[1];
            let beyond = (seen.current - explained).abs() > SHORT;
            (open, beyond && seen.current.abs() > explained.abs())
        });
        say(self.short.after(SHORT_STEPS, short), Code::ShortCircuit);
        say(self.open.after(OPEN_STEPS, open), Code::OpenLoad);
        let stuck = stalled && seen.still > STUCK_STEPS;
        say(self.stuck.after(STUCK_STEPS, stuck), Code::PlateStuck);
        if moving && code.is_none() && !disagreeing {
            code = self.balance.judge(seen, calibration);
        }
        code
    }
}

/// Speed at which a slide begins, and below which it ends, strokes a second.
const SLIDING: [f32; 2] = [0.4, 0.2];

/// How near its limp-home position the plate is left out, of the stroke: the preload turns there.
const NEAR_REST: f32 = 0.04;

/// Control steps of motion each way that a verdict is made from.
const WINDOW: u32 = 200;

/// Verdicts in a row that make a code. The first may have begun before the fault.
const VERDICTS: u32 = 2;

/// Share of the nominal friction beyond which it is high.
const FRICTION: f32 = 1.4;

/// Share of the preload by which the spring may be off.
const SPRING: f32 = 0.7;

/// What the motor's current has to balance in motion, besides what it is known to: friction, whose
/// sign is the motion's, and a missing spring, whose sign is not.
#[derive(Debug, Clone, PartialEq, Default)]
struct Balance {
    /// Sum and count of the unexplained current, A, opening and closing.
    opening: (f32, u32),
    closing: (f32, u32),
    /// Whether the last step was looked at, and its motion opening.
    sliding: Option<bool>,
    verdict: Option<Code>,
    verdicts: u32,
}

impl Balance {
    fn judge(&mut self, seen: &Observation, calibration: &Calibration) -> Option<Code> {
        let away = seen.positions[0] - calibration.limp_home;
        let slowest = if self.sliding.is_some() {
            SLIDING[1]
        } else {
            SLIDING[0]
        };
        let looked_at = seen.velocity.abs() > slowest && away.abs() > NEAR_REST;
        let sliding = looked_at.then_some(seen.velocity > 0.0);
        // The first step of a slide is left out: its acceleration is what the noise made of it that
        // brought it over the threshold. Those behind it add up to the change of speed.
        if sliding.is_some() && sliding == self.sliding {
            let known = calibration.preload.copysign(away)
                + calibration.spring * away
                + calibration.viscous * seen.velocity
                + calibration.inertia * seen.acceleration;
            let (sum, count) = if seen.velocity > 0.0 {
                &mut self.opening
            } else {
                &mut self.closing
            };
            *sum += seen.current - known;
            *count += 1;
        }
        self.sliding = sliding;
        if self.opening.1 < WINDOW || self.closing.1 < WINDOW {
            return None;
        }
        let mean = |(sum, count): (f32, u32)| sum / count as f32;
        let (opening, closing) = (mean(self.opening), mean(self.closing));
        let friction = 0.5 * (opening - closing);
        let spring = 0.5 * (opening + closing);
        let verdict = if spring.abs() > SPRING * calibration.preload {
            Some(Code::SpringReturn)
        } else if friction > FRICTION * calibration.friction {
            Some(Code::FrictionHigh)
        } else {
            None
        };
        self.verdicts = if verdict == self.verdict {
            self.verdicts + 1
        } else {
            1
        };
        self.verdict = verdict;
        (self.opening, self.closing) = ((0.0, 0), (0.0, 0));
        verdict.filter(|_| self.verdicts >= VERDICTS)
    }
}
