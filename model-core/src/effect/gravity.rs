//! `gravity`: an unbalanced load on a horizontal axis.
//!
//! ```text
//! J dω/dt = … − a sin θ − b cos θ = … − G sin(θ − θ_rest)
//! ```
//!
//! Source: the physical pendulum. Over a small stroke it is a spring and an offset; told from them
//! by a stroke of a radian or more.

use super::learned_map::Kind;
use super::{Bounds, Description, Effect, MOST_PARAMETERS, Middle, Parameter, Role, Scope, Summary, padded};
use crate::numeric::sine::{ripple, sine_cycles};
use crate::plant::actuator::Load;
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// The two components of the torque.
///
/// ```
/// use model_core::effect::{Effect, Middle, gravity::Gravity};
/// use model_core::plant::actuator::Load;
/// // A load of 0.5 N·m at a right angle, hanging at 0.3 rad, pulls back from a quarter of a turn on.
/// let effect = Gravity::new(Gravity::values(0.5, 0.3));
/// let middle = Middle { position: 0.3 + core::f32::consts::FRAC_PI_2, ..Middle::default() };
/// let mut load = Load::default();
/// effect.hold(&middle, &mut load);
/// assert!((load.torque + 0.5).abs() < 1e-6);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gravity {
    sine: f32,
    cosine: f32,
}

impl Gravity {
    /// The values of a load with the torque `torque` at a right angle to where it hangs, `rest`.
    pub fn values(torque: f32, rest: f32) -> [f32; MOST_PARAMETERS] {
        let cycles = rest * (0.5 * core::f32::consts::FRAC_1_PI);
        padded([
            torque * sine_cycles(cycles + 0.25),
            -torque * sine_cycles(cycles),
        ])
    }
}

impl Effect for Gravity {
    const DESCRIPTION: Description = Description {
        id: "gravity",
        summary: Summary::Same("an unbalanced load: a torque proportional to the sine of the angle"),
        source: "physical pendulum",
        parameters: &[
            Parameter {
                name: "sine",
                dimension: Dimension::Torque,
                role: Role::Strength,
                bounds: Bounds::Any,
            },
            Parameter {
                name: "cosine",
                dimension: Dimension::Torque,
                role: Role::Strength,
                bounds: Bounds::Any,
            },
        ],
        reported: &[("torque", Dimension::Torque), ("rest", Dimension::Phase)],
        rotary_only: true,
    };
    const MAP: Option<Kind> = Some(Kind::PositionTorque);
    const HELD: bool = true;

    fn new([sine, cosine, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self { sine, cosine }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        scope.friction
    }

    #[inline(always)]
    fn hold(&self, middle: &Middle, load: &mut Load) {
        let cycles = middle.position * (0.5 * core::f32::consts::FRAC_1_PI);
        load.torque -= ripple(self.sine, cycles) + ripple(self.cosine, cycles + 0.25);
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        padded([
            libm::hypotf(self.sine, self.cosine),
            libm::atan2f(-self.cosine, self.sine),
        ])
    }
}
