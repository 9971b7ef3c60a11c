//! What logs ask of a machine: the sizes at which an effect is said in words. A share of the voltage for each
//! watt means little to whoever stands beside the machine; the ohms of its supply do.

use model_core::gap::model::Model;
use model_core::gap::replay::Data;
use model_core::plant::parameters::{Drive, ParameterError};

use super::metrics::torque_balance;
use crate::quantity::decimal;

/// The largest that the training logs ask of a machine. A number that they do not have is 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Demand {
    /// Largest magnitude of the voltage that the input asks for, V, or that of the supply where the input is a share of it; 0 with a
    /// torque input.
    pub voltage: f64,
    /// Whether that is the supply's.
    pub is_of_supply: bool,
    /// Largest magnitude of the motor's torque or force, as the torque constant has it, N·m or N.
    pub torque: f64,
    /// Root mean square of the motor's current, A; 0 with a torque input.
    pub current_rms: f64,
    /// Largest speed, rad/s or m/s.
    pub speed: f64,
    /// Coulomb friction of the final model, the mean of both directions, N·m or N.
    pub friction: f64,
    /// Length of the longest log, s.
    pub duration_s: f64,
}

/// Largest input that is still a share of the supply's voltage: one, and what a logger rounds it up to with two decimals.
const WHOLE_DUTY: f64 = 1.01;

impl Demand {
    /// Of logs on a model. Torques and speeds are those of its torque balance, whose filter takes the
    /// sensor's noise out of them.
    ///
    /// # Errors
    /// A parameter of the model outside its range.
    pub fn of(data: &Data, model: &Model) -> Result<Self, ParameterError> {
        let plant = model.bound_plant();
        let constant = match plant.drive {
            Drive::Voltage {
                torque_constant, ..
            } => Some(f64::from(torque_constant)),
            Drive::Torque => None,
        };
        let largest = |values: &[f64]| {
            let magnitudes = values.iter().map(|value| value.abs());
            magnitudes
                .filter(|value| value.is_finite())
                .fold(0.0, f64::max)
        };
        let friction = 0.5 * (plant.coulomb.forward + plant.coulomb.backward);
        let mut demand = Self {
            friction: f64::from(friction),
            ..Self::default()
        };
        let (mut squares, mut entries) = (0.0, 0usize);
        let mut most_input = 0.0_f64;
        for log in data.logs {
            let balance = torque_balance(log, model, f64::from(data.settings.resolution))?;
            demand.torque = demand.torque.max(largest(&balance.torque));
            demand.speed = demand.speed.max(largest(&balance.velocity));
            let duration_s = log.samples() as f64 * decimal(log.period);
            demand.duration_s = demand.duration_s.max(duration_s);
            if let Some(constant) = constant {
                let inputs: Vec<f64> = log.input.iter().map(f64::from).collect();
                most_input = most_input.max(largest(&inputs));
                let currents = balance.torque.iter().map(|torque| torque / constant);
                squares += currents.map(|current| current * current).sum::<f64>();
                entries += balance.torque.len();
            }
        }
        if constant.is_some() {
            let gain = f64::from(plant.gain).abs();
            demand.is_of_supply = gain > 1.0 && most_input <= WHOLE_DUTY;
            demand.voltage = gain * if demand.is_of_supply { 1.0 } else { most_input };
        }
        let mean = squares / entries as f64;
        if mean.is_finite() {
            demand.current_rms = mean.sqrt();
        }
        Ok(demand)
    }
}
