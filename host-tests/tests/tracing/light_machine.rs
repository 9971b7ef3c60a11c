//! A bare rotor of 3 g·cm² at a spring whose torque grows with the cube of the angle, which no effect of the catalogue does.
//! Restarted every 0.2 s the model without the spring is a third of the stroke off, and its fit is lost; over a
//! shorter time what is missing is plain.

use host_tests::gap::engine;
use host_tests::log::Log;
use host_tests::machine::Machine;
use model_core::gap::verdict::Verdict;

use crate::stepped::{Stepped, torque_driven};

/// The rotor that it is, in steps of 20 µs.
const ROTOR: Stepped<3> = Stepped {
    inertia: 3.0e-6,
    viscous: 5.7e-5,
    coulomb: 2.1e-4,
    breakaway: 2.2e-4,
    count: 9.6e-5,
    period: 0.001,
    steps: 50,
    rows: 7000,
    frequencies: [0.4, 1.1, 2.3],
    amplitudes: [0.6, 0.3, 0.15],
    gains: [0.01, 0.05, 2.0e-4],
    limit: 0.01,
};

/// `spring`: its torque at 1 rad, N·m.
fn log(spring: f64, phases: [f64; 3]) -> Log {
    let torque = |acting: f64, position: f64, _: f64| acting - spring * position.powi(3);
    ROTOR.log_of_position(&format!("spring of {spring} N·m"), phases, torque)
}

fn light() -> Machine {
    let fit = ["viscous", "coulomb", "static"];
    torque_driven([3.0e-6, 3.0e-5], [3.3e-4, 3.3e-4], ROTOR.count, &fit)
}

#[test]
fn where_nothing_is_proven_over_long_windows_a_law_is_found_over_shorter_ones() {
    let train = log(1.4e-3, [1.0, 2.5, 0.2]);
    let other = log(1.4e-3, [2.2, 0.4, 5.1]);
    let outcome = engine::run(&light(), &[train], || Ok(vec![other]), |_| ())
        .unwrap()
        .outcome;
    assert_eq!(outcome.verdict, Verdict::UnknownEffect, "{outcome:?}");
    let unknown = outcome.unknown.expect("structure");
    assert_eq!(unknown.depends_on, "position");
    let errors = outcome.errors.validate.unwrap();
    assert!(errors.after.window_s < 0.2, "{errors:?}");
    // Half of the mean square: the map is straight between its knots.
    let ratio = errors.remaining();
    assert!(ratio < 0.5_f64.sqrt(), "{ratio} of the error is left");
}

#[test]
fn a_light_machine_without_the_law_is_given_none() {
    let train = log(0.0, [0.3, 1.9, 4.0]);
    let outcome = engine::run(&light(), &[train], || Ok(Vec::new()), |_| ())
        .unwrap()
        .outcome;
    assert!(outcome.effects.is_empty(), "{outcome:?}");
    assert!(outcome.unknown.is_none(), "{outcome:?}");
}
