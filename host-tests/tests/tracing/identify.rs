//! The semi-automatic identification against rigs whose truth is known.

use std::path::Path;

use host_tests::identify::{Identified, Numbers, Start, identify};
use host_tests::log::Log;
use host_tests::machine::Machine as Declared;
use host_tests::{free_run, identify::Series};
use model_core::signal::{aprts, growing_triangle};
use rayon::prelude::*;
use rig::{Effect, EffectKind, Experiment, Machine, Motor, Noise, Recording};

const PERIOD: f32 = 1e-3;
const SECONDS: f32 = 60.0;
const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Volts at the middle of the stroke that balance the spring, and volts to either side of it that reach
/// both ends sliding.
fn swing(machine: &Machine) -> (f32, f32) {
    let spring = machine.spring.unwrap();
    let stops = machine.stops.unwrap();
    let Motor::Winding {
        resistance,
        torque_constant,
        ..
    } = machine.motor
    else {
        panic!("a winding");
    };
    let strength = torque_constant / resistance;
    // A limp-home throttle is worked on the longer side of its rest.
    let below = spring.rest - stops.lower > stops.upper - spring.rest;
    let (low, high, sign) = if below {
        (stops.lower, spring.rest, -1.0)
    } else {
        (spring.rest, stops.upper, 1.0)
    };
    let middle = 0.5 * (low + high);
    let offset = spring.stiffness * (middle - spring.rest) + sign * spring.preload;
    let amplitude = 0.5 * spring.stiffness * (high - low) + machine.coulomb;
    (
        (offset / strength) as f32,
        (1.05 * amplitude / strength) as f32,
    )
}

fn triangle(machine: &Machine) -> Vec<f64> {
    let (offset, amplitude) = swing(machine);
    // A triangle moves the machine both ways from half of its static and sliding friction on.
    let truth = truth(machine);
    let moves = 24.0 * 0.5 * (truth[3] + truth[4]) / f64::from(amplitude);
    let signal = growing_triangle::Parameters {
        offset,
        amplitude,
        first: moves.ceil() as u32,
        last: 24,
        duration: SECONDS,
    }
    .build(PERIOD)
    .unwrap();
    (0..60_000).map(|tick| f64::from(signal.at(tick))).collect()
}

fn steps(machine: &Machine, seed: u64) -> Vec<f64> {
    let (offset, amplitude) = swing(machine);
    let signal = aprts::Parameters {
        lower: offset - 1.2 * amplitude,
        upper: offset + 1.2 * amplitude,
        shortest_hold: 0.1,
        longest_hold: 0.8,
        seed,
    }
    .build(PERIOD)
    .unwrap();
    (0..60_000).map(|tick| f64::from(signal.at(tick))).collect()
}

fn measure(machine: &Machine, effects: &[Effect], input: Vec<f64>, seed: u64) -> Recording {
    Experiment::replaying(machine.clone(), input, 1000.0)
        .with_effects(effects)
        .with_noise(Noise::potentiometer(machine))
        .seeded(seed)
        .run()
}

fn log(recording: &Recording, name: &str) -> Log {
    Log {
        path: name.into(),
        start_s: 0.0,
        period_s: 1e-3,
        input: recording.input.clone(),
        position: recording.position.clone(),
        ..Log::default()
    }
}

/// What a user would declare: the winding and the stops are right, inertia and viscous friction off
/// by a third, friction and spring unknown.
fn start(machine: &Machine) -> Start {
    let rough = Machine {
        inertia: 1.35 * machine.inertia,
        viscous: 0.7 * machine.viscous,
        coulomb: 0.5 * machine.coulomb,
        static_friction: 0.5 * machine.coulomb,
        spring: machine.spring.map(|spring| rig::ReturnSpring {
            stiffness: 0.0,
            preload: 0.0,
            ..spring
        }),
        ..machine.clone()
    };
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("start.toml");
    std::fs::write(&path, rough.to_toml()).unwrap();
    Start::new(Declared::read(&path).unwrap()).unwrap()
}

/// a₀/b₀ … b₀ of the rig.
fn truth(machine: &Machine) -> [f64; 6] {
    let spring = machine.spring.unwrap();
    let Motor::Winding {
        resistance,
        torque_constant,
        ..
    } = machine.motor
    else {
        panic!("a winding");
    };
    let strength = torque_constant / resistance;
    [
        spring.stiffness / strength,
        machine.viscous / strength + torque_constant,
        spring.preload / strength,
        machine.coulomb / strength,
        machine.static_friction / strength,
        strength / machine.inertia,
    ]
}

