//! Speed and position kept within limits, in every mode: the range of the motor's current is narrowed so that the actuator
//! goes no faster than its limit, and comes to rest at the end of its range.
//!
//! The momentum obeys J dω/dt = k i − T, with a torque *T* that holds friction, spring and load. That is the
//! equation of a [winding](super::current_limit) without resistance: (J/k) dω/dt = i − T/k. So the same loop that keeps a
//! current below its limit by the voltage keeps the speed below its limit by the current, with T/k observed: at rest
//! the speed is the limit itself, whatever load and friction are.
//!
//! # Constants
//! The speed is the encoder's mean over a control period *h*, so half a period old; a current is held for another one, in the
//! mean half of it old, comes a tick late, and has a time constant of a fifth: a dead time of 1.25 h. Twice that, as the
//! magnitude optimum has it, and a gain that is off by 1.2/0.8 as an inertia and a torque constant within their tolerances make
//! it, gives τ = 3.75 h, so 4 h; the observer's time constant is 3 τ as in the winding.
//!
//! Towards the end of the range, *d* away at the speed ω, the speed's limit is the lesser of d′/(2 τ) and √(2 a d′) with
//! d′ = d − τ ω, where the actuator is when the loop has acted. In the linear part that makes
//! τ d̈ + (3/2) ḋ + d/(2 τ) = 0, whose poles −1/τ and −1/2τ do not overshoot. The deceleration *a* is half of what the
//! current's limit, and the supply's at the highest speed, make of the largest inertia, the weakest magnets and the load,
//! without friction: the other half is for the loop.

use model_core::numeric::invalid_parameter::InvalidParameter;

use super::current_limit;
use super::supply_limit;
use crate::app::fault::observer::{Reading, Tolerances};
use crate::app::machine::Machine;
use crate::app::square_root::square_root;
use crate::app::timing::CONTROL_PERIOD;

/// τ in control periods.
const PERIODS: f32 = 4.0;

/// τ, s.
pub const TIME_CONSTANT: f32 = PERIODS * CONTROL_PERIOD;

/// A position that is no limit, either way, rad: the bound of the parameters.
pub const NO_POSITION: f32 = 1e3;

/// What the motion is kept within.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Most speed, rad/s either way; 0 for none.
    pub speed: f32,
    /// Least and most position, rad; [`NO_POSITION`] either way is none.
    pub position: [f32; 2],
}

impl Limits {
    /// Whether there is one of the position: then that has to be known.
    pub fn has_position(&self) -> bool {
        let [lower, upper] = self.position;
        lower > -NO_POSITION || upper < NO_POSITION
    }

    /// That set points from the least to the most are within the position's limits, rad.
    ///
    /// # Errors
    /// They are not.
    pub fn check(&self, [least, most]: [f32; 2]) -> Result<(), InvalidParameter> {
        let [lower, upper] = self.position;
        let inside = !self.has_position() || (least >= lower && most <= upper);
        inside.then_some(()).ok_or(InvalidParameter {
            name: "signal",
            requirement: "must stay from position_minimum to position_maximum",
        })
    }
}

/// The limiter's numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    limits: Limits,
    limiter: current_limit::Coefficients,
    /// Most current, A.
    current: f32,
    /// Of the approach to a limit of the position, rad/s².
    deceleration: f32,
    /// Beyond which the limiter has failed, rad/s; none without a limit.
    too_fast: Option<f32>,
}

/// What it remembers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    limiter: current_limit::State,
    /// Current of the step before.
    before: Option<f32>,
    /// Whether the position was within its limits since the drive was armed.
    was_within: bool,
}

/// What a step says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verdict {
    /// Range of the current, A, the least first.
    pub range: [f32; 2],
    /// Whether the speed is beyond what the limiter lets pass.
    pub too_fast: bool,
}

