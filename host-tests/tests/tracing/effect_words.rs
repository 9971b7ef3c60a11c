//! Promise: every effect of the catalogue has a sentence of its own that somebody understands who stands beside
//! the machine, with its size in the units of a workshop.
//!
//! The sizes are worked out here from the laws of `model-core/src/effect`; the calculation stands beside each.

use std::f64::consts::TAU;

use host_tests::gap::demand::Demand;
use host_tests::gap::effect_words::{Workshop, declared_by, sentence};
use host_tests::gap::outcome::{Estimate, FoundEffect, NeglectedInductance};
use model_core::effect::{Active, Id, Role};
use model_core::plant::parameters::Parameters;

/// An effect with these reported values, each with its standard deviation.
fn effect(id: &str, values: &[(&str, f64, f64)]) -> FoundEffect {
    let estimate = |&(name, value, std): &(&str, f64, f64)| Estimate {
        name: name.into(),
        value,
        std,
        unit: String::new(),
    };
    FoundEffect {
        id: id.into(),
        parameters: values.iter().map(estimate).collect(),
        declare: String::new(),
        score: 0.5,
        identifiability: 0.5,
        p_value: 1e-6,
        law: None,
        equivalent: vec![],
        neglected_inductance: None,
        presumes: vec![],
    }
}

/// A place that has no interval beside it has no digits that its deviation takes away.
#[test]
fn a_place_has_the_digits_that_are_known() {
    let hangs = |rest: f64, std: f64| {
        let rest = rest.to_radians();
        rotary(
            "gravity",
            &[("torque", 0.5, 0.01), ("rest", rest, std.to_radians())],
        )
    };
    for (rest, std, said) in [
        (0.001_88, 0.4, "hangs at 0.0°"),
        (-0.001_88, 0.4, "hangs at 0.0°"),
        (17.234, 0.4, "hangs at 17.2°"),
        (17.234, 3.0, "hangs at 17°"),
        (17.234, 20.0, "hangs at 20°"),
        (17.234, 0.001, "hangs at 17.2°"),
        (0.001_88, 1e-6, "hangs at 0.00188°"),
    ] {
        let sentence = hangs(rest, std);
        assert!(sentence.contains(said), "{rest} ± {std}: {sentence}");
    }
}

/// Logs of up to 12 V, 6 N·m, 2 A rms and 10 rad/s, 8 s long, of a machine with 0.12 N·m of friction.
const DEMAND: Demand = Demand {
    voltage: 12.0,
    is_of_supply: false,
    torque: 6.0,
    current_rms: 2.0,
    speed: 10.0,
    friction: 0.12,
    duration_s: 8.0,
};

fn rotary(id: &str, values: &[(&str, f64, f64)]) -> String {
    let workshop = Workshop {
        demand: &DEMAND,
        rotary: true,
        load_unit: "N·m",
    };
    sentence(&effect(id, values), &workshop)
}

/// The same of a slide whose logs have up to 0.1 m/s, with 20 N of friction.
fn linear(id: &str, values: &[(&str, f64, f64)]) -> String {
    let demand = Demand {
        speed: 0.1,
        friction: 20.0,
        ..DEMAND
    };
    let workshop = Workshop {
        demand: &demand,
        rotary: false,
        load_unit: "N",
    };
    sentence(&effect(id, values), &workshop)
}

/// The sentence has all of these.
#[track_caller]
fn says(sentence: &str, parts: &[&str]) {
    for part in parts {
        assert!(sentence.contains(part), "no {part:?} in {sentence:?}");
    }
}

