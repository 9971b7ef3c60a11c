//! `torque_saturation`: the torque constant falls with current.
//!
//! ```text
//! k(i) = k / (1 + c |T|),  T = k i
//! ```
//!
//! so that the motor's torque tends to 1/c; with it falls the back-EMF, which is k(i) ω. With
//! `kind = "torque"` T is the torque that the input asks for. Source: O. Frölich's law of
//! magnetisation (*Die dynamoelektrische Maschine*, 1886), the usual one-parameter curve of a
//! saturating iron path.
//!
//! Told from a smaller torque constant by torques of clearly different size, and from a load-dependent
//! friction by its curve, or by torques that decelerate: saturation takes from these too, where
//! friction helps. At one level of torque it is absorbed by the Coulomb friction; logs under several
//! levels of a brake tell it.

use super::learned_map::Kind;
use super::{Bounds, Description, Effect, MOST_PARAMETERS, Middle, Parameter, Role, Scope, Summary, padded};
use crate::plant::actuator::Load;
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Fall of the torque constant.
///
/// ```
/// use model_core::effect::{Effect, torque_saturation::TorqueSaturation, padded};
/// // A motor that never gives 2 N·m, asked for 6 N·m: 6 / (1 + 3) = 1.5.
/// let effect = TorqueSaturation::new(padded([0.5]));
/// assert_eq!(6.0 * effect.remaining(6.0), 1.5);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorqueSaturation {
    fall: f32,
}

impl TorqueSaturation {
    /// Share of the torque constant that is left under a current that would give this torque.
    #[inline(always)]
    pub fn remaining(&self, torque: f32) -> f32 {
        1.0 / (1.0 + self.fall * torque.abs())
    }
}

impl Effect for TorqueSaturation {
    const DESCRIPTION: Description = Description {
        id: "torque_saturation",
        summary: Summary::Same("the torque constant falls with current"),
        source: "Frölich 1886",
        parameters: &[Parameter {
            name: "fall",
            dimension: Dimension::PerTorque,
            role: Role::Strength,
            bounds: Bounds::NotNegative,
        }],
        reported: &[("fall", Dimension::PerTorque)],
        rotary_only: false,
    };
    const MAP: Option<Kind> = Some(Kind::CurrentTorque);
    const HELD: bool = true;
    const ELECTRIC: bool = true;

    fn new([fall, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self { fall }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        0.2 / scope.torque
    }

    #[inline(always)]
    fn hold(&self, middle: &Middle, load: &mut Load) {
        let lost = 1.0 - self.remaining(middle.motor_torque);
        load.torque -= lost * middle.motor_torque;
    }

    #[inline(always)]
    fn voltage(&self, middle: &Middle) -> f32 {
        // What the back-EMF has less.
        let lost = 1.0 - self.remaining(middle.motor_torque);
        lost * middle.torque_constant * middle.velocity
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        padded([self.fall])
    }
}
