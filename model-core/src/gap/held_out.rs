//! Errors on data that a fit has not seen, and whether one model is better than another on it.

use super::criterion::{
    FEW_BLOCKS, LARGEST_RATIO, LEAST_BLOCKS, LEAST_MEDIAN, NO_GAIN, SIGNIFICANCE, UNLIKE,
};
use super::model::Base;
use super::replay::{Data, WindowError};
use crate::numeric::statistics::median;
use crate::numeric::student;
use crate::numeric::wilcoxon::signed_rank;
use heapless::Vec;

/// Most blocks that held-out errors are kept for.
pub const MOST_BLOCKS: usize = 64;

/// Held-out errors by block and channel. A block that was not tested is empty.
pub type HeldOut = Vec<WindowError, MOST_BLOCKS>;

/// Two models compared on held-out blocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// Mean square error of the larger model over that of the smaller, product over the channels.
    pub ratio: f64,
    /// One-sided Wilcoxon p of so large a gain, if the larger model had no more than one percent of the
    /// error to gain. Of few blocks twice the lesser of that and of the paired t-test's.
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
    /// The fitted strength is not significantly other than zero.
    Uncertain,
    /// With it this fitted number has gone beyond its limits.
    Implausible(Base),
    /// Over shorter or longer predictions the model is clearly worse with it.
    WorseElsewhere,
    /// The model still does not follow the log, and most of what it missed is missing still: that may be this effect beside
    /// others, or another one in the place of all.
    ExplainsTooLittle,
    /// It is found over predictions of one length, and not over those of another.
    OverOneLength,
}

