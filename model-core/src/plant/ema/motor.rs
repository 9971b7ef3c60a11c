//! The brushed DC motor: a winding, its back-EMF, its rotor, and the saturation of its flux.

use crate::plant::parameters;

/// What the motor is.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters {
    /// Winding resistance, Ω, > 0.
    pub resistance: f32,
    /// Winding inductance, H, ≥ 0; 0 neglects it.
    pub inductance: f32,
    /// Torque constant, N·m/A, and back-EMF constant, V·s/rad, > 0.
    pub torque_constant: f32,
    /// Torque at which the flux saturates, N·m, > 0: no current gives more.
    pub peak_torque: f32,
    /// Inertia of rotor and gearbox, kg·m², > 0.
    pub inertia: f32,
    /// Viscous friction of all that turns, N·m·s/rad, ≥ 0.
    pub viscous: f32,
}

impl Parameters {
    pub(super) fn drive(&self) -> parameters::Drive {
        parameters::Drive::Voltage {
            resistance: self.resistance,
            inductance: self.inductance,
            torque_constant: self.torque_constant,
        }
    }

    /// Torque of a current, N·m, as far as the flux goes.
    pub fn torque(&self, current: f32) -> f32 {
        (self.torque_constant * current).clamp(-self.peak_torque, self.peak_torque)
    }
}
