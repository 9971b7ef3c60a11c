//! APRTS: amplitude-modulated pseudo-random steps.

use super::time;
use crate::numeric::invalid_parameter::{InvalidParameter, require, require_finite};
use crate::numeric::random::Random;

/// 2⁶⁴ over the golden ratio: spreads neighbouring numbers of steps over all seeds.
const SPREAD: u64 = 0x9e37_79b9_7f4a_7c15;

/// Levels, holds and seed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters {
    /// Least level.
    pub lower: f32,
    /// Largest level, not below the least.
    pub upper: f32,
    /// Shortest hold in s, rounded to a whole period: at least one.
    pub shortest_hold: f32,
    /// Longest hold in s, rounded to a whole period: not below the shortest.
    pub longest_hold: f32,
    /// Another seed is another signal.
    pub seed: u64,
}

impl Parameters {
    /// The signal for a `period` in s.
    pub fn build(self, period: f32) -> Result<Aprts, InvalidParameter> {
        require_finite(self.lower, "lower")?;
        let range = self.upper - self.lower;
        require(
            range >= 0.0 && range.is_finite(),
            "upper",
            "must not be below lower, within f32",
        )?;
        let shortest = time::ticks(self.shortest_hold, period, "shortest_hold")?;
        require(shortest > 0, "shortest_hold", "must be at least one period")?;
        let longest = time::ticks(self.longest_hold, period, "longest_hold")?;
        require(
            longest >= shortest,
            "longest_hold",
            "must not be below the shortest",
        )?;
        let slack = (longest - shortest) / 2;
        Ok(Aprts {
            lower: self.lower,
            range,
            cell: shortest + slack,
            slack,
            seed: self.seed,
        })
    }
}

/// Steps to levels that are uniform between two bounds, held for random times between two others:
/// the multi-step signal that excites the dynamics at every amplitude (O. Nelles, *Nonlinear System
/// Identification*, Springer 2001, §17.7).
///
/// Step n comes at n·c + s, with c the mean of the two holds and s uniform between 0 and half of
/// their difference. So a hold is at least the shortest and at most the longest, most often near the
/// mean (a triangular distribution), and the value is a function of the tick alone. Up to the first
/// step the level is that of step 0.
///
/// ```
/// use model_core::signal::aprts::Parameters;
///
/// let signal = Parameters {
///     lower: -12.0,
///     upper: 12.0,
///     shortest_hold: 0.1,
///     longest_hold: 0.5,
///     seed: 1,
/// }
/// .build(0.001)?;
/// let mut last = 0;
/// for tick in 1..60_000 {
///     if signal.at(tick) != signal.at(tick - 1) {
///         assert!(last == 0 || (100..=500).contains(&(tick - last)));
///         last = tick;
///     }
/// }
/// # Ok::<(), model_core::numeric::invalid_parameter::InvalidParameter>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Aprts {
    lower: f32,
    range: f32,
    /// c, ticks.
    cell: u32,
    /// Largest s, ticks.
    slack: u32,
    seed: u64,
}

impl Aprts {
    /// The value `tick` periods after the start.
    #[inline]
    pub fn at(&self, tick: u32) -> f32 {
        let number = tick / self.cell;
        let (delay, level) = self.step(number);
        if number > 0 && tick - number * self.cell < delay {
            self.step(number - 1).1
        } else {
            level
        }
    }

    /// s in ticks, and the level, of a step.
    fn step(&self, number: u32) -> (u32, f32) {
        let mut random = Random::new(
            self.seed
                .wrapping_add(u64::from(number).wrapping_mul(SPREAD)),
            0,
        );
        // The first output still has the seed's pattern in it.
        random.bits();
        let delay = (u64::from(random.bits()) * (u64::from(self.slack) + 1)) >> 32;
        (delay as u32, self.lower + self.range * random.uniform())
    }
}