#[test]
fn torques_are_said_with_their_direction() {
    // 30 mN·m; 1.96 · 1 mN·m either way.
    let pushed = rotary("offset_torque", &[("torque", -0.03, 0.001)]);
    says(
        &pushed,
        &[
            "30.0 mN·m (95 %: 28.0 to 32.0)",
            "torque",
            "towards smaller positions",
        ],
    );
    let pushed = linear("offset_torque", &[("torque", 3.0, 0.05)]);
    says(
        &pushed,
        &[
            "3.00 N (95 %: 2.90 to 3.10)",
            "force",
            "towards larger positions",
        ],
    );
    // The ends of an interval are told apart.
    says(
        &linear("offset_torque", &[("torque", 300.0, 0.1)]),
        &["300 N (95 %: 299.8 to 300.2)"],
    );
    // Until 2 s + 3 s.
    let values = [
        ("torque", 0.3, 0.01),
        ("begin", 2.0, 0.1),
        ("duration", 3.0, 0.1),
    ];
    says(
        &rotary("external_load", &values),
        &[
            "From 2.00 s to 5.00 s",
            "towards larger positions",
            "300 mN·m (95 %: 280 to 320)",
        ],
    );
    let values = [("torque", 0.5, 0.01), ("rest", 0.3, 0.01)];
    // 0.3 · 180/π.
    says(
        &rotary("gravity", &values),
        &["500 mN·m (95 %: 480 to 520)", "hangs at 17.2°"],
    );
    // 0.5 · π/180 N·m for a degree, and 0.25 · 180/π.
    let values = [("stiffness", 0.5, 0.0), ("rest", 0.25, 0.01)];
    says(
        &rotary("spring", &values),
        &["towards 14.3°", "8.73 mN·m", "each degree"],
    );
    // 2000 N/m are 2 N for a millimetre.
    let values = [("stiffness", 2000.0, 10.0), ("rest", 0.05, 0.0)];
    says(
        &linear("spring", &values),
        &["towards 50.0 mm", "2.00 N", "each millimetre"],
    );
    // A period of an eighth of a turn.
    let values = [
        ("amplitude", 0.02, 0.001),
        ("phase", 0.0, 0.1),
        ("period", TAU / 8.0, 0.001),
    ];
    says(
        &rotary("cogging", &values),
        &["20.0 mN·m (95 %: 18.0 to 22.0)", "8.00 cycles a turn"],
    );
    let values = [
        ("amplitude", 40.0, 1.0),
        ("phase", 0.0, 0.1),
        ("period", 0.012, 0.001),
    ];
    says(&linear("cogging", &values), &["40.0 N", "every 12.0 mm"]);
    let overtones = [("second_harmonic", 12.0, 0.1), ("third_harmonic", 3.0, 0.1)];
    let values: Vec<_> = values.into_iter().chain(overtones).collect();
    says(
        &linear("cogging", &values),
        &["12.0 N at twice", "3.00 N at three times that"],
    );
}

#[test]
fn a_hysteresis_is_said_with_its_torque_and_its_way() {
    // 0.1 · 180/π.
    let values = [("torque", 0.05, 0.001), ("reach", 0.1, 0.01)];
    says(
        &rotary("hysteresis", &values),
        &["50.0 mN·m (95 %: 48.0 to 52.0)", "5.73°"],
    );
}

#[test]
fn frictions_are_said_at_what_the_logs_have() {
    // 50 mN·m apart, and 1.96 · (1 + 1) mN·m at worst.
    let values = [("forward", 0.15, 0.001), ("backward", 0.10, 0.001)];
    says(
        &rotary("asymmetric_coulomb", &values),
        &[
            "150 mN·m forward",
            "100 mN·m backward",
            "50.0 mN·m (95 %: 46.1 to 53.9) more forward",
        ],
    );
    // At 0.1 m/s: 15.7 and 23.6 N, 7.9 N apart, and 0.1 · 1.96 · (1 + 1) N at worst.
    let values = [("forward", 157.0, 1.0), ("backward", 236.0, 1.0)];
    says(
        &linear("asymmetric_viscous", &values),
        &[
            "at 100 mm/s",
            "15.7 N forward",
            "23.6 N backward",
            "7.90 N (95 %: 7.51 to 8.29) more backward",
        ],
    );
    // 4e-4 · 10² N·m at 10 · 60/2π rpm.
    let values = [("coefficient", 4e-4, 1e-5)];
    says(
        &rotary("quadratic_drag", &values),
        &["40.0 mN·m (95 %: 38.0 to 42.0)", "at 95.5 rpm"],
    );
    // 2 · 60/2π rpm, at which 1/e is left.
    let values = [("drop", 0.04, 0.001), ("velocity", 2.0, 0.1)];
    says(
        &rotary("stribeck", &values),
        &["40.0 mN·m", "63 % of that is gone at 19.1 rpm"],
    );
    let values = [("share", 0.25, 0.01)];
    says(
        &rotary("load_dependent_friction", &values),
        &["25.0 % (95 %: 23.0 to 27.0) of the motor's torque"],
    );
    // A sine is largest at a quarter of its period of 2 rad: 0.5 rad.
    let values = [
        ("amplitude", 0.02, 0.001),
        ("phase", 0.0, 0.1),
        ("period", 2.0, 0.01),
    ];
    says(
        &rotary("position_dependent_friction", &values),
        &["20.0 mN·m", "tightest at 29°", "period of 115°"],
    );
    // A cosine, whose phase as a sine is a quarter of a turn, at its beginning.
    let values = [
        ("amplitude", 4.0, 0.1),
        ("phase", TAU / 4.0, 0.1),
        ("period", 0.2, 0.001),
    ];
    says(
        &linear("position_dependent_friction", &values),
        &["4.00 N", "tightest at 0 mm", "period of 200 mm"],
    );
    // 5 % a second for 8 s; 25 % a second leave nothing of it.
    says(
        &rotary("friction_drift", &[("rate", 0.05, 0.001)]),
        &["grows by 40.0 %", "8.00 s"],
    );
    says(
        &rotary("friction_drift", &[("rate", -0.25, 0.001)]),
        &["falls by 100 %"],
    );
    says(
        &rotary("friction_drift", &[("rate", -0.05, 0.0)]),
        &["falls by 40.0 %"],
    );
    // 0.01 rad/(N·m) under 0.12 N·m: 1.2 mrad; 1e-6 m/N under 20 N: 20 µm.
    let values = [("compliance", 0.01, 0.001), ("velocity", 0.1, 0.1)];
    says(
        &rotary("presliding", &values),
        &["0.0688°", "under 120 mN·m"],
    );
    let values = [("compliance", 1e-6, 1e-7), ("velocity", 0.1, 0.1)];
    says(
        &linear("presliding", &values),
        &["0.0200 mm", "under 20.0 N"],
    );
}

