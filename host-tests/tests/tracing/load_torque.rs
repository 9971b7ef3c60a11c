//! A load that a log has as `load_torque` is known, and no effect.

use std::fmt::Write as _;

use host_tests::gap::engine;
use host_tests::gap::outcome::Outcome;
use host_tests::log::Log;
use host_tests::machine::Machine;
use model_core::gap::verdict::Verdict;
use rig::{Effect, Experiment, Machine as RigMachine, Recording, Trajectory};

/// Length of a log, s.
const SECONDS: f64 = 10.0;

/// From when to when the machine is loaded, s: the middles of the ramps.
const LOADED: (f64, f64) = (3.7, 6.3);

/// Length of a ramp, s.
const RAMP: f64 = 0.02;

/// A quarter of the machine's Coulomb friction, towards positive motion.
fn torque(machine: &RigMachine) -> f64 {
    0.25 * machine.coulomb
}

/// A recording of the loaded machine, made by the rig's own integrator.
fn recording(machine: &RigMachine, seed: u64) -> Recording {
    let load = Effect::ExternalLoad {
        torque: torque(machine),
        begin: LOADED.0,
        duration: LOADED.1 - LOADED.0,
        ramp: RAMP,
    };
    Experiment::tracking(machine.clone(), Trajectory::sweep(machine, SECONDS))
        .with_effects(&[load])
        .lasting(SECONDS)
        .seeded(seed)
        .run()
}

/// The recording with the load as a sensor beside it has it: against positive motion.
fn with_load(recording: &Recording, torque: f64) -> String {
    let risen = |time: f64, middle: f64| ((time - middle) / RAMP + 0.5).clamp(0.0, 1.0);
    let csv = recording.to_csv();
    let mut lines = csv.lines();
    let mut text = format!("{},load_torque\n", lines.next().unwrap());
    for (line, time) in lines.zip(&recording.time) {
        let load = -torque * (risen(*time, LOADED.0) - risen(*time, LOADED.1));
        writeln!(text, "{line},{load:.9}").unwrap();
    }
    text
}

fn trace(machine: &RigMachine, csv: &str) -> Outcome {
    let directory = tempfile::tempdir().unwrap();
    let (file, path) = (
        directory.path().join("machine.toml"),
        directory.path().join("log.csv"),
    );
    std::fs::write(&file, machine.to_toml()).unwrap();
    std::fs::write(&path, csv).unwrap();
    let machine = Machine::read(&file).unwrap();
    let log = Log::read(&path).unwrap();
    engine::run(&machine, &[log], || Ok(Vec::new()), |_| ())
        .unwrap()
        .outcome
}

fn a_measured_load_is_no_effect(machine: &RigMachine, seed: u64) {
    let recording = recording(machine, seed);
    let unknown = trace(machine, &recording.to_csv());
    let names: Vec<&str> = unknown.effects.iter().map(|it| &*it.id).collect();
    assert_eq!(names, ["external_load"], "{}", machine.name);
    let known = trace(machine, &with_load(&recording, torque(machine)));
    assert_eq!(
        known.verdict,
        Verdict::NoMissingEffect,
        "{}: {:?}",
        machine.name,
        known.effects
    );
    // The wrong sign doubles the load.
    let doubled = trace(machine, &with_load(&recording, -torque(machine)));
    let [found] = &doubled.effects[..] else {
        panic!("{}: {:?}", machine.name, doubled.effects);
    };
    let strength = found.parameters[0].value;
    assert!(
        (strength / (2.0 * torque(machine)) - 1.0).abs() < 0.1,
        "{found:?}"
    );
}

#[test]
fn a_measured_load_is_no_effect_and_an_unmeasured_one_is() {
    a_measured_load_is_no_effect(&RigMachine::rotary_ema(), 5301);
}

#[test]
#[ignore = "other cases"]
fn a_measured_load_of_a_slide_is_no_effect_and_an_unmeasured_one_is() {
    a_measured_load_is_no_effect(&RigMachine::force_slide(), 5302);
}
