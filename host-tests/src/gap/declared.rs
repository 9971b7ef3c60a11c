//! The core's model of what a machine file declares.

use std::f64::consts::TAU;

use model_core::effect::{Active, Id, MOST_PARAMETERS, Role};
use model_core::gap::model::{Base, Model};
use model_core::plant::Directional;
use model_core::plant::parameters::{Drive, Parameters};

use super::catalogue;
use crate::error::InputError;
use crate::log::Log;
use crate::machine::{Coordinate, Machine, PARAMETERS, Parameter, SensorSide};
use crate::quantity::decimal;

/// Resolution of the position sensor, rad or m: the machine file's, else the step that the positions of these logs are
/// made of; 0 where neither has one.
pub fn resolution<'l>(machine: &Machine, logs: impl IntoIterator<Item = &'l Log>) -> f32 {
    let seen = || {
        let steps = logs.into_iter().filter_map(Log::position_step);
        steps.min_by(f64::total_cmp)
    };
    machine.resolution.or_else(seen).unwrap_or(0.0) as f32
}

/// Way of the coordinate for a turn of the position sensor's disc, where the machine file says it: at the motor, behind a gear
/// whose ratio is known.
pub(super) fn encoder_turn(machine: &Machine) -> Option<f32> {
    let is_at_motor =
        machine.coordinate == Coordinate::Radian && machine.sensor_side == Some(SensorSide::Motor);
    let ratio = machine.gear_ratio.filter(|_| is_at_motor)?;
    Some((TAU / ratio) as f32)
}

