//! The model as one file of C99 that needs `math.h` alone.

use std::fmt::Write as _;

use model_core::effect::encoder_eccentricity::EncoderEccentricity;
use model_core::effect::{Active, Effect, Id, MOST_PARAMETERS};
use model_core::plant::parameters::{Drive, Parameters};

use super::{Missing, Source, number};
use crate::machine::Coordinate;
use crate::outputs::MARK;

/// The equations and their integration, with places for what a machine file says.
const TEMPLATE: &str = include_str!("model.c");

/// Longest integration step, s.
const LONGEST_STEP: f64 = 1e-4;

/// Shortest one: what is faster is not worth its time.
const SHORTEST_STEP: f64 = 1e-7;

/// Steps in the shortest time constant of the linear model: a step of the method of order 4 is then off by (1/10)⁵/120.
const STEPS_A_TIME_CONSTANT: f64 = 10.0;

/// What stands in the catalogue and is not in the C text.
fn why_not(id: Id) -> Option<&'static str> {
    match id {
        Id::InputDelay => Some("feed the input so much later"),
        Id::SensorDelay => Some("read the position so much later"),
        Id::Presliding => Some("friction is rigid here"),
        Id::Hysteresis => Some("nothing remembers where the motion turned here"),
        Id::Compliance => {
            Some("the shaft is rigid here, with all of the inertia on the drive's side")
        }
        _ => None,
    }
}

/// The text, and what is not in it.
pub(super) fn text(source: &Source) -> (String, Vec<Missing>) {
    let missing = missing(source);
    let rotary = source.machine.coordinate == Coordinate::Radian;
    let plant = source.model.bound_plant();
    let step = number(longest_step(&plant) as f32);
    let mut text = header(source, &missing);
    let body = TEMPLATE
        .replace("@CONSTANTS@\n", &constants(source, &plant, &step))
        .replace("@LAWS@", &laws(source))
        .replace("@READING@", &reading(source))
        .replace("@MOST_STEP@", &step)
        .replace("@POSITION@", source.machine.coordinate.unit())
        .replace("@LOAD@", if rotary { "N m" } else { "N" })
        .replace("@INPUT@", input_unit(source));
    text += &body;
    (text, missing)
}

/// What one unit of the input is.
fn input_unit(source: &Source) -> &'static str {
    match source.machine.motor {
        Some(_) => "volts, divided by GAIN",
        None => "torque or force, divided by GAIN",
    }
}

fn missing(source: &Source) -> Vec<Missing> {
    let effects = source.model.effects.iter();
    let mut missing: Vec<Missing> = effects
        .filter_map(|effect| Some(source.effect_missing(effect.id, why_not(effect.id)?)))
        .collect();
    if source.machine.resolution.is_some() {
        missing.push(Missing {
            line: None,
            what:
                "the sensor's `resolution` is not expressed: the reported position is not rounded"
                    .into(),
        });
    }
    missing
}

fn header(source: &Source, missing: &[Missing]) -> String {
    let mut text = format!("/* {MARK} export: {}\n", source.name());
    text += " *\n * actuator_start, then actuator_step for each stretch of held input. SI units.\n";
    text += " * Double precision; the machine's numbers are those of the model core, in single precision.\n *\n";
    let effects: Vec<&str> = source
        .model
        .effects
        .iter()
        .filter(|effect| why_not(effect.id).is_none())
        .map(|effect| effect.id.description().id)
        .collect();
    let listed = if effects.is_empty() {
        "none".to_owned()
    } else {
        effects.join(", ")
    };
    let _ = writeln!(text, " * Effects: {listed}");
    for missing in missing {
        let _ = writeln!(text, " * NOT EXPRESSED: {}", missing.what);
    }
    text + " */\n"
}

/// Integration step that follows the linear model.
fn longest_step(plant: &Parameters) -> f64 {
    let inertia = f64::from(plant.inertia);
    let viscous = f64::from(plant.viscous.forward.max(plant.viscous.backward));
    let (braking, electric) = match plant.drive {
        Drive::Voltage {
            resistance,
            inductance,
            torque_constant,
        } => {
            let electric = f64::from(inductance / resistance);
            let braking = f64::from(torque_constant * torque_constant / resistance);
            (
                braking,
                if electric > 0.0 {
                    electric
                } else {
                    f64::INFINITY
                },
            )
        }
        Drive::Torque => (0.0, f64::INFINITY),
    };
    let mechanic = inertia / (viscous + braking);
    let swing = (inertia / f64::from(plant.spring)).sqrt();
    let shortest = mechanic.min(electric).min(swing);
    (shortest / STEPS_A_TIME_CONSTANT).clamp(SHORTEST_STEP, LONGEST_STEP)
}

