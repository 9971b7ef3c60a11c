//! Free run of an identified model over a log.

use model_core::plant::piecewise_affine::PiecewiseAffine;

use super::identify::rows;
use super::sampled::Sampled;
use crate::failure::Failure;
use crate::log::Log;

/// Positions of a model in free run, from the log's first position at rest: one for every row, on a
/// straight line between the model's samples; after the last whole period, the last of them.
///
/// # Errors
/// A log whose period does not divide the model's, an input that the model refuses.
pub fn positions(model: &PiecewiseAffine, log: &Log) -> Result<Vec<f64>, Failure> {
    let fail = |error| Failure::other(format!("{}: {error}", log.path.display()));
    let rows = rows(log, f64::from(model.parameters().period))?;
    let sampled = Sampled::new(log, rows);
    let mut state = model.rest(log.position[0] as f32).map_err(fail)?;
    let mut positions = Vec::with_capacity(log.samples());
    for &input in &sampled.input {
        let start = f64::from(state.position());
        let end = f64::from(model.step(&mut state, input as f32).map_err(fail)?);
        let part = |row: usize| row as f64 / rows as f64;
        positions.extend((0..rows).map(|row| start + part(row) * (end - start)));
    }
    positions.resize(log.samples(), f64::from(state.position()));
    Ok(positions)
}
