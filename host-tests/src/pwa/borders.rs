//! The partition: half-planes from centres, and the search that moves them.

use super::k_means::Point;
use super::levenberg_marquardt::{Budget, Problem, minimise};
use super::model::{Affine, COEFFICIENTS, INPUT, Model, POSITION};
use super::parallel::Parallel;
use super::reading::Space;

/// Centres in the clustered space, each with a lead over the others.
///
/// A point belongs to the centre for which its squared distance less twice the lead is least (a power
/// diagram; without leads the Voronoi diagram, the cells of k-means). The square of the point drops
/// out of the comparison, which leaves an affine function for each centre.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Partition {
    space: Space,
    centres: Vec<Point>,
    leads: Vec<f64>,
}

/// First step of the search, in standard deviations of the clustered space.
const FIRST: f64 = 0.2;

/// A step that shrank below this starts anew from [`RESTART`]: meanwhile the rest has moved.
const SMALLEST: f64 = 1e-3;
const RESTART: f64 = 0.1;

/// How a step follows success and failure.
const LENGTHEN: f64 = 1.5;
const SHORTEN: f64 = 0.5;

/// Share of the spring's slope that a step of 1 is.
const SLOPE_SHARE: f64 = 0.3;

/// Steps of Levenberg-Marquardt after each round.
const BETWEEN: Budget = Budget {
    iterations: 3,
    gain: 1e-3,
};

/// A round that gains less than this share of the cost is the last one.
const LEAST_GAIN: f64 = 2e-3;

impl Partition {
    /// The cells of a clustering.
    pub fn of(space: Space, centres: Vec<Point>) -> Self {
        let leads = vec![0.0; centres.len()];
        Self {
            space,
            centres,
            leads,
        }
    }

    /// The region of each cell.
    pub fn regions(&self) -> Vec<Affine> {
        let region = |(centre, lead): (&Point, &f64)| {
            let mut region = [0.0; COEFFICIENTS];
            for (row, place) in self.space.rows.iter().zip(centre) {
                for (sum, value) in region.iter_mut().zip(row) {
                    *sum += place * value;
                }
            }
            region[0] += lead - 0.5 * centre.iter().map(|place| place * place).sum::<f64>();
            region
        };
        self.centres.iter().zip(&self.leads).map(region).collect()
    }

    /// The spring's slope, input for each rad or m; 0 where the partition knows none.
    pub fn slope(&self) -> f64 {
        let row = self.space.rows[1];
        // Without the sign of a zero.
        0.0 - row[POSITION] / row[INPUT]
    }

    /// Gives a model these cells.
    pub fn put_into(&self, model: &mut Model) {
        for (cell, region) in model.cells.iter_mut().zip(self.regions()) {
            cell.region = region;
        }
    }

    /// The same, one of its numbers moved by a step.
    fn moved(&self, number: usize, step: f64) -> Self {
        let mut moved = self.clone();
        let each = self.space.dimensions() + 1;
        let (cell, which) = (number / each, number % each);
        if cell == self.centres.len() {
            moved.space.rows[1][POSITION] *= 1.0 + SLOPE_SHARE * step;
        } else if which < each - 1 {
            moved.centres[cell][which] += step;
        } else {
            moved.leads[cell] += step;
        }
        moved
    }

    /// How many numbers there are to be moved: places and leads, and the spring's slope if there is
    /// one.
    fn numbers(&self) -> usize {
        let sloped = self.space.rows[1][POSITION] != 0.0;
        self.centres.len() * (self.space.dimensions() + 1) + usize::from(sloped)
    }
}

/// Moves the borders to where the cost of the free run is least: a pattern search along each number of
/// the partition in turn (R. Hooke and T. A. Jeeves, *"Direct Search" Solution of Numerical and
/// Statistical Problems*, J. ACM 8, 1961), the sub-models identified anew after each round. The cost
/// is a step function of a border; no gradient leads there.
pub(super) fn improve(
    problem: &Parallel<'_>,
    start: (&Model, &Partition),
    rounds: usize,
) -> (Model, Partition) {
    let (mut model, mut partition) = (start.0.clone(), start.1.clone());
    let mut steps = vec![FIRST; partition.numbers()];
    let mut best = problem.cost(&model, f64::INFINITY);
    for _ in 0..rounds {
        let before = best;
        for (number, step) in steps.iter_mut().enumerate() {
            let better = [*step, -*step].into_iter().find_map(|step| {
                let moved = partition.moved(number, step);
                let mut trial = model.clone();
                moved.put_into(&mut trial);
                let cost = problem.cost(&trial, best);
                (cost < best).then_some((step, moved, trial, cost))
            });
            match better {
                Some((taken, moved, trial, cost)) => {
                    (partition, model, best) = (moved, trial, cost);
                    // The way that helped comes first the next time.
                    *step = LENGTHEN * taken;
                }
                None => *step *= SHORTEN,
            }
            if step.abs() < SMALLEST {
                *step = RESTART.copysign(*step);
            }
        }
        model = minimise(problem, &model, BETWEEN);
        best = problem.cost(&model, f64::INFINITY);
        if best > (1.0 - LEAST_GAIN) * before {
            break;
        }
    }
    (model, partition)
}
