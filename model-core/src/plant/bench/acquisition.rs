//! Filtering of the quadrature current (bench paper, section 3.6): a first-order low pass.
//!
//! Exact for an input held over a step, and it takes increments however small.

use crate::numeric::invalid_parameter::{InvalidParameter, require, require_positive};
use crate::numeric::matrix_exponential::exponential;
use crate::plant::Compensated;

/// A low pass for steps of one length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowPass {
    share: f32,
    output: Compensated,
}

impl LowPass {
    /// With a cut-off in Hz, for steps of `period` seconds, at zero.
    ///
    /// # Errors
    /// A value that is not above zero and finite.
    pub fn build(cut_off: f32, period: f32) -> Result<Self, InvalidParameter> {
        require_positive(cut_off, "current cut-off")?;
        require_positive(period, "period")?;
        let exponent = -core::f64::consts::TAU * f64::from(cut_off) * f64::from(period);
        let [[decay]] = exponential(&[[exponent]]);
        let share = (1.0 - decay) as f32;
        // A NaN fails the comparison.
        require(
            share > 0.0 && share <= 1.0,
            "current cut-off",
            "must be neither endlessly slow nor endlessly fast beside the period",
        )?;
        Ok(Self {
            share,
            output: Compensated::new(0.0),
        })
    }

    /// One step.
    #[inline]
    pub fn step(&mut self, input: f32) {
        let distance = -self.output.from(input);
        self.output.advance(self.share * distance);
    }

    /// Its output.
    #[inline]
    pub fn output(&self) -> f32 {
        self.output.value()
    }
}
