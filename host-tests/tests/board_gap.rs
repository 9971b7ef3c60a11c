//! The loop closed on the emulated board's logs: what the firmware does not declare is found in them,
//! by the board itself and by the host from the board's CSV, with the same numbers.
//!
//! The firmware's application runs here on the host; `cargo hil test` shows that the emulated board
//! sends the same bits.

use firmware::app::check;
use firmware::app::demonstration::{EMULATION, UNDECLARED};
use firmware::app::experiment::Experiment;
use firmware::app::machine::{EMA, Machine as Onboard, THROTTLE};
use host_tests::app_on_host::AppOnHost;
use host_tests::board_log::{BoardLog, Line, Sample};
use host_tests::gap::outcome::Outcome;
use host_tests::gap::{declared, engine};
use host_tests::log::Log;
use host_tests::machine::{DeclaredEffect, Machine};
use host_tests::workspace;
use model_core::gap::verdict::Verdict;

fn machine(name: &str) -> Machine {
    let path = format!("host-tests/machines/{name}.toml");
    Machine::read(&workspace::root().join(path)).unwrap()
}

#[test]
fn the_machine_files_are_what_the_firmware_declares() {
    let files: [(&str, &Onboard); 2] = [("ema-24v", &EMA), ("throttle-12v", &THROTTLE)];
    for (name, onboard) in files {
        let file = machine(name);
        assert_eq!(declared::model(&file).unwrap().plant, onboard.plant);
        let resolution = file.resolution.unwrap() as f32;
        assert_eq!(resolution, onboard.converters.position.unit());
    }
    let fitted = declared::base_parameters(&machine("ema-24v"));
    assert_eq!(fitted, check::BASE);
}

/// The log of an experiment as the board sends it and `cargo hil decode` writes it.
fn log(experiment: &Experiment) -> Log {
    let (samples, _) = AppOnHost::new().run(experiment);
    let lines = samples.iter().map(|sample| Line {
        time: String::new(),
        level: String::new(),
        message: String::new(),
        sample: Some(Sample::new(sample, &experiment.machine.converters)),
    });
    let board = BoardLog {
        lines: lines.collect(),
        damaged: 0,
    };
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("board.csv");
    board.recordings()[0].write_csv(&path).unwrap();
    Log::read(&path).unwrap()
}

fn traced(machine: &Machine, experiment: &Experiment) -> Outcome {
    let report = engine::run(machine, &[log(experiment)], || Ok(Vec::new()), |_| ());
    report.unwrap().outcome
}

#[test]
fn the_board_and_the_host_find_the_same_in_the_same_log() {
    let host = traced(&machine("ema-24v"), &UNDECLARED);

    let mut app = AppOnHost::new();
    let _ = app.run(&UNDECLARED);
    let log = app.memory.log(&EMA.converters);
    let board = check::check(&EMA, log).unwrap();

    assert_eq!(board.verdict, Verdict::EffectsFound);
    assert_eq!(host.verdict, Verdict::EffectsFound);
    let [found] = &host.effects[..] else {
        panic!("not one effect: {:?}", host.effects);
    };
    assert_eq!(board.effects.len(), 1);
    let on_board = &board.effects[0];
    assert_eq!(found.id, on_board.effect.id.description().id);
    assert_eq!(found.id, "asymmetric_viscous");
    assert_eq!(found.p_value, on_board.p_value);
    assert_eq!(found.score as f32, on_board.score);
    for (estimate, reported) in found.parameters.iter().zip(on_board.reported) {
        assert_eq!(estimate.value as f32, reported);
    }
    let errors = &host.errors.train;
    assert_eq!(errors.before.position_rms, board.before);
    assert_eq!(errors.after.position_rms, board.after);
    assert_eq!(host.cost.simulations, board.simulations);
}

#[test]
fn direction_dependent_friction_is_found_in_the_boards_log() {
    let outcome = traced(&machine("ema-24v"), &UNDECLARED);
    let [found] = &outcome.effects[..] else {
        panic!("not one effect: {:?}", outcome.effects);
    };
    let viscous = UNDECLARED.actuator.viscous;
    for (estimate, truth) in found
        .parameters
        .iter()
        .zip([viscous.forward, viscous.backward])
    {
        let error = estimate.value - f64::from(truth);
        assert!(error.abs() < 4.0 * estimate.std, "{estimate:?} for {truth}");
    }
    let errors = &outcome.errors.train;
    assert!(errors.after.position_rms < 0.1 * errors.before.position_rms);
}

#[track_caller]
fn assert_nothing_is_found(machine: &Machine, experiment: &Experiment) {
    let outcome = traced(machine, experiment);
    assert_eq!(
        outcome.verdict,
        Verdict::NoMissingEffect,
        "{:?} {:?}",
        outcome.effects,
        outcome.unknown
    );
}

#[test]
fn nothing_is_found_once_the_friction_is_declared() {
    let mut machine = machine("ema-24v");
    let viscous = UNDECLARED.actuator.viscous;
    machine.mechanics.viscous = 0.5 * f64::from(viscous.forward + viscous.backward);
    machine.declared_effects = vec![DeclaredEffect {
        id: "asymmetric_viscous".into(),
        parameters: [(
            "difference".into(),
            0.5 * f64::from(viscous.forward - viscous.backward),
        )]
        .into(),
        line: 1,
    }];
    assert_nothing_is_found(&machine, &UNDECLARED);
}

#[test]
fn nothing_is_found_in_a_throttle_that_is_what_it_is_declared_to_be() {
    assert_nothing_is_found(&machine("throttle-12v"), &EMULATION);
}
