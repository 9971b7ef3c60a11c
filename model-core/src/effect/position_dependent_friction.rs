//! `position_dependent_friction`: friction varies along the stroke.
//!
//! ```text
//! F(θ) = F_C + a sin(2π θ / P) + b cos(2π θ / P),  not below 0
//! ```
//!
//! Source: B. Armstrong, *Friction: experimental determination, modeling and compensation*, IEEE
//! International Conference on Robotics and Automation, 1988, who measured friction that swings with
//! the turn of a gear. One harmonic with a period that is scanned serves two machines: with a period
//! of a few strokes it is the slope and the bend of a guide that is tight at one end or worn in the
//! middle; with a shorter one a screw, or a gear that is out of true. Beyond three swings a stroke
//! it is not scanned: what is that local, a rough spot, is not of this kind. A map of friction over
//! position that does clearly better says so.
//!
//! Told from a torque over position, a [`spring`](super::spring) or [`cogging`](super::cogging), by
//! motion both ways over the same place, and from [`friction_drift`](super::friction_drift) by
//! coming back to it.

use super::harmonic::Harmonic;
use super::learned_map::Kind;
use super::{Description, Effect, MOST_PARAMETERS, Middle, Scope, Summary};
use crate::plant::actuator::Load;
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Swings over the stroke that are tried.
const SWINGS: [f32; 8] = [0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0];

/// What is added to friction.
///
/// ```
/// use model_core::effect::{Effect, Middle, position_dependent_friction::PositionDependentFriction, padded};
/// use model_core::plant::{Directional, actuator::Load};
/// // A quarter of a period of 2 rad on, friction of 0.1 N·m is 0.02 N·m more; it never drives.
/// let effect = PositionDependentFriction::new(padded([0.02, 0.0, 2.0]));
/// for (position, friction, expected) in [(0.5, 0.1, 0.12), (1.5, 0.01, 0.0)] {
///     let mut load = Load { coulomb: Directional::both(friction), ..Load::default() };
///     effect.hold(&Middle { position, ..Middle::default() }, &mut load);
///     assert!((load.coulomb.forward - expected).abs() < 1e-7);
/// }
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositionDependentFriction(Harmonic);

impl Effect for PositionDependentFriction {
    const DESCRIPTION: Description = Description {
        id: "position_dependent_friction",
        summary: Summary::Same("friction varies along the stroke"),
        source: "Armstrong 1988",
        parameters: &Harmonic::parameters(Dimension::Torque),
        reported: &Harmonic::reported(Dimension::Torque),
        rotary_only: false,
    };
    const MAP: Option<Kind> = Some(Kind::PositionFriction);
    const HELD: bool = true;
    const EXPANSION: bool = true;

    fn new(values: [f32; MOST_PARAMETERS]) -> Self {
        Self(Harmonic::new(values))
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        scope.friction
    }

    fn shape(scope: &Scope, index: usize) -> Option<f32> {
        SWINGS.get(index).map(|swings| scope.stroke / swings)
    }

    #[inline(always)]
    fn hold(&self, middle: &Middle, load: &mut Load) {
        let extra = self.0.at(middle.position);
        for friction in [&mut load.coulomb, &mut load.breakaway] {
            friction.forward = (friction.forward + extra).max(0.0);
            friction.backward = (friction.backward + extra).max(0.0);
        }
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        self.0.report()
    }
}
