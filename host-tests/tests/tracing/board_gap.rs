//! The loop closed on the emulated chip's logs: what the firmware does not declare is found in them,
//! by the board itself and by the host from the board's CSV, with the same numbers.
//!
//! The firmware's application runs here on the host; `cargo hil test` shows that the emulated chip
//! sends the same bits.

use firmware::app::check::{self, Finding};
use firmware::app::demonstration::{EMULATION, UNDECLARED};
use firmware::app::experiment::{Experiment, Peculiarity};
use firmware::app::machine::{EMA, Machine as Onboard, THROTTLE};
use firmware::app::verdicts::{PLAY, ROUGH_SPOT, SOUND, TWO, VERDICTS, WARM};
use host_tests::app_on_host::AppOnHost;
use host_tests::board_log::{BoardLog, Line, Sample};
use host_tests::gap::declared;
use host_tests::gap::engine::{self, AllCores};
use host_tests::gap::outcome::Outcome;
use host_tests::log::Log;
use host_tests::machine::{DeclaredEffect, Machine};
use host_tests::workspace;
use model_core::gap::lengths;
use model_core::gap::model::{Base, Model};
use model_core::gap::replay::{Data, InOrder, Schedule};
use model_core::gap::verdict::{Consideration, Trace, Verdict};
use model_core::gap::workbench::Options;
use model_core::plant::parameters::Drive;

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
    std::fs::write(&path, board.recordings()[0].to_csv()).unwrap();
    Log::read(&path).unwrap()
}

fn traced(machine: &Machine, experiment: &Experiment) -> Outcome {
    let report = engine::run(machine, &[log(experiment)], || Ok(Vec::new()), |_| ());
    report.unwrap().outcome
}

/// What the board makes of its log, after the host has made the same of the board's CSV.
#[track_caller]
fn found_alike(experiment: &Experiment) -> Finding {
    let host = traced(&machine("ema-24v"), experiment);

    let mut app = AppOnHost::new();
    let _ = app.run(experiment);
    let log = app.memory.log(&EMA.converters);
    let board = check::check(&EMA, log).unwrap();

    assert_eq!(host.verdict, board.verdict);
    assert_eq!(host.effects.len(), board.effects.len());
    for (found, on_board) in host.effects.iter().zip(&board.effects) {
        let description = on_board.effect.id.description();
        assert_eq!(found.id, description.id);
        assert_eq!(found.p_value, on_board.p_value);
        assert_eq!(found.score as f32, on_board.score);
        assert_eq!(found.parameters.len(), description.reported.len());
        for (estimate, reported) in found.parameters.iter().zip(on_board.reported) {
            assert_eq!(estimate.value as f32, reported);
        }
    }
    let carried = host.unknown.as_ref().map(|unknown| &unknown.depends_on[..]);
    assert_eq!(carried, board.unknown);
    assert_eq!(host.fit.len(), board.fitted.len());
    for (number, (base, fitted)) in host.fit.iter().zip(&board.fitted) {
        assert_eq!(
            (&number.name[..], number.fitted as f32),
            (base.name(), *fitted)
        );
    }
    let errors = &host.errors.train;
    assert_eq!(errors.before.position_rms, board.before);
    assert_eq!(errors.after.position_rms, board.after);
    assert_eq!(host.cost.simulations, board.simulations);
    board
}

/// The ids of the effects in a finding.
fn ids(finding: &Finding) -> Vec<&'static str> {
    let found = finding.effects.iter();
    found
        .map(|found| found.effect.id.description().id)
        .collect()
}

#[test]
fn the_board_and_the_host_find_the_same_in_the_same_log() {
    let finding = found_alike(&UNDECLARED);
    assert_eq!(finding.verdict, Verdict::EffectsFound);
    assert_eq!(ids(&finding), ["asymmetric_viscous"]);
}

