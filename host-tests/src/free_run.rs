//! Free run: a model driven by the measured input alone, from the first measured position on.

use model_core::plant::State;
use model_core::plant::actuator::Actuator;
use model_core::plant::parameters::{ParameterError, Parameters};
use serde::Serialize;

/// How far a prediction is off.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// Root mean square of the error over the standard deviation of the measurement (throttle paper,
    /// eq. 23).
    pub nrmse: f64,
    /// Largest magnitude of the error, rad or m (eq. 24).
    pub max_abs: f64,
}

/// The errors of a prediction. Without samples, or of a measurement that never moves, the NRMSE is
/// not a number.
///
/// ```
/// use host_tests::free_run::errors;
///
/// let found = errors(&[1.0, 2.0, 3.5], &[1.0, 2.0, 3.0]);
/// assert_eq!(found.max_abs, 0.5);
/// assert!((found.nrmse - (0.25_f64 / 2.0).sqrt()).abs() < 1e-12);
/// ```
pub fn errors<T: Copy + Into<f64>>(predicted: &[T], measured: &[T]) -> Errors {
    let mean = measured.iter().map(|&y| y.into()).sum::<f64>() / measured.len() as f64;
    let (mut error, mut spread, mut max_abs) = (0.0, 0.0, 0.0_f64);
    for (&predicted, &measured) in predicted.iter().zip(measured) {
        let measured = measured.into();
        let difference = predicted.into() - measured;
        error += difference * difference;
        spread += (measured - mean) * (measured - mean);
        max_abs = max_abs.max(difference.abs());
    }
    Errors {
        nrmse: (error / spread).sqrt(),
        max_abs,
    }
}

/// Runs the core's actuator over `input`, at rest at `start` (brought within its stops) before the
/// first sample: the position at each sample.
///
/// # Errors
/// Parameters that the core does not take.
pub fn simulate(
    parameters: &Parameters,
    period: f32,
    input: &[f32],
    start: f32,
) -> Result<Vec<f32>, ParameterError> {
    let actuator = Actuator::build(parameters, period)?;
    let start = start.clamp(parameters.lower_stop, parameters.upper_stop);
    let mut state = State::new(start, 0.0);
    let mut positions = Vec::with_capacity(input.len());
    for &input in input {
        positions.push(state.position.value());
        // A log's numbers are finite; beyond the core's limit the state stays as it is.
        let _ = actuator.step(&mut state, input);
    }
    Ok(positions)
}
