//! Parallel identification: the sub-models that make the error of a free run least.

use nalgebra::{DMatrix, DVector};

use super::levenberg_marquardt::Problem;
use super::model::{Cells, REGRESSORS};
use super::sampled::Sampled;
use super::sensitivity::Sensitivity;

/// The free-run error over the coefficients that are fitted in every cell, the partition held.
#[derive(Debug, Clone, Copy)]
pub struct Parallel<'l> {
    /// What is simulated.
    pub logs: &'l [Sampled],
    /// Which coefficients of a sub-model are fitted.
    pub fitted: [bool; REGRESSORS],
}

impl Parallel<'_> {
    fn coefficients(&self) -> Vec<usize> {
        (0..REGRESSORS).filter(|&i| self.fitted[i]).collect()
    }
}

impl Problem for Parallel<'_> {
    fn cost(&self, cells: &Cells) -> f64 {
        cells.cost(self.logs)
    }

    /// The active cell is held: where it changes is not differentiated.
    fn normal_equations(&self, cells: &Cells) -> (DMatrix<f64>, DVector<f64>) {
        let coefficients = self.coefficients();
        let mut sums = Sensitivity::new(cells.submodels.len() * coefficients.len());
        for log in self.logs {
            sums.restart();
            let mut measured = log.position[1..].iter();
            cells.run(log, |position, regressor, cell, limited| {
                if limited {
                    sums.hold();
                } else {
                    let [p, q, ..] = cells.submodels[cell];
                    sums.advance(p, q, |slopes| {
                        let own = &mut slopes[cell * coefficients.len()..];
                        for (slope, &coefficient) in own.iter_mut().zip(&coefficients) {
                            *slope += regressor[coefficient];
                        }
                    });
                }
                sums.add(position - measured.next().expect("as many as inputs"));
            });
        }
        sums.sums()
    }

    fn changed(&self, cells: &Cells, change: &DVector<f64>) -> Cells {
        let mut changed = cells.clone();
        let mut changes = change.iter();
        for submodel in &mut changed.submodels {
            for &coefficient in &self.coefficients() {
                submodel[coefficient] -= changes.next().expect("one for each");
            }
        }
        changed
    }
}
