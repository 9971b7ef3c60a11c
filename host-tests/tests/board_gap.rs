//! The loop closed on the emulated board's log: what the firmware does not declare is found in it.
//!
//! The firmware's application runs here on the host; `cargo hil test` shows that the emulated board
//! sends the same bits.

use firmware::app::machine::{ACTUATOR, DECLARED};
use firmware::app::timing::CONTROL_PERIOD;
use host_tests::app_on_host::AppOnHost;
use host_tests::gap::outcome::Verdict;
use host_tests::gap::{declared, engine};
use host_tests::hil::MACHINE;
use host_tests::log::Log;
use host_tests::machine::{DeclaredEffect, Machine};
use host_tests::workspace;

fn machine() -> Machine {
    Machine::read(&workspace::root().join(MACHINE)).unwrap()
}

#[test]
fn the_machine_file_is_what_the_firmware_declares() {
    assert_eq!(declared::model(&machine()).unwrap().plant, DECLARED);
}

/// The board's log as `cargo hil` reads it.
fn log() -> Log {
    let samples = AppOnHost::new().run();
    let column = |of: fn(&firmware::app::record::Sample) -> f32| -> Vec<f64> {
        samples.iter().map(|sample| f64::from(of(sample))).collect()
    };
    Log {
        path: "emulated.csv".into(),
        start_s: 0.0,
        period_s: (f64::from(CONTROL_PERIOD) * 1e6).round() * 1e-6,
        input: column(|sample| sample.input),
        position: column(|sample| sample.position),
        command: None,
        current: Some(column(|sample| sample.current)),
        velocity: Some(column(|sample| sample.velocity)),
    }
}

#[test]
fn nothing_is_found_once_the_friction_is_declared() {
    let mut machine = machine();
    let (forward, backward) = (ACTUATOR.viscous.forward, ACTUATOR.viscous.backward);
    machine.mechanics.viscous = 0.5 * f64::from(forward + backward);
    machine.declared_effects = vec![DeclaredEffect {
        id: "asymmetric_viscous".into(),
        parameters: [("difference".into(), 0.5 * f64::from(forward - backward))].into(),
        line: 1,
    }];
    let report = engine::run(&machine, &[log()], || Ok(Vec::new()), |_| ()).unwrap();
    assert_eq!(
        report.outcome.verdict,
        Verdict::NoMissingEffect,
        "{:?} {:?}",
        report.outcome.effects,
        report.outcome.unknown
    );
}

#[test]
fn direction_dependent_friction_is_found_in_the_boards_log() {
    let report = engine::run(&machine(), &[log()], || Ok(Vec::new()), |_| ()).unwrap();
    let outcome = report.outcome;
    assert_eq!(outcome.verdict, Verdict::EffectsFound);
    let [found] = &outcome.effects[..] else {
        panic!("not one effect: {:?}", outcome.effects);
    };
    assert_eq!(found.id, "asymmetric_viscous");
    let truth = [ACTUATOR.viscous.forward, ACTUATOR.viscous.backward];
    for (estimate, truth) in found.parameters.iter().zip(truth) {
        let truth = f64::from(truth);
        // The log is exact but for its rounding to f32.
        assert!(
            (estimate.value - truth).abs() < 0.01 * truth,
            "{estimate:?} for {truth}"
        );
    }
    let errors = &outcome.errors.train;
    assert!(errors.after.position_rms < 0.01 * errors.before.position_rms);
}
