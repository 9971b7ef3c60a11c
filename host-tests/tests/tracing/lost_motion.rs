//! What tells lost motion from everything else is what a reading does at a reversal: it stays, for as long as
//! the drive takes up the play, and follows unchanged from then on. Logs that are mostly that, and logs in
//! which something else moves a reading.

use std::ops::Range;

use host_tests::gap::engine;
use host_tests::gap::outcome::{Candidate, Outcome};
use host_tests::gap_benchmark::cases::{self, Case, Group, Motion};
use host_tests::log::Log;
use host_tests::machine::Machine;
use model_core::gap::verdict::Verdict;
use rig::{Effect, EffectKind, Experiment, Trajectory};

/// Shortest periods of the triangles, s: two dozen turns, and ten.
const PERIODS: [f64; 2] = [0.9, 2.4];

/// What is found in a log of turns between constant speeds, two in so many seconds.
fn traced(rig: &rig::Machine, effect: Effect, shortest: f64, seed: u64) -> Outcome {
    let amplitude = 0.4 * rig.amplitude();
    let trajectory = Trajectory::Triangle {
        centre: rig.centre(),
        amplitude,
        period: (4.0 * amplitude / rig.speed).max(shortest),
    };
    let recording = Experiment::tracking(rig.clone(), trajectory)
        .with_effects(&[effect])
        .lasting(12.0)
        .seeded(seed)
        .run();
    let directory = tempfile::tempdir().unwrap();
    let [file, csv] = ["machine.toml", "log.csv"].map(|name| directory.path().join(name));
    std::fs::write(&file, rig.to_toml()).unwrap();
    std::fs::write(&csv, recording.to_csv()).unwrap();
    let machine = Machine::read(&file).unwrap();
    let log = Log::read(&csv).unwrap();
    let report = engine::run(&machine, &[log], || Ok(Vec::new()), |_| ()).unwrap();
    report.outcome
}

fn named(outcome: &Outcome) -> Vec<&str> {
    outcome.effects.iter().map(|found| &*found.id).collect()
}

/// Of lost motion alone, in a log of these turns.
fn is_measured(rig: &rig::Machine, strength: f64, shortest: f64, seed: u64) {
    let effect = Effect::nominal(EffectKind::Backlash, rig).scaled(strength);
    let Effect::Backlash { width } = effect else {
        panic!("{effect:?}");
    };
    let outcome = traced(rig, effect, shortest, seed);
    let said = format!(
        "{} {strength} {shortest} s: {:?}",
        rig.name, outcome.effects
    );
    assert_eq!(named(&outcome), ["backlash"], "{said}");
    // The sensor does not see where within a count a plateau lies.
    let off = outcome.effects[0].parameters[0].value - width;
    let limit = rig.resolution + 0.02 * width;
    assert!(off.abs() < limit, "{off} of {width} off: {said}");
}

/// Each machine with one of two widths, from one to the next with the other; or with the one that is left.
fn its_width_is_measured(at_length: bool) {
    for (place, rig) in cases::machines().iter().enumerate() {
        for (column, strength) in [1.0, 3.0].into_iter().enumerate() {
            if at_length == (column == place % 2) {
                continue;
            }
            is_measured(rig, strength, PERIODS[0], 74_100 + place as u64);
        }
    }
}

#[test]
fn its_width_is_measured_on_plateaus() {
    its_width_is_measured(false);
}

#[test]
#[ignore = "other cases"]
fn other_widths_are_measured_on_plateaus() {
    its_width_is_measured(true);
}

/// Too few plateaus for ranks to prove it. The throttle needs more of them.
fn a_width_is_measured_on_ten_turns(seeds: Range<u64>) {
    let [ema, _, slide] = cases::machines();
    for seed in seeds {
        is_measured(&ema, 1.0, PERIODS[1], seed);
        is_measured(&slide, 1.0, PERIODS[1], seed);
    }
}

#[test]
fn ten_turns_are_enough() {
    a_width_is_measured_on_ten_turns(74_120..74_121);
}

#[test]
#[ignore = "other cases"]
fn ten_turns_of_other_logs_are_enough() {
    a_width_is_measured_on_ten_turns(74_121..74_123);
}

/// A sensor rounds by half a count both ways, at the same places again and again: nothing but that, and in
/// one log of many it looks like a play of a third of a count.
#[test]
fn what_is_less_than_half_a_count_is_the_sensors_rounding() {
    let case = Case {
        group: Group::Clean,
        rig: rig::Machine::rotary_ema(),
        declared: None,
        effects: Vec::new(),
        strength: 1.0,
        motion: Motion::Moves,
        seed: 20_261_755,
    };
    let directory = tempfile::tempdir().unwrap();
    let machine = case.machine_file(directory.path()).unwrap();
    let report = engine::run(&machine, &[case.log()], || Ok(Vec::new()), |_| ()).unwrap();
    let outcome = report.outcome;
    let backlash = |look: &&Candidate| look.id == "backlash";
    let look = outcome.candidates.iter().find(backlash).unwrap();
    assert!(look.reason.contains("half a count"), "{}", look.reason);
    assert_eq!(
        outcome.verdict,
        Verdict::NoMissingEffect,
        "{:?}",
        outcome.effects
    );
}

/// A late reading, bristles, a shaft that winds up and an encoder that is not centred move a reading about
/// as far as a play does.
/// `is_looked_at`: by the places of machine, kind and period.
fn what_moves_a_reading_otherwise(is_looked_at: impl Fn(usize, usize, usize) -> bool) {
    let kinds = [
        EffectKind::SensorDelay,
        EffectKind::Presliding,
        EffectKind::Compliance,
        EffectKind::EncoderEccentricity,
    ];
    for (place, rig) in cases::machines().iter().enumerate() {
        for (row, kind) in kinds.into_iter().enumerate() {
            for (column, shortest) in PERIODS.into_iter().enumerate() {
                if !is_looked_at(place, row, column) {
                    continue;
                }
                let effect = Effect::nominal(kind, rig);
                let outcome = traced(rig, effect, shortest, 74_200 + place as u64);
                let named = named(&outcome);
                assert!(
                    !named.contains(&"backlash"),
                    "{kind:?} on {}, {shortest} s: {named:?}",
                    rig.name
                );
            }
        }
    }
}

/// Every kind, machine and period, not each with each.
fn is_one_of_each_kind(place: usize, row: usize, column: usize) -> bool {
    [(0, 0), (1, 1), (1, 0), (2, 1)][row] == (place, column)
}

fn is_one_in_three(place: usize, row: usize, column: usize) -> bool {
    (place + row + column).is_multiple_of(3)
}

#[test]
fn what_moves_a_reading_otherwise_is_none() {
    what_moves_a_reading_otherwise(is_one_of_each_kind);
}

#[test]
#[ignore = "other cases"]
fn what_moves_other_readings_otherwise_is_none() {
    what_moves_a_reading_otherwise(|place, row, column| {
        let is_looked_at = !is_one_of_each_kind(place, row, column);
        is_looked_at && is_one_in_three(place, row, column)
    });
}

#[test]
#[ignore = "at length"]
fn what_moves_any_reading_otherwise_is_none() {
    what_moves_a_reading_otherwise(|_, _, _| true);
}
