//! `compliance`: an elastic shaft, a second inertia behind a spring between drive and sensor.
//!
//! ```text
//! J₂ ẍ = −k (x − θ) − d (ẋ − θ̇),  the drive carries the reaction;  J = J₁ + J₂ as declared
//! ```
//!
//! Its parameters are s = J₂/k, by which the far side trails behind for each unit of acceleration
//! (1/√s is its angular frequency with the drive held), the share J₂/J, and the damping ratio
//! d/(2 √(k J₂)). Source: the two-mass system of any text on drives (W. Leonhard, *Control of
//! electrical drives*, 2001).
//!
//! It is stepped as [`shaft`](crate::plant::shaft) says.
//!
//! It may be declared; the tracing does not look for it. A replay restarts it from the acceleration and
//! the jerk of a smoothed position. So it starts otherwise than every other model, which on logs
//! without a shaft explains enough of what restarts leave to be taken for one.

use super::{Chain, Description, Effect, MOST_PARAMETERS, Parameter, Role, Scope};
use crate::plant::parameters::Parameters;
use crate::plant::shaft::Shaft;
use crate::unit::Dimension;

/// Largest damping ratio: what does not swing is the sensor's own filter.
const MOST_DAMPING: f32 = 0.4;

/// A second inertia behind a spring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compliance {
    trailing: f32,
    share: f32,
    damping: f32,
}

impl Effect for Compliance {
    const DESCRIPTION: Description = Description {
        id: "compliance",
        summary: "an elastic shaft: a second inertia behind a spring",
        source: "Leonhard 2001",
        parameters: &[
            Parameter {
                name: "trailing",
                dimension: Dimension::SquaredTime,
                role: Role::Strength,
            },
            Parameter {
                name: "share",
                dimension: Dimension::Ratio,
                role: Role::Shape,
            },
            Parameter {
                name: "damping",
                dimension: Dimension::Ratio,
                role: Role::Shape,
            },
        ],
        reported: &[
            ("frequency", Dimension::Frequency),
            ("inertia", Dimension::Inertia),
            ("damping", Dimension::Ratio),
        ],
        rotary_only: false,
    };
    const TRACED: bool = false;

    fn new([trailing, share, damping]: [f32; MOST_PARAMETERS]) -> Self {
        Self {
            trailing,
            share: share.clamp(0.0, 0.95),
            damping: damping.clamp(0.0, MOST_DAMPING),
        }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        let time = 5.0 * scope.period;
        time * time
    }

    fn bind(&self, plant: &mut Parameters, chain: &mut Chain) {
        let far = self.share * plant.inertia;
        plant.inertia -= far;
        chain.shaft = Some(Shaft {
            trailing: self.trailing,
            inertia: far,
            damping: self.damping,
        });
    }

    fn report(&self, plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        let angular = 1.0 / libm::sqrtf(self.trailing.max(f32::MIN_POSITIVE));
        [
            angular / core::f32::consts::TAU,
            self.share * plant.inertia,
            self.damping,
        ]
    }
}
