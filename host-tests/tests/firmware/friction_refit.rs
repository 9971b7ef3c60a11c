//! The friction's re-estimation on the rig: another integrator in `f64`, a position loop, and the
//! sensors of the board.

use firmware::app::machine::EMA;
use model_core::gap::log::{Channel, Log};
use model_core::identify::friction::{Estimate, Refit, Refusal, Task};
use model_core::plant::parameters::Parameters;
use rig::{Machine, Pid, Plant, Random, Trajectory};
use std::f64::consts::TAU;

/// Sampling period of the logs and of the position loop, s.
const PERIOD: f64 = 1e-3;

/// Length of a log, s.
const SECONDS: f64 = 10.0;

/// Counts of the sensors and of the bridge: rad, A, V.
const ENCODER: f64 = TAU / 16384.0;
const SHUNT: f64 = 25.0 / 2048.0;
const BRIDGE: f64 = 24.0 / 4200.0;

fn counted(value: f64, count: f64) -> f64 {
    (value / count).round() * count
}

struct Recording {
    input: Vec<f32>,
    position: Vec<f32>,
    current: Vec<f32>,
}

impl Recording {
    fn log(&self) -> Log<'_> {
        Log {
            current: Some(Channel::Values(&self.current)),
            ..Log::new(
                PERIOD as f32,
                Channel::Values(&self.input),
                Channel::Values(&self.position),
            )
        }
    }
}

/// A machine whose loop follows `command`, a function of time.
fn track(machine: &Machine, command: impl Fn(f64) -> f64, seed: u64) -> Recording {
    let mut plant = Plant::new(machine, &[]);
    plant.place(command(0.0), 0.0);
    let mut pid = Pid::new(machine.gains, machine.input_limit, PERIOD);
    let mut random = Random::new(seed);
    let mut recording = Recording {
        input: Vec::new(),
        position: Vec::new(),
        current: Vec::new(),
    };
    for sample in 0..(SECONDS / PERIOD) as usize {
        let position = counted(plant.state().position, ENCODER);
        let current = counted(plant.state().current + 0.3 * SHUNT * random.normal(), SHUNT);
        let input = counted(pid.step(command(sample as f64 * PERIOD), position), BRIDGE);
        recording.position.push(position as f32);
        recording.current.push(current as f32);
        recording.input.push(input as f32);
        plant.advance(input, PERIOD);
    }
    recording
}

/// The rig's rotary machine, as declared: the board's actuator in free travel.
const DECLARED: Parameters = Parameters {
    lower_stop: f32::NEG_INFINITY,
    upper_stop: f32::INFINITY,
    ..EMA.plant
};

fn refit(task: &Task) -> Result<Estimate, Refusal> {
    Refit::new(task).unwrap().run()
}

/// What is in use after the re-estimation.
fn coulomb_in_use(task: &Task) -> f32 {
    match refit(task) {
        Ok(estimate) => estimate.coulomb,
        Err(Refusal::NoImprovement) => task.present,
        Err(refusal) => panic!("{refusal:?}"),
    }
}

/// Largest error of the friction in use, of the truth, from the declared value as the start: the
/// rig's rotary machine with 0.6 to 3 times the declared friction, several seeds of sensor noise
/// and of the annealing.
fn worst_error(name: &str, command: impl Fn(f64) -> f64) -> f64 {
    let nominal = Machine::rotary_ema();
    let mut worst = 0.0_f64;
    for factor in [0.6, 0.8, 1.0, 1.3, 1.8, 2.4, 3.0] {
        let machine = Machine {
            coulomb: factor * nominal.coulomb,
            static_friction: factor * nominal.static_friction,
            ..nominal.clone()
        };
        for seed in 11..=13 {
            let recording = track(&machine, &command, seed);
            let coulomb = coulomb_in_use(&Task {
                declared: DECLARED,
                log: recording.log(),
                resolution: ENCODER as f32,
                present: 0.12,
                seed,
            });
            let error = f64::from(coulomb) / machine.coulomb - 1.0;
            println!(
                "{name}, {factor} times, seed {seed}: {:.3} %",
                100.0 * error
            );
            worst = worst.max(error.abs());
        }
    }
    worst
}

/// Steps every 0.4 s between five positions.
fn steps(amplitude: f64) -> impl Fn(f64) -> f64 {
    move |time| amplitude * [0.0, 1.0, 0.3, -0.7, -1.0][(time / 0.4) as usize % 5]
}

#[test]
fn friction_is_found_within_one_percent_from_steps() {
    assert!(worst_error("steps", steps(3.0)) < 0.01);
    assert!(worst_error("small steps", steps(0.8)) < 0.01);
}

#[test]
fn friction_is_found_within_one_percent_from_a_sweep() {
    let sweep = Trajectory::sweep(&Machine::rotary_ema(), SECONDS);
    assert!(worst_error("sweep", |time| sweep.at(time)) < 0.01);
}

#[test]
fn friction_is_found_within_one_percent_from_a_triangle() {
    let triangle = Trajectory::triangle(&Machine::rotary_ema());
    assert!(worst_error("triangle", |time| triangle.at(time)) < 0.01);
}

#[test]
fn both_counts_are_reported_and_stay_about_a_hundred() {
    let machine = Machine {
        coulomb: 0.2,
        static_friction: 0.25,
        ..Machine::rotary_ema()
    };
    let recording = track(&machine, steps(3.0), 5);
    let estimate = refit(&Task {
        declared: DECLARED,
        log: recording.log(),
        resolution: ENCODER as f32,
        present: 0.12,
        seed: 5,
    })
    .unwrap();
    assert_eq!(estimate.annealing_evaluations, 82);
    assert!((5..=20).contains(&estimate.golden_section_evaluations));
    assert_eq!(estimate.windows, 49);
}
