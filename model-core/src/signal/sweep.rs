//! Sine sweep: a linear chirp.

use super::time;
use crate::numeric::invalid_parameter::{InvalidParameter, require};
use crate::numeric::sine::sine_phase;

/// 2¹²⁸.
const WRAP_128: f64 = 18_446_744_073_709_551_616.0 * 18_446_744_073_709_551_616.0;

/// From which frequency to which, and how fast.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters {
    /// Mean value.
    pub offset: f32,
    /// Peak above the mean.
    pub amplitude: f32,
    /// f₀ in Hz, from zero to half the sample rate.
    pub initial_frequency: f32,
    /// f₁ in Hz, likewise; below f₀ the sweep runs downwards.
    pub final_frequency: f32,
    /// T in s, rounded to a whole period: at least one.
    pub duration: f32,
}

impl Parameters {
    /// The signal for a `period` in s.
    pub fn build(self, period: f32) -> Result<Sweep, InvalidParameter> {
        time::require_peaks(self.offset, self.amplitude)?;
        let initial = time::cycles_per_tick(self.initial_frequency, period, "initial_frequency")?;
        let last = time::cycles_per_tick(self.final_frequency, period, "final_frequency")?;
        let ticks = time::ticks(self.duration, period, "duration")?;
        require(ticks > 0, "duration", "must be at least one period")?;
        let half_rate = (last - initial) / (2.0 * f64::from(ticks));
        Ok(Sweep {
            offset: self.offset,
            amplitude: self.amplitude,
            ticks,
            initial_advance: (initial * WRAP_128) as u128,
            final_advance: (last * WRAP_128) as u128,
            // A falling sweep has a negative rate; wrapping arithmetic takes it as it is.
            half_rate: (half_rate * WRAP_128) as i128 as u128,
        })
    }
}

/// A sweep: offset + amplitude·sin 2π(f₀ t + (f₁ − f₀) t²/(2T)), and from T on a sine of f₁ that
/// goes on without a break.
///
/// The phase is computed from the tick in integers of 2⁻¹²⁸ cycles. Its error is that of the rate
/// alone, 2.3e-16 of the cycles that the sweep adds: over one hour from 0 to 5 kHz at 10 kHz,
/// 9·10⁶ cycles, 2e-9 cycles. Worst error of the value 2.5e-7 of the amplitude, beside the rounding
/// of the sum.
///
/// ```
/// use model_core::signal::sweep::Parameters;
///
/// let sweep = Parameters {
///     offset: 0.0,
///     amplitude: 12.0,
///     initial_frequency: 0.0,
///     final_frequency: 4.0,
///     duration: 8.0,
/// }
/// .build(0.125)?;
/// // At 1 s the phase is t²/4 = 1/4 cycle, at 2 s a whole one.
/// assert_eq!(sweep.at(8), 12.0);
/// assert_eq!(sweep.at(16), 0.0);
/// # Ok::<(), model_core::numeric::invalid_parameter::InvalidParameter>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sweep {
    offset: f32,
    amplitude: f32,
    ticks: u32,
    /// f₀ in 2⁻¹²⁸ cycles per tick.
    initial_advance: u128,
    /// f₁ in 2⁻¹²⁸ cycles per tick.
    final_advance: u128,
    /// Half of the change of frequency per tick, in 2⁻¹²⁸ cycles per tick².
    half_rate: u128,
}

impl Sweep {
    /// The value `tick` periods after the start.
    #[inline]
    pub fn at(&self, tick: u32) -> f32 {
        let swept = u64::from(tick.min(self.ticks));
        let held = u64::from(tick) - swept;
        let phase = self
            .initial_advance
            .wrapping_mul(u128::from(swept))
            .wrapping_add(self.half_rate.wrapping_mul(u128::from(swept * swept)))
            .wrapping_add(self.final_advance.wrapping_mul(u128::from(held)));
        self.offset + self.amplitude * sine_phase((phase >> 96) as u32)
    }
}
