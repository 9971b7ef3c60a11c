//! `load_dependent_friction`: friction that grows with the transmitted torque.
//!
//! ```text
//! F = F_C + μ |T_motor|
//! ```
//!
//! Source: the efficiency of gears and screws; L. Márton, F. van der Linden, *Temperature dependent
//! friction estimation: application to lubricant health monitoring*, 2012, for gears with a
//! load-dependent part. The motor torque stands for the transmitted one. Told from Coulomb and
//! viscous friction by torques that are not spent on friction: acceleration, springs, loads.

use super::learned_map::Kind;
use super::{Bounds, Description, Effect, MOST_PARAMETERS, Middle, Parameter, Role, Scope, Summary, padded};
use crate::plant::actuator::Load;
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Largest share: from 1 on the machine locks itself, and shortly below it hardly moves.
const MOST_SHARE: f32 = 0.95;

/// Share of the motor torque that friction takes.
///
/// ```
/// use model_core::effect::{Effect, Middle, load_dependent_friction::LoadDependentFriction, padded};
/// use model_core::plant::{Directional, actuator::Load};
/// // A quarter of what the motor gives, whichever way.
/// let mut load = Load::default();
/// let middle = Middle { motor_torque: -2.0, ..Middle::default() };
/// LoadDependentFriction::new(padded([0.25])).hold(&middle, &mut load);
/// assert_eq!((load.coulomb, load.breakaway), (Directional::both(0.5), Directional::both(0.5)));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadDependentFriction {
    share: f32,
}

impl Effect for LoadDependentFriction {
    const DESCRIPTION: Description = Description {
        id: "load_dependent_friction",
        summary: Summary::ByCoordinate {
            angle: "friction grows with the transmitted torque",
            length: "friction grows with the transmitted force",
        },
        source: "Márton, van der Linden 2012",
        parameters: &[Parameter {
            name: "share",
            dimension: Dimension::Ratio,
            role: Role::Strength,
            bounds: Bounds::UpTo(MOST_SHARE),
        }],
        reported: &[("share", Dimension::Ratio)],
        rotary_only: false,
    };
    const MAP: Option<Kind> = Some(Kind::LoadFriction);
    const HELD: bool = true;

    fn new([share, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self { share }
    }

    fn scale(_scope: &Scope, _index: usize) -> f32 {
        0.2
    }

    #[inline(always)]
    fn hold(&self, middle: &Middle, load: &mut Load) {
        let extra = self.share * middle.motor_torque.abs();
        load.coulomb.forward += extra;
        load.coulomb.backward += extra;
        load.breakaway.forward += extra;
        load.breakaway.backward += extra;
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        padded([self.share])
    }
}
