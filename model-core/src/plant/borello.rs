//! Borello's friction by Euler steps: rest is a velocity of exactly zero.
//!
//! At rest friction equals the active load up to the breakaway level; in motion it is Coulomb's. A
//! velocity that would change its sign within a step is zero at the step's end, and the next step
//! decides between rest and the way back (L. Borello and M. D. L. Dalla Vedova, *Dry friction
//! discontinuous computational algorithms*, International Journal of Engineering and Innovative
//! Technology 3(8), 2014). Unlike Karnopp's scheme it has no band to be
//! chosen, and it takes the same care with steps: see [`crate::plant::karnopp`].

use super::euler::{Euler, FrictionRule};
use super::parameters::{ParameterError, Parameters};

/// The scheme, built for one step period.
pub type Borello = Euler<ZeroCrossing>;

/// State of the scheme. The position is a plain `f32`, as the published scheme has it.
pub type State = super::euler::State<f32>;

/// Rest begins where the velocity changes its sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZeroCrossing;

impl FrictionRule for ZeroCrossing {
    #[inline]
    fn seen(&self, velocity: f32) -> f32 {
        velocity
    }

    #[inline]
    fn settled(&self, before: f32, after: f32) -> f32 {
        let crosses = (before > 0.0 && after < 0.0) || (before < 0.0 && after > 0.0);
        if crosses { 0.0 } else { after }
    }
}

impl Borello {
    /// Euler steps of `period` seconds.
    ///
    /// # Errors
    /// A parameter outside its range; a period that is not above 0; a winding whose time constant is
    /// below half the period, for which Euler's rule diverges.
    pub fn build(parameters: &Parameters, period: f32) -> Result<Self, ParameterError> {
        Self::with_rule(parameters, period, ZeroCrossing)
    }
}
