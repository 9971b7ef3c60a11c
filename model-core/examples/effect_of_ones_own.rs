//! An effect that the catalogue does not have, a fan on the shaft of a small gearmotor, stepped with the plant:
//! `cargo run -p model-core --example effect_of_ones_own`.

use model_core::plant::actuator::{Actuator, Load};
use model_core::plant::parameters::{Drive, Parameters};
use model_core::plant::{Directional, State};
use std::error::Error;

const PERIOD: f32 = 1e-3;
const VOLTS: f32 = 6.0;
const RESISTANCE: f32 = 2.2;
const TORQUE_CONSTANT: f32 = 0.5;
const COULOMB: f32 = 0.1;

/// A fan: a torque against the motion that grows with the square of the speed.
struct Fan {
    /// N·m·s²/rad².
    coefficient: f32,
}

impl Fan {
    /// The declared load with the fan's torque beside it, which is held over a step.
    fn beside(&self, declared: Load, velocity: f32) -> Load {
        Load {
            torque: declared.torque - self.coefficient * velocity * velocity.abs(),
            ..declared
        }
    }

    /// Speed at which the motor's torque is that of friction and fan, rad/s: the positive root of
    /// c ω² + (k²/R) ω + F - k V/R = 0.
    fn steady_speed(&self) -> f32 {
        let back_emf = TORQUE_CONSTANT * TORQUE_CONSTANT / RESISTANCE;
        let left = TORQUE_CONSTANT * VOLTS / RESISTANCE - COULOMB;
        let root = (back_emf * back_emf + 4.0 * self.coefficient * left).sqrt();
        (root - back_emf) / (2.0 * self.coefficient)
    }
}

/// Runs the example.
///
/// # Errors
/// The plant does not reach the speed that it has to.
pub fn main() -> Result<(), Box<dyn Error>> {
    let parameters = Parameters {
        drive: Drive::Voltage {
            resistance: RESISTANCE,
            inductance: 1e-3,
            torque_constant: TORQUE_CONSTANT,
        },
        coulomb: Directional::both(COULOMB),
        breakaway: Directional::both(0.13),
        ..Parameters::free(2e-3)
    };
    let actuator = Actuator::build(&parameters, PERIOD)?;
    let declared = Load::declared(&parameters);
    let fan = Fan { coefficient: 5e-3 };
    let mut state = State::new(0.0, 0.0);
    for _ in 0..1000 {
        let load = fan.beside(declared, state.velocity.value());
        actuator.step_under(&mut state, VOLTS, &load)?;
    }
    let (reached, by_hand) = (state.velocity.value(), fan.steady_speed());
    println!("{reached:.3} rad/s, by hand {by_hand:.3} rad/s");
    if (reached / by_hand - 1.0).abs() > 1e-3 {
        return Err("the fan does not hold the speed that it has to".into());
    }
    Ok(())
}
