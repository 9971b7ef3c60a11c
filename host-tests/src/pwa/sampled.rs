//! A log at the model's period.

use super::model::Affine;
use crate::log::Log;

/// What a model of a longer period sees of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Sampled {
    /// Mean of the input from each sample to the next: a step of the input between two samples
    /// acts for its share of the period.
    pub input: Vec<f64>,
    /// Position at each sample: one more than inputs.
    pub position: Vec<f64>,
}

impl Sampled {
    /// Every `rows`-th row of a log. What is left after the last whole period is not in it.
    pub fn new(log: &Log, rows: usize) -> Self {
        let periods = (log.samples() - 1) / rows;
        let mean = |period: usize| {
            let held = &log.input[period * rows..(period + 1) * rows];
            held.iter().sum::<f64>() / rows as f64
        };
        Self {
            input: (0..periods).map(mean).collect(),
            position: (0..=periods)
                .map(|sample| log.position[sample * rows])
                .collect(),
        }
    }

    /// Periods from `start` to before `end`, with the position at both ends.
    pub fn part(&self, start: usize, end: usize) -> Self {
        Self {
            input: self.input[start..end].to_vec(),
            position: self.position[start..=end].to_vec(),
        }
    }

    /// Number of periods.
    pub fn periods(&self) -> usize {
        self.input.len()
    }

    /// At each period but the first: the regressor (position, its change in the period before,
    /// input, one) and the change of the position in it.
    pub fn pairs(&self) -> impl Iterator<Item = (Affine, f64)> {
        let inputs = self.input.iter().skip(1);
        self.position
            .windows(3)
            .zip(inputs)
            .map(|(at, &input)| ([at[1], at[1] - at[0], input, 1.0], at[2] - at[1]))
    }
}