#[test]
fn what_motor_and_drive_lose_is_said_in_volts_ohms_and_percent() {
    // 12 V behind 0.3 Ω: R/U² of the voltage for each watt.
    let share = 0.3 / 144.0;
    says(
        &rotary("supply_sag", &[("share", share, 0.01 * share)]),
        &[
            "asked for 12.0 V, the most in the logs, it gives 0.300 V (95 %: 0.294 to 0.306) less for each ampere",
            "as with 0.300 Ω in series; a supply of U volts has (U/12.0)² times that.",
        ],
    );
    // Where the input is a share of the supply's voltage, that is known.
    let of_supply = Workshop {
        demand: &Demand {
            is_of_supply: true,
            ..DEMAND
        },
        rotary: true,
        load_unit: "N·m",
    };
    says(
        &sentence(
            &effect("supply_sag", &[("share", share, 0.01 * share)]),
            &of_supply,
        ),
        &["as one of 12.0 V with 0.300 Ω (95 %: 0.294 to 0.306) in series."],
    );
    // k(i) = k / (1 + c T): of 6 N·m, 6 / (1 + 3) are left.
    says(
        &rotary("torque_saturation", &[("fall", 0.5, 0.01)]),
        &["6.00 N·m", "75.0 %"],
    );
    says(
        &rotary("brush_drop", &[("drop", 1.5, 0.05)]),
        &["1.50 V (95 %: 1.40 to 1.60)"],
    );
    says(
        &rotary("dead_time", &[("loss", 0.48, 0.01)]),
        &["0.480 V (95 %: 0.460 to 0.500)"],
    );
    // 1 % a second under 1 A is four times that under 2 A; 0.39 % a kelvin.
    let values = [("rate", 0.01, 0.0005), ("time_constant", 5.0, 1.0)];
    says(
        &rotary("thermal_drift", &values),
        &[
            "at 2.00 A",
            "4.00 % (95 %: 3.61 to 4.39) a second",
            "10.3 K",
            "5.00 s",
        ],
    );
}

#[test]
fn delays_are_said_in_ms_and_play_in_degrees_or_mm() {
    says(
        &rotary("input_delay", &[("delay", 0.002, 1e-4)]),
        &["2.00 ms (95 %: 1.80 to 2.20)"],
    );
    says(
        &rotary("sensor_delay", &[("delay", 5.04e-4, 0.0)]),
        &["0.504 ms"],
    );
    // 0.05 · 180/π, and 1.96 · 0.001 · 180/π either way.
    says(
        &rotary("backlash", &[("width", 0.05, 0.001)]),
        &["2.86° (95 %: 2.75 to 2.98) of play"],
    );
    says(
        &linear("backlash", &[("width", 3e-4, 1e-5)]),
        &["0.300 mm (95 %: 0.280 to 0.320) of play"],
    );
    // 1/(2π √s).
    let trailing = 1.0 / (TAU * 10.0).powi(2);
    let values = [
        ("trailing", trailing, 0.0),
        ("share", 0.2, 0.01),
        ("damping", 0.1, 0.1),
    ];
    says(
        &rotary("compliance", &values),
        &["10.0 Hz", "20.0 % of the inertia"],
    );
    // 0.02 · 180/π, of a whole turn.
    let values = [
        ("amplitude", 0.02, 0.001),
        ("phase", 0.0, 0.1),
        ("period", TAU, 0.01),
    ];
    says(
        &rotary("encoder_eccentricity", &values),
        &["1.15°", "1.00 times a turn"],
    );
    let values = [
        ("amplitude", 2e-5, 1e-6),
        ("phase", 0.0, 0.1),
        ("period", 0.005, 0.001),
    ];
    says(
        &linear("encoder_eccentricity", &values),
        &["0.0200 mm", "every 5.00 mm"],
    );
}

