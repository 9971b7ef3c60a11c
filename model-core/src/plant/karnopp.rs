//! Karnopp's velocity-band friction by Euler steps: the published scheme, for comparison.
//!
//! Inside a band |ω| < Dv the velocity counts as zero and friction balances the drive up to the
//! breakaway level; outside it friction is Coulomb's (D. Karnopp, *Computer simulation of
//! stick-slip friction in mechanical dynamic systems*, 1985; the prognostics paper's CSJ model).
//! It needs steps far below the electrical time constant, and in `f32` such steps are too small
//! for the position to notice: over a sweep of 90 rad, steps of 1 µs are off by 22 mrad rms, those
//! of [`crate::plant::actuator`] by 3 µrad with 100 µs. That one is what the project uses.

use super::actuator::INPUT_LIMIT;
use super::parameters::{Drive, ParameterError, Parameters};
use super::{Directional, InputRefused};

/// The scheme, built for one step period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Karnopp {
    parameters: Parameters,
    period: f32,
    band: f32,
}

/// State of the scheme. The position is a plain `f32`, as the published scheme has it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    /// Motor current, A; with a torque input the torque.
    pub current: f32,
    /// Velocity, rad/s or m/s.
    pub velocity: f32,
    /// Position, rad or m.
    pub position: f32,
}

impl Karnopp {
    /// Euler steps of `period` seconds with a velocity band of `band` rad/s or m/s (the prognostics
    /// paper's kind of model takes about a thousandth of the top speed).
    ///
    /// # Errors
    /// A parameter outside its range; a period or a band that is not above 0; a winding whose time
    /// constant is below half the period, for which Euler's rule diverges.
    pub fn build(parameters: &Parameters, period: f32, band: f32) -> Result<Self, ParameterError> {
        parameters.check()?;
        let above_zero = |parameter, value: f32| {
            if value > 0.0 && value.is_finite() {
                Ok(())
            } else {
                Err(ParameterError {
                    parameter,
                    requirement: "above 0",
                })
            }
        };
        above_zero("period", period)?;
        above_zero("band", band)?;
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
        let raised = |breakaway: f32, coulomb: f32| breakaway.max(coulomb);
        let breakaway = Directional {
            forward: raised(parameters.breakaway.forward, parameters.coulomb.forward),
            backward: raised(parameters.breakaway.backward, parameters.coulomb.backward),
        };
        Ok(Self {
            parameters: Parameters {
                breakaway,
                ..*parameters
            },
            period,
            band,
        })
    }

    /// One Euler step.
    ///
    /// # Errors
    /// [`InputRefused`] for an input that is not finite or beyond [`INPUT_LIMIT`].
    pub fn step(&self, state: &mut State, input: f32) -> Result<(), InputRefused> {
        let accepted = input.abs() <= INPUT_LIMIT;
        if !accepted {
            return Err(InputRefused);
        }
        let p = &self.parameters;
        let at_rest = state.velocity.abs() < self.band;
        let speed = if at_rest { 0.0 } else { state.velocity };
        match p.drive {
            Drive::Voltage {
                resistance,
                inductance,
                torque_constant,
            } => {
                let voltage = p.gain * input - torque_constant * speed;
                if inductance > 0.0 {
                    state.current +=
                        (voltage - resistance * state.current) / inductance * self.period;
                } else {
                    state.current = voltage / resistance;
                }
            }
            Drive::Torque => state.current = p.gain * input,
        }
        let deflection = state.position - p.spring_rest;
        let preload = if deflection == 0.0 {
            0.0
        } else {
            p.spring_preload.copysign(deflection)
        };
        let drive =
            p.torque_per_current() * state.current + p.offset - p.spring * deflection - preload;
        let friction = if at_rest {
            drive.clamp(-p.breakaway.backward, p.breakaway.forward)
        } else if speed > 0.0 {
            p.coulomb.forward + p.viscous.forward * speed
        } else {
            p.viscous.backward * speed - p.coulomb.backward
        };
        state.velocity = if at_rest && friction == drive {
            0.0
        } else {
            state.velocity + (drive - friction) / p.inertia * self.period
        };
        let moved = if state.velocity.abs() < self.band {
            0.0
        } else {
            state.velocity
        };
        state.position += moved * self.period;
        if state.position >= p.upper_stop && state.velocity > 0.0 {
            state.position = p.upper_stop;
            state.velocity = 0.0;
        }
        if state.position <= p.lower_stop && state.velocity < 0.0 {
            state.position = p.lower_stop;
            state.velocity = 0.0;
        }
        Ok(())
    }
}
