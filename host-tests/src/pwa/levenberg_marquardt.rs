//! Levenberg–Marquardt, for errors that depend on a model's numbers.

use nalgebra::{DMatrix, DVector};

use super::model::Cells;

/// Dampings tried in a step.
const TRIALS: usize = 8;
/// Damping of the first step, as a share of the diagonal.
const FIRST_DAMPING: f64 = 1e-3;
/// A share of the cost: a step that lowers it by less is the last.
const SETTLED: f64 = 1e-5;

/// A sum of squared errors over numbers of a model.
pub trait Problem {
    /// The sum; not finite for a model that is of no use.
    fn cost(&self, cells: &Cells) -> f64;

    /// JᵀJ and Jᵀe, J the derivatives of the errors e.
    fn normal_equations(&self, cells: &Cells) -> (DMatrix<f64>, DVector<f64>);

    /// The model with its numbers lowered by `change`.
    fn changed(&self, cells: &Cells, change: &DVector<f64>) -> Cells;
}

/// A fit under way.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The best model so far.
    pub cells: Cells,
    /// Its sum of squared errors.
    pub cost: f64,
    damping: f64,
}

impl Fit {
    /// From a first model.
    pub fn new(problem: &impl Problem, cells: Cells) -> Self {
        Self {
            cost: problem.cost(&cells),
            cells,
            damping: FIRST_DAMPING,
        }
    }

    /// Steps until none lowers the cost, or there were as many as given.
    pub fn run(mut self, problem: &impl Problem, steps: usize) -> Self {
        for _ in 0..steps {
            if !self.step(problem) {
                break;
            }
        }
        self
    }

    /// One step; whether another is worth it.
    fn step(&mut self, problem: &impl Problem) -> bool {
        let (gram, gradient) = problem.normal_equations(&self.cells);
        if !gradient.iter().all(|slope| slope.is_finite()) {
            return false;
        }
        // Numbers of a cell that no log visits stay where they are.
        let floor = 1e-9 * gram.diagonal().max();
        for _ in 0..TRIALS {
            let mut damped = gram.clone();
            for i in 0..gradient.len() {
                damped[(i, i)] += self.damping * gram[(i, i)] + floor;
            }
            if let Some(factor) = damped.cholesky() {
                let tried = problem.changed(&self.cells, &factor.solve(&gradient));
                let cost = problem.cost(&tried);
                if cost < self.cost {
                    let settled = cost > (1.0 - SETTLED) * self.cost;
                    self.cells = tried;
                    self.cost = cost;
                    self.damping = (self.damping / 5.0).max(1e-9);
                    return !settled;
                }
            }
            self.damping *= 4.0;
        }
        false
    }
}