fn run(machine: &Machine, effects: &[Effect], seed: u64) -> Identified {
    let slow = measure(machine, effects, triangle(machine), seed);
    let fast = measure(machine, effects, steps(machine, seed), seed + 1000);
    let begin = std::time::Instant::now();
    let found = identify(&start(machine), &log(&slow, "slow"), &log(&fast, "fast"));
    let found = found.unwrap_or_else(|error| panic!("{} {seed}: {error}", machine.name));
    println!(
        "{} seed {seed}: {} simulations, {:.2} s",
        machine.name,
        found.simulations,
        begin.elapsed().as_secs_f64()
    );
    found
}

/// Errors of the six numbers in half widths of their intervals.
fn misses(numbers: &Numbers, truth: [f64; 6]) -> [f64; 6] {
    let all = numbers.all();
    std::array::from_fn(|k| (all[k].value - truth[k]) / all[k].half_width)
}

/// The six numbers by the paper's procedure within 2.5 half widths of the truth, polished within 2 %; free
/// runs as good as the paper's, NRMSE 0.06: a level of the input next to a breakaway may cost a large
/// error for the time that it is held.
fn identifies(machine: &Machine, seed: u64) {
    let found = run(machine, &[], seed);
    let truth = truth(machine);
    let misses = misses(&found.full.numbers, truth);
    println!("{}: off by {misses:.2?} half widths", machine.name);
    assert!(misses.iter().all(|miss| miss.abs() < 2.5), "{misses:?}");
    let polished = found.best().numbers.values();
    let off: [f64; 6] = std::array::from_fn(|k| polished[k] / truth[k] - 1.0);
    println!("{}: polished off by {off:.4?}", machine.name);
    assert!(off.iter().all(|off| off.abs() < 0.02), "{off:?}");
    let fresh = log(
        &measure(machine, &[], steps(machine, seed + 500), seed),
        "fresh",
    );
    for model in [&found.reduced, &found.full, found.best()] {
        let fresh = Series::of(&fresh).free_run(&model.parameters).unwrap();
        for errors in [model.errors.slow, model.errors.fast, fresh] {
            println!("{}: {errors:.4?}", machine.name);
            assert!(errors.nrmse < 0.06, "{errors:?}");
        }
    }
}

/// A machine file without the sensor's resolution is as good as one with it, where the positions show its steps.
#[test]
fn the_steps_of_the_positions_stand_for_a_resolution_that_is_not_declared() {
    let machine = Machine::intake_throttle();
    let mut declared = start(&machine);
    let resolution = declared.machine.resolution.expect("of the rig's sensor");
    let logs = [triangle(&machine), steps(&machine, 5)].map(|input| {
        let mut log = log(&measure(&machine, &[], input, 5), "log");
        for position in &mut log.position {
            *position = (*position / resolution).round() * resolution;
        }
        log
    });
    let numbers = |start: &Start| {
        let found = identify(start, &logs[0], &logs[1]).unwrap();
        found.best().numbers.values()
    };
    let with = numbers(&declared);
    declared.machine.resolution = None;
    let without = numbers(&declared);
    // The step is the declared one to the rounding of the positions.
    for (one, other) in with.into_iter().zip(without) {
        assert!((one / other - 1.0).abs() < 1e-3, "{with:?} {without:?}");
    }
}

/// The machine files declare what the rig plays.
#[test]
fn the_machine_files_are_the_rigs_machines() {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines");
    for machine in [
        Machine::intake_throttle(),
        Machine::swirl_flap(),
        Machine::egr_valve(),
    ] {
        let file = directory.join(format!("{}.toml", machine.name));
        let file = Start::new(Declared::read(&file).unwrap()).unwrap();
        let own = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(own.path(), machine.to_toml()).unwrap();
        let own = Start::new(Declared::read(own.path()).unwrap()).unwrap();
        assert_eq!(file.parameters, own.parameters, "{}", machine.name);
        assert_eq!(file.machine.resolution, own.machine.resolution);
    }
}

#[test]
fn an_intake_throttle_is_identified() {
    identifies(&Machine::intake_throttle(), 111);
}

#[test]
fn a_limp_home_throttle_is_identified() {
    identifies(&Machine::throttle(), 112);
}

#[test]
fn a_swirl_flap_is_identified() {
    identifies(&Machine::swirl_flap(), 113);
}

#[test]
fn a_recirculation_valve_is_identified() {
    identifies(&Machine::egr_valve(), 114);
}

