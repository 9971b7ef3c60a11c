//! Torque of the phase currents (bench paper, section 3.4), and the one convention of currents.
//!
//! Each phase gives its current times its back-EMF coefficient. Currents in the windings are
//! instantaneous, so that with a sine of peak Î in each phase the sum is 1.5 k Î. The datasheet's
//! torque constant is per A *rms*, and Î = √2 I: this is the paper's factor √2, and
//!
//! ```text
//! T = Σ k_j i_j = 1.5 √2 k I = k_T I,   k = k_T/(1.5 √2) = 0.9004 V·s/rad
//! ```
//!
//! The power that leaves the windings, Σ k_j ω i_j, is then the shaft's, T ω. Outside the windings
//! (references, limits, what is logged) currents are rms. The datasheet's voltage constant alone
//! would give k = 0.9434 V·s/rad: cold magnets, where the torque constant is that of a warm motor.
//!
//! Beyond the paper, a torque constant that falls with current, off by default:
//! T = T₀/(1 + s |T₀|/k_T), with s in 1/A rms.

use crate::numeric::invalid_parameter::{InvalidParameter, require, require_positive};
use core::f32::consts::SQRT_2;

/// What turns current into torque.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// k_T, N·m per A rms, > 0.
    pub torque_constant: f32,
    /// s: how far the torque constant falls with current, 1/A rms, ≥ 0; 0 for not at all.
    pub saturation: f32,
}

impl Parameters {
    pub(super) fn check(&self) -> Result<(), InvalidParameter> {
        require_positive(self.torque_constant, "torque constant")?;
        require(
            self.saturation >= 0.0 && self.saturation.is_finite(),
            "saturation",
            "must be at least 0 and finite",
        )
    }

    /// k: back-EMF coefficient of a phase, V·s/rad, and torque for its current, N·m/A.
    pub fn coefficient(&self) -> f32 {
        self.torque_constant / (1.5 * SQRT_2)
    }

    /// What saturation leaves of a torque, N·m.
    #[inline]
    pub fn saturated(&self, torque: f32) -> f32 {
        if self.saturation == 0.0 {
            torque
        } else {
            torque / (1.0 + self.saturation * torque.abs() / self.torque_constant)
        }
    }
}

/// A scalar product: of currents and coefficients, the torque; of voltages and currents, the power.
#[inline]
pub fn sum_of_phases(currents: [f32; 3], coefficients: [f32; 3]) -> f32 {
    currents[0] * coefficients[0] + currents[1] * coefficients[1] + currents[2] * coefficients[2]
}
