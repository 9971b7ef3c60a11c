//! `supply_sag`: the supply's voltage falls with the power drawn from it.
//!
//! ```text
//! v = d (U − R_s d i) = u (1 − s u i),  d = u / U,  s = R_s / U²
//! ```
//!
//! The bridge gives the share d of what the supply has left, and draws the share d of the winding's
//! current: so u i is the power drawn, and s the share of the voltage that each watt takes. A machine
//! that feeds back raises the voltage. Source: an ideal voltage behind a resistance, and the averaged
//! bridge (R. W. Erickson, D. Maksimović, *Fundamentals of Power Electronics*, 2001).
//!
//! Told from a larger resistance, which takes as much at every voltage, by currents under small and
//! under large voltages. A log that stays at one duty does not tell it; the resistance is then the
//! better name.

use super::{Bounds, Description, Effect, MOST_PARAMETERS, Middle, Parameter, Role, Scope, Summary, padded};
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Share of the voltage that is lost with each watt.
///
/// ```
/// use model_core::effect::{Effect, supply_sag::SupplySag, padded};
/// // 12 V behind 0.3 Ω give 5 A at full duty: 1.5 V are missing.
/// let effect = SupplySag::new(padded([0.3 / (12.0 * 12.0)]));
/// assert!((effect.left_of(12.0, 5.0) - 10.5).abs() < 1e-5);
/// // At half the duty the supply gives half the current, and half of what it lacks is noticed.
/// assert!((effect.left_of(6.0, 5.0) - (6.0 - 0.25 * 1.5)).abs() < 1e-5);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SupplySag {
    share: f32,
}

impl SupplySag {
    /// What is left of a voltage that drives this current, V: nothing at worst, and no more than twice
    /// as much from a machine that feeds back.
    #[inline(always)]
    pub fn left_of(&self, voltage: f32, current: f32) -> f32 {
        let lost = self.share * voltage * current;
        voltage * (1.0 - lost.clamp(-1.0, 1.0))
    }
}

impl Effect for SupplySag {
    const DESCRIPTION: Description = Description {
        id: "supply_sag",
        summary: Summary::Same("the supply's voltage falls with the power drawn from it"),
        source: "Erickson, Maksimović 2001",
        parameters: &[Parameter {
            name: "share",
            dimension: Dimension::PerPower,
            role: Role::Strength,
            bounds: Bounds::NotNegative,
        }],
        reported: &[("share", Dimension::PerPower)],
        rotary_only: false,
    };
    const ELECTRIC: bool = true;
    const NEEDS_WINDING: bool = true;

    fn new([share, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self { share }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        0.1 / (scope.voltage * scope.current)
    }

    #[inline(always)]
    fn voltage(&self, middle: &Middle) -> f32 {
        self.left_of(middle.voltage, middle.current()) - middle.voltage
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        padded([self.share])
    }
}
