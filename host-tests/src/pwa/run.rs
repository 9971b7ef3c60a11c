//! Free run of an identified model over a log.

use model_core::plant::inter_sample::InterSample;
use model_core::plant::piecewise_affine::PiecewiseAffine;

use crate::failure::Failure;
use crate::log::Log;

/// Positions of a model in free run, from the log's first position at rest: one for every row, from
/// the inputs before it.
///
/// # Errors
/// A log whose period does not go into the model's, an input that the model refuses.
pub fn positions(model: &PiecewiseAffine, log: &Log) -> Result<Vec<f64>, Failure> {
    let fail =
        |error: &dyn std::fmt::Display| Failure::other(format!("{}: {error}", log.path.display()));
    let start = log.position[0] as f32;
    let mut run = InterSample::new(model.clone(), start, log.period_s as f32)
        .map_err(|error| fail(&error))?;
    let mut positions = Vec::with_capacity(log.samples());
    for &input in &log.input {
        positions.push(f64::from(run.position()));
        run.tick(input as f32).map_err(|error| fail(&error))?;
    }
    Ok(positions)
}
