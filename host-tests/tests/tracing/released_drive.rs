//! A drive that lets go of a geared motor now and then, as drives do on a fault or between two jobs: the machine coasts,
//! whatever the logged input says.

use host_tests::gap::engine;
use host_tests::gap::outcome::Outcome;
use host_tests::log::Log;
use model_core::gap::verdict::Verdict;

use crate::stepped::{COUNTS, GEARMOTOR, gearmotor};

const RESISTANCE: f64 = 4.7;
const TORQUE_CONSTANT: f64 = 1.316;

/// Rows in which the drive lets go: 0.3 s of every 1.4 s.
fn is_released(row: usize) -> bool {
    row % 700 >= 550
}

fn log(phases: [f64; 4]) -> Log {
    let mut steps = 0;
    let log = GEARMOTOR.log("released", phases, 0, |volts, _, velocity| {
        let row = steps / GEARMOTOR.steps;
        steps += 1;
        let flow = if is_released(row) {
            0.0
        } else {
            (volts - TORQUE_CONSTANT * velocity) / RESISTANCE
        };
        (TORQUE_CONSTANT * flow, flow)
    });
    let enabled = |row| if is_released(row) { 0.0 } else { 1.0 };
    Log {
        enabled: Some((0..GEARMOTOR.rows).map(enabled).collect()),
        ..log
    }
}

fn trace(log: Log) -> Outcome {
    let machine = gearmotor([RESISTANCE, 0.0, TORQUE_CONSTANT], COUNTS, "");
    engine::run(&machine, &[log], || Ok(Vec::new()), |_| ())
        .unwrap()
        .outcome
}

/// `current`: whether it is logged.
fn a_drive_that_lets_go_is_no_effect(current: bool) {
    let known = Log {
        current: log([0.3, 1.9, 4.0, 5.5]).current.filter(|_| current),
        ..log([0.3, 1.9, 4.0, 5.5])
    };
    let unsaid = Log {
        enabled: None,
        ..known.clone()
    };
    let outcome = trace(known);
    assert_eq!(outcome.verdict, Verdict::NoMissingEffect, "{outcome:?}");
    for (name, truth) in [
        ("inertia", GEARMOTOR.inertia),
        ("viscous", GEARMOTOR.viscous),
        ("coulomb", GEARMOTOR.coulomb),
    ] {
        let number = outcome.fit.iter().find(|it| it.name == name).unwrap();
        let off = number.fitted / truth - 1.0;
        assert!(off.abs() < 0.05, "current {current}, {name}: {number:?}");
    }
    let outcome = trace(unsaid);
    assert_ne!(outcome.verdict, Verdict::NoMissingEffect, "{outcome:?}");
}

#[test]
fn a_drive_that_lets_go_is_no_effect_where_the_log_says_when() {
    a_drive_that_lets_go_is_no_effect(true);
}

#[test]
#[ignore = "other cases"]
fn without_a_current_too_a_drive_that_lets_go_is_no_effect_where_the_log_says_when() {
    a_drive_that_lets_go_is_no_effect(false);
}
