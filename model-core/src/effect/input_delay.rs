//! `input_delay`: the drive acts late.
//!
//! ```text
//! u(t) acts at t + τ
//! ```
//!
//! Source: bus, bridge and modulator latencies. An input that is held from its row to the next
//! already acts half a sample late in the mean; the replay holds it, so that this is not found here
//! again. Without a measured current it equals [`sensor_delay`](super::sensor_delay).

use super::{Bounds, Chain, Description, Effect, LONGEST_DELAY, MOST_PARAMETERS, Parameter, Role, Scope, delay_start, Summary, padded};
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Time by which the drive acts late.
///
/// ```
/// use model_core::effect::{Chain, Effect, input_delay::InputDelay, padded};
/// use model_core::plant::parameters::Parameters;
/// let mut chain = Chain::default();
/// InputDelay::new(padded([2e-3])).bind(&mut Parameters::free(1e-4), &mut chain);
/// assert_eq!((chain.input_delay, chain.sensor_delay), (2e-3, 0.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InputDelay {
    delay: f32,
}

impl Effect for InputDelay {
    const DESCRIPTION: Description = Description {
        id: "input_delay",
        summary: Summary::Same("the drive acts late"),
        source: "transport delay",
        parameters: &[Parameter {
            name: "delay",
            dimension: Dimension::Time,
            role: Role::Strength,
            bounds: Bounds::UpTo(LONGEST_DELAY),
        }],
        reported: &[("delay", Dimension::Time)],
        rotary_only: false,
    };

    const BIASES_BASE: bool = true;

    fn new([delay, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self { delay }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        scope.period
    }

    /// A delay of many samples is as likely as one of a few.
    fn reach(_scope: &Scope, _index: usize) -> f32 {
        f32::INFINITY
    }

    fn start(scope: &Scope, index: usize) -> Option<[f32; MOST_PARAMETERS]> {
        delay_start(scope, index)
    }

    fn bind(&self, _plant: &mut Parameters, chain: &mut Chain) {
        chain.input_delay += self.delay;
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        padded([self.delay])
    }
}
