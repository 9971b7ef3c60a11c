//! What several tests of the plant share.

use model_core::plant::parameters::{Drive, Parameters};
use model_core::plant::{Directional, State};

/// A 24 V motor with friction.
pub const MOTOR: Parameters = Parameters {
    drive: Drive::Voltage {
        resistance: 1.0,
        inductance: 1e-3,
        torque_constant: 0.06,
    },
    viscous: Directional::both(2e-4),
    coulomb: Directional::both(0.12),
    breakaway: Directional::both(0.15),
    ..Parameters::free(1.2e-4)
};

/// Kinetic energy, that in the spring and that in the winding.
pub fn energy(parameters: &Parameters, state: &State) -> f64 {
    let square = |value: f32| f64::from(value) * f64::from(value);
    let deflection = state.position.from(parameters.spring_rest);
    let magnetic = match parameters.drive {
        Drive::Voltage { inductance, .. } => f64::from(inductance) * square(state.current),
        Drive::Torque => 0.0,
    };
    0.5 * (f64::from(parameters.inertia) * square(state.velocity.value())
        + f64::from(parameters.spring) * square(deflection)
        + magnetic)
        + f64::from(parameters.spring_preload) * f64::from(deflection.abs())
}
