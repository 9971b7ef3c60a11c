//! A current that is measured with a wrong gain, an offset or a lag is said to be that, and no physics is named
//! for it.

use host_tests::gap::engine;
use host_tests::gap::outcome::{FittedParameter, Outcome};
use host_tests::gap_benchmark::cases::{Case, Group, Motion};
use host_tests::machine::Machine;
use model_core::gap::verdict::Verdict;
use std::fs;

/// What a logger makes of a current.
type Channel = fn(&mut Vec<f64>);

/// A log of a machine as its file declares it, whose current is read through a channel.
fn trace(rig: &rig::Machine, seed: u64, channel: Channel) -> Outcome {
    let case = Case {
        group: Group::Clean,
        rig: rig.clone(),
        declared: None,
        effects: Vec::new(),
        strength: 1.0,
        motion: Motion::Sines,
        seed,
    };
    let mut log = case.log();
    channel(log.current.as_mut().unwrap());
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("machine.toml");
    fs::write(&path, rig.to_toml()).unwrap();
    let machine = Machine::read(&path).unwrap();
    let report = engine::run(&machine, &[log], || Ok(Vec::new()), |_| ()).unwrap();
    report.outcome
}

/// What is said of the channel.
fn of_channel(outcome: &Outcome) -> Vec<&FittedParameter> {
    let said = outcome.fit.iter();
    said.filter(|fit| fit.name.starts_with("current_"))
        .collect()
}

fn machines() -> [rig::Machine; 2] {
    [rig::Machine::rotary_ema(), rig::Machine::throttle()]
}

/// What was done to the current, its number in the answer, and the value that it must have to a tenth.
const CHANNELS: [(&str, f64, Channel); 4] = [
    ("current_gain_error", 0.04, |current| {
        current.iter_mut().for_each(|current| *current *= 1.04);
    }),
    ("current_gain_error", -0.03, |current| {
        current.iter_mut().for_each(|current| *current *= 0.97);
    }),
    ("current_offset", 0.05, |current| {
        current.iter_mut().for_each(|current| *current += 0.05);
    }),
    ("current_lag", 1e-3, |current| {
        current.rotate_right(1);
        current[0] = current[1];
    }),
];

#[test]
fn a_channel_that_errs_is_said_by_its_number_and_nothing_is_named_for_it() {
    for (machine, rig) in machines().iter().enumerate() {
        for (place, (name, expected, channel)) in CHANNELS.into_iter().enumerate() {
            let seed = 73_100 + 10 * machine as u64 + place as u64;
            let outcome = trace(rig, seed, channel);
            let said = format!("{} {name} {expected}: {outcome:?}", rig.name);
            assert_eq!(outcome.verdict, Verdict::NoMissingEffect, "{said}");
            assert_eq!(outcome.freed().count(), 0, "{said}");
            let number = of_channel(&outcome).into_iter().find(|it| it.name == name);
            let fitted = number.unwrap_or_else(|| panic!("{said}")).fitted;
            assert!((fitted / expected - 1.0).abs() < 0.1, "{said}");
        }
    }
}

#[test]
fn of_an_ideal_channel_nothing_is_said() {
    for (machine, rig) in machines().iter().enumerate() {
        let outcome = trace(rig, 73_150 + machine as u64, |_| ());
        assert_eq!(outcome.verdict, Verdict::NoMissingEffect, "{outcome:?}");
        assert!(of_channel(&outcome).is_empty(), "{outcome:?}");
    }
}
