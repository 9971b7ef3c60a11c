//! Step.

use super::time;
use crate::numeric::invalid_parameter::{InvalidParameter, require_finite};

/// What the step leads from and to, and when.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters {
    /// Value before the step.
    pub initial_value: f32,
    /// Value from the step on.
    pub final_value: f32,
    /// Time of the step in s, rounded to a whole period: zero or more.
    pub time: f32,
}

impl Parameters {
    /// The signal for a `period` in s.
    pub fn build(self, period: f32) -> Result<Step, InvalidParameter> {
        require_finite(self.initial_value, "initial_value")?;
        require_finite(self.final_value, "final_value")?;
        Ok(Step {
            initial_value: self.initial_value,
            final_value: self.final_value,
            start: time::ticks(self.time, period, "time")?,
        })
    }
}

/// A step, exact.
///
/// ```
/// use model_core::signal::step::Parameters;
///
/// let step = Parameters { initial_value: 0.0, final_value: 12.0, time: 0.5 }.build(0.001)?;
/// assert_eq!((step.at(499), step.at(500)), (0.0, 12.0));
/// # Ok::<(), model_core::numeric::invalid_parameter::InvalidParameter>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Step {
    initial_value: f32,
    final_value: f32,
    start: u32,
}

impl Step {
    /// The value `tick` periods after the start.
    #[inline]
    pub fn at(&self, tick: u32) -> f32 {
        if tick < self.start {
            self.initial_value
        } else {
            self.final_value
        }
    }
}
