//! Triangle.

use super::time::{self, UniformPhase};
use crate::numeric::invalid_parameter::InvalidParameter;
use crate::numeric::sine::triangle_phase;

/// Shape of the triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters {
    /// Mean value.
    pub offset: f32,
    /// Peak above the mean; negative turns the triangle upside down.
    pub amplitude: f32,
    /// In Hz, from zero to half the sample rate.
    pub frequency: f32,
    /// In rad, at tick 0: zero starts at the offset and rises.
    pub phase: f32,
}

impl Parameters {
    /// The signal for a `period` in s.
    pub fn build(self, period: f32) -> Result<Triangle, InvalidParameter> {
        time::require_peaks(self.offset, self.amplitude)?;
        Ok(Triangle {
            offset: self.offset,
            amplitude: self.amplitude,
            phase: UniformPhase::new(self.frequency, self.phase, period)?,
        })
    }
}

/// A triangle: straight lines between offset ± amplitude, with the phase of a sine, slope
/// ±4·amplitude·frequency.
///
/// The phase is an integer in 2⁻⁶⁴ cycles: it drifts by at most 2⁻³³ cycles in 2³² ticks. Worst error
/// 1e-7 of the amplitude, beside the rounding of the sum.
///
/// ```
/// use model_core::signal::triangle::Parameters;
///
/// let triangle = Parameters { offset: 0.0, amplitude: 2.0, frequency: 1.0, phase: 0.0 };
/// let triangle = triangle.build(0.125)?;
/// assert_eq!([0, 1, 2, 3, 4, 6, 8].map(|tick| triangle.at(tick)), [0.0, 1.0, 2.0, 1.0, 0.0, -2.0, 0.0]);
/// # Ok::<(), model_core::numeric::invalid_parameter::InvalidParameter>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Triangle {
    offset: f32,
    amplitude: f32,
    phase: UniformPhase,
}

impl Triangle {
    /// The value `tick` periods after the start.
    #[inline]
    pub fn at(&self, tick: u32) -> f32 {
        self.offset + self.amplitude * triangle_phase(self.phase.at(tick))
    }
}
