//! Sine.

use super::time::{self, UniformPhase};
use crate::numeric::invalid_parameter::InvalidParameter;
use crate::numeric::sine::sine_phase;

/// Shape of the sine.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters {
    /// Mean value.
    pub offset: f32,
    /// Peak above the mean; negative turns the sine upside down.
    pub amplitude: f32,
    /// In Hz, from zero to half the sample rate.
    pub frequency: f32,
    /// In rad, at tick 0: zero starts at the offset and rises.
    pub phase: f32,
}

impl Parameters {
    /// The signal for a `period` in s.
    pub fn build(self, period: f32) -> Result<Sine, InvalidParameter> {
        time::require_peaks(self.offset, self.amplitude)?;
        Ok(Sine {
            offset: self.offset,
            amplitude: self.amplitude,
            phase: UniformPhase::new(self.frequency, self.phase, period)?,
        })
    }
}

/// A sine: offset + amplitude·sin(2π f t + phase).
///
/// The phase is an integer in 2⁻⁶⁴ cycles: it drifts by at most 2⁻³³ cycles (0.7 nrad) in 2³² ticks,
/// five days at 10 kHz. Worst error 2.5e-7 of the amplitude, beside the rounding of the sum.
///
/// ```
/// use model_core::signal::sine::Parameters;
///
/// let sine = Parameters { offset: 1.0, amplitude: 2.0, frequency: 64.0, phase: 0.0 };
/// let sine = sine.build(1.0 / 1024.0)?;
/// assert_eq!([sine.at(0), sine.at(4), sine.at(12)], [1.0, 3.0, -1.0]);
/// // Ten hours later, 36 864 000 ticks.
/// assert_eq!(sine.at(36_864_012), -1.0);
/// # Ok::<(), model_core::numeric::invalid_parameter::InvalidParameter>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sine {
    offset: f32,
    amplitude: f32,
    phase: UniformPhase,
}

impl Sine {
    /// The value `tick` periods after the start.
    #[inline]
    pub fn at(&self, tick: u32) -> f32 {
        self.offset + self.amplitude * sine_phase(self.phase.at(tick))
    }
}
