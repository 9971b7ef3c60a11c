//! All six numbers together, by least squares on the free runs of both logs.

use model_core::numeric::cholesky::Cholesky;
use model_core::numeric::triangle::{Triangle, entries};
use rayon::prelude::*;

use super::{Assembly, Numbers, Series};
use crate::free_run;

/// Relative steps of the sensitivities: large enough to average over the jumps that a free run with
/// stiction has.
const STEP: f64 = 3e-3;

/// Steps of the Levenberg–Marquardt method at most.
const MOST_STEPS: usize = 12;

/// The search starts with a static friction of at least this share of Coulomb friction.
const LEAST_STATIC: f64 = 1.05;

/// A step that gains less than this share of the cost ends the search.
const LEAST_GAIN: f64 = 1e-4;

type Matrix = Triangle<f64, { entries(6) }>;

/// What came of it.
pub(super) struct Polished {
    /// The numbers; `None` if they are no better than the start.
    pub numbers: Option<Numbers>,
    /// Simulations of a log.
    pub simulations: usize,
}

/// Least squares on the mean squares of the logs, in the logarithms of the six numbers, by
/// Levenberg and Marquardt with simulated sensitivities, for the full motor. The numbers with the least
/// cost are kept.
///
/// They come without intervals. Those of the sandwich rule over blocks of a second covered the truth of
/// 24 throttles in 85 of 144 cases: the cost jumps where a breakaway moves, and what is
/// common to a whole log, a stop seated half a count off, no block shows.
pub(super) fn polish(assembly: &Assembly, start: &Numbers, logs: &[&Series]) -> Polished {
    let mut search = Search {
        assembly,
        logs,
        simulations: 0,
    };
    let nothing = |simulations| Polished {
        numbers: None,
        simulations,
    };
    let mut values = start.values();
    // Below Coulomb friction the static one has no influence, and would stay where it is.
    values[4] = values[4].max(LEAST_STATIC * values[3]);
    // A number that is not positive has no logarithm; the core takes none below zero anyway.
    if values.iter().any(|value| *value <= 0.0) {
        return nothing(0);
    }
    let Some(first) = search.cost(&values) else {
        return nothing(search.simulations);
    };
    let mut cost = first;
    let mut damping = 1e-3;
    'steps: for _ in 0..MOST_STEPS {
        let Some(system) = search.linearise(&values) else {
            break;
        };
        loop {
            let step = system.solve(damping);
            let next: [f64; 6] =
                std::array::from_fn(|k| values[k] * step[k].clamp(-0.3, 0.3).exp());
            match search.cost(&next) {
                Some(lower) if lower < cost => {
                    let gain = 1.0 - lower / cost;
                    (values, cost) = (next, lower);
                    damping = (damping / 5.0).max(1e-9);
                    if gain < LEAST_GAIN {
                        break 'steps;
                    }
                    break;
                }
                _ if damping > 1e3 => break 'steps,
                _ => damping *= 8.0,
            }
        }
    }
    if cost >= first {
        return nothing(search.simulations);
    }
    Polished {
        numbers: Some(Numbers::new(values, [f64::INFINITY; 6])),
        simulations: search.simulations,
    }
}

struct Search<'s> {
    assembly: &'s Assembly,
    logs: &'s [&'s Series],
    simulations: usize,
}

impl Search<'_> {
    /// Free runs of all logs.
    fn simulate(&self, values: &[f64; 6]) -> Option<Vec<Vec<f32>>> {
        let parameters = self.assembly.parameters(values, true);
        let run = |log: &&Series| {
            free_run::simulate(&parameters, log.period, &log.input, log.position[0]).ok()
        };
        self.logs.iter().map(run).collect()
    }

    /// Sum of the logs' mean squared errors.
    fn cost(&mut self, values: &[f64; 6]) -> Option<f64> {
        self.simulations += self.logs.len();
        let runs = self.simulate(values)?;
        let mean_square = |(run, log): (&Vec<f32>, &&Series)| {
            let pairs = run.iter().zip(&log.position);
            let squares = pairs.map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2));
            squares.sum::<f64>() / run.len() as f64
        };
        Some(runs.iter().zip(self.logs).map(mean_square).sum())
    }

    fn linearise(&mut self, values: &[f64; 6]) -> Option<System> {
        self.simulations += 13 * self.logs.len();
        let variants: Vec<[f64; 6]> = (0..13)
            .map(|variant| {
                let mut moved = *values;
                if variant > 0 {
                    let sign = if variant % 2 == 1 { STEP } else { -STEP };
                    moved[(variant - 1) / 2] *= sign.exp();
                }
                moved
            })
            .collect();
        let runs: Vec<Option<Vec<Vec<f32>>>> = variants
            .par_iter()
            .map(|values| self.simulate(values))
            .collect();
        let runs: Vec<Vec<Vec<f32>>> = runs.into_iter().collect::<Option<_>>()?;
        let mut system = System::default();
        for (number, log) in self.logs.iter().enumerate() {
            let weight = 1.0 / log.position.len() as f64;
            for (k, measured) in log.position.iter().enumerate() {
                let at = |variant: usize| f64::from(runs[variant][number][k]);
                let residual = f64::from(*measured) - at(0);
                let slopes: [f64; 6] =
                    std::array::from_fn(|p| (at(2 * p + 1) - at(2 * p + 2)) / (2.0 * STEP));
                for row in 0..6 {
                    system.gradient[row] += weight * slopes[row] * residual;
                    for (entry, slope) in system.normal.row_mut(row).iter_mut().zip(slopes) {
                        *entry += weight * slopes[row] * slope;
                    }
                }
            }
        }
        Some(system)
    }
}

/// Normal equations in the logarithms.
#[derive(Default)]
struct System {
    normal: Matrix,
    gradient: [f64; 6],
}

impl System {
    /// The step of Levenberg and Marquardt.
    fn solve(&self, damping: f64) -> [f64; 6] {
        let mut matrix = self.normal.clone();
        for row in 0..6 {
            matrix.row_mut(row)[row] *= 1.0 + damping;
        }
        let mut step = self.gradient;
        Cholesky::new(matrix, 6).solve(&mut step);
        step
    }
}
