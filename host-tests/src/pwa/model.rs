//! The model in double precision, as it is identified.

use model_core::numeric::invalid_parameter::InvalidParameter;
use model_core::plant::piecewise_affine::{self as core_model, Parameters, PiecewiseAffine};

/// Coefficients of an affine function of the regressor, in the order of [`Affine`].
pub(super) const COEFFICIENTS: usize = 4;

/// Places of the coefficients.
pub(super) const CHANGE: usize = 1;
pub(super) const INPUT: usize = 2;
pub(super) const POSITION: usize = 3;

/// An affine function of the regressor: constant, and what y(k−1) − y(k−2), u(k−1) and y(k−1) are
/// multiplied by.
pub(super) type Affine = [f64; COEFFICIENTS];

/// One polyhedron and what holds in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cell {
    /// The regressor belongs to the cell for which this is largest, of equal ones to the first.
    pub region: Affine,
    /// y(k) − y(k−1) in the cell, rad or m.
    pub growth: Affine,
}

/// A piecewise affine model.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Model {
    /// Sample time, s.
    pub period_s: f64,
    /// Least output, rad or m.
    pub lower: f64,
    /// Largest output, rad or m.
    pub upper: f64,
    /// 1 to 10 cells.
    pub cells: Vec<Cell>,
}

/// The value of an affine function.
#[inline]
pub(super) fn value(function: &Affine, regressor: &Affine) -> f64 {
    ((function[0] * regressor[0] + function[CHANGE] * regressor[CHANGE])
        + function[INPUT] * regressor[INPUT])
        + function[POSITION] * regressor[POSITION]
}

impl Model {
    /// The number of the cell that has a regressor.
    #[inline]
    pub fn cell(&self, regressor: &Affine) -> usize {
        let mut best = 0;
        let mut largest = f64::NEG_INFINITY;
        for (number, cell) in self.cells.iter().enumerate() {
            let value = value(&cell.region, regressor);
            if value > largest {
                best = number;
                largest = value;
            }
        }
        best
    }

    /// The model as the core evaluates it.
    ///
    /// Of the regions only differences count, and only their signs: their mean is taken off and the
    /// largest coefficient made 1, so that single precision holds them well.
    ///
    /// # Errors
    /// What the core refuses.
    pub fn core(&self) -> Result<PiecewiseAffine, InvalidParameter> {
        let count = self.cells.len() as f64;
        let mut mean = [0.0; COEFFICIENTS];
        for cell in &self.cells {
            for (sum, coefficient) in mean.iter_mut().zip(cell.region) {
                *sum += coefficient / count;
            }
        }
        let centred = |region: &Affine| -> Affine { std::array::from_fn(|i| region[i] - mean[i]) };
        let coefficients = self.cells.iter().flat_map(|cell| centred(&cell.region));
        let largest = coefficients.fold(0.0_f64, |most, coefficient| most.max(coefficient.abs()));
        let scale = if largest > 0.0 { largest } else { 1.0 };
        let single = |[constant, change, input, position]: Affine| core_model::Affine {
            position: position as f32,
            change: change as f32,
            input: input as f32,
            constant: constant as f32,
        };
        let cells = self.cells.iter().map(|cell| core_model::Cell {
            region: single(centred(&cell.region).map(|coefficient| coefficient / scale)),
            growth: single(cell.growth),
        });
        PiecewiseAffine::build(Parameters {
            period: self.period_s as f32,
            lower_limit: self.lower as f32,
            upper_limit: self.upper as f32,
            cells: cells.collect(),
        })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use model_core::numeric::random::Random;

    use super::*;
    use crate::pwa::series::Series;

    /// Nearly held within a band of the input that moves with a spring; opening and closing beyond it.
    /// It never rests on a limit without being pressed, where it could not be differentiated.
    pub(in crate::pwa) fn example() -> Model {
        let cell = |region, growth| Cell { region, growth };
        Model {
            period_s: 0.01,
            lower: 0.0,
            upper: 1.5,
            cells: vec![
                cell([0.0; 4], [5e-4, 0.3, 0.0, -6e-4]),
                cell([-1.5, 40.0, 1.0, -0.8], [-0.012, 0.75, 0.009, -0.007]),
                cell([-0.5, -40.0, -1.0, 0.8], [0.004, 0.7, 0.008, -0.006]),
            ],
        }
    }

    /// A free run without noise, from the middle, over inputs of a few levels that are held for ten
    /// samples.
    pub(in crate::pwa) fn driven(model: &Model, samples: usize, seed: u64) -> Series {
        let mut random = Random::new(seed, 0);
        let mut input = Vec::with_capacity(samples);
        while input.len() < samples {
            let level = 10.0 * f64::from(random.uniform()) - 4.0;
            input.extend([level; 10]);
        }
        input.truncate(samples);
        let mut position = vec![0.5 * (model.lower + model.upper)];
        let mut change = 0.0;
        for &input in &input[..samples - 1] {
            let last = position[position.len() - 1];
            let regressor = [1.0, change, input, last];
            let growth = value(&model.cells[model.cell(&regressor)].growth, &regressor);
            let next = (last + growth).clamp(model.lower, model.upper);
            change = next - last;
            position.push(next);
        }
        Series { position, input }
    }

    #[test]
    fn the_core_takes_the_same_way() {
        let model = example();
        let series = driven(&model, 150, 3);
        let core = model.core().unwrap();
        let mut state = core.rest(series.position[0] as f32).unwrap();
        for (input, expected) in series.input.iter().zip(&series.position[1..]) {
            let position = core.step(&mut state, *input as f32).unwrap();
            assert!((f64::from(position) - expected).abs() < 1e-5);
        }
    }
}
