//! Boundaries by gradient: the free run of a model whose cells overlap.
//!
//! The error of a model with sharp cells jumps as a boundary passes a sample, so it has no useful
//! derivative. Here every cell has a share of the prediction, softmax of the partition's functions
//! (Jacobs, Jordan, Nowlan and Hinton, *Adaptive Mixtures of Local Experts*, Neural Computation 3,
//! 1991). The larger the functions, the sharper the cells: they are made sharper in rounds, until
//! the largest alone may decide.

use nalgebra::{DMatrix, DVector};

use super::levenberg_marquardt::{Fit, Problem};
use super::model::{Affine, Cells, value};
use super::reading::Reading;
use super::sampled::Sampled;
use super::sensitivity::Sensitivity;

/// Sharpness of the cells at the start: shares change from 12 to 88 % over 4/15 of a spread where
/// two centres are one spread apart.
const SHARPNESS: f64 = 15.0;
/// How much sharper a round is than the one before.
const SHARPER: f64 = 2.5;
/// Most steps of each round.
const ROUNDS: [usize; 4] = [20, 6, 6, 6];
/// A share below this is none.
const LEAST_SHARE: f64 = 1e-5;

/// Fits boundaries and sub-models together.
pub fn refine(logs: &[Sampled], reading: Reading, mut cells: Cells) -> Cells {
    let problem = Soft { logs, reading };
    sharpen(&mut cells, SHARPNESS);
    for steps in ROUNDS {
        cells = Fit::new(&problem, cells).run(&problem, steps).cells;
        sharpen(&mut cells, SHARPER);
    }
    cells
}

fn sharpen(cells: &mut Cells, factor: f64) {
    for coefficient in cells.partition.iter_mut().flatten() {
        *coefficient *= factor;
    }
}

/// The free-run error over the numbers of boundaries and sub-models.
struct Soft<'l> {
    logs: &'l [Sampled],
    reading: Reading,
}

/// What a period of a free run shows.
struct Period<'p> {
    position: f64,
    regressor: &'p Affine,
    shares: &'p [f64],
    growth: f64,
    limited: bool,
}

fn run(cells: &Cells, log: &Sampled, mut observe: impl FnMut(&Period)) {
    let (lower, upper) = cells.limits;
    let mut position = log.position[0];
    let mut before = position;
    let mut shares = vec![0.0; cells.partition.len()];
    for &input in &log.input {
        let regressor = [position, position - before, input, 1.0];
        divide(cells, &regressor, &mut shares);
        let mut growth = 0.0;
        for (share, submodel) in shares.iter().zip(&cells.submodels) {
            growth += share * value(submodel, &regressor);
        }
        let free = position + growth;
        before = position;
        position = free.clamp(lower, upper);
        observe(&Period {
            position,
            regressor: &regressor,
            shares: &shares,
            growth,
            limited: position != free,
        });
    }
}

/// Softmax, less what does not count.
fn divide(cells: &Cells, regressor: &Affine, shares: &mut [f64]) {
    let mut largest = f64::NEG_INFINITY;
    for (share, region) in shares.iter_mut().zip(&cells.partition) {
        *share = value(region, regressor);
        largest = largest.max(*share);
    }
    let mut sum = 0.0;
    for share in &mut *shares {
        let relative = (*share - largest).exp();
        *share = if relative > LEAST_SHARE {
            relative
        } else {
            0.0
        };
        sum += *share;
    }
    for share in shares {
        *share /= sum;
    }
}

impl Soft<'_> {
    /// The numbers of a cell that are fitted: first those of its sub-model.
    fn numbers(&self) -> (Vec<usize>, Vec<usize>) {
        let places = |which: [bool; 4]| (0..which.len()).filter(|&i| which[i]).collect();
        (
            places(self.reading.fitted()),
            places(self.reading.partitioned()),
        )
    }
}

