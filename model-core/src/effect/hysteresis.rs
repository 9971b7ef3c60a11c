//! `hysteresis`: a torque that follows the position and remembers where the motion turned, as of a rubber mount, a cable
//! or a seal.
//!
//! ```text
//! J dω/dt = … − T z/r      dz = dθ − |dθ| z/r
//! ```
//!
//! z is a deflection that comes to the reach r on the side that the motion goes to, over about as long a way
//! ([`deflected`]). Source: P. R. Dahl, *A solid friction model*, 1968, with his exponent of 1; it
//! gives back less than it took, whatever the speed.
//!
//! Told from `presliding` by what holds the machine at rest: bristles are all of its dry friction and bend over a way that is
//! short, this acts beside that friction, over a way of a good part of the stroke. Told from a spring by the way back, on which
//! it pulls less. Replays start it from the measured way behind them.

use super::{
    Bounds, Chain, Description, Effect, MOST_PARAMETERS, Middle, Parameter, Role, Scope, Summary,
    padded,
};
use crate::numeric::exponential::decay;
use crate::plant::actuator::Load;
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Reaches that are tried, as shares of the stroke: less than three times apart, as far as a fit goes from where it starts.
const REACHES: [f32; 4] = [0.025, 0.06, 0.15, 0.4];

/// A deflection behind a displacement: it comes to the reach on the side that the motion goes to, over
/// about as long a way, and where the motion turns it turns from where it is.
///
/// ```
/// use model_core::effect::hysteresis::deflected;
/// let there = deflected(0.0, 0.2, 0.1);
/// assert!((there - 0.1 * (1.0 - (-2.0_f32).exp())).abs() < 1e-7);
/// // On the way back it is another one than there on the way.
/// assert!(deflected(there, -0.2, 0.1) < -0.07);
/// ```
#[inline(always)]
pub fn deflected(deflection: f32, displacement: f32, reach: f32) -> f32 {
    let towards = if displacement < 0.0 { -reach } else { reach };
    towards - (towards - deflection) * decay(displacement.abs() / reach)
}

/// The torque.
///
/// ```
/// use model_core::effect::{Effect, Middle, hysteresis::Hysteresis, padded};
/// use model_core::plant::actuator::Load;
/// // 0.5 N·m where the deflection has come to the reach of 0.2 rad, half of that half way there.
/// let effect = Hysteresis::new(padded([0.5, 0.2]));
/// for (deflection, torque) in [(0.2, -0.5), (-0.1, 0.25)] {
///     let mut load = Load::default();
///     effect.hold(&Middle { deflection, ..Middle::default() }, &mut load);
///     assert!((load.torque - torque).abs() < 1e-7);
/// }
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hysteresis {
    torque: f32,
    reach: f32,
}

impl Effect for Hysteresis {
    const DESCRIPTION: Description = Description {
        id: "hysteresis",
        summary: Summary::ByCoordinate {
            angle: "a torque that remembers where the motion turned",
            length: "a force that remembers where the motion turned",
        },
        source: "Dahl 1968",
        parameters: &[
            Parameter {
                name: "torque",
                dimension: Dimension::Torque,
                role: Role::Strength,
                bounds: Bounds::NotNegative,
            },
            Parameter {
                name: "reach",
                dimension: Dimension::Position,
                role: Role::Shape,
                bounds: Bounds::Positive,
            },
        ],
        reported: &[("torque", Dimension::Torque), ("reach", Dimension::Position)],
        rotary_only: false,
    };
    const HELD: bool = true;

    fn new([torque, reach, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self {
            torque,
            reach: reach.max(f32::MIN_POSITIVE),
        }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        scope.friction
    }

    fn shape(scope: &Scope, index: usize) -> Option<f32> {
        REACHES.get(index).map(|reach| reach * scope.stroke)
    }

    fn bind(&self, _plant: &mut Parameters, chain: &mut Chain) {
        chain.reach = Some(self.reach);
    }

    #[inline(always)]
    fn hold(&self, middle: &Middle, load: &mut Load) {
        load.torque -= self.torque * (middle.deflection / self.reach);
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        padded([self.torque, self.reach])
    }
}
