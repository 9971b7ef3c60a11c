//! The method of Levenberg and Marquardt: least squares over numbers that errors depend on smoothly.
//!
//! D. Marquardt, *An Algorithm for Least-Squares Estimation of Nonlinear Parameters*, J. SIAM 11
//! (1963): the damping is a share of each diagonal element, so that units do not matter.

use nalgebra::{DMatrix, DVector};

/// Damping at the start, and how it follows success and failure.
const DAMPING: f64 = 1e-2;
const EASE: f64 = 0.2;
const STIFFEN: f64 = 6.0;

/// Failures after which there is nothing to be gained.
const FAILURES: usize = 12;

/// How long to go on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Budget {
    /// Accepted steps.
    pub iterations: usize,
    /// Share by which a step must lower the cost for another to follow.
    pub gain: f64,
}

/// What is minimised.
pub(super) trait Problem {
    /// What the numbers belong to.
    type Model: Clone;

    /// The sum over the errors; infinite beyond `limit`, which ends its computation.
    fn cost(&self, model: &Self::Model, limit: f64) -> f64;

    /// JᵀWJ and JᵀWe, J the derivatives of the errors e by the numbers, W their weights.
    fn normal_equations(&self, model: &Self::Model) -> (DMatrix<f64>, DVector<f64>);

    /// The model with its numbers lowered by `step`.
    fn stepped(&self, model: &Self::Model, step: &DVector<f64>) -> Self::Model;
}

/// Improves a model.
pub(super) fn minimise<P: Problem>(problem: &P, start: &P::Model, budget: Budget) -> P::Model {
    let mut model = start.clone();
    let mut damping = DAMPING;
    let mut best = problem.cost(&model, f64::INFINITY);
    for _ in 0..budget.iterations {
        let (gram, slope) = problem.normal_equations(&model);
        let before = best;
        for _ in 0..FAILURES {
            if let Some(step) = damped(&gram, &slope, damping) {
                let trial = problem.stepped(&model, &step);
                let cost = problem.cost(&trial, best);
                if cost < best {
                    (model, best) = (trial, cost);
                    damping *= EASE;
                    break;
                }
            }
            damping *= STIFFEN;
        }
        // A NaN ends it too.
        let gained = best < (1.0 - budget.gain) * before;
        if !gained {
            break;
        }
    }
    model
}

/// The solution of the damped normal equations, if there is one.
fn damped(gram: &DMatrix<f64>, slope: &DVector<f64>, damping: f64) -> Option<DVector<f64>> {
    let mut sum = gram.clone();
    for index in 0..gram.nrows() {
        let diagonal = gram[(index, index)];
        // What no error depends on stays as it is.
        sum[(index, index)] += if diagonal > 0.0 {
            damping * diagonal
        } else {
            1.0
        };
    }
    Some(sum.cholesky()?.solve(slope))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Misra1a of the statistical reference datasets of NIST: y = b₁(1 − exp(−b₂ x)).
    struct Misra1a;

    const DATA: [(f64, f64); 14] = [
        (77.6, 10.07),
        (114.9, 14.73),
        (141.1, 17.94),
        (190.8, 23.93),
        (239.9, 29.61),
        (289.0, 35.18),
        (332.8, 40.02),
        (378.4, 44.82),
        (434.8, 50.76),
        (477.3, 55.05),
        (536.8, 61.01),
        (593.1, 66.40),
        (689.1, 75.47),
        (760.0, 81.78),
    ];

    /// The certified values.
    const CERTIFIED: [f64; 2] = [2.389_421_291_8e2, 5.501_564_318_1e-4];
    const CERTIFIED_SUM: f64 = 1.245_513_889_4e-1;

    impl Problem for Misra1a {
        type Model = [f64; 2];

        fn cost(&self, &[b1, b2]: &[f64; 2], _limit: f64) -> f64 {
            let errors = DATA.iter().map(|(x, y)| b1 * (1.0 - (-b2 * x).exp()) - y);
            errors.map(|error| error * error).sum()
        }

        fn normal_equations(&self, &[b1, b2]: &[f64; 2]) -> (DMatrix<f64>, DVector<f64>) {
            let mut gram = DMatrix::zeros(2, 2);
            let mut slope = DVector::zeros(2);
            for (x, y) in DATA {
                let decay = (-b2 * x).exp();
                let row = DVector::from_column_slice(&[1.0 - decay, b1 * x * decay]);
                gram.ger(1.0, &row, &row, 1.0);
                slope.axpy(b1 * (1.0 - decay) - y, &row, 1.0);
            }
            (gram, slope)
        }

        fn stepped(&self, &[b1, b2]: &[f64; 2], step: &DVector<f64>) -> [f64; 2] {
            [b1 - step[0], b2 - step[1]]
        }
    }

    #[test]
    fn a_reference_problem_ends_at_its_certified_values() {
        let budget = Budget {
            iterations: 200,
            gain: 0.0,
        };
        // Both starts of the reference.
        for start in [[500.0, 1e-4], [250.0, 5e-4]] {
            let found = minimise(&Misra1a, &start, budget);
            for (found, certified) in found.iter().zip(CERTIFIED) {
                assert!((found / certified - 1.0).abs() < 1e-6, "{found}");
            }
            let sum = Misra1a.cost(&found, f64::INFINITY);
            assert!((sum / CERTIFIED_SUM - 1.0).abs() < 1e-9, "{sum}");
        }
    }

    #[test]
    fn a_model_without_a_cost_is_given_back() {
        let start = [f64::NAN, 1.0];
        let budget = Budget {
            iterations: 3,
            gain: 1e-3,
        };
        assert_eq!(minimise(&Misra1a, &start, budget)[1], 1.0);
    }
}
