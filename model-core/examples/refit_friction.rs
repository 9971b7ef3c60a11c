//! Friction that has grown, estimated anew from a log: `cargo run --release -p model-core --example refit_friction`.

use model_core::gap::log::{Channel, Log};
use model_core::identify::friction::{Refit, Task};
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
    let declared = Parameters {
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
    // What plays the measured machine: the same actuator, its friction a quarter larger.
    let worn = Parameters {
        coulomb: Directional::both(0.15),
        breakaway: Directional::both(0.1875),
        ..declared
    };
    let actuator = Actuator::build(&worn, PERIOD)?;
    let mut state = State::new(0.0, 0.0);
    let (mut input, mut position, mut current) = (Vec::new(), Vec::new(), Vec::new());
    for sample in 0..5000 {
        let time = sample as f32 * PERIOD;
        let volts = 6.0 * libm::sinf(7.0 * time) + 4.0 * libm::sinf(23.0 * time);
        input.push(volts);
        position.push(state.position.value());
        current.push(state.current);
        actuator.step(&mut state, volts)?;
    }

    let task = Task {
        declared,
        log: Log {
            current: Some(Channel::Values(&current)),
            ..Log::new(PERIOD, Channel::Values(&input), Channel::Values(&position))
        },
        resolution: 0.0,
        present: declared.coulomb.forward,
        seed: 1,
    };
    match Refit::new(&task)?.run() {
        Ok(estimate) => println!("{:.4} N·m, where 0.15 acts", estimate.coulomb),
        Err(refusal) => println!("no estimate: {refusal:?}"),
    }
    Ok(())
}