#[test]
fn both_find_the_play_before_the_sensor() {
    let finding = found_alike(&PLAY);
    assert_eq!(finding.verdict, Verdict::EffectsFound);
    assert_eq!(ids(&finding), ["backlash"]);
    let Some(Peculiarity::Play(width)) = PLAY.peculiarity else {
        panic!("{:?}", PLAY.peculiarity);
    };
    // Two counts of the encoder.
    let error = finding.effects[0].reported[0] - width;
    assert!(
        error.abs() < 2.0 * EMA.converters.position.unit(),
        "{error}"
    );
}

#[test]
#[ignore = "other cases"]
fn both_find_two_effects_at_once() {
    let finding = found_alike(&TWO);
    assert_eq!(finding.verdict, Verdict::EffectsFound);
    let mut found = ids(&finding);
    found.sort_unstable();
    assert_eq!(found, ["asymmetric_viscous", "backlash"]);
}

#[test]
fn both_call_a_rough_spot_unknown_by_position() {
    let finding = found_alike(&ROUGH_SPOT);
    assert_eq!(finding.verdict, Verdict::UnknownEffect);
    assert_eq!(finding.unknown, Some("position"));
}

#[test]
fn both_name_the_resistance_of_a_warm_winding() {
    let finding = found_alike(&WARM);
    assert_eq!(finding.verdict, Verdict::NoMissingEffect);
    let freed = &finding.fitted[check::BASE.len()..];
    let [(Base::Resistance, resistance)] = freed else {
        panic!("freed {freed:?}");
    };
    let Drive::Voltage {
        resistance: truth, ..
    } = WARM.actuator.drive
    else {
        panic!("{:?}", WARM.actuator.drive);
    };
    assert!((resistance / truth - 1.0).abs() < 0.005, "{resistance} Ω");
}

#[test]
fn both_find_nothing_where_nothing_is() {
    let finding = found_alike(&SOUND);
    assert_eq!(finding.verdict, Verdict::NoMissingEffect);
    assert_eq!(finding.fitted.len(), check::BASE.len());
}

/// Every look at every candidate, and what came of them, by a schedule.
fn looks(experiment: &Experiment, schedule: &impl Schedule) -> (Vec<Consideration>, Trace) {
    let mut app = AppOnHost::new();
    let _ = app.run(experiment);
    let logs = [app.memory.log(&EMA.converters)];
    let data = Data::new(&logs, EMA.converters.position.unit()).unwrap();
    let declared = declared::model(&machine("ema-24v")).unwrap();
    let options = Options::new(&data, &declared, &check::BASE, true).unwrap();
    let mut looks = Vec::new();
    let observe = |look: &Consideration| looks.push(*look);
    let trace = lengths::trace(&data, schedule, &declared, &options, observe).unwrap();
    (looks, trace)
}

/// The board replays window after window, the host sixteen at once on every core.
fn schedules_look_at_the_same(experiments: &[Experiment]) {
    for experiment in experiments {
        let (in_order, board) = looks(experiment, &InOrder);
        let (side_by_side, host) = looks(experiment, &AllCores);
        assert!(!in_order.is_empty(), "{}", experiment.name);
        // All bits, in the shortest words that tell them apart.
        let words = |looks: &[Consideration]| format!("{looks:?}");
        assert_eq!(
            words(&in_order),
            words(&side_by_side),
            "{}",
            experiment.name
        );
        for (board, host) in [(&board.before, &host.before), (&board.after, &host.after)] {
            assert_eq!(
                board.cost.to_bits(),
                host.cost.to_bits(),
                "{}",
                experiment.name
            );
            let words = |model: &Model| format!("{model:?}");
            assert_eq!(
                words(&board.model),
                words(&host.model),
                "{}",
                experiment.name
            );
        }
    }
}

#[test]
fn the_board_s_schedule_and_the_host_s_look_at_the_same_and_come_to_the_same() {
    schedules_look_at_the_same(&[PLAY]);
}

#[test]
#[ignore = "other cases"]
fn in_every_log_the_schedules_look_at_the_same_and_come_to_the_same() {
    schedules_look_at_the_same(&VERDICTS);
    schedules_look_at_the_same(&[UNDECLARED]);
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
