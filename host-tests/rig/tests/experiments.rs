//! What the bench logs: delays, quantisation, noise, coverage of the stroke, files.

use rig::{Bench, Effect, EffectKind, Experiment, Machine, Motor, Noise, Random, Trajectory};
use std::f64::consts::TAU;

fn machines() -> [Machine; 6] {
    [
        Machine::rotary_ema(),
        Machine::force_slide(),
        Machine::throttle(),
        Machine::intake_throttle(),
        Machine::swirl_flap(),
        Machine::egr_valve(),
    ]
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, n), x| (sum + x * x, n + 1));
    (sum / f64::from(count)).sqrt()
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    rms(a.iter().zip(b).map(|(a, b)| a - b))
}

/// 1 kg, 1 N, no friction: x = ½ t², with either delay τ reported as ½ (t − τ)².
#[test]
fn delays_are_exact_between_the_samples() {
    let machine = Machine {
        motor: Motor::Direct { gain: 1.0 },
        inertia: 1.0,
        viscous: 0.0,
        coulomb: 0.0,
        static_friction: 0.0,
        resolution: 0.0,
        ..Machine::force_slide()
    };
    let delayed = |input: f64, sensor: f64| {
        Experiment::driven(machine.clone(), Trajectory::Constant(1.0))
            .with_effects(&[
                Effect::InputDelay { seconds: input },
                Effect::SensorDelay { seconds: sensor },
            ])
            .lasting(0.1)
            .run()
    };
    for (input, sensor) in [
        (0.0, 0.0),
        (0.3e-3, 0.0),
        (2.3e-3, 0.0),
        (3.0e-3, 0.0),
        (0.0, 0.4e-3),
        (0.0, 2.7e-3),
        (0.0, 2.0e-3),
        (1.2e-3, 2.3e-3),
        (1.8e-3, 2.9e-3),
        (1.5e-3, 0.5e-3),
    ] {
        let log = delayed(input, sensor);
        for (t, x) in log.time.iter().zip(&log.position) {
            let expected = 0.5 * (t - input - sensor).max(0.0).powi(2);
            assert!((x - expected).abs() < 1e-12, "{input} {sensor} at {t}");
        }
        for (t, x) in log.time.iter().zip(&log.true_position) {
            let expected = 0.5 * (t - input).max(0.0).powi(2);
            assert!((x - expected).abs() < 1e-12, "{input} {sensor} at {t}");
        }
    }
}

/// A delayed sensor leaves the current alone.
#[test]
fn current_is_not_delayed_by_the_position_sensor() {
    let run = |effects: &[Effect]| {
        let triangle = Trajectory::Triangle {
            centre: 0.0,
            amplitude: 10.0,
            period: 0.25,
        };
        Experiment::driven(Machine::rotary_ema(), triangle)
            .with_effects(effects)
            .lasting(0.3)
            .run()
    };
    let late = run(&[Effect::SensorDelay { seconds: 2.5e-3 }]);
    let prompt = run(&[]);
    assert_eq!(late.input, prompt.input);
    // The sensor catches within a step that is then cut, which rounds otherwise.
    assert!(difference(&late.current, &prompt.current) < 1e-9);
    assert!(difference(&late.position, &prompt.position) > 1e-2);
}

#[test]
fn the_encoder_rounds_to_whole_counts() {
    for machine in machines() {
        let resolution = machine.resolution;
        let log = Experiment::tracking(machine.clone(), Trajectory::sines(&machine))
            .lasting(2.0)
            .run();
        for (seen, real) in log.position.iter().zip(&log.true_position) {
            let counts = seen / resolution;
            assert!((counts - counts.round()).abs() < 1e-6);
            assert!((seen - real).abs() <= 0.5000001 * resolution);
        }
    }
}

