//! Logs of one machine that differ among themselves, and a log of another machine among them.

use host_tests::gap::engine;
use host_tests::gap::headline::{Headline, Step};
use host_tests::gap::outcome::Report;
use host_tests::log::Log;
use host_tests::machine::Machine;
use rig::{Experiment, Machine as RigMachine, Trajectory};

/// Length of a log, s.
const SECONDS: f64 = 10.0;

/// What is said of a validation log of another machine than the one that was trained on.
fn traced(trained: &RigMachine, other: &RigMachine, seed: u64) -> Report {
    let directory = tempfile::tempdir().unwrap();
    let write = |name: &str, text: String| {
        let path = directory.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let log = |name: &str, machine: &RigMachine, motion: Trajectory| {
        let experiment = Experiment::tracking(machine.clone(), motion);
        let recording = experiment.lasting(SECONDS).seeded(seed).run();
        Log::read(&write(name, recording.to_csv())).unwrap()
    };
    let machine = Machine::read(&write("machine.toml", trained.to_toml())).unwrap();
    let train = [log(
        "train.csv",
        trained,
        Trajectory::sweep(trained, SECONDS),
    )];
    let validate = vec![log("validate.csv", other, Trajectory::sines(other))];
    engine::run(&machine, &train, || Ok(validate), |_| ()).unwrap()
}

/// The numbers that are said to differ, with the share of what the training log has and its standard deviation.
fn differences(report: &Report) -> Vec<(&str, f64, f64)> {
    let logs = report.outcome.between_logs.iter();
    let numbers = logs.flat_map(|log| &log.numbers);
    let shares = numbers.map(|it| {
        let share = 1.0 / it.trained;
        (it.name.as_str(), share * it.difference, share * it.std)
    });
    shares.collect()
}

fn machines() -> [RigMachine; 2] {
    [RigMachine::force_slide(), RigMachine::rotary_ema()]
}

#[test]
fn two_logs_of_one_machine_differ_in_nothing() {
    for machine in machines() {
        let report = traced(&machine, &machine, 81_100);
        assert_eq!(differences(&report), [], "{}", machine.name);
        // What a free run of it is off by is told beside it.
        let costs = &report.outcome.free_run_costs;
        assert!(costs.len() == 2 && costs.iter().all(|cost| cost.position_rms > 0.0));
    }
}

/// A changed friction is told with its size, and what the model leaves with it is what it leaves on a log without it.
#[test]
fn friction_that_has_risen_is_told_as_that() {
    for machine in machines() {
        let mut stiffer = machine.clone();
        stiffer.coulomb *= 1.1;
        stiffer.static_friction *= 1.1;
        let report = traced(&machine, &stiffer, 81_200);
        let told = differences(&report);
        let [("coulomb", share, std)] = told[..] else {
            panic!("{}: {told:?}", machine.name);
        };
        assert!(
            (share - 0.1).abs() < 3.0 * std,
            "{}: {told:?}",
            machine.name
        );
        // What is left with it is the sensor's.
        let log = &report.outcome.between_logs[0];
        let floor = report.outcome.residual.unwrap().floor;
        assert!(log.position_rms_with < 3.0 * floor, "{log:?} {floor}");
        let details = Headline::of(&report).details;
        let (_, sentence) = details
            .iter()
            .find(|(of, _)| of.ends_with("validate.csv"))
            .unwrap();
        assert!(sentence.contains("Coulomb friction") && sentence.contains("higher"));
        assert!(!sentence.contains("the same machine"), "{sentence}");
    }
}

/// What no machine changes from log to log makes the answer ask whether it is one machine.
#[test]
fn a_log_of_another_machine_is_doubted() {
    for machine in machines() {
        let mut heavier = machine.clone();
        heavier.inertia *= 1.6;
        let report = traced(&machine, &heavier, 81_300);
        let told = differences(&report);
        let (name, share, std) = told[0];
        assert_eq!(name, "inertia", "{}: {told:?}", machine.name);
        assert!((share - 0.6).abs() < 3.0 * std + 0.02, "{told:?}");
        let details = Headline::of(&report).details;
        let (_, sentence) = details
            .iter()
            .find(|(of, _)| of.ends_with("validate.csv"))
            .unwrap();
        assert!(sentence.contains("the same machine"), "{sentence}");
    }
}

/// One worn log among those that are trained on makes all of them differ from what is fitted to them together.
#[test]
fn a_worn_log_among_the_training_logs_is_named() {
    let new = RigMachine::force_slide();
    let mut worn = new.clone();
    worn.coulomb *= 1.3;
    worn.static_friction *= 1.3;
    let directory = tempfile::tempdir().unwrap();
    let write = |name: &str, text: String| {
        let path = directory.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let log = |name: &str, machine: &RigMachine, seed: u64| {
        let motion = Trajectory::sweep(machine, SECONDS);
        let experiment = Experiment::tracking(machine.clone(), motion);
        let recording = experiment.lasting(SECONDS).seeded(seed).run();
        Log::read(&write(name, recording.to_csv())).unwrap()
    };
    let machine = Machine::read(&write("machine.toml", new.to_toml())).unwrap();
    let train = [
        log("a.csv", &new, 81_401),
        log("b.csv", &worn, 81_402),
        log("c.csv", &new, 81_403),
    ];
    let report = engine::run(&machine, &train, || Ok(Vec::new()), |_| ()).unwrap();
    assert!(report.outcome.between_logs.iter().all(|log| log.trained_on));
    let headline = Headline::of(&report);
    assert!(
        headline
            .finding
            .contains("b.csv differs from the other training logs in Coulomb friction"),
        "{headline:?}"
    );
    let without = "run it again without ";
    assert!(
        matches!(&headline.next[0], Step::Do(step) if step.starts_with(without) && step.contains("b.csv")),
        "{headline:?}"
    );
}
