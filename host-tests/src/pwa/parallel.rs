//! Parallel identification: the sub-models for which the free run of the model errs least.

use nalgebra::{DMatrix, DVector};

use super::levenberg_marquardt::Problem;
use super::model::{Model, value};
use super::penalty::Penalty;
use super::reading::Reading;
use super::sensitivity::Sensitivities;
use super::series::{Data, Part};

/// Every how many samples the sensitivities are taken: they change little from one to the next.
const STRIDE: usize = 2;

/// What is minimised: which coefficients, on which data. The partition is held.
#[derive(Debug, Clone, Copy)]
pub(super) struct Parallel<'a> {
    /// The training data.
    pub data: &'a Data,
    /// What of it.
    pub part: Part,
    /// The cost of an error.
    pub penalty: Penalty,
    /// Which coefficients are identified.
    pub reading: Reading,
}

impl Problem for Parallel<'_> {
    type Model = Model;

    fn cost(&self, model: &Model, limit: f64) -> f64 {
        let mut sum = 0.0;
        for series in &self.data.series {
            let (mut position, mut change) = (series.position[0], 0.0);
            for sample in 1..series.samples() {
                let regressor = [1.0, change, series.input[sample - 1], position];
                let growth = value(&model.cells[model.cell(&regressor)].growth, &regressor);
                let next = (position + growth).clamp(model.lower, model.upper);
                change = next - position;
                position = next;
                if self.data.has(self.part, sample) {
                    sum += self.penalty.of(position - series.position[sample]);
                    if sum > limit {
                        return f64::INFINITY;
                    }
                }
            }
        }
        sum
    }

    fn normal_equations(&self, model: &Model) -> (DMatrix<f64>, DVector<f64>) {
        let free = self.reading.free();
        let size = model.cells.len() * free.len();
        let mut gram = DMatrix::zeros(size, size);
        let mut slope = DVector::zeros(size);
        for series in &self.data.series {
            let mut run = Sensitivities::new(model, series, free);
            for sample in 1..series.samples() {
                run.advance(sample);
                if sample % STRIDE == 0 && self.data.has(self.part, sample) {
                    let error = run.position - series.position[sample];
                    let weight = self.penalty.weight(error);
                    accumulate(&mut gram, &mut slope, &run.of_position, weight, error);
                }
            }
        }
        gram.fill_upper_triangle_with_lower_triangle();
        (gram, slope)
    }

    fn stepped(&self, model: &Model, step: &DVector<f64>) -> Model {
        let free = self.reading.free();
        let mut model = model.clone();
        let steps = step.as_slice().chunks(free.len());
        for (cell, step) in model.cells.iter_mut().zip(steps) {
            for (&coefficient, step) in free.iter().zip(step) {
                cell.growth[coefficient] -= step;
            }
            self.reading.steady(&mut cell.growth);
        }
        model
    }
}

/// Adds a sample to the lower triangle of JᵀWJ and to JᵀWe.
fn accumulate(
    gram: &mut DMatrix<f64>,
    slope: &mut DVector<f64>,
    row: &[f64],
    weight: f64,
    error: f64,
) {
    let size = row.len();
    for (number, column) in gram.as_mut_slice().chunks_exact_mut(size).enumerate() {
        let factor = weight * row[number];
        // Until its cell was active once.
        if factor != 0.0 {
            slope[number] += factor * error;
            for (sum, value) in column[number..].iter_mut().zip(&row[number..]) {
                *sum += factor * value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pwa::levenberg_marquardt::{Budget, minimise};
    use crate::pwa::model::INPUT;
    use crate::pwa::model::tests::{driven, example};

    #[test]
    fn sub_models_come_out_of_a_free_run_although_the_start_is_off() {
        let model = example();
        let data = Data {
            series: vec![driven(&model, 1500, 1), driven(&model, 1500, 2)],
            block: 200,
        };
        let problem = Parallel {
            data: &data,
            part: Part::All,
            penalty: Penalty::with_scale(0.1),
            reading: Reading::default(),
        };
        let mut start = model.clone();
        for cell in &mut start.cells {
            cell.growth = cell.growth.map(|coefficient| 1.02 * coefficient);
        }
        let budget = Budget {
            iterations: 100,
            gain: 0.0,
        };
        let found = minimise(&problem, &start, budget);
        assert!(problem.cost(&start, f64::INFINITY) > 1e-2);
        assert!(problem.cost(&found, f64::INFINITY) < 1e-12);
        for (found, truth) in found.cells.iter().zip(&model.cells) {
            for (found, truth) in found.growth.iter().zip(truth.growth) {
                assert!((found - truth).abs() < 1e-5, "{found} {truth}");
            }
        }
    }

    #[test]
    fn what_exceeds_the_limit_costs_infinitely_much() {
        let model = example();
        let data = Data {
            series: vec![driven(&model, 500, 1)],
            block: 100,
        };
        let problem = Parallel {
            data: &data,
            part: Part::All,
            penalty: Penalty::with_scale(0.1),
            reading: Reading::default(),
        };
        let mut other = model.clone();
        other.cells[1].growth[INPUT] *= 1.1;
        let cost = problem.cost(&other, f64::INFINITY);
        assert!(cost > 0.0 && cost.is_finite());
        assert_eq!(problem.cost(&other, 1.01 * cost), cost);
        assert_eq!(problem.cost(&other, 0.99 * cost), f64::INFINITY);
    }
}
