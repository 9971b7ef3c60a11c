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

#[cfg(test)]
pub(super) mod tests {
    use model_core::numeric::random::Random;

    use super::super::levenberg_marquardt::Fit;
    use super::*;

    /// Three cells by the input and the change: at rest, opening, closing.
    pub fn truth() -> Cells {
        Cells {
            partition: vec![[0.0; 4], [-1.3, 30.0, 1.0, 0.2], [1.3, -30.0, -1.0, -1.4]],
            submodels: vec![
                [0.0, 0.3, 0.0, 0.0],
                [-0.05, 0.6, 0.03, 0.02],
                [-0.04, 0.7, 0.02, 0.03],
            ],
            limits: (-2.0, 2.0),
        }
    }

    /// Levels of the input, each held for a while, and what the model makes of them.
    pub fn log(cells: &Cells) -> Sampled {
        let mut random = Random::new(3, 3);
        let mut level = 0.0;
        let input: Vec<f64> = (0..2000)
            .map(|period| {
                if period % 25 == 0 {
                    level = 3.0 * f64::from(random.uniform()) - 1.5;
                }
                level
            })
            .collect();
        let mut log = Sampled {
            position: vec![0.1; input.len() + 1],
            input,
        };
        let mut position = vec![0.1];
        cells.run(&log, |at, _, _, _| position.push(at));
        log.position = position;
        log
    }

    #[test]
    fn the_sub_models_of_a_run_are_found_again() {
        let truth = truth();
        let logs = [log(&truth)];
        let problem = Parallel {
            logs: &logs,
            fitted: [true; REGRESSORS],
        };
        let mut start = truth.clone();
        for (number, coefficient) in start.submodels.iter_mut().flatten().enumerate() {
            *coefficient *= if number % 2 == 0 { 1.05 } else { 0.97 };
        }
        assert!(problem.cost(&start) > 1.0);
        let found = Fit::new(&problem, start).run(&problem, 60);
        assert!(found.cost < 1e-9, "{}", found.cost);
        let pairs = truth.submodels[1..].iter().zip(&found.cells.submodels[1..]);
        for (truth, found) in pairs.flat_map(|(truth, found)| truth.iter().zip(found)) {
            assert!((truth - found).abs() < 1e-5, "{truth} {found}");
        }
    }

    #[test]
    fn normal_equations_are_those_of_differences() {
        let truth = truth();
        let mut log = log(&truth);
        for (row, position) in log.position.iter_mut().enumerate() {
            *position += 0.01 * (row as f64).sin();
        }
        // Before a cell is left: where the boundaries are crossed does not depend on θ there.
        let logs = [log.part(0, 20)];
        let problem = Parallel {
            logs: &logs,
            fitted: [true; REGRESSORS],
        };
        let (_, gradient) = problem.normal_equations(&truth);
        const STEP: f64 = 1e-6;
        for number in 0..gradient.len() {
            let moved = |by: f64| {
                let mut change = DVector::zeros(gradient.len());
                change[number] = by;
                problem.cost(&problem.changed(&truth, &change))
            };
            // The cost is a sum of squares without a half, and `changed` lowers.
            let slope = (moved(-STEP) - moved(STEP)) / (4.0 * STEP);
            assert!(
                (slope - gradient[number]).abs() < 1e-6,
                "{number}: {slope} {}",
                gradient[number]
            );
        }
    }
}
