//! The inertia that gives a throttle the rise time of the real part.
//!
//! From its lower stop a constant voltage drives the plate to its upper one; the rise time is that
//! from 10 to 90 % of the stroke. It grows with the inertia, so halving an interval finds it.

use super::State;
use super::actuator::Actuator;
use super::parameters::{ParameterError, Parameters};

/// How far the inertia may go from the declared one, as a factor either way.
const REACH: f32 = 1e3;

/// Halvings of the interval, in the inertia's logarithm: to 1e-6 of it.
const HALVINGS: u32 = 24;

/// Longest rise that is followed, in steps.
const STEPS: u32 = 200_000;

/// Why there is no such inertia.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RiseTimeError {
    /// A parameter or the period is out of its range.
    Parameter(ParameterError),
    /// The voltage does not take the plate through 90 % of a finite stroke in 200,000 steps.
    NotReached,
    /// The rise times, s, that a thousandth and a thousandfold of the declared inertia give: what
    /// was asked for lies outside.
    OutOfRange {
        /// With the smallest inertia.
        shortest: f32,
        /// With the largest inertia, or the longest that is followed.
        longest: f32,
    },
}

impl From<ParameterError> for RiseTimeError {
    fn from(error: ParameterError) -> Self {
        Self::Parameter(error)
    }
}

impl core::fmt::Display for RiseTimeError {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Parameter(error) => error.fmt(formatter),
            Self::NotReached => formatter.write_str(
                "the voltage does not open the plate: raise it, or give both stops and less friction",
            ),
            Self::OutOfRange { shortest, longest } => {
                write!(formatter, "rise time must be {shortest} to {longest} s")
            }
        }
    }
}

impl core::error::Error for RiseTimeError {}

/// Time from 10 to 90 % of the stroke, s, at a constant voltage from rest at the lower stop,
/// simulated in steps of `period` seconds and interpolated between them.
///
/// # Errors
/// [`RiseTimeError::Parameter`] and [`RiseTimeError::NotReached`].
pub fn rise_time(parameters: &Parameters, voltage: f32, period: f32) -> Result<f32, RiseTimeError> {
    let actuator = Actuator::build(parameters, period)?;
    let stroke = parameters.upper_stop - parameters.lower_stop;
    if !stroke.is_finite() {
        return Err(RiseTimeError::NotReached);
    }
    let [tenth, nine_tenths] = [0.1, 0.9].map(|share| parameters.lower_stop + share * stroke);
    let mut state = State::new(parameters.lower_stop, 0.0);
    let mut begin = None;
    for tick in 0..STEPS {
        let before = state.position.value();
        if actuator.step(&mut state, voltage).is_err() {
            return Err(RiseTimeError::NotReached);
        }
        let after = state.position.value();
        // Steps up to where the line between two positions meets a level.
        let met = |level: f32| tick as f32 + (level - before) / (after - before);
        if begin.is_none() && after >= tenth {
            begin = Some(met(tenth));
        }
        if let Some(begin) = begin
            && after >= nine_tenths
        {
            return Ok((met(nine_tenths) - begin) * period);
        }
    }
    Err(RiseTimeError::NotReached)
}

/// The parameters with the inertia that gives this rise time, s, at this voltage.
///
/// # Errors
/// [`RiseTimeError`]; for a time that no inertia within reach gives, with the times that it gives.
pub fn with_rise_time(
    parameters: &Parameters,
    target: f32,
    voltage: f32,
    period: f32,
) -> Result<Parameters, RiseTimeError> {
    let heavier = |factor: f32| Parameters {
        inertia: parameters.inertia * factor,
        ..*parameters
    };
    let rise = |factor: f32| rise_time(&heavier(factor), voltage, period);
    let shortest = rise(1.0 / REACH)?;
    // What takes longer than is followed is too heavy.
    let too_heavy = |factor: f32| match rise(factor) {
        Ok(time) => Ok(time > target),
        Err(RiseTimeError::NotReached) => Ok(true),
        Err(error) => Err(error),
    };
    let (mut light, mut heavy) = (1.0 / REACH, REACH);
    if !(target >= shortest && too_heavy(heavy)?) {
        let longest = rise(heavy).unwrap_or(STEPS as f32 * period);
        return Err(RiseTimeError::OutOfRange { shortest, longest });
    }
    for _ in 0..HALVINGS {
        let middle = libm::sqrtf(light * heavy);
        if too_heavy(middle)? {
            heavy = middle;
        } else {
            light = middle;
        }
    }
    Ok(heavier(light))
}
