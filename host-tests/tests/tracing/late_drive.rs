//! A geared motor whose drive acts late, its resistance and torque constant as far off as a data sheet's may be: the
//! numbers that are fitted without the delay bend to it until a small delay makes the error larger.

use std::f64::consts::PI;
use std::path::Path;

use host_tests::gap::engine;
use host_tests::log::Log;
use host_tests::machine::Machine;

/// The machine file: what a data sheet says.
const DECLARED: &str = r#"
name = "gearmotor"
coordinate = "rad"
[input]
kind = "voltage"
gain = 1.0
[motor]
resistance = 4.0
inductance = 0.0
torque_constant = 1.482
[mechanics]
inertia = 0.08
viscous = 0.02
[friction]
coulomb = 0.3
static = 0.35
[sensor]
resolution = 1.122e-4
[fit]
parameters = ["resistance", "torque_constant", "inertia", "viscous", "coulomb", "static"]
declared_effects = []
"#;

fn gearmotor() -> Machine {
    Machine::of_bytes(Path::new("gearmotor.toml"), DECLARED.into()).unwrap()
}

/// Steps of the simulation in a row of the log, and a row's time, s.
const STEPS: usize = 20;
const PERIOD: f64 = 0.002;

const ROWS: usize = 6000;

/// The motor that it is, in explicit steps of 0.1 ms, driven by a PID over four sines; `current`: whether its current
/// is logged.
fn log(delay: f64, phases: [f64; 4], current: bool) -> Log {
    let (resistance, constant, inertia, viscous) = (4.7, 1.316, 0.09, 0.02);
    let (coulomb, breakaway) = (0.34, 0.40);
    let step = PERIOD / STEPS as f64;
    let count = 2.0 * PI / 56_000.0;
    let mut acting = vec![0.0; (delay / step).round() as usize];
    let (mut position, mut velocity) = (0.0_f64, 0.0_f64);
    let (mut integral, mut last) = (0.0, 0.0);
    let (mut input, mut positions, mut currents) = (Vec::new(), Vec::new(), Vec::new());
    let mut amperes = 0.0;
    for row in 0..ROWS {
        let time = row as f64 * PERIOD;
        let wave = |(place, phase): (usize, &f64)| {
            let frequency = [0.15, 0.37, 0.81, 1.43][place];
            [0.55, 0.4, 0.3, 0.25][place] * (2.0 * PI * frequency * time + phase).sin()
        };
        let command: f64 = phases.iter().enumerate().map(wave).sum();
        let measured = (position / count).round() * count;
        let error = command - measured;
        integral += error * PERIOD;
        let told = 40.0 * error + 30.0 * integral + 0.8 * (error - last) / PERIOD;
        last = error;
        input.push(told.clamp(-24.0, 24.0));
        positions.push(measured);
        currents.push(amperes);
        for _ in 0..STEPS {
            acting.push(input[row]);
            amperes = (acting.remove(0) - constant * velocity) / resistance;
            let torque = constant * amperes;
            if velocity == 0.0 && torque.abs() < breakaway {
                continue;
            }
            let direction = if velocity == 0.0 { torque } else { velocity }.signum();
            let moved =
                velocity + step * (torque - viscous * velocity - coulomb * direction) / inertia;
            let stops = velocity * moved < 0.0 && torque.abs() < breakaway;
            velocity = if stops { 0.0 } else { moved };
            position += step * velocity;
        }
    }
    Log {
        path: format!("late by {delay} s").into(),
        period_s: PERIOD,
        input,
        position: positions,
        current: current.then_some(currents),
        ..Log::default()
    }
}

#[test]
fn a_late_drive_is_named_beside_a_motor_with_wrong_numbers() {
    let machine = gearmotor();
    for (delay, current) in [(6e-3, true), (6e-3, false), (12e-3, true), (20e-3, true)] {
        let train = log(delay, [0.3, 1.9, 4.0, 5.5], current);
        let other = log(delay, [2.2, 0.4, 5.1, 1.0], current);
        let report = engine::run(&machine, &[train], || Ok(vec![other]), |_| ()).unwrap();
        let outcome = report.outcome;
        let named: Vec<&str> = outcome.effects.iter().map(|it| it.id.as_str()).collect();
        assert_eq!(
            named,
            ["input_delay"],
            "{delay} s, current {current}: {outcome:?}"
        );
        let found = outcome.effects[0].parameters[0].value;
        assert!(
            (found / delay - 1.0).abs() < 0.05,
            "{found} s for {delay} s"
        );
        let ratio = outcome.errors.validate.unwrap().remaining();
        assert!(ratio < 0.1, "{ratio} of the error is left");
    }
}

#[test]
fn a_drive_in_time_is_not_called_late() {
    let machine = gearmotor();
    let train = log(0.0, [0.3, 1.9, 4.0, 5.5], true);
    let report = engine::run(&machine, &[train], || Ok(Vec::new()), |_| ()).unwrap();
    assert!(report.outcome.effects.is_empty(), "{:?}", report.outcome);
}
