//! `spring`: a torque proportional to the position.
//!
//! ```text
//! J dω/dt = … − K θ
//! ```
//!
//! Source: Hooke. A spring that rests elsewhere than at position 0 is this one and an
//! [`offset_torque`](super::offset_torque).

use super::{Delays, Description, Effect, MOST_PARAMETERS, Parameter, Role, Scope};
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Stiffness of a spring at rest at position 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring {
    stiffness: f32,
}

impl Effect for Spring {
    const DESCRIPTION: Description = Description {
        id: "spring",
        summary: "a torque proportional to the position",
        source: "Hooke",
        parameters: &[Parameter {
            name: "stiffness",
            dimension: Dimension::TorquePerPosition,
            role: Role::Strength,
        }],
        reported: &[("stiffness", Dimension::TorquePerPosition)],
        rotary_only: false,
    };

    fn new([stiffness, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self { stiffness }
    }

    fn scale(scope: &Scope) -> f32 {
        scope.friction / scope.stroke
    }

    fn bind(&self, plant: &mut Parameters, _delays: &mut Delays) {
        // −K θ = −K (θ − rest) − K rest: the declared spring keeps its rest, where its preload acts.
        plant.spring += self.stiffness;
        plant.offset -= self.stiffness * plant.spring_rest;
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        [self.stiffness, 0.0, 0.0]
    }
}
