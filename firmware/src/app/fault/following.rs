//! The encoder against the torque: a rotor that is pushed harder than its friction and its load can hold
//! it moves, and its encoder says so.
//!
//! The declared mechanics run beside the drive, with the measured current and the encoder's speed as
//! their input. Over a control period *h* their momentum changes by
//!
//! J Δω = (k i − b ω − F − s(θ) + o − T) h,
//!
//! with friction *F*, the return spring's torque *s*, the declared constant torque *o*, and a load *T* that
//! nobody measures. So what is left of the torque,
//!
//! r = k i − J Δω/h − b ω − s + o,
//!
//! is F + T. While the encoder says that the rotor slides, F lies between the Coulomb and the breakaway
//! level against the motion, while it stands still between the breakaway levels of both directions; T is
//! at most the declared load, either way. Numbers within their tolerances widen that by
//!
//! δk k |i| + k |Δi|/4 + δJ J |Δω|/h + δm (b |ω| + |s|).
//!
//! The second term is what two means of the current, of two periods, may be off from the current that
//! made Δω: that is weighed by a triangle over both, whose integral is nowhere more than an eighth from that
//! of the mean, and a current that is monotone over both changes by twice the difference of its means.
//!
//! Excess over the interval's ends goes through a first-order filter each, with the time constant *τ* of the
//! [winding's](super::back_emf) monitor, and what stays within in every period stays within behind it. Reading in
//! steps of *q* rad is off by half a step at most, which the second difference and the filter make
//! J q (1 + h/τ)/(τ h) of, and the viscous friction b q/τ. Hence an excess beyond the two is
//! [`Fault::FollowingError`]: the encoder stands still, counts too little, or the wrong way round; or the
//! actuator is blocked where it should not be, against which the drive should push no more than against its
//! load either. No debounce, no number that was tried out.
//!
//! An actuator that stands still under the current
//!
//! I = ((1 + δm) breakaway + T)/((1 − δk) k)
//!
//! is told from one that is held by its load from there on: at 1.1 I within three time constants. Less than that,
//! friction and load may hold in truth. What the winding's monitor finds, it finds by speed, this one
//! by torque: before the rotor is fast, and when it is at a stop that its encoder has not reached.
//!
//! The end stops take any torque, so nothing counts that pushes towards one in its reach.

use model_core::numeric::invalid_parameter::InvalidParameter;
use model_core::plant::Directional;
use model_core::plant::parameters::{Drive, Parameters};

use super::Fault;
use super::observer::{Reading, TIME_CONSTANT, Tolerances, check_encoder};

/// An interval of torques, N·m.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Range {
    low: f32,
    high: f32,
}

/// The monitor's numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    torque_constant: f32,
    /// J/h.
    inertia: f32,
    viscous: Directional,
    coulomb: Directional,
    breakaway: Directional,
    spring: f32,
    spring_rest: f32,
    spring_preload: f32,
    offset: f32,
    /// Where the lower stop's reach ends and the upper one's begins, rad or m.
    reach: [f32; 2],
    tolerances: Tolerances,
    /// Most load, N·m or N.
    load: f32,
    /// One step of the encoder, rad or m.
    resolution: f32,
    /// What the encoder's steps may make, N·m or N.
    quantisation: f32,
    period: f32,
    /// h/τ.
    gain: f32,
}

/// What is remembered of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Step {
    current: f32,
    /// Whether it is in reach of the lower and the upper stop.
    in_reach: [bool; 2],
    /// The period that it ended; none before the second step.
    motion: Option<Motion>,
}

/// A period.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Motion {
    /// Mean speed, rad/s or m/s.
    speed: f32,
    /// What friction may have been.
    friction: Range,
    /// Whether it began in reach of the lower and the upper stop.
    from_reach: [bool; 2],
}

/// What the monitor remembers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    before: Option<Step>,
    /// Filtered excess above the interval, and below it, N·m or N; negative inside.
    above: f32,
    below: f32,
}

