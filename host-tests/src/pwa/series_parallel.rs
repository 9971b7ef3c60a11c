//! Series-parallel identification: least squares of one-step predictions from measured outputs, in
//! each cell. Biased where outputs are noisy; the start of the parallel one.

use nalgebra::{DMatrix, DVector};

use super::model::{Model, POSITION, value};
use super::reading::Reading;
use super::series::Step;

/// Weight of zero beside the data, as a share of each regressor's mean square in the cell and of 1: a
/// cell without samples holds, and regressors that stand in proportion do no harm.
const RIDGE: f64 = 1e-9;

/// How near to a limit a machine may be pressed onto it, as a share of the range.
const PRESSED: f64 = 2e-3;

/// Fits the sub-models of all cells to measured steps.
///
/// Steps at a limit are left out: there the stop holds the machine, which the model's limits know.
pub(super) fn fit(model: &mut Model, reading: Reading, steps: &[Step]) {
    let free = reading.free();
    let size = free.len();
    let fixed = reading.fixed();
    let mut sums = vec![
        (
            DMatrix::<f64>::zeros(size, size),
            DVector::<f64>::zeros(size)
        );
        model.cells.len()
    ];
    let margin = PRESSED * (model.upper - model.lower);
    let inside = model.lower + margin..model.upper - margin;
    for step in steps {
        if !inside.contains(&(step.regressor[POSITION] + step.growth)) {
            continue;
        }
        let (gram, moment) = &mut sums[model.cell(&step.regressor)];
        let target = step.growth - value(&fixed, &step.regressor);
        for (row, &i) in free.iter().enumerate() {
            moment[row] += step.regressor[i] * target;
            for (column, &j) in free.iter().enumerate() {
                gram[(row, column)] += step.regressor[i] * step.regressor[j];
            }
        }
    }
    for (cell, (mut gram, moment)) in model.cells.iter_mut().zip(sums) {
        for diagonal in 0..size {
            gram[(diagonal, diagonal)] += RIDGE * (gram[(diagonal, diagonal)] + 1.0);
        }
        cell.growth = fixed;
        if let Some(factor) = gram.cholesky() {
            let solution = factor.solve(&moment);
            for (&coefficient, &found) in free.iter().zip(&solution) {
                cell.growth[coefficient] = found;
            }
        }
        reading.steady(&mut cell.growth);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pwa::model::tests::{driven, example};
    use crate::pwa::series::{Data, Part};

    #[test]
    fn sub_models_come_out_of_a_run_without_noise() {
        let model = example();
        let data = Data {
            series: vec![driven(&model, 2000, 1), driven(&model, 2000, 2)],
            block: 200,
        };
        let mut found = model.clone();
        for cell in &mut found.cells {
            cell.growth = [0.0; 4];
        }
        fit(&mut found, Reading::default(), &data.steps(Part::All));
        for (found, truth) in found.cells.iter().zip(&model.cells) {
            for (found, truth) in found.growth.iter().zip(truth.growth) {
                assert!((found - truth).abs() < 1e-6, "{found} {truth}");
            }
        }
    }

    #[test]
    fn a_cell_without_samples_holds() {
        let mut model = example();
        let steps = Data {
            series: vec![driven(&model, 500, 1)],
            block: 100,
        }
        .steps(Part::All);
        // Below every other cell everywhere.
        model.cells[2].region[0] -= 1e6;
        fit(&mut model, Reading::default(), &steps);
        assert_eq!(model.cells[2].growth, [0.0; 4]);
        fit(&mut model, Reading::Output, &steps);
        assert_eq!(model.cells[2].growth, [0.0, 0.0, 0.0, -1.0]);
    }
}