impl Problem for Soft<'_> {
    fn cost(&self, cells: &Cells) -> f64 {
        let mut sum = 0.0;
        for log in self.logs {
            let mut measured = log.position[1..].iter();
            run(cells, log, |period| {
                let error = period.position - measured.next().expect("as many as inputs");
                sum += error * error;
            });
        }
        sum
    }

    fn normal_equations(&self, cells: &Cells) -> (DMatrix<f64>, DVector<f64>) {
        let (submodel, region) = self.numbers();
        let width = submodel.len() + region.len();
        let mut sums = Sensitivity::new(cells.partition.len() * width);
        for log in self.logs {
            sums.restart();
            let mut measured = log.position[1..].iter();
            run(cells, log, |period| {
                let x = period.regressor;
                // ∂growth/∂(value of a region) = share · (growth of the cell − growth).
                let shared = || {
                    let cells = period.shares.iter().zip(&cells.submodels).enumerate();
                    cells.filter(|(_, (share, _))| **share > 0.0).map(
                        |(cell, (share, submodel))| {
                            (cell, *share, share * (value(submodel, x) - period.growth))
                        },
                    )
                };
                if period.limited {
                    sums.hold();
                } else {
                    let (mut position, mut change) = (0.0, 0.0);
                    for (cell, share, pull) in shared() {
                        let (submodel, region) = (&cells.submodels[cell], &cells.partition[cell]);
                        position += share * submodel[0] + pull * region[0];
                        change += share * submodel[1] + pull * region[1];
                    }
                    sums.advance(position, change, |slopes| {
                        for (cell, share, pull) in shared() {
                            let own = &mut slopes[cell * width..(cell + 1) * width];
                            let (first, second) = own.split_at_mut(submodel.len());
                            for (slope, &place) in first.iter_mut().zip(&submodel) {
                                *slope += share * x[place];
                            }
                            for (slope, &place) in second.iter_mut().zip(&region) {
                                *slope += pull * x[place];
                            }
                        }
                    });
                }
                sums.add(period.position - measured.next().expect("as many as inputs"));
            });
        }
        sums.sums()
    }

    fn changed(&self, cells: &Cells, change: &DVector<f64>) -> Cells {
        let (submodel, region) = self.numbers();
        let mut changed = cells.clone();
        let mut changes = change.iter();
        let both = changed.submodels.iter_mut().zip(&mut changed.partition);
        for (growth, function) in both {
            for &place in &submodel {
                growth[place] -= changes.next().expect("one for each");
            }
            for &place in &region {
                function[place] -= changes.next().expect("one for each");
            }
        }
        changed
    }
}

#[cfg(test)]
mod tests {
    use super::super::parallel::Parallel;
    use super::super::parallel::tests::{log, truth};
    use super::*;

    #[test]
    fn normal_equations_are_those_of_differences() {
        let mut cells = truth();
        sharpen(&mut cells, 5.0);
        let mut log = log(&cells);
        for (row, position) in log.position.iter_mut().enumerate() {
            *position += 0.01 * (row as f64).sin();
        }
        let logs = [log.part(0, 200)];
        let problem = Soft {
            logs: &logs,
            reading: Reading::Balance,
        };
        let (_, gradient) = problem.normal_equations(&cells);
        const STEP: f64 = 1e-6;
        for number in 0..gradient.len() {
            let moved = |by: f64| {
                let mut change = DVector::zeros(gradient.len());
                change[number] = by;
                problem.cost(&problem.changed(&cells, &change))
            };
            let slope = (moved(-STEP) - moved(STEP)) / (4.0 * STEP);
            let scale = gradient.amax();
            assert!(
                (slope - gradient[number]).abs() < 1e-5 * scale,
                "{number}: {slope} {}",
                gradient[number]
            );
        }
    }

    #[test]
    fn moving_boundaries_off_their_place_more_than_halves_the_cost() {
        let truth = truth();
        let logs = [log(&truth)];
        let mut start = truth.clone();
        start.partition[1][3] -= 0.1;
        start.partition[2][3] += 0.1;
        let problem = Parallel {
            logs: &logs,
            fitted: Reading::Balance.fitted(),
        };
        let held = Fit::new(&problem, start).run(&problem, 60);
        let moved = refine(&logs, Reading::Balance, held.cells.clone());
        let moved = Fit::new(&problem, moved).run(&problem, 60);
        assert!(moved.cost < 0.5 * held.cost, "{} {}", held.cost, moved.cost);
    }
}
