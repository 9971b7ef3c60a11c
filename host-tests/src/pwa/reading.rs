//! What the partition sees of the regressor, and what the sub-models use of it.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::k_means::Point;
use super::model::{Affine, REGRESSORS, value};

/// How the paper's choice of a regressor is read.
///
/// The paper clusters by Δy = y(k−1) − y(k−2) and u(k−1), and "excludes" y(k−1). Whether the
/// sub-models lose it too is not said; a throttle with a return spring rests where the spring asks
/// for, which no sub-model without y(k−1) can say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reading {
    /// y(k) is affine in (Δy, u): eqs. 21 and 22 with the new regressor put in, to the letter.
    Output,
    /// The growth y(k) − y(k−1) is affine in (Δy, u).
    Growth,
    /// The partition is in (Δy, u), sub-models are affine in (y(k−1), y(k−2), u).
    Velocity,
    /// The partition is in (Δy, u, y(k−1)), sub-models as before.
    Position,
    /// The partition is in (Δy, u − s·y(k−1)), s the slope of the line on which spring and motor
    /// balance, from the data: what is left of the input to overcome friction. Sub-models as before.
    Balance,
}

impl Reading {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Output,
        Self::Growth,
        Self::Velocity,
        Self::Position,
        Self::Balance,
    ];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Output => "output",
            Self::Growth => "growth",
            Self::Velocity => "velocity",
            Self::Position => "position",
            Self::Balance => "balance",
        }
    }

    /// Coefficients of a sub-model that are fitted: position, change, input, constant.
    pub fn fitted(self) -> [bool; REGRESSORS] {
        let position = !matches!(self, Self::Output | Self::Growth);
        [position, true, true, true]
    }

    /// The coefficient of the position where it is not fitted: the growth takes y(k−1) off again, or
    /// does not know it.
    pub fn given(self) -> f64 {
        if self == Self::Output { -1.0 } else { 0.0 }
    }

    /// Coefficients of the partition's functions that are not zero.
    pub fn partitioned(self) -> [bool; REGRESSORS] {
        let position = matches!(self, Self::Position | Self::Balance);
        [position, true, true, true]
    }
}

impl fmt::Display for Reading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Reading {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let found = Self::ALL.into_iter().find(|reading| reading.name() == name);
        found.ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("no reading \"{name}\"; expected one of {names}")
        })
    }
}

/// The plane or space in which k-means works: linear in the regressor, every axis scaled by the
/// spread of the samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Two axes or three: Δy, the input or what is left of it, position.
    pub axes: [Affine; 3],
}

/// What a change counts, in the spread of the samples. Much less than its spread: friction differs
/// between standstill and a slow motion, where the samples of fast motions stretch the axis.
/// Measured on the stand, see [`crate::pwa`].
const CHANGE_WEIGHT: f64 = 0.5;

impl Plane {
    /// From samples, and the slope of the balance line in units of the input per rad or m.
    pub fn new(reading: Reading, samples: &[(Affine, f64)], slope: f64) -> Self {
        let scaled = |axis: Affine, weight: f64| {
            let values = samples.iter().map(|(x, _)| value(&axis, x));
            let mean = values.clone().sum::<f64>() / samples.len() as f64;
            let variance = values.map(|v| (v - mean) * (v - mean)).sum::<f64>();
            let spread = (variance / samples.len() as f64).sqrt().max(1e-12);
            axis.map(|coefficient| weight * coefficient / spread)
        };
        let change = scaled([0.0, 1.0, 0.0, 0.0], CHANGE_WEIGHT);
        let input = scaled([0.0, 0.0, 1.0, 0.0], 1.0);
        let position = scaled([1.0, 0.0, 0.0, 0.0], 1.0);
        let axes = match reading {
            Reading::Output | Reading::Growth | Reading::Velocity => [change, input, [0.0; 4]],
            Reading::Position => [change, input, position],
            Reading::Balance => {
                let mut left = input;
                left[0] = -slope * input[2];
                [change, left, [0.0; 4]]
            }
        };
        Self { axes }
    }

    /// Where a regressor lies.
    pub fn point(&self, regressor: &Affine) -> Point {
        self.axes.map(|axis| value(&axis, regressor))
    }

    /// A function of the regressor that is largest, among those of other centres, where this centre
    /// is nearest: c·z − ½ |c|².
    pub fn region(&self, centre: &Point) -> Affine {
        let mut region = [0.0; REGRESSORS];
        for (axis, coordinate) in self.axes.iter().zip(centre) {
            for (sum, coefficient) in region.iter_mut().zip(axis) {
                *sum += coordinate * coefficient;
            }
        }
        region[REGRESSORS - 1] = -0.5 * centre.iter().map(|c| c * c).sum::<f64>();
        region
    }
}