impl Comparison {
    /// Whether nothing speaks for the larger model: its error falls in less than half of the blocks, and not
    /// as a whole.
    pub fn is_hopeless(&self) -> bool {
        self.median <= 0.0 && self.ratio > LARGEST_RATIO
    }

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

/// Windows in a block: about as long as asked, at least [`LEAST_BLOCKS`] blocks where the log allows it.
pub fn windows_per_block(data: &Data, samples: usize) -> usize {
    let windows = data.windows();
    let asked = (samples as f32 / data.settings.window as f32 + 0.5) as usize;
    asked
        .min(windows / LEAST_BLOCKS)
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

/// Whether nothing speaks for the larger model: its error falls in less than half of the tested blocks of a
/// mask, and in all tested blocks together not by much. If none of the mask's was tested, nothing speaks
/// against it.
pub fn is_hopeless_within(smaller: &HeldOut, larger: &HeldOut, mask: &Mask) -> bool {
    let mut within = larger.iter().zip(mask).filter(|(_, within)| **within);
    within.any(|(block, _)| is_tested(block)) && compare_within(smaller, larger, mask).is_hopeless()
}

/// Whether a block was tested: one that was has at least the floor of the errors.
fn is_tested(block: &WindowError) -> bool {
    block.position > 0.0
}

/// Held-out error of a log as a whole, by channel.
#[derive(Debug, Clone, Copy, Default)]
pub struct Total {
    position: f32,
    current: f32,
}

impl Total {
    /// Of all blocks.
    pub fn of(blocks: &HeldOut) -> Self {
        let mut total = Self::default();
        for error in blocks {
            total.add(error);
        }
        total
    }

    fn add(&mut self, error: &WindowError) {
        self.position += error.position;
        self.current += error.current;
    }

    /// It over another one, product over the channels.
    pub fn over(&self, other: &Self) -> f64 {
        let ratio = |before: f32, after: f32| {
            if before > 0.0 {
                f64::from(after) / f64::from(before)
            } else {
                1.0
            }
        };
        ratio(other.position, self.position) * ratio(other.current, self.current)
    }
}

/// Compares two models block by block. The channels' logarithms add: each has its own, unknown
/// noise, and a channel that is mere noise does not hide a gain in the other. Blocks in which the larger
/// model was not tested take no part.
pub fn compare(smaller: &HeldOut, larger: &HeldOut) -> Comparison {
    let mut differences: Vec<f32, MOST_BLOCKS> = Vec::new();
    let mut totals = [Total::default(); 2];
    let pairs = smaller.iter().zip(larger);
    for (before, after) in pairs.filter(|(_, after)| is_tested(after)) {
        let gain = |before: f32, after: f32| {
            if before > 0.0 && after > 0.0 {
                libm::logf(before / after)
            } else {
                0.0
            }
        };
        let difference =
            gain(before.position, after.position) + gain(before.current, after.current);
        if (difference - NO_GAIN).abs() > UNLIKE * NO_GAIN {
            let _ = differences.push(difference);
        }
        for (total, error) in totals.iter_mut().zip([before, after]) {
            total.add(error);
        }
    }
    let median = median(&mut differences).unwrap_or(0.0);
    for difference in &mut differences {
        *difference -= NO_GAIN;
    }
    let p_value = p_value(&mut differences);
    Comparison {
        ratio: totals[1].over(&totals[0]),
        p_value,
        median,
    }
}

/// P of such gains, or larger ones, by blocks, if there is none. The differences are reordered.
///
/// Where the blocks are few, also by what ranks do not see: that the gains are alike, and far from zero. A
/// log with ten reversals shows a play in ten blocks, however wide it is. Either test may prove it, so twice
/// the lesser p counts.
fn p_value(differences: &mut [f32]) -> f64 {
    let by_ranks = signed_rank(differences).map_or(1.0, |test| test.p_value);
    if differences.len() >= FEW_BLOCKS {
        return by_ranks;
    }
    (2.0 * by_ranks.min(paired_t(differences))).min(1.0)
}

/// P of such a mean of the differences, or a larger one, if they are normal about zero (Student, *The
/// probable error of a mean*, 1908). 1 where they are fewer than two, or all the same.
fn paired_t(differences: &[f32]) -> f64 {
    let count = differences.len() as f64;
    let mean = differences.iter().map(|&it| f64::from(it)).sum::<f64>() / count;
    let square = |&it: &f32| (f64::from(it) - mean) * (f64::from(it) - mean);
    let squares: f64 = differences.iter().map(square).sum();
    if squares > 0.0 {
        let freedom = count - 1.0;
        student::upper_tail(mean / libm::sqrt(squares / (count * freedom)), freedom)
    } else {
        1.0
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
    fn a_gain_of_two_percent_is_none_however_common() {
        assert_eq!(gain(0.022).p_value, 1.0);
        // All blocks gain: one of 2²⁰ choices of signs.
        assert_eq!(gain(0.023).p_value, 1.0 / f64::from(1 << 20));
    }

    /// Twelve blocks in which the error falls to a half, among so many in which nothing changes, as where the machine
    /// rests: one of 2¹² choices of signs, doubled, for they are few.
    #[test]
    fn blocks_in_which_nothing_differs_say_nothing() {
        for resting in [0, 12, 40] {
            let blocks = |error: f32| -> HeldOut {
                let position = |block: usize| if block < 12 { error * error } else { 1.0 };
                (0..12 + resting)
                    .map(|block| WindowError {
                        // Of unlike blocks the t-test says less than the ranks.
                        position: position(block)
                            * if block == 0 && error < 1.0 { 0.01 } else { 1.0 },
                        ..WindowError::default()
                    })
                    .collect()
            };
            let comparison = compare(&blocks(1.0), &blocks(0.5));
            assert_eq!(comparison.p_value, 2.0 / f64::from(1 << 12), "{resting}");
            assert_eq!(comparison.median, libm::logf(4.0), "{resting}");
        }
    }

    /// `scipy.stats.ttest_1samp(d, 0.0, alternative='greater')` and `scipy.stats.wilcoxon(d,
    /// alternative='greater')`, SciPy 1.17, the lesser of them doubled.
    #[test]
    fn few_blocks_are_proven_by_either_test() {
        for (differences, expected) in [
            // All gain, and alike: Wilcoxon's p is 1/64.
            (
                &mut [9.1, 9.5, 8.9, 9.0, 9.4, 9.2][..],
                1.098_151_118_598_835e-9,
            ),
            (
                &mut [1.0, -2.0, 3.0, 4.0, -0.5, 6.0][..],
                0.087_595_864_899_305_56,
            ),
            // Of sixteen that all gain, too: Wilcoxon's is 2⁻¹⁶.
            (
                &mut [
                    1.1, 0.9, 1.3, 0.8, 1.2, 1.0, 1.4, 0.7, 1.15, 0.95, 1.25, 0.85, 1.05, 1.35,
                    0.75, 1.45,
                ][..],
                6.861_866_920_417_498e-12,
            ),
            // All gain, but one far more than all others: Student's p is 0.07.
            (&mut [1.0, 2.0, 3.0, 4.0, 9.5, 60.0, 15.0][..], 1.0 / 128.0),
        ] {
            let found = p_value(differences);
            assert!((found / (2.0 * expected) - 1.0).abs() < 1e-9, "{found}");
        }
    }

    /// Two models of which the second one gains in the blocks of `better`, the first three tested.
    fn is_hopeless(better: &[usize], mask: [bool; 6]) -> bool {
        let error = |position: f32| WindowError {
            position,
            ..WindowError::default()
        };
        let smaller: HeldOut = [error(1.0); 6].into_iter().collect();
        let mut larger = HeldOut::new();
        let _ = larger.resize(3, error(1.0));
        let _ = larger.resize(6, error(0.0));
        for &block in better {
            larger[block] = error(0.8);
        }
        is_hopeless_within(&smaller, &larger, &mask.into_iter().collect())
    }

    #[test]
    fn only_blocks_in_which_an_effect_may_show_speak_against_it() {
        const EVERYWHERE: [bool; 6] = [true; 6];
        assert!(is_hopeless(&[], EVERYWHERE));
        assert!(!is_hopeless(&[0, 1], EVERYWHERE));
        // One of three blocks, which is the only one where it may show.
        assert!(!is_hopeless(&[2], [false, false, true, false, true, false]));
        // It may show in blocks that were not tested.
        assert!(!is_hopeless(&[], [false, false, false, true, true, true]));
    }

    #[test]
    fn whatever_their_number_alike_gains_prove_what_the_most_looks_ask_for() {
        for count in 8..=25_u8 {
            let mut gains: Vec<f32, 25> = (0..count)
                .map(|place| 1.0 + 0.05 * f32::from(place % 5))
                .collect();
            let found = p_value(&mut gains);
            assert!(found < 3.4e-6, "{count}: {found}");
        }
    }

    #[test]
    fn no_block_one_block_and_equal_ones_have_no_spread_to_prove_anything_by() {
        assert_eq!(p_value(&mut [5.0]), 1.0);
        assert_eq!(p_value(&mut []), 1.0);
        assert_eq!(p_value(&mut [5.0; 4]), 2.0 / 16.0);
    }
}