/// A constant of the text: its name, its value, what it is.
type Constant = (&'static str, String, &'static str);

fn constants(source: &Source, plant: &Parameters, step: &str) -> String {
    let has_winding = matches!(plant.drive, Drive::Voltage { .. });
    let has_inductance =
        matches!(plant.drive, Drive::Voltage { inductance, .. } if inductance > 0.0);
    let drops = [Id::BrushDrop, Id::DeadTime].map(|id| values(source, id)[0]);
    let holds = has_inductance && drops.iter().any(|drop| *drop > 0.0);
    let mut text = format!(
        "enum {{ HAS_WINDING = {}, HOLDS_CURRENT = {} }};\n",
        u8::from(has_winding),
        u8::from(holds)
    );
    let mut constants = of_plant(plant);
    constants.extend(of_effects(source));
    constants.push(("MOST_STEP", step.to_owned(), "longest integration step, s"));
    for (name, value, comment) in constants {
        let _ = writeln!(
            text,
            "static const double {name} = {value}; /* {comment} */"
        );
    }
    text
}

/// A number that may be beyond all others.
fn end(value: f32) -> String {
    match value {
        f32::INFINITY => "INFINITY".to_owned(),
        f32::NEG_INFINITY => "-INFINITY".to_owned(),
        value => number(value),
    }
}

fn constant(name: &'static str, value: f32, comment: &'static str) -> Constant {
    (name, end(value), comment)
}

/// What the machine file and its affine effects make of the plant.
fn of_plant(plant: &Parameters) -> Vec<Constant> {
    let [resistance, inductance, torque_constant] = match plant.drive {
        Drive::Voltage {
            resistance,
            inductance,
            torque_constant,
        } => [resistance, inductance, torque_constant],
        Drive::Torque => [1.0, 0.0, 0.0],
    };
    let (viscous, coulomb) = (plant.viscous, plant.coulomb);
    // The core raises the breakaway level to the Coulomb level.
    let forward = plant.breakaway.forward.max(coulomb.forward);
    let backward = plant.breakaway.backward.max(coulomb.backward);
    vec![
        constant(
            "GAIN",
            plant.gain,
            "volts, torque or force for one unit of input",
        ),
        constant("RESISTANCE", resistance, "ohms"),
        constant("INDUCTANCE", inductance, "H"),
        constant(
            "TORQUE_CONSTANT",
            torque_constant,
            "torque or force for one ampere, and back-EMF",
        ),
        constant("INERTIA", plant.inertia, "kg m2, or kg"),
        constant(
            "VISCOUS_FORWARD",
            viscous.forward,
            "torque or force for one unit of velocity",
        ),
        constant(
            "VISCOUS_BACKWARD",
            viscous.backward,
            "the same the other way",
        ),
        constant("COULOMB_FORWARD", coulomb.forward, "N m, or N"),
        constant("COULOMB_BACKWARD", coulomb.backward, "N m, or N"),
        constant("BREAKAWAY_FORWARD", forward, "static friction"),
        constant("BREAKAWAY_BACKWARD", backward, "static friction"),
        constant("OFFSET", plant.offset, "constant torque or force"),
        constant("SPRING", plant.spring, "stiffness"),
        constant("SPRING_REST", plant.spring_rest, "where it rests"),
        constant(
            "SPRING_PRELOAD",
            plant.spring_preload,
            "on either side of its rest",
        ),
        constant("LOWER_STOP", plant.lower_stop, "inelastic"),
        constant("UPPER_STOP", plant.upper_stop, "inelastic"),
    ]
}

/// The values of an effect, 0 without the effect.
fn values(source: &Source, id: Id) -> [f32; MOST_PARAMETERS] {
    let effect = source.model.effects.iter().find(|effect| effect.id == id);
    effect.map_or([0.0; MOST_PARAMETERS], |effect| effect.values)
}

