//! `external_load`: a torque that comes and goes in time.
//!
//! ```text
//! J dω/dt = … + T  from t_begin to t_begin + d,  t from the beginning of the log
//! ```
//!
//! Source: the step disturbance by which servo drives are tested (W. Leonhard, *Control of electrical
//! drives*, 1985), taken away again: somebody leans on the machine, a load is picked up and put
//! down. It has no law beyond that; when it acts is found by a scan over the log, and refined in the
//! fit. Of several logs it acts in each.
//!
//! Told from a constant [`offset_torque`](super::offset_torque) by the time without it, from friction
//! by motion both ways while it lasts; one that fills nine tenths of the log is left to those. A torque
//! over position looks the same as long as the machine comes to that place once only. It is held
//! against the part of the log in which it acts, in short windows: elsewhere it says nothing. Less than
//! about a second of it, at rest throughout, stays unseen.

use super::learned_map::Kind;
use super::{Bounds, Description, Effect, MOST_PARAMETERS, MOST_SHAPES, Middle, Parameter, Role, Scope, Summary, padded};
use crate::plant::actuator::Load;
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Lengths that are tried, in parts of the log: factors of two, at places half a length apart, lie
/// near enough for a fit to find the rest.
const PARTS: [usize; 4] = [2, 4, 8, 16];

/// The torque, when it ends and how long it lasts. When it begins may be before the log.
///
/// ```
/// use model_core::effect::{Effect, external_load::ExternalLoad, padded};
/// // 0.3 N·m from 2 s to 5 s; of a step from 4.999 s to 5.003 s it acts in a quarter.
/// let effect = ExternalLoad::new(padded([0.3, 5.0, 3.0]));
/// assert_eq!((effect.mean(1.0, 0.5), effect.mean(4.0, 0.5)), (0.0, 0.3));
/// assert!((effect.mean(4.999, 0.004) - 0.075).abs() < 1e-4);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExternalLoad {
    torque: f32,
    begin: f32,
    end: f32,
}

impl ExternalLoad {
    /// Its mean over a step from `time` on: a fit sees parts of a step, too.
    #[inline(always)]
    pub fn mean(&self, time: f32, step: f32) -> f32 {
        if time >= self.end || time + step <= self.begin {
            return 0.0;
        }
        let within = step - (self.begin - time).max(0.0) - (time + step - self.end).max(0.0);
        self.torque * (within / step).max(0.0)
    }
}

impl Effect for ExternalLoad {
    const DESCRIPTION: Description = Description {
        id: "external_load",
        summary: Summary::ByCoordinate {
            angle: "a torque that comes and goes in time",
            length: "a force that comes and goes in time",
        },
        source: "Leonhard 1985",
        parameters: &[
            Parameter {
                name: "torque",
                dimension: Dimension::Torque,
                role: Role::Strength,
                bounds: Bounds::Any,
            },
            Parameter {
                name: "end",
                dimension: Dimension::Time,
                role: Role::Shape,
                bounds: Bounds::Positive,
            },
            Parameter {
                name: "duration",
                dimension: Dimension::Time,
                role: Role::Shape,
                bounds: Bounds::Positive,
            },
        ],
        reported: &[
            ("torque", Dimension::Torque),
            ("begin", Dimension::Time),
            ("duration", Dimension::Time),
        ],
        rotary_only: false,
    };
    const MAP: Option<Kind> = Some(Kind::TimeTorque);
    const HELD: bool = true;

    fn new([torque, end, duration, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self {
            torque,
            begin: end - duration,
            end,
        }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        scope.friction
    }

    fn shapes(scope: &Scope, mut index: usize) -> Option<[f32; MOST_SHAPES]> {
        for parts in PARTS {
            let places = 2 * parts - 1;
            if index < places {
                let duration = scope.seconds / parts as f32;
                return Some([duration * (1.0 + 0.5 * index as f32), duration]);
            }
            index -= places;
        }
        None
    }

    fn span(&self) -> Option<(f32, f32)> {
        Some((self.begin, self.end))
    }

    #[inline(always)]
    fn hold(&self, middle: &Middle, load: &mut Load) {
        load.torque += self.mean(middle.time, middle.step);
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        padded([self.torque, self.begin, self.end - self.begin])
    }
}
