//! `asymmetric_viscous`: viscous friction that depends on the direction of motion.
//!
//! ```text
//! B(ω > 0) = B + δ,  B(ω < 0) = B − δ
//! ```
//!
//! Source: Armstrong-Hélouvry, Dupont, Canudas de Wit 1994 (see
//! [`asymmetric_coulomb`](super::asymmetric_coulomb)). Told from an asymmetric Coulomb level by
//! motion at several speeds; at one speed the two are the same.

use super::learned_map::Kind;
use super::{Bounds, Chain, Description, Effect, MOST_PARAMETERS, Parameter, Role, Scope, Summary, padded};
use crate::plant::Directional;
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Half the difference between the two directions' viscous coefficients.
///
/// ```
/// use model_core::effect::{Chain, Effect, asymmetric_viscous::AsymmetricViscous, padded};
/// use model_core::plant::{Directional, parameters::Parameters};
/// let mut plant = Parameters { viscous: Directional::both(0.5), ..Parameters::free(1e-4) };
/// AsymmetricViscous::new(padded([0.75])).bind(&mut plant, &mut Chain::default());
/// // Friction never drives: the smaller one ends at nothing.
/// assert_eq!(plant.viscous, Directional { forward: 1.25, backward: 0.0 });
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AsymmetricViscous {
    difference: f32,
}

impl Effect for AsymmetricViscous {
    const DESCRIPTION: Description = Description {
        id: "asymmetric_viscous",
        summary: Summary::Same("viscous friction depends on the direction of motion"),
        source: "Armstrong-Hélouvry, Dupont, Canudas de Wit 1994",
        parameters: &[Parameter {
            name: "difference",
            dimension: Dimension::TorquePerVelocity,
            role: Role::Strength,
            bounds: Bounds::Any,
        }],
        reported: &[
            ("forward", Dimension::TorquePerVelocity),
            ("backward", Dimension::TorquePerVelocity),
        ],
        rotary_only: false,
    };
    const MAP: Option<Kind> = Some(Kind::VelocityTorque);

    fn new([difference, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self { difference }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        scope.friction / scope.speed
    }

    fn bind(&self, plant: &mut Parameters, _chain: &mut Chain) {
        let [forward, backward, ..] = self.report(plant);
        plant.viscous = Directional { forward, backward };
    }

    fn report(&self, plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        // A mode with negative damping is not friction any more.
        padded([
            (plant.viscous.forward + self.difference).max(0.0),
            (plant.viscous.backward - self.difference).max(0.0),
        ])
    }
}