/// The core's model of a machine file.
///
/// # Errors
/// A number beyond what the plant takes. A declared effect that the catalogue does not have, that
/// is there twice or has no meaning along a stroke; a parameter that it does not have, lacks, or has
/// out of its bounds.
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
        current_sensor: Default::default(),
        input_lead: 0.0,
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
        let rotary = machine.coordinate == Coordinate::Radian;
        let mut values = [0.0; MOST_PARAMETERS];
        for (name, value) in &declared.parameters {
            let Some(index) = parameters.iter().position(|known| known.name == name) else {
                let message = format!(
                    "effect `{}` has no parameter `{name}`: expected {}",
                    declared.id,
                    catalogue::parameters(id, rotary)
                );
                return Err(machine.error_at(declared.line, message));
            };
            values[index] = *value as f32;
            if !parameters[index].bounds.contains(values[index]) {
                let message = format!(
                    "`{name}` of effect `{}` is {value:?}, expected {}",
                    declared.id,
                    catalogue::values(&parameters[index], rotary)
                );
                return Err(machine.error_at(declared.line, message));
            }
        }
        if let Some(missing) = parameters.iter().find(|parameter| {
            let given = declared.parameters.contains_key(parameter.name);
            parameter.role != Role::Overtone && !given
        }) {
            let message = format!(
                "effect `{}` lacks its parameter `{}`; expected {}",
                declared.id,
                missing.name,
                catalogue::parameters(id, rotary)
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
        .filter(|base| machine.fits(base.name()))
        .collect()
}

/// By what factor a machine file says that its base parameters may be off.
pub(super) fn unsure(machine: &Machine) -> Vec<(Base, f32)> {
    let stated = |base: Base| Some((base, *machine.unsure.get(base.name())? as f32));
    Base::ALL.into_iter().filter_map(stated).collect()
}

/// These base parameters as a machine file holds them, SI: the inverse of [`model`] for a model that was
/// fitted from this machine. The breakaway level is among them where it has to rise with the Coulomb level,
/// below which the plant raises it by itself and the file's reader refuses it.
pub(super) fn numbers(machine: &Machine, fitted: &Model, base: &[Base]) -> Vec<(Parameter, f64)> {
    let named = |name: &str| PARAMETERS.into_iter().find(|known| known.name == name);
    let mut numbers: Vec<(Parameter, f64)> = base
        .iter()
        .filter_map(|&base| Some((named(base.name())?, held(fitted.get(base)))))
        .collect();
    let level = |base: Base| {
        let fitted = numbers.iter().find(|(known, _)| known.name == base.name());
        let declared = || machine.parameter(base.name()).unwrap_or_default();
        fitted.map_or_else(declared, |&(_, value)| value)
    };
    let coulomb = level(Base::Coulomb);
    if level(Base::Static) < coulomb {
        let name = Base::Static.name();
        numbers.retain(|(known, _)| known.name != name);
        numbers.extend(named(name).map(|known| (known, coulomb)));
    }
    numbers
}

/// A number that a machine file may hold: none so small that single precision does not hold it in full.
fn held(value: f32) -> f64 {
    if value.abs() < f32::MIN_POSITIVE {
        0.0
    } else {
        decimal(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::DeclaredEffect;
    use crate::workspace;

    /// Every parameter of the catalogue with a sound value, and the values next to it that physics does
    /// not let be, with the words that say what it does.
    const PARAMETERS: [(&str, &str, f64, &[f64], &str); 44] = [
        ("offset_torque", "torque", 0.01, &[], ""),
        ("asymmetric_coulomb", "difference", 0.01, &[], ""),
        ("asymmetric_viscous", "difference", 1e-4, &[], ""),
        (
            "quadratic_drag",
            "coefficient",
            1e-6,
            &[-1e-9],
            "0 or more, in N·m·s²/rad²",
        ),
        ("stribeck", "drop", 0.01, &[-1e-9], "0 or more, in N·m"),
        (
            "stribeck",
            "velocity",
            1.0,
            &[0.0, -1.0],
            "more than 0, in rad/s",
        ),
        (
            "load_dependent_friction",
            "share",
            0.2,
            &[-0.01, 0.96, 1.5],
            "0 to 0.95",
        ),
        (
            "spring",
            "stiffness",
            0.01,
            &[-1e-9],
            "0 or more, in N·m/rad",
        ),
        ("spring", "torque", 0.01, &[], ""),
        ("gravity", "sine", 0.01, &[], ""),
        ("gravity", "cosine", 0.01, &[], ""),
        ("cogging", "sine", 0.01, &[], ""),
        ("cogging", "cosine", 0.01, &[], ""),
        (
            "cogging",
            "period",
            0.5,
            &[0.0, -0.5],
            "more than 0, in rad",
        ),
        ("cogging", "sine_2", 0.01, &[], ""),
        ("cogging", "cosine_2", 0.01, &[], ""),
        ("cogging", "sine_3", 0.01, &[], ""),
        ("cogging", "cosine_3", 0.01, &[], ""),
        (
            "input_delay",
            "delay",
            0.01,
            &[-1e-3, 0.26],
            "0 to 0.25, in s",
        ),
        (
            "sensor_delay",
            "delay",
            0.01,
            &[-1e-3, 0.26],
            "0 to 0.25, in s",
        ),
        ("backlash", "width", 0.01, &[-1e-9], "0 or more, in rad"),
        (
            "torque_saturation",
            "fall",
            0.1,
            &[-1e-9],
            "0 or more, in 1/(N·m)",
        ),
        ("friction_drift", "rate", 0.01, &[], ""),
        ("position_dependent_friction", "sine", 0.01, &[], ""),
        ("position_dependent_friction", "cosine", 0.01, &[], ""),
        (
            "position_dependent_friction",
            "period",
            0.5,
            &[0.0, -0.5],
            "more than 0, in rad",
        ),
        ("external_load", "torque", 0.01, &[], ""),
        (
            "external_load",
            "end",
            2.0,
            &[0.0, -1.0],
            "more than 0, in s",
        ),
        (
            "external_load",
            "duration",
            1.0,
            &[0.0, -1.0],
            "more than 0, in s",
        ),
        (
            "presliding",
            "compliance",
            0.01,
            &[-1e-9],
            "0 or more, in rad/(N·m)",
        ),
        (
            "presliding",
            "velocity",
            0.5,
            &[0.0, -0.5],
            "more than 0, in rad/s",
        ),
        ("supply_sag", "share", 1e-3, &[-1e-9], "0 or more, in 1/W"),
        ("brush_drop", "drop", 0.5, &[-1e-9], "0 or more, in V"),
        ("dead_time", "loss", 0.5, &[-1e-9], "0 or more, in V"),
        ("encoder_eccentricity", "sine", 0.01, &[], ""),
        ("encoder_eccentricity", "cosine", 0.01, &[], ""),
        (
            "encoder_eccentricity",
            "period",
            0.5,
            &[0.0, -0.5],
            "more than 0, in rad",
        ),
        (
            "thermal_drift",
            "rate",
            1e-3,
            &[-1e-9],
            "0 or more, in 1/(A²·s)",
        ),
        (
            "thermal_drift",
            "time_constant",
            5.0,
            &[0.0, -5.0],
            "more than 0, in s",
        ),
        (
            "compliance",
            "trailing",
            1e-4,
            &[-1e-9, 2e6],
            "0 to 1000000, in s²",
        ),
        (
            "compliance",
            "share",
            0.3,
            &[-0.1, 1.0],
            "0 or more and below 1",
        ),
        ("compliance", "damping", 0.1, &[-0.1], "0 or more"),
        ("hysteresis", "torque", 0.01, &[-1e-9], "0 or more, in N·m"),
        (
            "hysteresis",
            "reach",
            0.1,
            &[0.0, -0.1],
            "more than 0, in rad",
        ),
    ];

    /// The model of a machine whose file declares one effect with these values, on its line 3.
    fn declaring(
        id: &str,
        values: impl Iterator<Item = (&'static str, f64)>,
    ) -> Result<Model, String> {
        let file = workspace::root().join("host-tests/machines/ema-24v.toml");
        let mut machine = Machine::read(&file).unwrap();
        machine.declared_effects = vec![DeclaredEffect {
            id: id.to_owned(),
            parameters: values
                .map(|(name, value)| (name.to_owned(), value))
                .collect(),
            line: 3,
        }];
        model(&machine).map_err(|error| error.to_string())
    }

    #[test]
    fn what_a_parameter_may_not_be_is_refused_with_what_it_may_be() {
        for (id, name, sound, beyond, expected) in PARAMETERS {
            let own = PARAMETERS.iter().filter(|entry| entry.0 == id);
            let with = |value| {
                let values = own.clone().map(|entry| (entry.1, entry.2));
                declaring(
                    id,
                    values.map(|(own, sound)| (own, if own == name { value } else { sound })),
                )
            };
            assert!(with(sound).is_ok(), "{id} {name}");
            // What is not bounded has a direction.
            assert_eq!(with(-sound).is_ok(), beyond.is_empty(), "{id} {name}");
            for &value in beyond {
                let error = with(value).unwrap_err();
                let words = format!(
                    "ema-24v.toml:3: `{name}` of effect `{id}` is {value:?}, expected {expected}"
                );
                assert!(error.ends_with(&words), "{error}");
            }
        }
    }

    #[test]
    fn overtones_may_be_left_out_and_nothing_else() {
        let cogging = [("sine", 0.01), ("cosine", 0.02), ("period", 0.5)];
        let model = declaring("cogging", cogging.into_iter()).unwrap();
        assert_eq!(
            model.effects[0],
            Active::new(Id::Cogging, [0.01, 0.02, 0.5])
        );
        let third = cogging.into_iter().chain([("cosine_3", 0.001)]);
        let model = declaring("cogging", third).unwrap();
        assert_eq!(model.effects[0].values[6], 0.001);
        let error = declaring("cogging", cogging.into_iter().take(2)).unwrap_err();
        assert!(error.contains("lacks its parameter `period`"), "{error}");
    }

    #[test]
    fn fitted_numbers_are_those_of_the_model_that_the_file_gives() {
        let file = workspace::root().join("host-tests/machines/ema-24v.toml");
        let machine = Machine::read(&file).unwrap();
        let declared = model(&machine).unwrap();
        // The lead of the log's input is no number of the machine.
        for base in Base::ALL
            .into_iter()
            .filter(|&base| base != Base::InputLead)
        {
            let mut fitted = declared.clone();
            let value = 0.9 * declared.get(base) + 1e-6;
            fitted.set(base, value);
            let numbers = numbers(&machine, &fitted, &[base]);
            let [(parameter, number)] = numbers[..] else {
                panic!("{base:?}: {numbers:?}");
            };
            assert_eq!(parameter.name, base.name());
            assert_eq!(number as f32, value, "{base:?}");
        }
    }

    /// The file's reader refuses a breakaway level below the Coulomb level.
    #[test]
    fn the_breakaway_level_rises_with_the_coulomb_level() {
        let file = workspace::root().join("host-tests/machines/ema-24v.toml");
        let machine = Machine::read(&file).unwrap();
        let mut fitted = model(&machine).unwrap();
        fitted.set(Base::Coulomb, 0.2);
        let names = |base: &[Base]| {
            let numbers = numbers(&machine, &fitted, base);
            let named = numbers.iter().map(|(known, value)| (known.name, *value));
            named.collect::<Vec<_>>()
        };
        let both = [("coulomb", 0.2), ("static", 0.2)];
        assert_eq!(names(&[Base::Coulomb]), both);
        assert_eq!(names(&[Base::Coulomb, Base::Static]), both);
    }

    #[test]
    fn a_number_too_small_for_a_file_is_none() {
        assert_eq!(held(1e-40), 0.0);
        assert!(held(-0.0).is_sign_positive());
        assert_eq!(held(0.1), 0.1);
    }

    #[test]
    fn every_parameter_of_the_catalogue_is_tested_above() {
        let catalogue = Id::ALL.iter().flat_map(|id| {
            let description = id.description();
            description
                .parameters
                .iter()
                .map(|own| (description.id, own.name))
        });
        let tested = PARAMETERS.iter().map(|entry| (entry.0, entry.1));
        assert!(catalogue.eq(tested));
    }
}