#[test]
fn noise_has_the_deviation_asked_for_and_depends_on_the_seed_alone() {
    let machine = Machine {
        resolution: 0.0,
        ..Machine::rotary_ema()
    };
    let noise = Noise {
        position: 1e-3,
        current: 0.05,
    };
    let experiment = Experiment::driven(machine, Trajectory::Constant(5.0))
        .lasting(10.0)
        .with_noise(noise);
    let log = experiment.run();
    let silent = experiment.clone().with_noise(Noise::NONE).run();
    // Standard error of a deviation over 10 000 samples: 0.7 %.
    assert!((difference(&log.position, &silent.position) / 1e-3 - 1.0).abs() < 0.03);
    assert!((difference(&log.current, &silent.current) / 0.05 - 1.0).abs() < 0.03);
    assert_eq!(log, experiment.run());
    let other = experiment.seeded(2).run();
    assert_ne!(log.current, other.current);
    assert_eq!(log.true_position, other.true_position);
}

/// Every log moves over most of the stroke, both ways, with rests or reversals, and the loop
/// follows; a log without that would hide the effects.
#[test]
fn every_machine_follows_every_trajectory() {
    for machine in machines() {
        for trajectory in Trajectory::all(&machine, 10.0) {
            let log = Experiment::tracking(machine.clone(), trajectory.clone()).run();
            let span = 2.0 * machine.amplitude();
            let place = format!("{} {trajectory:?}", machine.name);
            let low = log.position.iter().copied().fold(f64::INFINITY, f64::min);
            let high = log
                .position
                .iter()
                .copied()
                .fold(f64::NEG_INFINITY, f64::max);
            assert!(high - low > 0.6 * span, "{place}: {low} to {high}");
            let error = difference(&log.position, &log.command);
            assert!(error < 0.12 * span, "{place}: follows within {error}");
            let share = |wanted: fn(f64, f64) -> bool| {
                let hits = log
                    .true_velocity
                    .iter()
                    .filter(|v| wanted(**v, machine.speed));
                hits.count() as f64 / log.time.len() as f64
            };
            assert!(share(|v, top| v > 0.1 * top) > 0.1, "{place}");
            assert!(share(|v, top| v < -0.1 * top) > 0.1, "{place}");
            let limited = log.input.iter().filter(|u| u.abs() >= machine.input_limit);
            assert!(
                (limited.count() as f64) < 0.2 * log.time.len() as f64,
                "{place}"
            );
        }
    }
}

/// At its nominal strength every effect costs the loop at least a hundredth of its input.
#[test]
fn every_nominal_effect_shows() {
    for machine in machines() {
        let trajectory = Trajectory::sines(&machine);
        let clean = Experiment::tracking(machine.clone(), trajectory.clone()).run();
        let possible = |kind: &EffectKind| kind.can_act_on(&machine);
        for kind in EffectKind::ALL.into_iter().filter(possible) {
            let effect = Effect::nominal(kind, &machine);
            let log = Experiment::tracking(machine.clone(), trajectory.clone())
                .with_effects(&[effect])
                .run();
            // In closed loop the input carries what the position does not.
            let input = difference(&log.input, &clean.input) / rms(clean.input.iter().copied());
            assert!(input > 0.01, "{} {kind:?}: {input}", machine.name);
            assert!(log.position.iter().all(|x| x.is_finite()));
        }
    }
}

/// A position loop that sees a reading error: what is logged is the true position and the error there.
#[test]
fn an_eccentric_encoder_errs_once_a_period() {
    let machine = Machine {
        resolution: 0.0,
        ..Machine::rotary_ema()
    };
    let log = Experiment::tracking(machine.clone(), Trajectory::moves(&machine))
        .with_effects(&[Effect::EncoderEccentricity {
            amplitude: 0.02,
            period: 3.0,
            phase: 0.5,
        }])
        .with_noise(Noise::NONE)
        .lasting(2.0)
        .run();
    let mut most = 0.0f64;
    for (reported, position) in log.position.iter().zip(&log.true_position) {
        let error = 0.02 * (TAU * position / 3.0 + 0.5).sin();
        assert!((reported - position - error).abs() < 1e-12);
        most = most.max(error.abs());
    }
    assert!(most > 0.0199);
}

#[test]
fn scaling_by_zero_removes_an_effect() {
    let machine = Machine::throttle();
    let run = |effects: &[Effect]| {
        Experiment::tracking(machine.clone(), Trajectory::moves(&machine))
            .with_effects(effects)
            .lasting(1.0)
            .run()
    };
    let clean = run(&[]);
    let nothing = EffectKind::ALL.map(|kind| Effect::nominal(kind, &machine).scaled(0.0));
    assert!(difference(&run(&nothing).true_position, &clean.true_position) < 1e-12);
}

