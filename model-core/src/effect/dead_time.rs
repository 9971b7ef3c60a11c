//! `dead_time`: voltage lost in the bridge while both switches of a leg are off.
//!
//! ```text
//! v = u − min(V, |u|) sgn i,  V = U t_d / T
//! ```
//!
//! In the dead time t_d of each period T the diodes hold the supply U against the current. Pulses
//! shorter than it are swallowed, so that no more than u is lost: around zero the drive does nothing.
//! At zero current the loss is what keeps it there. Source: S.-G. Jeong, M.-H. Park, *The analysis and
//! compensation of dead-time effects in PWM inverters*, IEEE Trans. Ind. Electron. 38, 1991; one leg
//! of an H-bridge switches at a time, and at u = 0 none does.
//!
//! Beyond V it is the same voltage as a [`brush_drop`](super::brush_drop), and below V neither lets the
//! motor drive. What differs is a motor that generates while the bridge hardly drives: the brushes
//! take their voltage from the back-EMF, a bridge that does not switch takes none. Few logs have that,
//! and the two are then equivalent.

use super::brush_drop::BrushDrop;
use super::{Bounds, Description, Effect, MOST_PARAMETERS, Middle, Parameter, Role, Scope, Summary, padded};
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Mean voltage of the dead time.
///
/// ```
/// use model_core::effect::{Effect, dead_time::DeadTime, padded};
/// // 1 µs of each 50 µs, from 24 V.
/// let effect = DeadTime::new(padded([24.0 / 50.0]));
/// assert_eq!(effect.against(12.0, 5.0), -0.48);
/// // Braking at 12 V: the current flows against the voltage, which the dead time raises.
/// assert_eq!(effect.against(12.0, -5.0), 0.48);
/// // Shorter pulses than the dead time are swallowed.
/// assert_eq!(0.3 + effect.against(0.3, 5.0), 0.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeadTime {
    loss: f32,
}

impl DeadTime {
    /// What the bridge adds to a voltage that is so much beyond the one without current, V.
    #[inline(always)]
    pub fn against(&self, voltage: f32, excess: f32) -> f32 {
        BrushDrop::new(padded([self.loss.min(voltage.abs())])).against(excess)
    }
}

impl Effect for DeadTime {
    const DESCRIPTION: Description = Description {
        id: "dead_time",
        summary: Summary::Same("voltage lost in the bridge near zero"),
        source: "Jeong, Park 1991",
        parameters: &[Parameter {
            name: "loss",
            dimension: Dimension::Voltage,
            role: Role::Strength,
            bounds: Bounds::NotNegative,
        }],
        reported: &[("loss", Dimension::Voltage)],
        rotary_only: false,
    };
    const ELECTRIC: bool = true;
    const NEEDS_WINDING: bool = true;

    fn new([loss, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self { loss }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        0.1 * scope.voltage
    }

    #[inline(always)]
    fn voltage(&self, middle: &Middle) -> f32 {
        self.against(middle.voltage, middle.excess)
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        padded([self.loss])
    }
}
