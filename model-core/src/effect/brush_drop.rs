//! `brush_drop`: voltage lost at the brushes, whatever the current.
//!
//! ```text
//! v = u − V sgn i,  sgn 0 = what keeps the current at zero, −1 … 1
//! ```
//!
//! As dry friction holds a mechanism, the brushes hold the current at zero until V is exceeded. Source:
//! the contact voltage of carbon brushes, which hardly depends on the current (IEC 60034-2-1 counts
//! with a constant one). At zero the drop is found together with the current in the end of the step,
//! which needs no slope around it and does not chatter (V. Acary, B. Brogliato, *Implicit Euler
//! numerical scheme and chattering-free implementation of sliding mode systems*, 2010).
//!
//! Where the current was measured, voltage and speed tell it. Where it was not, it is Coulomb friction
//! of k V / R while the motor drives, and only motions that the motor brakes tell the two apart. Told
//! from a [`dead_time`](super::dead_time) by a motor that generates under hardly any voltage.

use super::{Bounds, Description, Effect, MOST_PARAMETERS, Middle, Parameter, Role, Scope, Summary, padded};
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Voltage of all brushes in series.
///
/// ```
/// use model_core::effect::{Effect, brush_drop::BrushDrop, padded};
/// let effect = BrushDrop::new(padded([1.5]));
/// // 4 V more than would leave no current: the whole drop, either way.
/// assert_eq!((effect.against(4.0), effect.against(-4.0)), (-1.5, 1.5));
/// // Half a volt does not drive a current through the brushes.
/// assert_eq!(effect.against(0.5), -0.5);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BrushDrop {
    drop: f32,
}

impl BrushDrop {
    /// What the brushes add to a winding's voltage that is so much beyond the one without current, V.
    #[inline(always)]
    pub fn against(&self, excess: f32) -> f32 {
        -excess.max(-self.drop).min(self.drop)
    }
}

impl Effect for BrushDrop {
    const DESCRIPTION: Description = Description {
        id: "brush_drop",
        summary: Summary::Same("voltage lost at the brushes"),
        source: "IEC 60034-2-1",
        parameters: &[Parameter {
            name: "drop",
            dimension: Dimension::Voltage,
            role: Role::Strength,
            bounds: Bounds::NotNegative,
        }],
        reported: &[("drop", Dimension::Voltage)],
        rotary_only: false,
    };
    const ELECTRIC: bool = true;
    const NEEDS_WINDING: bool = true;

    fn new([drop, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self { drop }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        0.1 * scope.voltage
    }

    #[inline(always)]
    fn voltage(&self, middle: &Middle) -> f32 {
        self.against(middle.excess)
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        padded([self.drop])
    }
}
