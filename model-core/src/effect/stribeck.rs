//! `stribeck`: friction falls with speed from its static to its Coulomb level.
//!
//! ```text
//! F(ω) = F_C + ΔF exp(−|ω| / ω_S)
//! ```
//!
//! Source: A. Tustin, *The effects of backlash and of speed-dependent friction on the stability of
//! closed-cycle control systems*, 1947. Told from viscous friction by slow motion, at speeds around
//! ω_S and below.

use super::learned_map::Kind;
use super::{Bounds, Chain, Description, Effect, MOST_PARAMETERS, Middle, Parameter, Role, Scope, Summary, padded};
use crate::numeric::exponential::decay;
use crate::plant::actuator::Load;
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Fall of friction from rest to fast motion, and the speed over which it falls.
///
/// ```
/// use model_core::effect::{Effect, Middle, stribeck::Stribeck, padded};
/// use model_core::plant::actuator::Load;
/// // 0.04 N·m more at rest than fast; at ω_S a share of 1/e is left.
/// let effect = Stribeck::new(padded([0.04, 2.0]));
/// for (velocity, extra) in [(0.0, 0.04), (-2.0, 0.04 / core::f32::consts::E), (100.0, 0.0)] {
///     let mut load = Load::default();
///     effect.hold(&Middle { velocity, ..Middle::default() }, &mut load);
///     assert!((load.coulomb.forward - extra).abs() < 1e-8);
/// }
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stribeck {
    drop: f32,
    inverse_velocity: f32,
}

impl Effect for Stribeck {
    const DESCRIPTION: Description = Description {
        id: "stribeck",
        summary: Summary::Same("friction falls with speed from its static to its Coulomb level"),
        source: "Tustin 1947",
        parameters: &[
            Parameter {
                name: "drop",
                dimension: Dimension::Torque,
                role: Role::Strength,
                bounds: Bounds::NotNegative,
            },
            Parameter {
                name: "velocity",
                dimension: Dimension::Velocity,
                role: Role::Shape,
                bounds: Bounds::Positive,
            },
        ],
        reported: &[("drop", Dimension::Torque), ("velocity", Dimension::Velocity)],
        rotary_only: false,
    };
    const MAP: Option<Kind> = Some(Kind::SpeedFriction);
    const HELD: bool = true;

    fn new([drop, velocity, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self {
            drop,
            inverse_velocity: 1.0 / velocity.max(f32::MIN_POSITIVE),
        }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        scope.friction
    }

    fn shape(scope: &Scope, index: usize) -> Option<f32> {
        const SHARES: [f32; 5] = [0.03, 0.07, 0.15, 0.3, 0.6];
        SHARES.get(index).map(|share| share * scope.speed)
    }

    fn bind(&self, plant: &mut Parameters, _chain: &mut Chain) {
        let hold = |breakaway: f32, coulomb: f32| breakaway.max(coulomb + self.drop);
        plant.breakaway.forward = hold(plant.breakaway.forward, plant.coulomb.forward);
        plant.breakaway.backward = hold(plant.breakaway.backward, plant.coulomb.backward);
    }

    #[inline(always)]
    fn hold(&self, middle: &Middle, load: &mut Load) {
        let extra = self.drop * decay(middle.velocity.abs() * self.inverse_velocity);
        load.coulomb.forward += extra;
        load.coulomb.backward += extra;
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        padded([self.drop, 1.0 / self.inverse_velocity])
    }
}
