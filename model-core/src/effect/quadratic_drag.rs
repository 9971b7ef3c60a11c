//! `quadratic_drag`: a torque that grows with the square of the speed, as of a fan or of oil.
//!
//! ```text
//! J dω/dt = … − c ω |ω|
//! ```
//!
//! Source: turbulent drag (any text on fluid mechanics). Told from viscous friction by motion at
//! clearly different speeds.

use super::learned_map::Kind;
use super::{Bounds, Description, Effect, MOST_PARAMETERS, Middle, Parameter, Role, Scope, Summary, padded};
use crate::plant::actuator::Load;
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Drag coefficient.
///
/// ```
/// use model_core::effect::{Effect, Middle, quadratic_drag::QuadraticDrag, padded};
/// use model_core::plant::actuator::Load;
/// // Twice as fast, four times the drag, and always against the motion.
/// let effect = QuadraticDrag::new(padded([0.5]));
/// for (velocity, torque) in [(1.0, -0.5), (2.0, -2.0), (-2.0, 2.0)] {
///     let mut load = Load::default();
///     effect.hold(&Middle { velocity, ..Middle::default() }, &mut load);
///     assert_eq!(load.torque, torque);
/// }
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuadraticDrag {
    coefficient: f32,
}

impl Effect for QuadraticDrag {
    const DESCRIPTION: Description = Description {
        id: "quadratic_drag",
        summary: Summary::ByCoordinate {
            angle: "a torque that grows with the square of the speed",
            length: "a force that grows with the square of the speed",
        },
        source: "turbulent drag",
        parameters: &[Parameter {
            name: "coefficient",
            dimension: Dimension::TorquePerSquaredVelocity,
            role: Role::Strength,
            bounds: Bounds::NotNegative,
        }],
        reported: &[("coefficient", Dimension::TorquePerSquaredVelocity)],
        rotary_only: false,
    };
    const MAP: Option<Kind> = Some(Kind::SpeedFriction);
    const HELD: bool = true;

    fn new([coefficient, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self { coefficient }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        scope.friction / (scope.speed * scope.speed)
    }

    #[inline(always)]
    fn hold(&self, middle: &Middle, load: &mut Load) {
        load.torque -= self.coefficient * middle.velocity * middle.velocity.abs();
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        padded([self.coefficient])
    }
}
