//! Errors on data that a fit has not seen, and whether one model is better than another on it.

use super::replay::{Data, WindowError};
use crate::numeric::statistics::median;
use crate::numeric::wilcoxon::signed_rank;
use heapless::Vec;

/// Most blocks that held-out errors are kept for.
pub const MOST_BLOCKS: usize = 64;

/// Error of the whole test, shared among the candidates of a round and, for each, among the shapes
/// that were tried for it.
const SIGNIFICANCE: f64 = 0.01;

/// Held-out mean square error that a larger model must fall below, as a share of the smaller one's.
pub const LARGEST_RATIO: f64 = 0.9;

/// Least median over blocks of the logarithm of the two errors' ratio.
const LEAST_MEDIAN: f32 = 0.05;

/// Gain that is of no interest, as the logarithm of the mean square: one percent of the error. That much
/// is left to be explained where nothing is missing, by restarts and by rounding, and a test in enough
/// blocks finds it.
const NO_GAIN: f32 = 0.02;

/// Held-out errors by block and channel.
pub type HeldOut = Vec<WindowError, MOST_BLOCKS>;

/// Two models compared on held-out blocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// Mean square error of the larger model over that of the smaller, product over the channels.
    pub ratio: f64,
    /// One-sided Wilcoxon p of so large a gain, if the larger model had no more than one percent of the
    /// error to gain.
    pub p_value: f64,
    /// Median over blocks of the logarithm of the smaller model's error over the larger one's.
    pub median: f32,
}

/// Why a larger model is refused.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Refusal {
    /// The held-out gain is not significant.
    NotSignificant {
        /// The p-value that it would have to be below, shared among all looks.
        required: f64,
    },
    /// The held-out error falls too little.
    GainTooSmall,
    /// The held-out gain comes from few blocks.
    GainNotCommon,
    /// Fitted without it from where the fit with it has come to, the model follows the log as well.
    NotNeeded,
    /// The fitted strength is within three standard deviations of zero.
    Uncertain,
}

impl Comparison {
    /// Whether the larger model is refused, as one of `looks` that were taken at the data.
    pub fn refusal(&self, looks: usize) -> Option<Refusal> {
        let required = SIGNIFICANCE / looks.max(1) as f64;
        if self.p_value >= required {
            Some(Refusal::NotSignificant { required })
        } else if self.ratio > LARGEST_RATIO {
            Some(Refusal::GainTooSmall)
        } else if self.median < LEAST_MEDIAN {
            Some(Refusal::GainNotCommon)
        } else {
            None
        }
    }
}

/// Windows in a block: about as long as asked, at least two dozen blocks where the log allows it.
pub fn windows_per_block(data: &Data, samples: usize) -> usize {
    let windows = data.windows();
    let asked = (samples as f32 / data.settings.window as f32 + 0.5) as usize;
    asked
        .min(windows / 24)
        .max(windows.div_ceil(MOST_BLOCKS))
        .max(1)
}

/// Which blocks take part in a comparison.
pub type Mask = Vec<bool, MOST_BLOCKS>;

/// As [`compare`], the test over the blocks of a mask alone: those in which the larger model may
/// differ from the smaller one. The ratio is that of all blocks.
// Not part of a frame under which models are fitted.
#[inline(never)]
pub fn compare_within(smaller: &HeldOut, larger: &HeldOut, mask: &Mask) -> Comparison {
    let within = |blocks: &HeldOut| -> HeldOut {
        let chosen = blocks.iter().zip(mask).filter(|(_, within)| **within);
        chosen.map(|(block, _)| *block).collect()
    };
    Comparison {
        ratio: compare(smaller, larger).ratio,
        ..compare(&within(smaller), &within(larger))
    }
}

/// Compares two models block by block. The channels' logarithms add: each has its own, unknown
/// noise, and a channel that is mere noise does not hide a gain in the other.
pub fn compare(smaller: &HeldOut, larger: &HeldOut) -> Comparison {
    let mut differences: Vec<f32, MOST_BLOCKS> = Vec::new();
    let mut totals = [WindowError::default(); 2];
    for (before, after) in smaller.iter().zip(larger) {
        let gain = |before: f32, after: f32| {
            if before > 0.0 && after > 0.0 {
                libm::logf(before / after)
            } else {
                0.0
            }
        };
        let _ = differences
            .push(gain(before.position, after.position) + gain(before.current, after.current));
        for (total, error) in totals.iter_mut().zip([before, after]) {
            total.position += error.position;
            total.current += error.current;
        }
    }
    let ratio = |before: f32, after: f32| {
        if before > 0.0 {
            f64::from(after) / f64::from(before)
        } else {
            1.0
        }
    };
    let median = median(&mut differences).unwrap_or(0.0);
    for difference in &mut differences {
        *difference -= NO_GAIN;
    }
    let p_value = signed_rank(&mut differences).map_or(1.0, |test| test.p_value);
    Comparison {
        ratio: ratio(totals[0].position, totals[1].position)
            * ratio(totals[0].current, totals[1].current),
        p_value,
        median,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blocks whose error, that of the first model 1, falls by this share.
    fn gain(share: f32) -> Comparison {
        let blocks = |error: f32| -> HeldOut {
            let block = WindowError {
                position: error * error,
                ..WindowError::default()
            };
            (0..20).map(|_| block).collect()
        };
        compare(&blocks(1.0), &blocks(1.0 - share))
    }

    #[test]
    fn a_gain_of_less_than_one_percent_is_none_however_common() {
        assert_eq!(gain(0.009).p_value, 1.0);
        // All blocks gain: one of 2²⁰ choices of signs.
        assert_eq!(gain(0.011).p_value, 1.0 / f64::from(1 << 20));
    }
}
