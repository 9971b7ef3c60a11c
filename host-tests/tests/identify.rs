//! The semi-automatic identification against rigs whose truth is known.

use host_tests::identify::{Identified, Numbers, Start, identify};
use host_tests::log::Log;
use host_tests::machine::Machine as Declared;
use host_tests::{free_run, identify::Series};
use model_core::signal::{aprts, growing_triangle};
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
    let signal = growing_triangle::Parameters {
        offset,
        amplitude,
        first: 11,
        last: 18,
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
        command: None,
        current: None,
        velocity: None,
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

fn show(found: &Identified, truth: [f64; 6]) {
    for (name, model) in [
        ("lines", Some(&found.reduced)),
        ("full", Some(&found.full)),
        ("polished", found.polished.as_ref()),
    ] {
        let Some(model) = model else { continue };
        let misses = misses(&model.numbers, truth);
        for (k, number) in model.numbers.all().into_iter().enumerate() {
            println!(
                "  {name} {k}: {:.5} ± {:.5}, truth {:.5}, {:+.2}",
                number.value, number.half_width, truth[k], misses[k]
            );
        }
        println!("  {name} {:?}", model.errors);
    }
    println!("  {:?}", found.warnings);
}

#[test]
fn probe() {
    for machine in [
        Machine::intake_throttle(),
        Machine::throttle(),
        Machine::swirl_flap(),
        Machine::egr_valve(),
    ] {
        let found = run(&machine, &[], 1);
        show(&found, truth(&machine));
    }
    let machine = Machine::intake_throttle();
    let effects = [
        EffectKind::Cogging,
        EffectKind::Presliding,
        EffectKind::AsymmetricCoulomb,
    ]
    .map(|kind| Effect::nominal(kind, &machine));
    let found = run(&machine, &effects, 2);
    show(&found, truth(&machine));
    let fresh = log(&measure(&machine, &effects, steps(&machine, 77), 78), "v");
    for model in [&found.reduced, &found.full, found.best()] {
        let e = Series::of(&fresh).free_run(&model.parameters).unwrap();
        println!("validation {:.4} {:.2}°", e.nrmse, e.max_abs / DEGREE);
    }
    let _ = free_run::errors;
}
