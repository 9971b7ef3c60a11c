//! A small gearmotor under a step of voltage: `cargo run -p model-core --example step_a_plant`.

use model_core::plant::actuator::Actuator;
use model_core::plant::parameters::{Drive, Parameters};
use model_core::plant::{Directional, State};
use std::error::Error;

const PERIOD: f32 = 1e-3;

/// Runs the example.
///
/// # Errors
/// None: its numbers are valid.
pub fn main() -> Result<(), Box<dyn Error>> {
    // Motor values referred to the output shaft.
    let parameters = Parameters {
        drive: Drive::Voltage {
            resistance: 2.2,
            inductance: 1e-3,
            torque_constant: 0.5,
        },
        viscous: Directional::both(2e-3),
        coulomb: Directional::both(0.1),
        breakaway: Directional::both(0.13),
        ..Parameters::free(2e-3)
    };
    let actuator = Actuator::build(&parameters, PERIOD)?;

    println!("time_s,position,velocity,current_a");
    let mut state = State::new(0.0, 0.0);
    for sample in 0..500 {
        let time = sample as f32 * PERIOD;
        let volts = if time < 0.1 { 0.0 } else { 6.0 };
        actuator.step(&mut state, volts)?;
        if sample % 20 == 0 {
            let (position, velocity) = (state.position.value(), state.velocity.value());
            println!("{time:.3},{position:.5},{velocity:.4},{:.4}", state.current);
        }
    }
    Ok(())
}
