//! `cogging`: a torque periodic in position, as of a slotted motor or of gear teeth.
//!
//! ```text
//! J dω/dt = … + Σ aₙ sin(2π n θ / P) + bₙ cos(2π n θ / P),   n = 1, 2, 3
//! ```
//!
//! Source: the harmonics of a cogging torque (J. R. Hendershot, T. J. E. Miller, *Design of
//! brushless permanent-magnet motors*, 1994). The second and the third are 0 unless a log that has been found to have the
//! first is followed clearly better with them. The period is scanned: in cycles a stroke, and on a
//! rotary actuator in whole cycles a turn too.
//!
//! Told from a friction over position by passes in both directions, with which a friction turns and a
//! torque does not, and from an encoder that is not centred by slow and fast passes over one place, at
//! which a reading is off alike. Of one cycle a turn it is an unbalanced load. A motion over less than a cycle
//! and a half does not show that a torque repeats: a spring, straight or bent, looks like that. No longer period
//! is fitted.

use super::harmonic::Harmonic;
use super::learned_map::Kind;
use super::{Description, Effect, MOST_PARAMETERS, Middle, Scope, Summary};
use crate::plant::actuator::Load;
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Cycles over the stroke that the scan starts from, and the step between two tries: a ripple that
/// is half a cycle off over the stroke still correlates.
const FIRST_CYCLES: f32 = 1.5;
const CYCLES_STEP: f32 = 0.5;
const STROKE_TRIES: usize = 80;

/// Whole cycles a turn that a rotary actuator's scan ends at.
const TURN_TRIES: usize = 48;

/// The torque.
///
/// ```
/// use model_core::effect::{Effect, Middle, cogging::Cogging, padded};
/// use model_core::plant::actuator::Load;
/// // 0.02 N·m at a quarter of the period of 0.8 rad, and as much the other way half a period on.
/// let effect = Cogging::new(padded([0.02, 0.0, 0.8]));
/// for (position, torque) in [(0.2, 0.02), (0.6, -0.02)] {
///     let mut load = Load::default();
///     effect.hold(&Middle { position, ..Middle::default() }, &mut load);
///     assert!((load.torque - torque).abs() < 1e-7);
/// }
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cogging(Harmonic);

impl Effect for Cogging {
    const DESCRIPTION: Description = Description {
        id: "cogging",
        summary: Summary::ByCoordinate {
            angle: "a torque periodic in position",
            length: "a force periodic in position",
        },
        source: "Hendershot, Miller 1994",
        parameters: &Harmonic::parameters_with_overtones(Dimension::Torque),
        reported: &Harmonic::reported_with_overtones(Dimension::Torque),
        rotary_only: false,
    };
    const MAP: Option<Kind> = Some(Kind::PositionTorque);
    const HELD: bool = true;

    fn new(values: [f32; MOST_PARAMETERS]) -> Self {
        Self(Harmonic::new(values))
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        scope.friction
    }

    fn largest_shape(scope: &Scope) -> f32 {
        scope.stroke / FIRST_CYCLES
    }

    fn shape(scope: &Scope, index: usize) -> Option<f32> {
        let longest = Self::largest_shape(scope);
        if index < STROKE_TRIES {
            return Some(scope.stroke / (FIRST_CYCLES + CYCLES_STEP * index as f32));
        }
        if !scope.rotary {
            return None;
        }
        // The turn's own orders, where the stroke's scan is too coarse or ends before them.
        let shortest = scope.stroke / (FIRST_CYCLES + CYCLES_STEP * STROKE_TRIES as f32);
        (1..=TURN_TRIES)
            .map(|cycles| core::f32::consts::TAU / cycles as f32)
            .filter(|&period| period < shortest && period < longest)
            .nth(index - STROKE_TRIES)
    }

    #[inline(always)]
    fn hold(&self, middle: &Middle, load: &mut Load) {
        load.torque += self.0.at(middle.position);
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        self.0.report()
    }
}
