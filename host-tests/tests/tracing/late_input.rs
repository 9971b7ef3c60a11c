//! A logger that takes down what the loop wrote a row before: each input acted earlier than the log has it. That is said, the
//! numbers are those of the machine, and nothing else is made of it.

use host_tests::gap::engine;
use host_tests::gap::headline::Headline;
use host_tests::gap::outcome::Report;
use host_tests::log::Log;

use crate::stepped::{COUNTS, GEARMOTOR, gearmotor};

const RESISTANCE: f64 = 4.0;
const TORQUE_CONSTANT: f64 = 1.4;

/// A log of a geared motor with a weight at its shaft of so much torque at a right angle; its input is so many rows late.
fn log(rows: usize, weight: f64, phases: [f64; 4]) -> Log {
    let path = format!("late by {rows} rows");
    let mut log = GEARMOTOR.log_of_position(&path, phases, |volts, position, velocity| {
        let flow = (volts - TORQUE_CONSTANT * velocity) / RESISTANCE;
        TORQUE_CONSTANT * flow - weight * position.sin()
    });
    log.input.rotate_right(rows);
    log.input[..rows].fill(0.0);
    log
}

/// The answer to such a log, which finds these effects. What it says that it took is what it ends with: nothing that was taken
/// before the input turned out late is left.
fn trace(rows: usize, (weight, effects): (f64, &[&str])) -> Report {
    let machine = gearmotor([4.0, 0.0, 1.4], COUNTS, "");
    let train = log(rows, weight, [0.3, 1.9, 4.0, 5.5]);
    let other = log(rows, weight, [2.2, 0.4, 5.1, 1.0]);
    let report = engine::run(&machine, &[train], || Ok(vec![other]), |_| ()).unwrap();
    let outcome = &report.outcome;
    let named: Vec<&str> = outcome.effects.iter().map(|it| it.id.as_str()).collect();
    assert_eq!(named, effects, "{outcome:?}");
    let looks = outcome.candidates.iter().filter(|look| look.accepted);
    let taken: Vec<&str> = looks.map(|look| look.id.as_str()).collect();
    let lead = outcome.input_lead.iter().map(|lead| lead.name.as_str());
    let expected: Vec<&str> = lead.chain(effects.iter().copied()).collect();
    assert_eq!(taken, expected, "{outcome:?}");
    report
}

/// Weights, each with the effects that are to be found.
const WEIGHTS: [(f64, &[&str]); 2] = [(0.0, &[]), (0.4, &["gravity"])];

#[test]
fn an_input_that_is_a_row_late_is_said_and_is_no_effect_and_no_wrong_number() {
    for case in WEIGHTS {
        let report = trace(1, case);
        let outcome = &report.outcome;
        assert_eq!(outcome.freed().count(), 0, "{outcome:?}");
        let lead = outcome.input_lead.as_ref().expect("the input is late");
        let period = GEARMOTOR.period;
        assert!((lead.value / period - 1.0).abs() < 0.1, "{lead:?}");
        let said = format!("{:?}", Headline::of(&report));
        assert!(said.contains("The log has each input"), "{said}");
        let inertia = outcome.fit.iter().find(|it| it.name == "inertia").unwrap();
        let error = (inertia.fitted / GEARMOTOR.inertia - 1.0).abs();
        assert!(error < 0.02, "{inertia:?}");
    }
}

#[test]
fn an_input_in_its_row_is_not_called_late() {
    for case in WEIGHTS {
        let outcome = trace(0, case).outcome;
        assert!(outcome.input_lead.is_none(), "{outcome:?}");
    }
}
