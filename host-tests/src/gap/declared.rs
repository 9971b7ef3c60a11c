//! The core's model of what a machine file declares.

use model_core::effect::{Active, Id, MOST_PARAMETERS, Role};
use model_core::gap::model::{Base, Model};
use model_core::plant::Directional;
use model_core::plant::parameters::{Drive, Parameters};
use model_core::unit::Dimension;

use crate::error::InputError;
use crate::machine::{Coordinate, Machine};

/// Longest delay that may be declared, s. What is meant in milliseconds is beyond it.
const LONGEST_DELAY_S: f64 = 1.0;

/// The core's model of a machine file.
///
/// # Errors
/// A number beyond what the plant takes. A declared effect that the catalogue does not have, that
/// is there twice or has no meaning along a stroke; a parameter that it does not have, lacks, or
/// may not have with that value.
pub fn model(machine: &Machine) -> Result<Model, InputError> {
    let mechanics = &machine.mechanics;
    let plant = Parameters {
        drive: match &machine.motor {
            Some(motor) => Drive::Voltage {
                resistance: motor.resistance as f32,
                inductance: motor.inductance as f32,
                torque_constant: motor.torque_constant as f32,
            },
            None => Drive::Torque,
        },
        gain: machine.gain as f32,
        inertia: mechanics.inertia as f32,
        viscous: Directional::both(mechanics.viscous as f32),
        coulomb: Directional::both(machine.friction.coulomb as f32),
        breakaway: Directional::both(machine.friction.r#static as f32),
        spring: mechanics.spring as f32,
        spring_rest: mechanics.spring_rest as f32,
        spring_preload: mechanics.spring_preload as f32,
        offset: 0.0,
        lower_stop: mechanics
            .lower_stop
            .map_or(f32::NEG_INFINITY, |stop| stop as f32),
        upper_stop: mechanics
            .upper_stop
            .map_or(f32::INFINITY, |stop| stop as f32),
    };
    plant
        .check()
        .map_err(|error| InputError::new(&machine.path, None, error.to_string()))?;
    let mut model = Model {
        plant,
        gravity_torque: mechanics.gravity_torque as f32,
        gravity_rest: mechanics.gravity_rest as f32,
        effects: Default::default(),
        map: None,
    };
    for declared in &machine.declared_effects {
        let known = || {
            let ids: Vec<&str> = Id::ALL.iter().map(|id| id.description().id).collect();
            ids.join(", ")
        };
        let id = Id::from_id(&declared.id).ok_or_else(|| {
            let message = format!(
                "unknown effect `{}`: expected one of {}",
                declared.id,
                known()
            );
            machine.error_at(declared.line, message)
        })?;
        if model.has(id) {
            let message = format!("effect `{}` is declared twice; remove one", declared.id);
            return Err(machine.error_at(declared.line, message));
        }
        if id.description().rotary_only && machine.coordinate == Coordinate::Metre {
            let message = format!(
                "effect `{}` is for rotary machines only; remove it, or set `coordinate = \"rad\"`",
                declared.id
            );
            return Err(machine.error_at(declared.line, message));
        }
        if id.needs_winding() && machine.motor.is_none() {
            let message = format!(
                "effect `{}` is for machines with a voltage input only; remove it, or declare \
                 `kind = \"voltage\"` and [motor]",
                declared.id
            );
            return Err(machine.error_at(declared.line, message));
        }
        let parameters = id.description().parameters;
        let form: Vec<&str> = parameters.iter().map(|parameter| parameter.name).collect();
        let mut values = [0.0; MOST_PARAMETERS];
        for (name, value) in &declared.parameters {
            let Some(index) = form.iter().position(|known| known == name) else {
                let message = format!(
                    "effect `{}` has no parameter `{name}`: expected {}",
                    declared.id,
                    form.join(", ")
                );
                return Err(machine.error_at(declared.line, message));
            };
            let expected = match parameters[index].role {
                Role::Strength if *value < 0.0 => "0 or more",
                Role::Shape if *value <= 0.0 => "more than 0",
                Role::Strength
                    if parameters[index].dimension == Dimension::Time
                        && *value > LONGEST_DELAY_S =>
                {
                    "1 s at most"
                }
                _ => {
                    values[index] = *value as f32;
                    continue;
                }
            };
            let message = format!(
                "`{name}` of effect `{}` is {value:?}, expected {expected}",
                declared.id
            );
            return Err(machine.error_at(declared.line, message));
        }
        if let Some(missing) = form
            .iter()
            .find(|name| !declared.parameters.contains_key(**name))
        {
            let message = format!(
                "effect `{}` lacks its parameter `{missing}`; expected {}",
                declared.id,
                form.join(", ")
            );
            return Err(machine.error_at(declared.line, message));
        }
        if model.effects.push(Active { id, values }).is_err() {
            let message = "too many declared effects: at most 8";
            return Err(machine.error_at(declared.line, message));
        }
        // What an effect adds to the plant must leave it one; the period does not matter here.
        model.build(1.0).map_err(|error| {
            let message = format!("with effect `{}`, {error}", declared.id);
            machine.error_at(declared.line, message)
        })?;
    }
    Ok(model)
}

/// The base parameters that a machine file lets be fitted; its reader has checked their names.
pub fn base_parameters(machine: &Machine) -> Vec<Base> {
    Base::ALL
        .into_iter()
        .filter(|base| machine.fit.iter().any(|name| name == base.name()))
        .collect()
}
