//! Triangle that grows from cycle to cycle, at one slope.

use super::time;
use crate::numeric::invalid_parameter::{InvalidParameter, require};

/// Shape of the triangles.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters {
    /// Mean value, and the value at tick 0.
    pub offset: f32,
    /// Peak of the last cycle above the mean; negative turns the triangles upside down.
    pub amplitude: f32,
    /// m, the first cycle: 1 to n. A triangle that does not overcome friction is no use.
    pub first: u32,
    /// n, the last cycle: 1 to 1000.
    pub last: u32,
    /// Duration of all cycles in s, rounded so that the quarter of cycle 1 would be a whole number of
    /// periods: at least one.
    pub duration: f32,
}

impl Parameters {
    /// The signal for a `period` in s.
    pub fn build(self, period: f32) -> Result<GrowingTriangle, InvalidParameter> {
        time::require_peaks(self.offset, self.amplitude)?;
        require((1..=1000).contains(&self.last), "last", "must be 1 to 1000")?;
        require(
            (1..=self.last).contains(&self.first),
            "first",
            "must be 1 to the last",
        )?;
        let ticks = time::ticks(self.duration, period, "duration")?;
        // Cycle k takes 4 k quarters: 2 n (n + 1) in all.
        let before = 2 * self.first * (self.first - 1);
        let quarters = 2 * self.last * (self.last + 1) - before;
        let quarter = (f64::from(ticks) / f64::from(quarters) + 0.5) as u32;
        require(
            quarter > 0,
            "duration",
            "must give the quarter of cycle 1 a period",
        )?;
        Ok(GrowingTriangle {
            offset: self.offset,
            per_tick: self.amplitude / (self.last as f32 * quarter as f32),
            quarter: u64::from(quarter),
            before: u64::from(before) * u64::from(quarter),
            ticks: u64::from(quarters) * u64::from(quarter),
        })
    }
}

/// Cycles m to n of a triangle around the offset, cycle k with k/n of the amplitude and k times as long
/// as cycle 1, so that the slope is the same everywhere; after cycle n it starts over.
///
/// Driven slowly enough, a machine with friction reverses at as many places as there are
/// cycles, always at the same rate: what the line procedure of
/// the input/output characteristic wants. The value is exact to the rounding of
/// a product and a sum.
///
/// ```
/// use model_core::signal::growing_triangle::Parameters;
///
/// let signal =
///     Parameters { offset: 1.0, amplitude: 4.0, first: 1, last: 2, duration: 12.0 };
/// let signal = signal.build(1.0)?;
/// let values: [f32; 13] = core::array::from_fn(|tick| signal.at(tick as u32));
/// assert_eq!(values, [1.0, 3.0, 1.0, -1.0, 1.0, 3.0, 5.0, 3.0, 1.0, -1.0, -3.0, -1.0, 1.0]);
/// # Ok::<(), model_core::numeric::invalid_parameter::InvalidParameter>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GrowingTriangle {
    offset: f32,
    per_tick: f32,
    /// Ticks of a quarter of cycle 1.
    quarter: u64,
    /// Ticks that the cycles before m would take.
    before: u64,
    /// Ticks of all cycles.
    ticks: u64,
}

impl GrowingTriangle {
    /// The value `tick` periods after the start.
    #[inline]
    pub fn at(&self, tick: u32) -> f32 {
        let within = self.before + u64::from(tick) % self.ticks;
        // Cycle k starts after 2 k (k − 1) quarters: the largest k for which that is not later.
        let cycle = (1 + 2 * (within / self.quarter)).isqrt().div_ceil(2);
        let after = (within - 2 * cycle * (cycle - 1) * self.quarter) as i64;
        let peak = (cycle * self.quarter) as i64;
        let height = if after <= peak {
            after
        } else if after <= 3 * peak {
            2 * peak - after
        } else {
            after - 4 * peak
        };
        self.offset + self.per_tick * height as f32
    }
}