/// What effects make of the winding, its supply, time and the sensor.
fn of_effects(source: &Source) -> Vec<Constant> {
    let first = |id| values(source, id)[0];
    let [rate, time_constant, ..] = values(source, Id::ThermalDrift);
    let cooling = if time_constant > 0.0 {
        1.0 / time_constant
    } else {
        0.0
    };
    let [_, load_end, duration, ..] = values(source, Id::ExternalLoad);
    vec![
        constant(
            "SATURATION",
            first(Id::TorqueSaturation),
            "fall of the torque constant, 1 over a torque",
        ),
        constant(
            "SUPPLY_SAG",
            first(Id::SupplySag),
            "share of the voltage for each watt",
        ),
        constant("BRUSH_DROP", first(Id::BrushDrop), "V"),
        constant("DEAD_TIME", first(Id::DeadTime), "V"),
        constant("HEATING", rate, "rise of the resistance, 1/(A2 s)"),
        constant("COOLING", cooling, "1/s"),
        constant("LOAD_BEGIN", load_end - duration, "of an external load, s"),
        constant("LOAD_END", load_end, "s"),
        constant("PLAY", first(Id::Backlash), "full width before the sensor"),
    ]
}

/// The laws that act on torque and friction, in their order in the model.
fn laws(source: &Source) -> String {
    let model = &source.model;
    let mut text = String::new();
    if model.gravity_torque != 0.0 {
        let _ = writeln!(
            text,
            "    /* gravity of [mechanics] */\n    load.torque -= {} * sin(x - {});",
            number(model.gravity_torque),
            number(model.gravity_rest)
        );
    }
    for effect in &model.effects {
        if let Some(law) = law(effect) {
            let _ = writeln!(text, "    /* {} */\n{law}", effect.id.description().id);
        }
    }
    text
}

/// The statements of an effect; `None` where it is no law of torque or friction.
fn law(effect: &Active) -> Option<String> {
    let [a, b, c, ..] = effect.values.map(number);
    let harmonic = || {
        let wave = |order: &str, sine: f32, cosine: f32| {
            let phase = format!("{order}6.283185307179586 * x / {c}");
            format!(
                "{} * sin({phase}) + {} * cos({phase})",
                number(sine),
                number(cosine)
            )
        };
        let first = wave("", effect.values[0], effect.values[1]);
        let overtones = effect.overtones().chunks_exact(2).zip(["2.0 * ", "3.0 * "]);
        overtones
            .filter(|(pair, _)| pair.iter().any(|&value| value != 0.0))
            .fold(first, |sum, (pair, order)| {
                format!("{sum}\n        + {}", wave(order, pair[0], pair[1]))
            })
    };
    let on_both = |value: &str| {
        format!(
            "    {{\n        const double extra = {value};\n        load.coulomb += extra;\n        load.breakaway += extra;\n    }}"
        )
    };
    Some(match effect.id {
        Id::Stribeck => format!("    load.coulomb += {a} * exp(-fabs(v) / {b});"),
        Id::QuadraticDrag => format!("    load.torque -= {a} * v * fabs(v);"),
        Id::Gravity => format!("    load.torque -= {a} * sin(x) + {b} * cos(x);"),
        Id::Cogging => format!("    load.torque += {};", harmonic()),
        Id::LoadDependentFriction => on_both(&format!("{a} * fabs(motor)")),
        Id::PositionDependentFriction => {
            let floor = "    load.coulomb = load.coulomb > 0.0 ? load.coulomb : 0.0;\n    load.breakaway = load.breakaway > 0.0 ? load.breakaway : 0.0;";
            format!("{}\n{floor}", on_both(&harmonic()))
        }
        Id::FrictionDrift => format!(
            "    {{\n        const double factor = within(1.0 + {a} * t, 0.0, 1e3);\n        load.coulomb *= factor;\n        load.breakaway *= factor;\n    }}"
        ),
        Id::ExternalLoad => {
            format!("    load.torque += begun >= LOAD_BEGIN && begun < LOAD_END ? {a} : 0.0;")
        }
        _ => return None,
    })
}

/// What is added to the reported position.
fn reading(source: &Source) -> String {
    let effects = source.model.effects.iter();
    let mut text = String::new();
    for effect in effects.filter(|effect| effect.id == Id::EncoderEccentricity) {
        // The core flattens a reading that would turn back: its amplitudes are asked for where they stand alone.
        let (own, period) = (EncoderEccentricity::new(effect.values), effect.values[2]);
        let (sine, cosine) = (own.error(0.25 * period), own.error(0.0));
        let _ = writeln!(
            text,
            "    s->reported += {} * sin(6.283185307179586 * s->far / {period}) + {} * cos(6.283185307179586 * s->far / {period});",
            number(sine),
            number(cosine),
            period = number(period)
        );
    }
    text
}
