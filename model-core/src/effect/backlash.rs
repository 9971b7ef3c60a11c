//! `backlash`: lost motion between drive and sensor.
//!
//! ```text
//! θ_reported stays until the drive has taken up the play, and is dragged along from then on:
//! θ − w/2 ≤ θ_reported ≤ θ + w/2
//! ```
//!
//! w is the full width: what a reversal loses. Source: the play operator (M. A. Krasnosel'skii,
//! A. V. Pokrovskii, *Systems with hysteresis*, 1989); the far side has no inertia and no load of its
//! own, so that it stays where the drive leaves it.
//!
//! Told from every delay by slow reversals: a delay loses time, the play loses angle, whatever the
//! speed. A log without reversals says nothing about it. What lies between small and large plays
//! is not linear: a reading that rests for a second is no sum of readings that rest for a moment. So
//! it is screened at several widths.
//!
//! A replay starts from the sensor's side. Where the drive is within the play follows from the last
//! clear motion: moving forward it leads by w/2, backward it trails by w/2; on the plateau behind a
//! reversal it is on its way, and is simulated from the end of that motion on.

use super::{Bounds, Chain, Description, Effect, MOST_PARAMETERS, Parameter, Role, Scope, Summary, padded};
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Widths at which it is screened, as shares of the stroke: factors of two, which lie near enough for
/// a fit to find the rest.
const TRIALS: [f32; 9] = [0.0005, 0.001, 0.002, 0.004, 0.008, 0.016, 0.032, 0.064, 0.128];

/// Width of the play.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Backlash {
    width: f32,
}

/// Where the far side of a play of this half width is, once the near side is at `near`.
///
/// ```
/// use model_core::effect::backlash::follow;
/// // A play of 0.2 rad: half of it is taken up on the way there, the whole of it on the way back.
/// let there = follow(0.0, 1.0, 0.1);
/// let resting = follow(there, 0.85, 0.1);
/// let back = follow(resting, 0.5, 0.1);
/// assert_eq!((there, resting, back), (0.9, 0.9, 0.6));
/// ```
#[inline(always)]
pub fn follow(far: f32, near: f32, half_width: f32) -> f32 {
    far.max(near - half_width).min(near + half_width)
}

impl Effect for Backlash {
    const DESCRIPTION: Description = Description {
        id: "backlash",
        summary: Summary::Same("lost motion between drive and sensor"),
        source: "Krasnosel'skii, Pokrovskii 1989",
        parameters: &[Parameter {
            name: "width",
            dimension: Dimension::Position,
            role: Role::Strength,
            bounds: Bounds::NotNegative,
        }],
        reported: &[("width", Dimension::Position)],
        rotary_only: false,
    };

    const STATEFUL: bool = true;
    const BIASES_BASE: bool = true;
    const MISREADS: bool = true;

    fn new([width, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self { width }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        0.01 * scope.stroke
    }

    fn trial(scope: &Scope, index: usize) -> Option<[f32; MOST_PARAMETERS]> {
        TRIALS.get(index).map(|share| padded([share * scope.stroke]))
    }

    fn bind(&self, _plant: &mut Parameters, chain: &mut Chain) {
        chain.play = Some(chain.play.unwrap_or(0.0) + self.width);
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        padded([self.width])
    }
}
