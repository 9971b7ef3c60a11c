//! The brushed-DC actuator: motor, rotor and load, friction, return spring, end stops.
//!
//! In a *mode* (at rest, or sliding one way, on one side of the spring's rest) the actuator is an
//! affine system. A step is exact for an input held over it; an *event* (standstill, breakaway,
//! the spring's rest, an end stop) ends a mode inside the step. What is left is the rounding of
//! `f32`: 3 µrad rms over a sweep of 90 rad in 10 s.
//!
//! * [`parameters`]: what the actuator is made of, in SI, and the check of it;
//! * [`modes`]: the affine modes, discretised at the step and at its halves, quarters, …;
//! * [`mode_store`]: modes that several actuators share;
//! * [`actuator`]: the step itself, with its events;
//! * [`batch`]: many actuators at once, with the same bits;
//! * [`euler`]: the same actuator by Euler steps, under a published friction rule: [`karnopp`]'s
//!   velocity band or [`borello`]'s zero crossing, for comparison;
//! * [`ema`]: the whole servo of the prognostics paper, from its position command to its rod;
//! * [`mod@bench`]: the test bench of a synchronous motor, from its position command to its encoder;
//! * [`piecewise_affine`]: a model without physics, learned from input and output;
//! * [`inter_sample`]: its position between its samples;
//! * [`throttle`]: an actuator behind a [`bridge`], read by two tracks of a [`potentiometer`], with
//!   the faults that an engine controller has to find;
//! * [`rise_time`]: the inertia that gives the rise time of a real part.

pub mod actuator;
pub mod batch;
pub mod bench;
pub mod borello;
pub mod bridge;
pub mod ema;
pub mod euler;
pub mod inter_sample;
pub mod karnopp;
pub(crate) mod lanes;
pub mod mode_store;
pub mod modes;
pub mod parameters;
pub mod piecewise_affine;
pub mod potentiometer;
pub mod rise_time;
pub mod throttle;

/// Longest period that a model can be stepped by, s.
pub const LONGEST_PERIOD: f32 = 10.0;

/// Direction of motion, or rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Motion {
    /// Held by friction or by a stop; the velocity is exactly zero.
    #[default]
    Rest,
    /// Towards larger positions.
    Forward,
    /// Towards smaller positions.
    Backward,
}

impl Motion {
    /// The direction of a velocity; rest at zero.
    pub fn of(velocity: f32) -> Self {
        if velocity > 0.0 {
            Self::Forward
        } else if velocity < 0.0 {
            Self::Backward
        } else {
            Self::Rest
        }
    }

    /// 1 forwards, −1 backwards, 0 at rest.
    pub fn sign(self) -> f32 {
        match self {
            Self::Forward => 1.0,
            Self::Backward => -1.0,
            Self::Rest => 0.0,
        }
    }
}

/// A value for each direction of motion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Directional {
    /// While the position grows.
    pub forward: f32,
    /// While the position falls.
    pub backward: f32,
}

impl Directional {
    /// The same value in both directions.
    pub const fn both(value: f32) -> Self {
        Self {
            forward: value,
            backward: value,
        }
    }

    /// The value of the way that a displacement goes; forward without one.
    #[inline]
    pub fn of(self, displacement: f32) -> f32 {
        if displacement < 0.0 {
            self.backward
        } else {
            self.forward
        }
    }

    /// Both values times a factor.
    pub fn scaled(self, factor: f32) -> Self {
        Self {
            forward: self.forward * factor,
            backward: self.backward * factor,
        }
    }
}

/// A state that loses no increment: the value and what rounding kept from it.
///
/// At 100 rad a step of 1 µs at 1 rad/s is less than half a unit in the last place of an `f32`,
/// and so is, at 150 rad/s, the change of speed over 100 µs once a motor with a time constant of
/// 30 ms is within 2 mrad/s of its final speed. The remainder carries both until they count.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Compensated {
    value: f32,
    remainder: f32,
}

impl Compensated {
    /// A value without remainder.
    pub const fn new(value: f32) -> Self {
        Self {
            value,
            remainder: 0.0,
        }
    }

    /// Rounded to `f32`.
    #[inline]
    pub fn value(self) -> f32 {
        self.value
    }

    /// Distance from `origin`, which keeps the remainder.
    #[inline]
    pub fn from(self, origin: f32) -> f32 {
        (self.value - origin) + self.remainder
    }

    /// What [`Compensated::value`] is after an increment.
    #[inline]
    pub fn after(self, increment: f32) -> f32 {
        self.value + (self.remainder + increment)
    }

    /// Adds an increment that is small beside the value (Dekker's fast two-sum).
    #[inline]
    pub fn advance(&mut self, increment: f32) {
        let carried = self.remainder + increment;
        let sum = self.value + carried;
        self.remainder = carried - (sum - self.value);
        self.value = sum;
    }
}

/// What the actuator is doing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct State {
    /// Motor current, A. With a torque input: the motor torque or force, N·m or N.
    pub current: f32,
    /// Velocity, rad/s or m/s.
    pub velocity: Compensated,
    /// Position, rad or m.
    pub position: Compensated,
    /// Direction of motion; `Rest` only with a velocity of zero.
    pub motion: Motion,
}

impl State {
    /// At a position, with a velocity and without current.
    pub fn new(position: f32, velocity: f32) -> Self {
        Self {
            current: 0.0,
            velocity: Compensated::new(velocity),
            position: Compensated::new(position),
            motion: Motion::of(velocity),
        }
    }

    /// Whether each of its numbers is one.
    pub(crate) fn is_finite(&self) -> bool {
        // The remainders are finite where the values are.
        let [velocity, position] = [self.velocity, self.position].map(|sum| sum.from(0.0));
        self.current.is_finite() && velocity.is_finite() && position.is_finite()
    }
}

/// An input that the step does not take: not finite, beyond [`actuator::INPUT_LIMIT`], or one under
/// which the state would leave the range of `f32`. The state is unchanged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct InputRefused;

impl core::fmt::Display for InputRefused {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        formatter.write_str("input is not finite or beyond the limit")
    }
}

impl core::error::Error for InputRefused {}