#[test]
fn kinds_and_effects_name_each_other() {
    for kind in EffectKind::ALL {
        assert_eq!(Effect::nominal(kind, &Machine::throttle()).kind(), kind);
    }
}

/// Rows, columns and numbers of the file, read back.
#[test]
fn csv_holds_what_was_logged() {
    for (machine, header) in [
        (
            Machine::rotary_ema(),
            "time_s,input,position,command,current_a",
        ),
        (Machine::force_slide(), "time_s,input,position,command"),
    ] {
        let log = Experiment::tracking(machine.clone(), Trajectory::moves(&machine))
            .lasting(0.2)
            .run();
        let text = log.to_csv();
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some(header));
        let mut rows = 0;
        for (row, line) in lines.enumerate() {
            let numbers: Vec<f64> = line.split(',').map(|n| n.parse().unwrap()).collect();
            let mut expected = vec![
                log.time[row],
                log.input[row],
                log.position[row],
                log.command[row],
            ];
            expected.extend(log.current.get(row));
            assert_eq!(numbers.len(), expected.len());
            for (number, expected) in numbers.iter().zip(expected) {
                assert!((number - expected).abs() <= 0.6e-9);
            }
            rows += 1;
        }
        assert_eq!(rows, 200);
    }
}

/// Keys and values of the machine file, table by table.
#[test]
fn machine_file_declares_the_machine() {
    let text = Machine::throttle().to_toml();
    let mut table = String::new();
    let mut pairs = Vec::new();
    for line in text.lines().filter(|line| !line.is_empty()) {
        match line.strip_prefix('[') {
            Some(name) => table = name.trim_end_matches(']').to_string() + ".",
            None => pairs.push(table.clone() + line),
        }
    }
    assert_eq!(
        pairs,
        [
            "name = \"throttle\"",
            "coordinate = \"rad\"",
            "input.kind = \"voltage\"",
            "input.gain = 1.0",
            "motor.resistance = 2.0",
            "motor.inductance = 0.0012",
            "motor.torque_constant = 0.38",
            "mechanics.inertia = 0.0016",
            "mechanics.viscous = 0.008",
            "mechanics.spring = 0.25",
            "mechanics.spring_rest = 0.2",
            "mechanics.spring_preload = 0.3",
            "mechanics.lower_stop = 0.02",
            "mechanics.upper_stop = 1.57",
            "friction.coulomb = 0.24",
            "friction.static = 0.28",
            "sensor.resolution = 0.001",
            "fit.parameters = [\"inertia\", \"viscous\", \"coulomb\", \"static\"]",
        ]
    );
    let slide = Machine::force_slide().to_toml();
    assert!(slide.contains("[input]\nkind = \"torque\"\ngain = 35.0\n"));
    assert!(!slide.contains("[motor]") && !slide.contains("spring") && !slide.contains("stop"));
    assert!(slide.contains("resolution = 1e-6\n"));
}

#[test]
fn random_numbers_differ_between_seeds() {
    let (mut a, mut b) = (Random::new(1), Random::new(2));
    assert!((0..100).all(|_| a.bits() != b.bits()));
}

/// A motor without inductance that a brake holds: its current is the voltage over the resistance.
#[test]
fn supply_and_current_sensor_err_as_asked_for() {
    let machine = Machine {
        motor: Motor::Winding {
            resistance: 2.0,
            inductance: 0.0,
            torque_constant: 0.06,
        },
        coulomb: 9.0,
        static_friction: 9.0,
        ..Machine::rotary_ema()
    };
    let bench = Bench {
        current_offset: 0.3,
        current_drift: -0.05,
        supply_ripple: 0.04,
        supply_frequency: 90.0,
        supply_phase: 0.7,
        ..Bench::IDEAL
    };
    let log = Experiment::driven(machine, Trajectory::Constant(12.0))
        .lasting(2.0)
        .with_noise(Noise::NONE)
        .on(bench)
        .run();
    for (time, current) in log.time.iter().zip(&log.current) {
        let supply = 1.0 + 0.04 * (TAU * 90.0 * time + 0.7).sin();
        let expected = 12.0 * supply / 2.0 + 0.3 - 0.05 * time;
        assert!((current - expected).abs() < 1e-9, "{time}");
    }
    assert!(log.input.iter().all(|input| *input == 12.0));
}

