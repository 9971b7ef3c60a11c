//! Which sample of a log belongs to a step of a simulation.

use super::log::Channel;

/// By how much a column of the log is behind a step of the simulation, in samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lateness {
    /// Whole samples; below 0 where it is ahead.
    whole: isize,
    /// What is left: the part of the step in which the sample before still counts, 0 to 1.
    pub share: f32,
}

/// Parts of a sample under which a delay counts as whole: a mode is not worked out for them.
const LEAST_SHARE: f32 = 1e-3;

impl Lateness {
    /// `delay`: by how much it is behind, s; below 0 where it is ahead.
    pub(super) fn new(delay: f32, period: f32) -> Self {
        let samples = delay / period;
        let below = libm::floorf(samples);
        let (whole, share) = (below as isize, samples - below);
        if share < LEAST_SHARE {
            Self { whole, share: 0.0 }
        } else if share > 1.0 - LEAST_SHARE {
            Self {
                whole: whole.saturating_add(1),
                share: 0.0,
            }
        } else {
            Self { whole, share }
        }
    }

    /// The same by one sample more.
    #[inline]
    #[must_use]
    pub fn one_more(self) -> Self {
        Self {
            whole: self.whole.saturating_add(1),
            ..self
        }
    }

    /// Whether what belongs to a step is in the sample that the step starts from.
    #[inline]
    pub fn is_at_hand(self) -> bool {
        self.whole == 0
    }

    /// The sample that belongs to the step from this one; `None` before the first.
    #[inline]
    pub fn behind(self, index: usize) -> Option<usize> {
        index.checked_add_signed(self.whole.saturating_neg())
    }

    /// The same of so many samples; at the ends of a log the nearest.
    #[inline]
    pub fn sample(self, index: usize, samples: usize) -> usize {
        self.behind(index)
            .unwrap_or(0)
            .min(samples.saturating_sub(1))
    }

    /// What a channel has there.
    #[inline]
    pub fn read(self, channel: Channel, index: usize) -> f32 {
        channel.at(self.sample(index, channel.len()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Delays in periods, each with the sample that belongs to the step from sample 5, and the share of that step in which the
    /// one before still counts.
    #[test]
    fn a_delay_reaches_back_and_a_lead_ahead() {
        for (periods, sample, share) in [
            (0.0, 5, 0.0),
            (0.25, 5, 0.25),
            (2.0, 3, 0.0),
            (2.75, 3, 0.75),
            (-0.25, 6, 0.75),
            (-1.0, 6, 0.0),
            (-1.5, 7, 0.5),
            // As near to a whole period as single precision comes.
            (1.0 - f32::EPSILON, 4, 0.0),
            (-1.0 - f32::EPSILON, 6, 0.0),
        ] {
            let late = Lateness::new(periods * 0.5, 0.5);
            assert_eq!(late.behind(5), Some(sample), "{periods}");
            assert_eq!(late.share, share, "{periods}");
            assert_eq!(late.one_more().behind(5), Some(sample - 1), "{periods}");
            assert_eq!(late.is_at_hand(), sample == 5, "{periods}");
        }
    }

    #[test]
    fn at_the_ends_of_a_log_the_nearest_sample_counts() {
        let values = [1.0, 2.0, 3.0];
        let channel = Channel::Values(&values);
        let (late, early) = (Lateness::new(1.0, 0.5), Lateness::new(-1.0, 0.5));
        assert_eq!(late.behind(1), None);
        assert_eq!(
            [0, 1, 2].map(|index| late.read(channel, index)),
            [1.0, 1.0, 1.0]
        );
        assert_eq!(
            [0, 1, 2].map(|index| early.read(channel, index)),
            [3.0, 3.0, 3.0]
        );
    }
}
