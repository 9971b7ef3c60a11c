//! `asymmetric_coulomb`: Coulomb friction that depends on the direction of motion.
//!
//! ```text
//! F(ω > 0) = F_C + δ,  F(ω < 0) = F_C − δ
//! ```
//!
//! with the breakaway levels shifted alike. Source: B. Armstrong-Hélouvry, P. Dupont, C. Canudas de
//! Wit, *A survey of models, analysis tools and compensation methods for the control of machines
//! with friction*, Automatica 30 (1994). Equal to [`offset_torque`](super::offset_torque) of −δ in
//! every motion.

use super::learned_map::Kind;
use super::{Bounds, Chain, Description, Effect, MOST_PARAMETERS, Parameter, Role, Scope, Summary, padded};
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Half the difference between the two directions' Coulomb levels.
///
/// ```
/// use model_core::effect::{Chain, Effect, asymmetric_coulomb::AsymmetricCoulomb, padded};
/// use model_core::plant::{Directional, parameters::Parameters};
/// let mut plant = Parameters { coulomb: Directional::both(0.5), ..Parameters::free(1e-4) };
/// AsymmetricCoulomb::new(padded([0.125])).bind(&mut plant, &mut Chain::default());
/// assert_eq!(plant.coulomb, Directional { forward: 0.625, backward: 0.375 });
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AsymmetricCoulomb {
    difference: f32,
}

impl Effect for AsymmetricCoulomb {
    const DESCRIPTION: Description = Description {
        id: "asymmetric_coulomb",
        summary: Summary::Same("Coulomb friction depends on the direction of motion"),
        source: "Armstrong-Hélouvry, Dupont, Canudas de Wit 1994",
        parameters: &[Parameter {
            name: "difference",
            dimension: Dimension::Torque,
            role: Role::Strength,
            bounds: Bounds::Any,
        }],
        reported: &[
            ("forward", Dimension::Torque),
            ("backward", Dimension::Torque),
        ],
        rotary_only: false,
    };
    const MAP: Option<Kind> = Some(Kind::VelocityTorque);

    fn new([difference, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self { difference }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        scope.friction
    }

    fn bind(&self, plant: &mut Parameters, _chain: &mut Chain) {
        for level in [&mut plant.coulomb, &mut plant.breakaway] {
            level.forward = (level.forward + self.difference).max(0.0);
            level.backward = (level.backward - self.difference).max(0.0);
        }
    }

    fn report(&self, plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        // As they act: friction never drives.
        padded([
            (plant.coulomb.forward + self.difference).max(0.0),
            (plant.coulomb.backward - self.difference).max(0.0),
        ])
    }
}