impl Coefficients {
    /// For an actuator that bears a load of up to `load`, N·m or N, either way, an encoder with steps of
    /// `resolution`, rad or m, and a control period, s. Lost motion and an elastic shaft are a load.
    ///
    /// # Errors
    /// The drive is no voltage, or a number is out of its range.
    pub fn new(
        plant: &Parameters,
        tolerances: Tolerances,
        load: f32,
        resolution: f32,
        period: f32,
    ) -> Result<Self, InvalidParameter> {
        let refused = |name, requirement| Err(InvalidParameter { name, requirement });
        let Drive::Voltage {
            torque_constant, ..
        } = plant.drive
        else {
            return refused("drive", "must be a voltage");
        };
        check_encoder(resolution, period)?;
        if !(load >= 0.0 && load.is_finite()) {
            return refused("load", "must be at least 0");
        }
        tolerances.check()?;
        let Parameters {
            inertia,
            viscous,
            coulomb,
            breakaway,
            spring,
            spring_rest,
            spring_preload,
            offset,
            lower_stop,
            upper_stop,
            ..
        } = *plant;
        let reach = tolerances.stop * (upper_stop - lower_stop) + resolution;
        // Without a stop on one side the other one's reach has no measure, and there is none.
        let reach = if reach.is_finite() { reach } else { 0.0 };
        let gain = period / TIME_CONSTANT;
        Ok(Self {
            torque_constant,
            inertia: inertia / period,
            viscous,
            coulomb,
            breakaway: Directional {
                forward: breakaway.forward.max(coulomb.forward),
                backward: breakaway.backward.max(coulomb.backward),
            },
            spring,
            spring_rest,
            spring_preload,
            offset,
            reach: [lower_stop + reach, upper_stop - reach],
            tolerances,
            load,
            resolution,
            quantisation: (inertia * (1.0 + gain) / period + viscous.forward.max(viscous.backward))
                * resolution
                / TIME_CONSTANT,
            period,
            gain,
        })
    }

    /// What friction may be over a period in which the encoder moved by this much.
    fn friction(&self, moved: f32) -> Range {
        let less = 1.0 - self.tolerances.mechanics;
        let more = 1.0 + self.tolerances.mechanics;
        // One step of the encoder says nothing of the direction.
        if moved > self.resolution {
            Range {
                low: less * self.coulomb.forward,
                high: more * self.breakaway.forward,
            }
        } else if moved < -self.resolution {
            Range {
                low: -more * self.breakaway.backward,
                high: -less * self.coulomb.backward,
            }
        } else {
            Range {
                low: -more * self.breakaway.backward,
                high: more * self.breakaway.forward,
            }
        }
    }

    /// The return spring's torque, against positive motion, and what it may be off by.
    fn spring(&self, position: f32) -> (f32, f32) {
        let from_rest = position - self.spring_rest;
        // The preload changes its sign within a step of the encoder.
        let (preload, unknown) = if from_rest.abs() > self.resolution {
            (self.spring_preload.copysign(from_rest), 0.0)
        } else {
            (0.0, self.spring_preload)
        };
        let torque = self.spring * from_rest + preload;
        (torque, self.tolerances.mechanics * torque.abs() + unknown)
    }

    /// Takes a reading: [`Fault::FollowingError`] as long as the encoder does not follow. A reading that is
    /// not finite is none, and the monitor begins anew; so it does with the bridge off.
    pub fn step(&self, state: &mut State, reading: &Reading) -> Option<Fault> {
        let &Reading {
            position,
            moved,
            current,
            voltage,
            ..
        } = reading;
        let finite = [position, moved, current].into_iter().all(f32::is_finite);
        let driven = voltage.is_some_and(f32::is_finite);
        let mut now = Step {
            current,
            in_reach: [position <= self.reach[0], position >= self.reach[1]],
            motion: None,
        };
        let Some(before) = state.before.filter(|_| finite && driven) else {
            *state = State {
                before: finite.then_some(now),
                ..State::default()
            };
            return None;
        };
        let speed = moved / self.period;
        let friction = self.friction(moved);
        now.motion = Some(Motion {
            speed,
            friction,
            from_reach: before.in_reach,
        });
        state.before = Some(now);
        let motion_before = before.motion?;

        let viscous = if moved < 0.0 {
            self.viscous.backward
        } else {
            self.viscous.forward
        } * speed;
        let (spring, spring_unknown) = self.spring(position);
        let Tolerances {
            torque_constant,
            inertia,
            mechanics,
            ..
        } = self.tolerances;
        let mean = 0.5 * (before.current + current);
        let accelerating = self.inertia * (speed - motion_before.speed);
        let left = self.torque_constant * mean - accelerating - viscous - spring + self.offset;
        let unknown = self.load
            + self.torque_constant
                * (torque_constant * mean.abs() + 0.25 * (current - before.current).abs())
            + inertia * accelerating.abs()
            + mechanics * viscous.abs()
            + spring_unknown;
        let mut above = left - 0.5 * (friction.high + motion_before.friction.high) - unknown;
        let mut below = 0.5 * (friction.low + motion_before.friction.low) - unknown - left;
        // In reach at any of the three readings that the acceleration is made of.
        let touched = |side: usize| {
            now.in_reach[side] || before.in_reach[side] || motion_before.from_reach[side]
        };
        if touched(0) {
            below = below.min(0.0);
        }
        if touched(1) {
            above = above.min(0.0);
        }
        state.above += self.gain * (above - state.above);
        state.below += self.gain * (below - state.below);
        let follows = state.above <= self.quantisation && state.below <= self.quantisation;
        (!follows).then_some(Fault::FollowingError)
    }
}
