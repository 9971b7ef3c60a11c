//! A geared motor whose drive acts late, its resistance and torque constant as far off as a data sheet's may be: the
//! numbers that are fitted without the delay bend to it until a small delay makes the error larger.

use std::f64::consts::PI;
use std::path::Path;

use host_tests::gap::engine;
use host_tests::log::Log;
use host_tests::machine::Machine;

use crate::stepped::Stepped;

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

/// The motor that it is, in steps of 0.1 ms; friction and inertia at its shaft.
const MOTOR: Stepped<4> = Stepped {
    inertia: 0.09,
    viscous: 0.02,
    coulomb: 0.34,
    breakaway: 0.40,
    count: 2.0 * PI / 56_000.0,
    period: 0.002,
    steps: 20,
    rows: 6000,
    frequencies: [0.15, 0.37, 0.81, 1.43],
    amplitudes: [0.55, 0.4, 0.3, 0.25],
    gains: [40.0, 30.0, 0.8],
    limit: 24.0,
};

const RESISTANCE: f64 = 4.7;
const TORQUE_CONSTANT: f64 = 1.316;

/// `current`: whether its current is logged.
fn log(delay: f64, phases: [f64; 4], current: bool) -> Log {
    let mut acting = vec![0.0; (delay / MOTOR.step()).round() as usize];
    // One a step, behind that before the first one: each row logs what flows as it begins.
    let mut amperes = vec![0.0];
    let torque = |volts: f64, _: f64, velocity: f64| {
        acting.push(volts);
        let flow = (acting.remove(0) - TORQUE_CONSTANT * velocity) / RESISTANCE;
        amperes.push(flow);
        TORQUE_CONSTANT * flow
    };
    let (input, position) = MOTOR.drive(phases, torque);
    let currents = amperes.into_iter().step_by(MOTOR.steps).take(MOTOR.rows);
    Log {
        path: format!("late by {delay} s").into(),
        period_s: MOTOR.period,
        input,
        position,
        current: current.then(|| currents.collect()),
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
