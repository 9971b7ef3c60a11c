//! A board keeps its log as a ring of counts and traces it on one core, a host has values and all
//! cores: both must find the same, to the bit.

use std::f32::consts::TAU;

use host_tests::gap::declared;
use host_tests::gap::engine::AllCores;
use host_tests::machine::Machine;
use model_core::gap::log::{Channel, Log};
use model_core::gap::model::Base;
use model_core::gap::replay::{Data, InOrder, Schedule, Settings};
use model_core::gap::select;
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

/// All that the tracing finds in a log, and what it says on the way. A number printed in full is
/// another one wherever a bit is.
fn traced(
    declared: &Machine,
    [input, position, current]: [Channel; 3],
    schedule: &impl Schedule,
) -> String {
    let log = Log {
        period: PERIOD,
        input,
        position,
        current: Some(current),
        velocity: None,
    };
    let model = declared::model(declared).unwrap();
    let data = Data {
        logs: &[log],
        settings: Settings::new(PERIOD, UNITS[1]),
    };
    let base = [Base::Inertia, Base::Viscous, Base::Coulomb, Base::Static];
    let options = Options::new(&data, &model, &base, true).unwrap();
    let mut looks = Vec::new();
    let trace = select::trace(&data, schedule, &model, &options, |look| looks.push(*look));
    let trace = trace.unwrap();
    assert!(!trace.accepted.is_empty(), "{looks:?}");
    format!("{trace:?} {looks:?}")
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
    let values = std::array::from_fn(|channel| Channel::Values(&values[channel]));
    assert_eq!(
        traced(&declared, ring, &InOrder),
        traced(&declared, values, &AllCores)
    );
}
