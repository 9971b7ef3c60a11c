//! Free run: one simulation of a whole log, from its first position at rest, without restarts, and how
//! far it is off (throttle paper, eqs. 23 and 24).

use model_core::gap::model::Model;
use model_core::plant::State;

use crate::failure::Failure;
use crate::log::Log;

/// How far a free run is off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Norm of the error over that of the measurement less its mean: 1 is as good as the mean.
    pub nrmse: f64,
    /// Largest magnitude of the error, unit of the position.
    pub largest: f64,
}

/// Errors of predicted positions beside measured ones, as many as both have.
pub fn errors(predicted: &[f64], measured: &[f64]) -> Errors {
    let mean = measured.iter().sum::<f64>() / measured.len() as f64;
    let (mut error, mut spread, mut largest) = (0.0, 0.0, 0.0_f64);
    for (predicted, measured) in predicted.iter().zip(measured) {
        let difference = predicted - measured;
        error += difference * difference;
        spread += (measured - mean) * (measured - mean);
        largest = largest.max(difference.abs());
    }
    Errors {
        nrmse: (error / spread).sqrt(),
        largest,
    }
}

/// Positions of a model in free run, a row of the log each. A delay in the model is not in them.
///
/// # Errors
/// A parameter out of its range, an input that the plant refuses.
pub fn positions(model: &Model, log: &Log) -> Result<Vec<f64>, Failure> {
    let simulator = model
        .build(log.period_s as f32)
        .map_err(|error| Failure::other(error.to_string()))?;
    let mut state = State::new(log.position[0] as f32, 0.0);
    let rows = log.input.iter().enumerate();
    rows.map(|(row, &input)| {
        let position = f64::from(state.position.value());
        let input = input as f32;
        let stepped = simulator.step(&mut state, (input, input), row);
        stepped
            .map(|_| position)
            .map_err(|error| Failure::other(error.to_string()))
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_those_of_the_paper() {
        // By hand: errors 0, 1, -2; measured 1, 2, 6 about 3.
        let errors = errors(&[1.0, 3.0, 4.0], &[1.0, 2.0, 6.0]);
        assert_eq!(errors.largest, 2.0);
        assert!((errors.nrmse - (5.0_f64 / 14.0).sqrt()).abs() < 1e-15);
    }
}
