//! A machine to be traced.

use model_core::effect::Scope;
use model_core::gap::model::Model;
use model_core::plant::Directional;
use model_core::plant::parameters::{Drive, Parameters};

pub const PERIOD: f32 = 1e-3;

/// What its logs of so many seconds span.
pub const fn scope(seconds: f32) -> Scope {
    Scope {
        friction: 0.12,
        torque: 0.2,
        voltage: 6.0,
        current: 3.0,
        speed: 10.0,
        stroke: 2.0,
        period: PERIOD,
        seconds,
        rotary: true,
        encoder_turn: core::f32::consts::TAU,
    }
}

pub fn winding(inductance: f32) -> Drive {
    Drive::Voltage {
        resistance: 1.0,
        inductance,
        torque_constant: 0.06,
    }
}

/// With a spring every parameter means something.
pub fn plant(drive: Drive, sprung: bool) -> Parameters {
    let stiff = |value: f32| if sprung { value } else { 0.0 };
    Parameters {
        drive,
        gain: if drive == Drive::Torque { 0.06 } else { 1.0 },
        inertia: 1.2e-4,
        viscous: Directional::both(2e-4),
        coulomb: Directional::both(0.12),
        breakaway: Directional::both(0.15),
        spring: stiff(0.02),
        spring_rest: stiff(0.1),
        spring_preload: stiff(0.01),
        offset: 0.0,
        lower_stop: -1.0,
        upper_stop: 1.0,
    }
}

/// Its model, without effects.
pub fn model(plant: &Parameters) -> Model {
    Model::new(*plant)
}