/// Twenty-four throttles, each with parameters of its own: of 144 intervals of 95 %, 137 are expected to
/// cover the truth. Those of one throttle share its log; if they count as three instead of six, 124 or
/// fewer (62 of 72) come by chance once in 300.
#[test]
#[ignore = "at length"]
fn intervals_cover_the_truth() {
    let covered: Vec<[bool; 6]> = (40..64_u64)
        .into_par_iter()
        .map(|seed| {
            let mut random = rig::Random::new(9000 + seed);
            let mut vary = |value: f64| value * (0.8 + 0.4 * random.uniform());
            let throttle = Machine::intake_throttle();
            let coulomb = vary(0.22);
            let machine = Machine {
                inertia: vary(throttle.inertia),
                viscous: vary(throttle.viscous),
                coulomb,
                static_friction: 1.15 * coulomb,
                spring: throttle.spring.map(|spring| rig::ReturnSpring {
                    stiffness: vary(spring.stiffness),
                    ..spring
                }),
                ..throttle
            };
            let misses = misses(&run(&machine, &[], seed).full.numbers, truth(&machine));
            println!("seed {seed}: off by {misses:.2?} half widths");
            std::array::from_fn(|k| misses[k].abs() <= 1.0)
        })
        .collect();
    let count = covered.iter().flatten().filter(|covers| **covers).count();
    println!("{count} of 144 intervals cover the truth");
    assert!(count > 124, "{count}");
}

/// What the paper asks for, on machines that have what the model does not: cogging, presliding and
/// friction that depends on the direction, noise and 12 bits; identification and validation.
fn undeclared_effects_cost_five_degrees(seeds: &[u64]) {
    let machine = Machine::intake_throttle();
    let effects = [
        EffectKind::Cogging,
        EffectKind::Presliding,
        EffectKind::AsymmetricCoulomb,
    ]
    .map(|kind| Effect::nominal(kind, &machine).scaled(0.5));
    for &seed in seeds {
        let found = run(&machine, &effects, seed);
        let fresh = log(
            &measure(&machine, &effects, steps(&machine, seed + 500), seed),
            "fresh",
        );
        for (name, model) in [
            ("reduced", &found.reduced),
            ("full", &found.full),
            ("polished", found.best()),
        ] {
            let fresh = Series::of(&fresh).free_run(&model.parameters).unwrap();
            for (on, errors) in [
                ("slow", model.errors.slow),
                ("fast", model.errors.fast),
                ("validation", fresh),
            ] {
                let degrees = errors.max_abs / DEGREE;
                println!(
                    "{seed} {name} {on}: NRMSE {:.3}, {degrees:.2}°",
                    errors.nrmse
                );
                assert!(degrees <= 5.0, "{degrees}");
            }
        }
    }
}

#[test]
fn undeclared_effects_cost_five_degrees_at_most() {
    undeclared_effects_cost_five_degrees(&[201]);
}

#[test]
#[ignore = "at length"]
fn undeclared_effects_cost_five_degrees_at_most_on_another_log() {
    undeclared_effects_cost_five_degrees(&[202]);
}

/// The physical model, eqs 1–7, against the f64 rig of the same parameters: without and with
/// inductance, preload, stops, viscous friction, static above Coulomb friction.
fn both_assemblies_follow(inductances: &[f64], ticks: usize) {
    for &inductance in inductances {
        for machine in [Machine::intake_throttle(), Machine::throttle()] {
            let machine = Machine {
                motor: Motor::Winding {
                    resistance: 2.0,
                    inductance,
                    torque_constant: 0.38,
                },
                ..machine
            };
            for mut input in [triangle(&machine), steps(&machine, 301)] {
                input.truncate(ticks);
                let reference = measure(&machine, &[], input, 1);
                let directory = tempfile::tempdir().unwrap();
                let path = directory.path().join("machine.toml");
                std::fs::write(&path, machine.to_toml()).unwrap();
                let declared = Start::new(Declared::read(&path).unwrap()).unwrap();
                let input: Vec<f32> = reference.input.iter().map(|&u| u as f32).collect();
                let rest = declared.parameters.spring_rest;
                let ours = free_run::simulate(&declared.parameters, PERIOD, &input, rest).unwrap();
                let truth: Vec<f32> = reference.true_position.iter().map(|&y| y as f32).collect();
                let errors = free_run::errors(&ours, &truth);
                println!("{} L {inductance}: {errors:?}", machine.name);
                assert!(errors.max_abs < 1e-4, "{errors:?}");
            }
        }
    }
}

/// Twenty seconds have breakaways, stops and the rest.
#[test]
fn both_assemblies_follow_an_independent_integration() {
    both_assemblies_follow(&[0.0, 6e-3], 20_000);
}

#[test]
#[ignore = "at length"]
fn both_assemblies_follow_an_independent_integration_for_a_minute() {
    both_assemblies_follow(&[0.0, 1.2e-3, 6e-3], 60_000);
}
