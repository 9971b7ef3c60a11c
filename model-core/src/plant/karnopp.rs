//! Karnopp's velocity-band friction by Euler steps: the published scheme, for comparison.
//!
//! Inside a band |ω| < Dv the velocity counts as zero and friction balances the drive up to the
//! breakaway level; outside it friction is Coulomb's (D. Karnopp, *Computer simulation of
//! stick-slip friction in mechanical dynamic systems*, 1985). The prognostics paper's model is based
//! on it and modified (section V, its references 13 and 14); the modification is not in the paper.
//! It needs steps far below the electrical time constant, and in `f32` such steps are too small
//! for the position to notice: over a sweep of 90 rad, steps of 1 µs are off by 22 mrad rms, those
//! of [`crate::plant::actuator`] by 3 µrad with 100 µs. That one is what the project uses.

use super::euler::{Euler, FrictionRule, above_zero};
use super::parameters::{ParameterError, Parameters};

/// The scheme, built for one step period.
pub type Karnopp = Euler<VelocityBand>;

/// State of the scheme. The position is a plain `f32`, as the published scheme has it.
pub type State = super::euler::State<f32>;

/// Rest is a band of velocities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VelocityBand {
    /// Half its width, rad/s or m/s.
    half_width: f32,
}

impl FrictionRule for VelocityBand {
    #[inline]
    fn seen(&self, velocity: f32) -> f32 {
        if velocity.abs() < self.half_width {
            0.0
        } else {
            velocity
        }
    }

    #[inline]
    fn settled(&self, _before: f32, after: f32) -> f32 {
        after
    }
}

impl Karnopp {
    /// Euler steps of `period` seconds with a velocity band of `band` rad/s or m/s. The prognostics paper
    /// gives none; a thousandth of the top speed does.
    ///
    /// # Errors
    /// A parameter outside its range; a period or a band that is not above 0; a winding whose time
    /// constant is below half the period, for which Euler's rule diverges.
    pub fn build(parameters: &Parameters, period: f32, band: f32) -> Result<Self, ParameterError> {
        above_zero("band", band)?;
        Self::with_rule(parameters, period, VelocityBand { half_width: band })
    }
}
