//! What the model predicts from, and in which space it is partitioned.

use nalgebra::{DMatrix, DVector};

use super::model::{Affine, CHANGE, INPUT, POSITION, value};
use super::series::Step;

/// Dimensions of the space that is clustered, at most.
pub(super) const DIMENSIONS: usize = 3;

/// How much a standard deviation of y(k−1) − y(k−2) counts beside one of the rest. Fast motion is
/// rare and far out: with 1 it gets most of the clusters, and the border to standstill too few.
const CHANGE_WEIGHT: f64 = 0.5;

/// How the regressor of the paper is read. Δ = y(k−1) − y(k−2), u = u(k−1), y = y(k−1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Reading {
    /// To the letter: partition in (Δ, u), y(k) = a Δ + b u + f.
    Output,
    /// The paper's, as it can be meant: partition in (Δ, u), y(k) − y(k−1) = a Δ + b u + f.
    Growth,
    /// Partition in (Δ, u), sub-models with s y beside: affine in y(k−1), y(k−2), u(k−1), as eqs. 21
    /// and 22 have it.
    Velocity,
    /// Partition in (Δ, u, y), sub-models with y.
    Position,
    /// Partition in (Δ, u − m y), sub-models with y. The slope m is the share of the input that the
    /// spring takes for each rad or m: u − m y is what is left for friction.
    #[default]
    Balance,
}

impl Reading {
    /// All, in the order in which they know more.
    pub const ALL: [Self; 5] = [
        Self::Output,
        Self::Growth,
        Self::Velocity,
        Self::Position,
        Self::Balance,
    ];

    /// What it is called in a table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Output => "output",
            Self::Growth => "growth",
            Self::Velocity => "velocity",
            Self::Position => "position",
            Self::Balance => "balance",
        }
    }

    /// The coefficients that are identified.
    pub(super) fn free(self) -> &'static [usize] {
        match self {
            Self::Output | Self::Growth => &[0, CHANGE, INPUT],
            _ => &[0, CHANGE, INPUT, POSITION],
        }
    }

    /// The coefficients before anything is identified. A growth of −y + … is y(k) = ….
    pub(super) fn fixed(self) -> Affine {
        match self {
            Self::Output => [0.0, 0.0, 0.0, -1.0],
            _ => [0.0; 4],
        }
    }

    /// Keeps a sub-model from swinging up: the speed of a machine with friction decays, and does not
    /// ring. To the letter there is no speed to decay.
    pub(super) fn steady(self, growth: &mut Affine) {
        if self != Self::Output {
            growth[CHANGE] = growth[CHANGE].clamp(0.0, 1.0);
        }
    }

    /// The clustered space: the regressor's coordinates, each over its standard deviation.
    pub(super) fn space(self, steps: &[Step]) -> Space {
        let [_, change, input, position] = deviations(steps);
        let mut rows = [[0.0; 4]; DIMENSIONS];
        rows[0][CHANGE] = CHANGE_WEIGHT / change;
        rows[1][INPUT] = 1.0 / input;
        match self {
            Self::Position => rows[2][POSITION] = 1.0 / position,
            Self::Balance => rows[1][POSITION] = -spring_slope(steps) / input,
            _ => {}
        }
        Space { rows }
    }
}

/// A linear map of the regressor to the space that is clustered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Space {
    /// A row for each dimension; those of zeros do not count.
    pub rows: [Affine; DIMENSIONS],
}

impl Space {
    /// The image of a regressor.
    pub fn point(&self, regressor: &Affine) -> [f64; DIMENSIONS] {
        self.rows.map(|row| value(&row, regressor))
    }

    /// Dimensions that count.
    pub fn dimensions(&self) -> usize {
        self.rows.iter().filter(|row| **row != [0.0; 4]).count()
    }
}

/// Standard deviation of each regressor, 1 for what does not vary.
fn deviations(steps: &[Step]) -> Affine {
    let count = steps.len() as f64;
    std::array::from_fn(|which| {
        let values = || steps.iter().map(|step| step.regressor[which]);
        let mean = values().sum::<f64>() / count;
        let variance = values().map(|value| (value - mean).powi(2)).sum::<f64>() / count;
        if variance > 0.0 { variance.sqrt() } else { 1.0 }
    })
}

/// m: by how much the input that balances the machine changes with its position.
///
/// From least squares over the steps in motion: the growth is affine in Δ, u, y and, for
/// friction, the sign of Δ. 0 where that says nothing.
fn spring_slope(steps: &[Step]) -> f64 {
    let rms = (steps
        .iter()
        .map(|step| step.regressor[CHANGE].powi(2))
        .sum::<f64>()
        / steps.len() as f64)
        .sqrt();
    let mut gram = DMatrix::<f64>::zeros(5, 5);
    let mut moment = DVector::<f64>::zeros(5);
    for step in steps {
        let [one, change, input, position] = step.regressor;
        if change.abs() > 0.3 * rms {
            let row = DVector::from_column_slice(&[one, change, input, position, change.signum()]);
            gram.ger(1.0, &row, &row, 1.0);
            moment.axpy(step.growth, &row, 1.0);
        }
    }
    let slope = gram.cholesky().map_or(0.0, |factor| {
        let solution = factor.solve(&moment);
        -solution[POSITION] / solution[INPUT]
    });
    if slope.is_finite() { slope } else { 0.0 }
}
