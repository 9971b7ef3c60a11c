//! Times and frequencies in ticks.

use crate::numeric::invalid_parameter::{
    InvalidParameter, require, require_finite, require_positive,
};

/// 2⁶⁴.
const WRAP_64: f64 = 18_446_744_073_709_551_616.0;

/// The whole number of periods nearest to `time`.
pub(super) fn ticks(time: f32, period: f32, name: &'static str) -> Result<u32, InvalidParameter> {
    require_positive(period, "period")?;
    let ticks = libm::rint(f64::from(time) / f64::from(period));
    require(
        (0.0..=f64::from(u32::MAX)).contains(&ticks),
        name,
        "must be zero or positive, and below 2^32 periods",
    )?;
    Ok(ticks as u32)
}

/// Whether a signal that swings about a mean by an amplitude stays within `f32`.
pub(super) fn require_peaks(offset: f32, amplitude: f32) -> Result<(), InvalidParameter> {
    require_finite(offset, "offset")?;
    require_finite(amplitude, "amplitude")?;
    require(
        (offset.abs() + amplitude.abs()).is_finite(),
        "amplitude",
        "must keep the peaks within f32",
    )
}

/// Cycles per tick of a `frequency` in Hz, exact: two `f32` multiply without rounding in `f64`.
pub(super) fn cycles_per_tick(
    frequency: f32,
    period: f32,
    name: &'static str,
) -> Result<f64, InvalidParameter> {
    require_positive(period, "period")?;
    let cycles = f64::from(frequency) * f64::from(period);
    require(
        (0.0..=0.5).contains(&cycles),
        name,
        "must be between zero and half the sample rate",
    )?;
    Ok(cycles)
}

/// A phase that advances by the same amount every tick and wraps at a whole cycle, in 2⁻⁶⁴ cycles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct UniformPhase {
    start: u64,
    per_tick: u64,
}

impl UniformPhase {
    /// From a frequency in Hz and the phase in rad at tick 0.
    pub(super) fn new(frequency: f32, phase: f32, period: f32) -> Result<Self, InvalidParameter> {
        let cycles = cycles_per_tick(frequency, period, "frequency")?;
        require(phase.is_finite(), "phase", "must be finite")?;
        let start = f64::from(phase) / core::f64::consts::TAU;
        Ok(Self {
            start: ((start - libm::floor(start)) * WRAP_64) as u64,
            per_tick: libm::rint(cycles * WRAP_64) as u64,
        })
    }

    /// The phase at `tick`, in 2⁻³² cycles.
    pub(super) fn at(&self, tick: u32) -> u32 {
        (self
            .start
            .wrapping_add(self.per_tick.wrapping_mul(u64::from(tick)))
            >> 32) as u32
    }
}
