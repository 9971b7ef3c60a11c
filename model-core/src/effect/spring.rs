//! `spring`: a torque proportional to the position, measured from wherever the spring rests.
//!
//! ```text
//! J dω/dt = … − K θ + T₀ = … − K (θ − θ_rest)
//! ```
//!
//! Source: Hooke. Where it rests is as unknown as its stiffness, so that it has two strengths. With
//! a stiffness near zero it is an [`offset_torque`](super::offset_torque); over a small angle
//! [`gravity`](super::gravity) is a spring.

use super::learned_map::Kind;
use super::{Bounds, Chain, Description, Effect, MOST_PARAMETERS, Parameter, Role, Scope, Summary, padded};
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Stiffness, and torque at position 0.
///
/// ```
/// use model_core::effect::{Chain, Effect, spring::Spring, padded};
/// use model_core::plant::parameters::Parameters;
/// let mut plant = Parameters::free(1e-4);
/// let effect = Spring::new(padded([0.5, 0.125]));
/// effect.bind(&mut plant, &mut Chain::default());
/// // Its rest is where stiffness and torque balance: 0.125 / 0.5.
/// assert_eq!(effect.report(&plant), padded([0.5, 0.25]));
/// assert_eq!(plant.spring * 0.25, plant.offset);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring {
    stiffness: f32,
    torque: f32,
}

impl Effect for Spring {
    const DESCRIPTION: Description = Description {
        id: "spring",
        summary: Summary::ByCoordinate {
            angle: "a torque proportional to the position",
            length: "a force proportional to the position",
        },
        source: "Hooke",
        parameters: &[
            Parameter {
                name: "stiffness",
                dimension: Dimension::TorquePerPosition,
                role: Role::Strength,
                bounds: Bounds::NotNegative,
            },
            Parameter {
                name: "torque",
                dimension: Dimension::Torque,
                role: Role::Strength,
                bounds: Bounds::Any,
            },
        ],
        reported: &[
            ("stiffness", Dimension::TorquePerPosition),
            ("rest", Dimension::Position),
        ],
        rotary_only: false,
    };
    const MAP: Option<Kind> = Some(Kind::PositionTorque);

    fn new([stiffness, torque, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self { stiffness, torque }
    }

    fn scale(scope: &Scope, index: usize) -> f32 {
        match index {
            0 => scope.friction / scope.stroke,
            _ => scope.friction,
        }
    }

    fn bind(&self, plant: &mut Parameters, _chain: &mut Chain) {
        // −K θ = −K (θ − rest) − K rest: the declared spring keeps its rest, where its preload acts.
        plant.spring += self.stiffness;
        plant.offset += self.torque - self.stiffness * plant.spring_rest;
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        // A spring without stiffness rests anywhere.
        let rest = if self.stiffness > 0.0 {
            self.torque / self.stiffness
        } else {
            0.0
        };
        padded([self.stiffness, rest])
    }
}
