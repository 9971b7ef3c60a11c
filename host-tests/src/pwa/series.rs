//! A log at the sample time of the model, and which of its samples are for what.

use crate::failure::Failure;
use crate::log::Log;

/// Samples of a log at the period of a model.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Series {
    /// Position at each sample, rad or m.
    pub position: Vec<f64>,
    /// Mean of the input from each sample to the next.
    pub input: Vec<f64>,
}

impl Series {
    /// A log at a sample time.
    ///
    /// The input of a sample is the mean of the inputs held over it, which is what a motor's speed
    /// answers to. The position is the mean of the rows around it, symmetric and so without delay:
    /// the difference of two positions consists of noise otherwise wherever the machine is slow.
    ///
    /// # Errors
    /// A sample time that is no multiple of the log's period.
    pub fn of(log: &Log, period_s: f64) -> Result<Self, Failure> {
        let rows = rows(log, period_s)?;
        let samples = log.samples() / rows;
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let around = |sample: usize| {
            let row = sample * rows;
            // At the ends there are fewer rows, but as many on either side.
            let reach = ((rows - 1) / 2).min(row).min(log.samples() - 1 - row);
            mean(&log.position[row - reach..=row + reach])
        };
        Ok(Self {
            position: (0..samples).map(around).collect(),
            input: (0..samples)
                .map(|sample| mean(&log.input[sample * rows..(sample + 1) * rows]))
                .collect(),
        })
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.position.len()
    }

    /// The step that ends on a sample, from the third one on.
    pub fn step(&self, sample: usize) -> Step {
        let [last, now] = [sample - 1, sample].map(|sample| self.position[sample]);
        Step {
            regressor: [
                1.0,
                last - self.position[sample - 2],
                self.input[sample - 1],
                last,
            ],
            growth: now - last,
        }
    }
}

/// Rows of a log in a sample.
fn rows(log: &Log, period_s: f64) -> Result<usize, Failure> {
    let ratio = period_s / log.period_s;
    let rows = ratio.round();
    if rows >= 1.0 && (ratio - rows).abs() <= 1e-3 * rows {
        return Ok(rows as usize);
    }
    Err(Failure::other(format!(
        "{}: its period is {} s, and the sample time of the model, {period_s} s, is no multiple of it; \
         choose one",
        log.path.display(),
        log.period_s
    )))
}

/// Which samples of the training data count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    /// Those that parameters are fitted to.
    Fit,
    /// Those by which the number of clusters is chosen.
    HeldOut,
    /// All: what the chosen model is fitted to in the end.
    All,
}

/// Of five blocks the last one is held out.
const BLOCKS: usize = 5;

/// The training data.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Data {
    /// One for each log.
    pub series: Vec<Series>,
    /// Samples in a block. A model runs freely through all blocks and never starts anew.
    pub block: usize,
}

impl Data {
    /// Whether a sample belongs to a part.
    #[inline]
    pub fn has(&self, part: Part, sample: usize) -> bool {
        match part {
            Part::All => true,
            Part::Fit => (sample / self.block) % BLOCKS != BLOCKS - 1,
            Part::HeldOut => (sample / self.block) % BLOCKS == BLOCKS - 1,
        }
    }

    /// Samples of a part.
    pub fn count(&self, part: Part) -> usize {
        let of = |series: &Series| {
            (1..series.samples())
                .filter(|&sample| self.has(part, sample))
                .count()
        };
        self.series.iter().map(of).sum()
    }

    /// The measured steps of a part.
    pub fn steps(&self, part: Part) -> Vec<Step> {
        let of = |series: &Series| -> Vec<Step> {
            (2..series.samples())
                .filter(|&sample| self.has(part, sample))
                .map(|sample| series.step(sample))
                .collect()
        };
        self.series.iter().flat_map(of).collect()
    }
}

/// A regressor as it was measured, and the growth that followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Step {
    /// 1, y(k−1) − y(k−2), u(k−1), y(k−1).
    pub regressor: [f64; 4],
    /// y(k) − y(k−1).
    pub growth: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_has_the_mean_input_after_it_and_the_mean_position_around_it() {
        let rows = 15;
        let log = Log {
            path: "line.csv".into(),
            start_s: 0.0,
            period_s: 1e-3,
            input: (0..rows).map(f64::from).collect(),
            position: (0..rows).map(|row| 2.0 * f64::from(row)).collect(),
            ..Log::default()
        };
        let series = Series::of(&log, 5e-3).unwrap();
        assert_eq!(series.input, [2.0, 7.0, 12.0]);
        // A straight line is its own symmetric mean.
        assert_eq!(series.position, [0.0, 10.0, 20.0]);
        for period_s in [0.0, 5e-4, 2.5e-3, f64::NAN] {
            assert!(Series::of(&log, period_s).is_err(), "{period_s}");
        }
    }

    #[test]
    fn every_fifth_block_is_held_out() {
        let data = Data {
            series: Vec::new(),
            block: 3,
        };
        let held: Vec<usize> = (0..30).filter(|&k| data.has(Part::HeldOut, k)).collect();
        assert_eq!(held, [12, 13, 14, 27, 28, 29]);
        assert!((0..30).all(|k| data.has(Part::Fit, k) != data.has(Part::HeldOut, k)));
    }
}
