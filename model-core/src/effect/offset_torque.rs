//! `offset_torque`: a constant torque or force on the mechanism.
//!
//! ```text
//! J dω/dt = … + T
//! ```
//!
//! Source: the offset of the published EMPS model (Janot, Gautier, Brunot 2019). It shifts the
//! sliding and the breakaway levels of both directions alike, so that it equals
//! [`asymmetric_coulomb`](super::asymmetric_coulomb) in every motion: no log tells them apart, and
//! the tracing reports both.

use super::{Bounds, Chain, Description, Effect, MOST_PARAMETERS, Parameter, Role, Scope, Summary, padded};
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// A constant torque, positive towards larger positions.
///
/// ```
/// use model_core::effect::{Chain, Effect, offset_torque::OffsetTorque, padded};
/// use model_core::plant::parameters::Parameters;
/// let mut plant = Parameters::free(1e-4);
/// OffsetTorque::new(padded([-0.03])).bind(&mut plant, &mut Chain::default());
/// assert_eq!(plant.offset, -0.03);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OffsetTorque {
    torque: f32,
}

impl Effect for OffsetTorque {
    const DESCRIPTION: Description = Description {
        id: "offset_torque",
        summary: Summary::ByCoordinate {
            angle: "a constant torque",
            length: "a constant force",
        },
        source: "Janot, Gautier, Brunot 2019",
        parameters: &[Parameter {
            name: "torque",
            dimension: Dimension::Torque,
            role: Role::Strength,
            bounds: Bounds::Any,
        }],
        reported: &[("torque", Dimension::Torque)],
        rotary_only: false,
    };

    fn new([torque, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self { torque }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        scope.friction
    }

    fn bind(&self, plant: &mut Parameters, _chain: &mut Chain) {
        plant.offset += self.torque;
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        padded([self.torque])
    }
}