#[test]
fn a_size_that_the_logs_do_not_determine_is_said_to_be_that() {
    let unknown = rotary("backlash", &[("width", 0.05, f64::NAN)]);
    says(&unknown, &["2.86° (the logs do not determine how much)"]);
    // An interval beyond zero has no frequency at its end.
    let values = [
        ("trailing", 2.5e-4, 2e-4),
        ("share", 0.2, 0.01),
        ("damping", 0.1, 0.1),
    ];
    says(
        &rotary("compliance", &values),
        &["10.1 Hz (the logs do not determine how much)"],
    );
}

/// With logs that say nothing of their sizes, each sentence still has the effect's own.
#[test]
fn every_effect_has_a_sentence_of_its_own_at_any_demand() {
    for demand in [&DEMAND, &Demand::default()] {
        let mut beginnings = Vec::new();
        for id in Id::ALL {
            let description = id.description();
            let values = description.reported.iter();
            let values: Vec<_> = values.map(|(name, _)| (*name, 0.5, 0.01)).collect();
            let workshop = Workshop {
                demand,
                rotary: true,
                load_unit: "N·m",
            };
            let said = sentence(&effect(description.id, &values), &workshop);
            assert!(
                said.ends_with('.') && said.starts_with(char::is_uppercase),
                "{said}"
            );
            assert!(
                said.contains("(95 %: ") || said.contains("half of it"),
                "{said}"
            );
            assert!(
                !said.contains("diverged") && !said.contains("NaN"),
                "{said}"
            );
            assert!(
                said.chars().count() < 230,
                "{}: {said}",
                said.chars().count()
            );
            beginnings.push(said[..18].to_owned());
        }
        let count = beginnings.len();
        beginnings.sort();
        beginnings.dedup();
        assert_eq!(beginnings.len(), count, "{beginnings:?}");
    }
}

/// 1.2 ms behind 1 Ω is 1.2 mH.
#[test]
fn a_delay_may_be_the_inductance_that_the_machine_file_neglects() {
    for id in ["input_delay", "sensor_delay"] {
        let delay = FoundEffect {
            neglected_inductance: Some(NeglectedInductance {
                inductance: 1.2e-3,
                resistance: 1.0,
            }),
            ..effect(id, &[("delay", 1.2e-3, 1e-5)])
        };
        let workshop = Workshop {
            demand: &DEMAND,
            rotary: true,
            load_unit: "N·m",
        };
        says(
            &sentence(&delay, &workshop),
            &[
                "or it is the winding's inductance, which the machine file neglects: a delay of 1.20 ms would be 1.20 mH at \
                 1.00 Ω",
            ],
        );
        let declared = rotary(id, &[("delay", 1.2e-3, 1e-5)]);
        assert!(!declared.contains("inductance"), "{declared}");
    }
}

/// Whoever copies the line that declares an effect knows what its numbers are.
#[test]
fn numbers_that_an_effect_is_declared_by_are_reported_or_explained() {
    for id in Id::ALL {
        let description = id.description();
        for parameter in description.parameters {
            let is_reported = description
                .reported
                .iter()
                .any(|(name, _)| *name == parameter.name);
            let quoted = format!("`{}`", parameter.name);
            let is_explained = declared_by(*id).is_some_and(|words| words.contains(&quoted));
            let is_overtone = parameter.role == Role::Overtone;
            assert!(
                is_reported || is_explained || is_overtone,
                "{}: {quoted}",
                description.id
            );
        }
    }
}

/// What is said of an effect that may be there is how strong it is: the first number that is reported.
#[test]
fn the_first_reported_number_is_how_much_acts() {
    let plant = Parameters::free(1.0);
    for id in Id::ALL {
        let first = |strength: f32| {
            let mut active = Active::new(*id, []);
            for (value, parameter) in active.values.iter_mut().zip(id.description().parameters) {
                *value = match parameter.role {
                    Role::Strength => strength,
                    Role::Shape => 0.5,
                    Role::Overtone => 0.0,
                };
            }
            active.report(&plant)[0]
        };
        let name = id.description().id;
        assert_eq!(first(0.0), 0.0, "{name}");
        assert!(first(0.02) > first(0.01), "{name}");
    }
}
