//! Dry friction of all that moves, and the scheme that steps motor and friction.

use super::motor;
use crate::plant::actuator::{Actuator, Load};
use crate::plant::borello::Borello;
use crate::plant::euler::{self, Accumulator};
use crate::plant::karnopp::Karnopp;
use crate::plant::parameters::{ParameterError, Parameters as Plant};
use crate::plant::{Compensated, InputRefused, Motion, State};

/// Levels, referred to the motor's shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters {
    /// Friction while sliding, N·m, ≥ 0.
    pub coulomb: f32,
    /// Friction that holds at rest, N·m; raised to the Coulomb level where it is below it.
    pub breakaway: f32,
}

/// How motor and friction are stepped.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Scheme {
    /// Euler steps with a velocity band: [`crate::plant::karnopp`].
    Karnopp {
        /// Half the width of the band, rad/s of the motor, > 0.
        band: f32,
    },
    /// Euler steps with a zero crossing: [`crate::plant::borello`].
    Borello,
    /// Exact steps with events: [`crate::plant::actuator`]. Exact while the motor's torque stays
    /// below its peak. Above it, what exceeds the peak in the middle of a step is taken off as a
    /// torque held over that step, an error of second order in the step.
    Exact,
}

/// A scheme at work.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "there is no allocation")]
pub(super) enum Mechanism {
    Karnopp(Karnopp),
    Borello(Borello),
    Exact(Actuator),
}

impl Mechanism {
    pub(super) fn build(
        scheme: Scheme,
        plant: &Plant,
        peak_torque: f32,
        period: f32,
    ) -> Result<Self, ParameterError> {
        Ok(match scheme {
            Scheme::Karnopp { band } => {
                Self::Karnopp(Karnopp::build(plant, period, band)?.with_torque_limit(peak_torque)?)
            }
            Scheme::Borello => {
                Self::Borello(Borello::build(plant, period)?.with_torque_limit(peak_torque)?)
            }
            Scheme::Exact => {
                euler::above_zero("torque limit", peak_torque)?;
                Self::Exact(Actuator::build(plant, period)?)
            }
        })
    }

    pub(super) fn set_friction(&mut self, friction: Parameters) {
        let Parameters { coulomb, breakaway } = friction;
        match self {
            Self::Karnopp(scheme) => scheme.set_friction(coulomb, breakaway),
            Self::Borello(scheme) => scheme.set_friction(coulomb, breakaway),
            Self::Exact(actuator) => actuator.set_friction(coulomb, breakaway),
        }
    }

    /// So many steps with a voltage held over them.
    pub(super) fn advance(
        &self,
        state: &mut State,
        motor: &motor::Parameters,
        voltage: f32,
        steps: u16,
    ) -> Result<(), InputRefused> {
        match self {
            Self::Karnopp(scheme) => by_euler(scheme, state, voltage, steps),
            Self::Borello(scheme) => by_euler(scheme, state, voltage, steps),
            Self::Exact(actuator) => {
                for _ in 0..steps {
                    let declared = actuator.load();
                    let (current, ..) = actuator.middle(state, voltage, &declared);
                    let excess = motor.torque_constant * current - motor.torque(current);
                    let load = Load {
                        torque: declared.torque - excess,
                        ..declared
                    };
                    actuator.step_under(state, voltage, &load)?;
                }
                Ok(())
            }
        }
    }
}

/// Euler steps of the state of an [`Actuator`] with an input held over them.
#[inline]
pub(in crate::plant) fn by_euler<F: euler::FrictionRule>(
    scheme: &euler::Euler<F>,
    state: &mut State,
    input: f32,
    steps: u16,
) -> Result<(), InputRefused> {
    let mut stepped = euler::State::<Compensated> {
        current: state.current,
        velocity: state.velocity,
        position: state.position,
    };
    for _ in 0..steps {
        scheme.step(&mut stepped, input)?;
    }
    *state = State {
        current: stepped.current,
        velocity: stepped.velocity,
        position: stepped.position,
        motion: Motion::of(Accumulator::value(stepped.velocity)),
    };
    Ok(())
}
