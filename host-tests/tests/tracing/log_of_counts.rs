//! A board keeps its log as a ring of counts and traces it on one core, a host has values and all
//! cores: both must find the same, to the bit, and the program must report it.

use std::f32::consts::TAU;

use host_tests::gap::declared;
use host_tests::gap::engine::{self, AllCores};
use host_tests::log::Log;
use host_tests::machine::Machine;
use model_core::gap::lengths;
use model_core::gap::log::{Channel, Log as CoreLog};
use model_core::gap::model::Base;
use model_core::gap::replay::{Data, InOrder, Schedule, total_error};
use model_core::gap::workbench::Options;
use rig::{Effect, EffectKind, Experiment, Machine as RigMachine, Trajectory};

/// One count of input, position and current: V, rad and A.
const UNITS: [f32; 3] = [24.0 / 4200.0, TAU / 16384.0, 25.0 / 2048.0];

const PERIOD: f32 = 1e-3;

/// A log of 4 s, as counts, of a machine whose friction depends on the direction.
fn counts(machine: &RigMachine) -> [Vec<i16>; 3] {
    let effect = Effect::nominal(EffectKind::AsymmetricViscous, machine);
    let recording = Experiment::tracking(machine.clone(), Trajectory::sweep(machine, 4.0))
        .with_effects(&[effect])
        .lasting(4.0)
        .seeded(4001)
        .run();
    let series = [recording.input, recording.position, recording.current];
    let count = |value: f64, unit: f32| (value / f64::from(unit)).round() as i16;
    std::array::from_fn(|channel| {
        let values = series[channel].iter();
        values.map(|&value| count(value, UNITS[channel])).collect()
    })
}

/// What the tracing finds in a log.
#[derive(Debug, PartialEq)]
struct Found {
    /// All of it, and what is said on the way. A number printed in full is another one wherever a
    /// bit is.
    text: String,
    /// Windowed position error of the three models.
    position_rms: [f64; 3],
}

fn traced(
    declared: &Machine,
    [input, position, current]: [Channel; 3],
    schedule: &impl Schedule,
) -> Found {
    let log = CoreLog {
        current: Some(current),
        ..CoreLog::new(PERIOD, input, position)
    };
    let model = declared::model(declared).unwrap();
    let logs = [log];
    let data = Data::new(&logs, declared.resolution.unwrap() as f32).unwrap();
    let base = [Base::Inertia, Base::Viscous, Base::Coulomb, Base::Static];
    let options = Options::new(&data, &model, &base, true).unwrap();
    let mut looks = Vec::new();
    let trace = lengths::trace(&data, schedule, &model, &options, |look| looks.push(*look));
    let trace = trace.unwrap();
    assert!(!trace.accepted.is_empty(), "{looks:?}");
    let judged = Data {
        settings: trace.settings,
        ..data
    };
    let models = [&model, &trace.before.model, &trace.after.model];
    Found {
        text: format!("{trace:?} {looks:?}"),
        position_rms: models.map(|model| {
            let simulator = model.build(PERIOD).unwrap();
            total_error(&judged, schedule, &simulator).position_rms()
        }),
    }
}

#[test]
fn a_ring_of_counts_is_traced_as_its_values_are() {
    let machine = RigMachine::rotary_ema();
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("machine.toml");
    std::fs::write(&file, machine.to_toml()).unwrap();
    let declared = Machine::read(&file).unwrap();

    let counts = counts(&machine);
    let values: [Vec<f32>; 3] = std::array::from_fn(|channel| {
        let values = counts[channel].iter();
        values.map(|&c| f32::from(c) * UNITS[channel]).collect()
    });
    // The ring's newest sample lies somewhere in the middle of a window.
    let ring = std::array::from_fn(|channel| {
        let (older, newer) = counts[channel].split_at(1537);
        Channel::Counts {
            older,
            newer,
            unit: UNITS[channel],
        }
    });
    let slices = std::array::from_fn(|channel| Channel::Values(&values[channel]));
    let on_board = traced(&declared, ring, &InOrder);
    assert_eq!(on_board, traced(&declared, slices, &AllCores));

    let [input, position, current] =
        values.map(|values| values.into_iter().map(f64::from).collect::<Vec<f64>>());
    let log = Log {
        path: "counts.csv".into(),
        start_s: 0.0,
        period_s: f64::from(PERIOD),
        input,
        position,
        command: None,
        current: Some(current),
        ..Log::default()
    };
    let outcome = engine::run(&declared, &[log], || Ok(Vec::new()), |_| ()).unwrap();
    let errors = outcome.outcome.errors.train;
    let reported = [errors.declared, errors.before, errors.after].map(|e| e.position_rms);
    assert_eq!(on_board.position_rms, reported);
}
