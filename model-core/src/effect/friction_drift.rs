//! `friction_drift`: friction changes during the log.
//!
//! ```text
//! F(t) = F_C (1 + r t),  t from the beginning of the log,  not below 0
//! ```
//!
//! r is a signed rate: grease that warms up takes friction away, wear and dirt add to it. Source: L.
//! Márton, F. van der Linden, *Temperature dependent friction estimation: application to lubricant
//! health monitoring*, 2012, of which this is the first order in time. Coulomb and breakaway level
//! are scaled, with what the effects before it in the model add to them; a brake's friction is not.
//!
//! Told from a wrong Coulomb friction by motion at both ends of the log, and from an
//! [`external_load`](super::external_load) by motion both ways: friction changes sides, a load does
//! not. In a log whose motion grows or decays steadily, friction that depends on speed or place
//! looks alike.

use super::learned_map::Kind;
use super::{Bounds, Description, Effect, MOST_PARAMETERS, Middle, Parameter, Role, Scope, Summary, padded};
use crate::plant::actuator::Load;
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Most that friction grows by: beyond any machine, and what keeps it finite.
const MOST_GROWTH: f32 = 1e3;

/// Change of friction with time.
///
/// ```
/// use model_core::effect::{Effect, friction_drift::FrictionDrift, padded};
/// // 5 % a second: 8 s on, friction is 1.4 times what it was; falling, it ends at nothing.
/// assert_eq!(FrictionDrift::new(padded([0.05])).factor(8.0), 1.4);
/// assert_eq!(FrictionDrift::new(padded([-0.25])).factor(8.0), 0.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionDrift {
    rate: f32,
}

impl FrictionDrift {
    /// Friction over that at the beginning of the log, `time` seconds ago.
    #[inline(always)]
    pub fn factor(&self, time: f32) -> f32 {
        let factor = 1.0 + self.rate * time;
        if factor > 0.0 {
            factor.min(MOST_GROWTH)
        } else {
            0.0
        }
    }
}

impl Effect for FrictionDrift {
    const DESCRIPTION: Description = Description {
        id: "friction_drift",
        summary: Summary::Same("friction changes during the log"),
        source: "Márton, van der Linden 2012",
        parameters: &[Parameter {
            name: "rate",
            dimension: Dimension::PerTime,
            role: Role::Strength,
            bounds: Bounds::Any,
        }],
        reported: &[("rate", Dimension::PerTime)],
        rotary_only: false,
    };
    const MAP: Option<Kind> = Some(Kind::TimeFriction);
    const HELD: bool = true;

    fn new([rate, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self { rate }
    }

    /// Friction that doubles within the log.
    fn scale(scope: &Scope, _index: usize) -> f32 {
        1.0 / scope.seconds
    }

    #[inline(always)]
    fn hold(&self, middle: &Middle, load: &mut Load) {
        let factor = self.factor(middle.time);
        for friction in [&mut load.coulomb, &mut load.breakaway] {
            friction.forward *= factor;
            friction.backward *= factor;
        }
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        padded([self.rate])
    }
}