impl Coefficients {
    /// For a machine with a winding of this torque constant, N·m/A, at this supply.
    ///
    /// # Errors
    /// Limits that are none, or a position that is to be kept against a load that is too much for the current.
    pub fn new(
        machine: &Machine,
        torque_constant: f32,
        supply: &supply_limit::Coefficients,
    ) -> Result<Self, InvalidParameter> {
        let Tolerances {
            torque_constant: weaker,
            inertia: heavier,
            mechanics,
            ..
        } = Tolerances::INDUSTRIAL;
        let limits = machine.motion;
        let current = machine.limits.current();
        let plant = &machine.plant;
        let [lower, upper] = limits.position;
        if lower.is_nan() || upper.is_nan() || lower >= upper {
            return Err(InvalidParameter {
                name: "position_minimum",
                requirement: "must be below position_maximum",
            });
        }
        let load = machine.limits.load;
        let left = |current: f32| (1.0 - weaker) * torque_constant * current - load;
        // The back-EMF of the highest speed: the limit's, or what the supply can drive to.
        let [lowest, highest] = machine.limits.supply;
        let fastest = match limits.speed {
            0.0 => highest,
            speed => highest.min((1.0 + weaker) * torque_constant * speed),
        };
        let braking = left(current.min(supply.braking(fastest, lowest)));
        if limits.has_position() && braking <= 0.0 {
            const HELD: &str = "must hold the load, for a position that is limited";
            let (name, requirement) = if left(current) <= 0.0 {
                ("current_limit", HELD)
            } else if left(supply.holding(lowest)) <= 0.0 {
                ("supply_current_limit", HELD)
            } else {
                (
                    "regeneration_limit",
                    "must brake the load, for a position that is limited",
                )
            };
            return Err(InvalidParameter { name, requirement });
        }
        // A load that turns round, and friction that is there no more.
        let friction = plant.breakaway.forward.max(plant.breakaway.backward);
        let change = 2.0 * load + 2.0 * (1.0 + mechanics) * friction;
        let overshoot = change * TIME_CONSTANT / ((1.0 - heavier) * plant.inertia)
            + 2.0 * machine.converters.position.unit() / CONTROL_PERIOD;
        let inertia = plant.inertia / torque_constant;
        Ok(Self {
            limits,
            limiter: current_limit::Coefficients::of_loop(0.0, inertia, CONTROL_PERIOD, PERIODS),
            current,
            deceleration: 0.5 * braking.max(0.0) / ((1.0 + heavier) * plant.inertia),
            too_fast: (limits.speed > 0.0).then_some(limits.speed + overshoot),
        })
    }

    /// Most speed towards a limit that is this far ahead, rad. Beyond it the actuator is brought back if it was within since
    /// the drive was armed, no faster than `most`. Else it only goes no farther: a drive that is armed begins where the
    /// actuator is.
    fn approach(&self, distance: f32, was_within: bool, most: f32) -> f32 {
        let linear = distance / (2.0 * TIME_CONSTANT);
        if distance > 0.0 {
            linear.min(square_root(2.0 * self.deceleration * distance))
        } else if was_within {
            linear.max(-most)
        } else {
            0.0
        }
    }

    /// Takes a control step's reading.
    pub fn step(&self, state: &mut State, reading: &Reading) -> Verdict {
        let &Reading {
            position,
            moved,
            current,
            ..
        } = reading;
        let free = Verdict {
            range: [-self.current, self.current],
            too_fast: false,
        };
        let finite = [position, moved, current].into_iter().all(f32::is_finite);
        let before = state.before.filter(|_| finite && reading.voltage.is_some());
        state.before = finite.then_some(current);
        let Some(current_before) = before else {
            state.limiter = current_limit::State::default();
            state.was_within = false;
            return free;
        };
        let speed = moved / CONTROL_PERIOD;
        let most = match self.limits.speed {
            // Finite, as infinity times no resistance is no number.
            0.0 => f32::MAX,
            most => most,
        };
        let mut speeds = [-most, most];
        if self.limits.has_position() {
            let ahead = position + TIME_CONSTANT * speed;
            let [lower, upper] = self.limits.position;
            state.was_within |= position >= lower && position <= upper;
            let within = state.was_within;
            speeds[0] = speeds[0].max(-self.approach(ahead - lower, within, most));
            speeds[1] = speeds[1].min(self.approach(upper - ahead, within, most));
        }
        let mean = 0.5 * (current_before + current);
        let range = self
            .limiter
            .step(&mut state.limiter, speed, Some(mean), speeds)
            .map(|current| current.min(self.current).max(-self.current));
        Verdict {
            range,
            too_fast: self.too_fast.is_some_and(|most| speed.abs() > most),
        }
    }
}
