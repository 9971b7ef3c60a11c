//! Series-parallel identification: least squares on the change of the next measured position.

use nalgebra::{DMatrix, DVector};

use super::model::{Affine, Cells, REGRESSORS};
use super::reading::Reading;

/// A share of the largest diagonal element, added to all: a cell whose samples do not tell its
/// coefficients apart gets small ones.
const RIDGE: f64 = 1e-9;

/// Coefficients that predict targets from rows best.
pub fn least_squares(rows: &[(Vec<f64>, f64)], size: usize) -> Vec<f64> {
    let mut gram = DMatrix::<f64>::zeros(size, size);
    let mut right = DVector::<f64>::zeros(size);
    for (row, target) in rows {
        for i in 0..size {
            right[i] += row[i] * target;
            for j in 0..size {
                gram[(i, j)] += row[i] * row[j];
            }
        }
    }
    let ridge = RIDGE * gram.diagonal().max();
    for i in 0..size {
        gram[(i, i)] += ridge;
    }
    match gram.cholesky() {
        Some(factor) => factor.solve(&right).iter().copied().collect(),
        // No sample at all.
        None => vec![0.0; size],
    }
}

/// The sub-models of a partition.
pub fn fit(cells: &mut Cells, reading: Reading, samples: &[(Affine, f64)]) {
    let fitted: Vec<usize> = (0..REGRESSORS).filter(|&i| reading.fitted()[i]).collect();
    let mut rows = vec![Vec::new(); cells.partition.len()];
    for (regressor, growth) in samples {
        let row = fitted.iter().map(|&i| regressor[i]).collect();
        let target = growth - reading.given() * regressor[0];
        rows[cells.cell(regressor)].push((row, target));
    }
    for (submodel, rows) in cells.submodels.iter_mut().zip(&rows) {
        *submodel = [reading.given(), 0.0, 0.0, 0.0];
        let solved = least_squares(rows, fitted.len());
        for (&place, coefficient) in fitted.iter().zip(solved) {
            submodel[place] = coefficient;
        }
    }
}
