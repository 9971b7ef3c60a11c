//! Derivatives of a free run by the coefficients of the sub-models.
//!
//! They follow the model's own recursion,
//!
//! ```text
//! dy(k)/dθ = dy(k−1)/dθ + a_i dΔ(k−1)/dθ + s_i dy(k−1)/dθ + (1, Δ, u, y at the places of cell i)
//! ```
//!
//! in the cell i that is active, and are zero where a stop holds the output. That a coefficient also
//! moves the instant of a transition they do not know.

use super::model::{CHANGE, Model, POSITION, value};
use super::series::Series;

/// A free run with the derivatives of its state.
pub(super) struct Sensitivities<'a> {
    model: &'a Model,
    series: &'a Series,
    /// The coefficients of each sub-model that are meant.
    free: &'a [usize],
    /// The position at the last sample.
    pub position: f64,
    change: f64,
    /// Its derivatives, cell by cell.
    pub of_position: Vec<f64>,
    of_change: Vec<f64>,
}

impl<'a> Sensitivities<'a> {
    /// At the first sample of a series, at rest.
    pub fn new(model: &'a Model, series: &'a Series, free: &'a [usize]) -> Self {
        let zeros = vec![0.0; model.cells.len() * free.len()];
        Self {
            model,
            series,
            free,
            position: series.position[0],
            change: 0.0,
            of_position: zeros.clone(),
            of_change: zeros,
        }
    }

    /// Goes on to a sample, the one after the last.
    pub fn advance(&mut self, sample: usize) {
        let input = self.series.input[sample - 1];
        let regressor = [1.0, self.change, input, self.position];
        let number = self.model.cell(&regressor);
        let growth = &self.model.cells[number].growth;
        let unconfined = self.position + value(growth, &regressor);
        let next = unconfined.clamp(self.model.lower, self.model.upper);
        if next == unconfined {
            for (change, position) in self.of_change.iter_mut().zip(&mut self.of_position) {
                *change = growth[CHANGE] * *change + growth[POSITION] * *position;
                *position += *change;
            }
            for (place, &coefficient) in self.free.iter().enumerate() {
                let index = number * self.free.len() + place;
                self.of_change[index] += regressor[coefficient];
                self.of_position[index] += regressor[coefficient];
            }
        } else {
            for (change, position) in self.of_change.iter_mut().zip(&mut self.of_position) {
                *change = -*position;
                *position = 0.0;
            }
        }
        self.change = next - self.position;
        self.position = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pwa::model::tests::{driven, example};

    const FREE: [usize; 4] = [0, 1, 2, 3];
    /// So small that no sample crosses a border by it.
    const DIFFERENCE: f64 = 1e-8;

    /// Positions of a free run.
    fn run(model: &Model, series: &Series) -> Vec<f64> {
        let mut run = Sensitivities::new(model, series, &FREE);
        let samples = 1..series.samples();
        let positions = samples.map(|sample| {
            run.advance(sample);
            run.position
        });
        positions.collect()
    }

    #[test]
    fn they_are_what_differences_say() {
        let model = example();
        let series = driven(&model, 400, 3);
        for number in 0..model.cells.len() * FREE.len() {
            let (cell, coefficient) = (number / FREE.len(), number % FREE.len());
            let moved = |by: f64| {
                let mut moved = model.clone();
                moved.cells[cell].growth[coefficient] += by;
                run(&moved, &series)
            };
            let (above, below) = (moved(DIFFERENCE), moved(-DIFFERENCE));
            let mut sensitivities = Sensitivities::new(&model, &series, &FREE);
            for sample in 1..series.samples() {
                sensitivities.advance(sample);
                let expected = (above[sample - 1] - below[sample - 1]) / (2.0 * DIFFERENCE);
                let found = sensitivities.of_position[number];
                let tolerance = 1e-6 * (1.0 + expected.abs());
                assert!(
                    (found - expected).abs() < tolerance,
                    "number {number}, sample {sample}: {found} {expected}"
                );
            }
        }
        let stops = run(&model, &series);
        let held = |limit: f64| stops.contains(&limit);
        assert!(held(model.lower) && held(model.upper));
    }
}