/// A brake holds the machine: the position sensor's offset and drift are all that it reports.
#[test]
fn position_sensor_and_converter_err_as_asked_for() {
    let machine = Machine {
        coulomb: 9.0,
        static_friction: 9.0,
        resolution: 0.0,
        ..Machine::rotary_ema()
    };
    let bench = Bench {
        position_offset: 0.03,
        position_drift: -0.002,
        current_resolution: 0.25,
        ..Bench::IDEAL
    };
    let log = Experiment::driven(machine, Trajectory::Constant(1.2))
        .lasting(2.0)
        .with_noise(Noise::NONE)
        .on(bench)
        .run();
    for (time, position) in log.time.iter().zip(&log.position) {
        assert!((position - (0.03 - 0.002 * time)).abs() < 1e-12, "{time}");
    }
    // 1.2 A, once it has risen through the winding's inductance.
    assert_eq!(log.current.last(), Some(&1.25));
    assert!(log.current.iter().all(|current| current % 0.25 == 0.0));
}

/// Almost without inertia and without any friction, the back-EMF is the voltage at every angle.
#[test]
fn the_torque_constant_ripples_over_the_angle() {
    let machine = Machine {
        motor: Motor::Winding {
            resistance: 1.0,
            inductance: 0.0,
            torque_constant: 0.06,
        },
        inertia: 1e-7,
        viscous: 0.0,
        coulomb: 0.0,
        static_friction: 0.0,
        ..Machine::rotary_ema()
    };
    let bench = Bench {
        torque_ripple: 0.1,
        ripples_per_turn: 3.0,
        ..Bench::IDEAL
    };
    let log = Experiment::driven(machine, Trajectory::Constant(1.2))
        .lasting(1.0)
        .on(bench)
        .run();
    let states = log.true_position.iter().zip(&log.true_velocity).skip(5);
    for (position, velocity) in states {
        let emf = 0.06 * (1.0 + 0.1 * (3.0 * position).sin()) * velocity;
        assert!((emf / 1.2 - 1.0).abs() < 5e-3, "{position}");
    }
}

/// The position sensor stays within half of the play of the machine, and uses all of it.
#[test]
fn lost_motion_shows_at_reversals() {
    let machine = Machine {
        resolution: 0.0,
        ..Machine::rotary_ema()
    };
    let bench = Bench {
        backlash: 0.02,
        ..Bench::IDEAL
    };
    let log = Experiment::tracking(machine.clone(), Trajectory::triangle(&machine))
        .lasting(2.0)
        .on(bench)
        .run();
    let lag = |pair: (&f64, &f64)| pair.0 - pair.1;
    let lags: Vec<f64> = log
        .position
        .iter()
        .zip(&log.true_position)
        .map(lag)
        .collect();
    let (low, high) = lags.iter().fold((0.0_f64, 0.0_f64), |(low, high), lag| {
        (low.min(*lag), high.max(*lag))
    });
    assert!(
        (low + 0.01).abs() < 1e-9 && (high - 0.01).abs() < 1e-9,
        "{low} {high}"
    );
}

#[test]
fn a_sampled_trajectory_holds_each_value_and_the_last_one_for_ever() {
    let trajectory = Trajectory::Sampled {
        rate: 1000.0,
        values: vec![1.0, 2.0, 3.0],
    };
    let at: Vec<f64> = (0..5)
        .map(|row| trajectory.at(f64::from(row) * 1e-3))
        .collect();
    assert_eq!(at, [1.0, 2.0, 3.0, 3.0, 3.0]);
    assert_eq!(trajectory.at(1.7e-3), 2.0);
    let none = Trajectory::Sampled {
        rate: 1000.0,
        values: Vec::new(),
    };
    assert_eq!(none.at(0.5), 0.0);
}
