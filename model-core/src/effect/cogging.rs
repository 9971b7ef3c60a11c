//! `cogging`: a torque periodic in position, as of a slotted motor or of gear teeth.
//!
//! ```text
//! J dω/dt = … + a sin(2π θ / P) + b cos(2π θ / P)
//! ```
//!
//! Source: the fundamental of a cogging torque (J. R. Hendershot, T. J. E. Miller, *Design of
//! brushless permanent-magnet motors*, 1994). The period is scanned: in cycles a stroke, and on a
//! rotary actuator in whole cycles a turn too.

use super::{Description, Effect, MOST_PARAMETERS, Middle, Parameter, Role, Scope};
use crate::numeric::sine::ripple;
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

/// The two components and the period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cogging {
    sine: f32,
    cosine: f32,
    wavenumber: f32,
}

impl Effect for Cogging {
    const DESCRIPTION: Description = Description {
        id: "cogging",
        summary: "a torque periodic in position",
        source: "Hendershot, Miller 1994",
        parameters: &[
            Parameter {
                name: "sine",
                dimension: Dimension::Torque,
                role: Role::SignedStrength,
            },
            Parameter {
                name: "cosine",
                dimension: Dimension::Torque,
                role: Role::SignedStrength,
            },
            Parameter {
                name: "period",
                dimension: Dimension::Position,
                role: Role::Shape,
            },
        ],
        reported: &[
            ("amplitude", Dimension::Torque),
            ("phase", Dimension::Phase),
            ("period", Dimension::Position),
        ],
        rotary_only: false,
    };
    const HELD: bool = true;

    fn new([sine, cosine, period]: [f32; MOST_PARAMETERS]) -> Self {
        Self {
            sine,
            cosine,
            wavenumber: 1.0 / period.max(f32::MIN_POSITIVE),
        }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        scope.friction
    }

    fn shape(scope: &Scope, index: usize) -> Option<f32> {
        let longest = scope.stroke / FIRST_CYCLES;
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

    #[inline]
    fn hold(&self, middle: &Middle, load: &mut Load) {
        let cycles = middle.position * self.wavenumber;
        load.torque += ripple(self.sine, cycles) + ripple(self.cosine, cycles + 0.25);
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        [
            libm::hypotf(self.sine, self.cosine),
            libm::atan2f(self.cosine, self.sine),
            1.0 / self.wavenumber,
        ]
    }
}
