//! The actuator that is emulated and the gains of its position loop.

use model_core::plant::Directional;
use model_core::plant::parameters::{Drive, Parameters};

use model_core::control::pid;

/// Supply of the bridge, V.
const SUPPLY: f32 = 24.0;

/// A small 24 V brushed-DC actuator, referred to its output shaft: what `ema-24v.toml` among the
/// host's machine files declares.
pub const DECLARED: Parameters = Parameters {
    drive: Drive::Voltage {
        resistance: 1.0,
        inductance: 1.0e-3,
        torque_constant: 0.06,
    },
    gain: 1.0,
    inertia: 1.2e-4,
    viscous: Directional::both(2.0e-4),
    coulomb: Directional::both(0.12),
    breakaway: Directional::both(0.15),
    spring: 0.0,
    spring_rest: 0.0,
    spring_preload: 0.0,
    offset: 0.0,
    lower_stop: -1.0,
    upper_stop: 1.0,
};

/// The actuator that is emulated. Its viscous friction depends on the direction of motion, which
/// nobody declares: the host's tracing has to find it in the log.
pub const ACTUATOR: Parameters = Parameters {
    viscous: Directional {
        forward: 1.4e-3,
        backward: DECLARED.viscous.backward,
    },
    ..DECLARED
};

/// Position loop. The derivative cancels the mechanical time constant J R / k² = 33 ms, which
/// leaves an integrator: the crossover K_p / k = 500 1/s lies at half the corner R / L of the
/// winding. The actuator may rest wherever friction holds it, at most breakaway · R / (k K_p) =
/// 83 mrad off; what the integral does about that within one hold is left at that.
pub const POSITION_LOOP: pid::Parameters = pid::Parameters {
    proportional: 30.0,
    integral: 150.0,
    derivative: 1.0,
    derivative_filter_time: 0.2e-3,
    set_point_weight: 1.0,
    derivative_set_point_weight: 0.0,
    output_minimum: -SUPPLY,
    output_maximum: SUPPLY,
    anti_windup: pid::AntiWindup::ConditionalIntegration,
};
