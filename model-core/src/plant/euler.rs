//! A brushed-DC actuator by Euler steps under a friction rule: what the published schemes share.
//!
//! The rule says what counts as rest, and when a motion ends in it. Everything else is the same for
//! all of them: at rest friction equals the active load up to the breakaway level, in motion it is
//! Coulomb's against the velocity; current, velocity and position follow by Euler's rule.

use super::actuator::{INPUT_LIMIT, Load};
use super::parameters::{Drive, ParameterError, Parameters};
use super::{Compensated, InputRefused};

/// What a published friction scheme decides.
pub trait FrictionRule {
    /// The velocity that friction, winding and position see; zero is rest.
    fn seen(&self, velocity: f32) -> f32;

    /// The velocity at the end of a step that led from one velocity to another.
    fn settled(&self, before: f32, after: f32) -> f32;
}

/// A velocity or a position that increments are added to: a plain `f32` as in the published schemes,
/// or [`Compensated`], which does not lose those below half a unit in its last place.
pub trait Accumulator: Copy + From<f32> {
    /// Rounded to `f32`.
    fn value(self) -> f32;

    /// Adds an increment.
    fn add(&mut self, increment: f32);
}

impl Accumulator for f32 {
    #[inline]
    fn value(self) -> f32 {
        self
    }

    #[inline]
    fn add(&mut self, increment: f32) {
        *self += increment;
    }
}

impl Accumulator for Compensated {
    #[inline]
    fn value(self) -> f32 {
        self.value()
    }

    #[inline]
    fn add(&mut self, increment: f32) {
        self.advance(increment);
    }
}

impl From<f32> for Compensated {
    fn from(value: f32) -> Self {
        Self::new(value)
    }
}

/// State of a scheme.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State<A = f32> {
    /// Motor current, A; with a torque input the torque.
    pub current: f32,
    /// Velocity, rad/s or m/s.
    pub velocity: A,
    /// Position, rad or m.
    pub position: A,
}

/// A scheme, built for one step period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Euler<F> {
    parameters: Parameters,
    load: Load,
    torque_limit: f32,
    period: f32,
    rule: F,
}

pub(super) fn above_zero(parameter: &'static str, value: f32) -> Result<(), ParameterError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(ParameterError {
            parameter,
            requirement: "above 0",
        })
    }
}

impl<F: FrictionRule> Euler<F> {
    pub(super) fn with_rule(
        parameters: &Parameters,
        period: f32,
        rule: F,
    ) -> Result<Self, ParameterError> {
        parameters.check()?;
        above_zero("period", period)?;
        if let Drive::Voltage {
            resistance,
            inductance,
            ..
        } = parameters.drive
            && inductance > 0.0
            && period * resistance > 2.0 * inductance
        {
            return Err(ParameterError {
                parameter: "period",
                requirement: "at most twice the winding's time constant",
            });
        }
        let load = Load::declared(parameters);
        Ok(Self {
            parameters: Parameters {
                breakaway: load.breakaway,
                ..*parameters
            },
            load,
            torque_limit: f32::INFINITY,
            period,
            rule,
        })
    }

    /// The same with a motor whose torque saturates at ±`limit` N·m or N.
    ///
    /// # Errors
    /// A limit that is not above 0 and finite.
    pub fn with_torque_limit(self, limit: f32) -> Result<Self, ParameterError> {
        above_zero("torque limit", limit)?;
        Ok(Self {
            torque_limit: limit,
            ..self
        })
    }

    /// Sets the friction levels, as [`Load::set_friction`].
    pub fn set_friction(&mut self, coulomb: f32, breakaway: f32) {
        self.load.set_friction(coulomb, breakaway);
    }

    /// One Euler step.
    ///
    /// # Errors
    /// [`InputRefused`] for an input that is not finite or beyond [`INPUT_LIMIT`], and where the step
    /// would leave the range of `f32`; the state is unchanged.
    #[inline]
    pub fn step<A: Accumulator>(
        &self,
        state: &mut State<A>,
        input: f32,
    ) -> Result<(), InputRefused> {
        let accepted = input.abs() <= INPUT_LIMIT;
        if !accepted {
            return Err(InputRefused);
        }
        let mut next = *state;
        let before = state.velocity.value();
        let speed = self.rule.seen(before);
        next.current = self.current(state.current, speed, input);
        let drive = self.drive(next.current, state.position.value());
        let friction = self.friction(speed, drive);
        if speed == 0.0 && friction == drive {
            next.velocity = A::from(0.0);
        } else {
            next.velocity
                .add((drive - friction) / self.parameters.inertia * self.period);
            let after = next.velocity.value();
            let settled = self.rule.settled(before, after);
            if settled != after {
                next.velocity = A::from(settled);
            }
        }
        next.position
            .add(self.rule.seen(next.velocity.value()) * self.period);
        self.confine(&mut next);
        let values = [next.current, next.velocity.value(), next.position.value()];
        if !values.iter().all(|value| value.is_finite()) {
            return Err(InputRefused);
        }
        *state = next;
        Ok(())
    }

    fn current(&self, current: f32, speed: f32, input: f32) -> f32 {
        let p = &self.parameters;
        match p.drive {
            Drive::Voltage {
                resistance,
                inductance,
                torque_constant,
            } => {
                let voltage = p.gain * input - torque_constant * speed;
                if inductance > 0.0 {
                    current + (voltage - resistance * current) / inductance * self.period
                } else {
                    voltage / resistance
                }
            }
            Drive::Torque => p.gain * input,
        }
    }

    /// The active load: motor, spring and offset.
    fn drive(&self, current: f32, position: f32) -> f32 {
        let p = &self.parameters;
        let deflection = position - p.spring_rest;
        let preload = if deflection == 0.0 {
            0.0
        } else {
            p.spring_preload.copysign(deflection)
        };
        let motor = (p.torque_per_current() * current).clamp(-self.torque_limit, self.torque_limit);
        motor + self.load.torque - p.spring * deflection - preload
    }

    fn friction(&self, speed: f32, drive: f32) -> f32 {
        let viscous = self.parameters.viscous;
        let Load {
            coulomb, breakaway, ..
        } = self.load;
        if speed > 0.0 {
            coulomb.forward + viscous.forward * speed
        } else if speed < 0.0 {
            viscous.backward * speed - coulomb.backward
        } else {
            drive.clamp(-breakaway.backward, breakaway.forward)
        }
    }

    /// An end stop ends the motion that runs into it.
    fn confine<A: Accumulator>(&self, state: &mut State<A>) {
        let p = &self.parameters;
        let position = state.position.value();
        let velocity = state.velocity.value();
        let stop = if position >= p.upper_stop && velocity > 0.0 {
            p.upper_stop
        } else if position <= p.lower_stop && velocity < 0.0 {
            p.lower_stop
        } else {
            return;
        };
        state.position = A::from(stop);
        state.velocity = A::from(0.0);
    }
}
