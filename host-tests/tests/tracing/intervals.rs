//! What the answer says of its own certainty, on logs of which the truth is known.

use std::collections::HashSet;

use host_tests::gap_benchmark::cases::{Case, Group, Motion};
use host_tests::gap_benchmark::trace_all;

/// Logs of a throttle: few of its windows hold a breakaway or a stop, and these decide the fit.
const LOGS: u64 = 20;

/// Of honest intervals 95 % hold the truth, of 60 numbers from 20 logs 52 or more; of intervals that are
/// too narrow by half two thirds.
const LEAST_SHARE: f64 = 0.87;

/// Half of all estimates are within 0.67 standard deviations of the truth. Twice as wide an interval
/// would have them within 0.34.
const LEAST_MEDIAN: f64 = 0.4;

#[test]
fn the_truth_is_as_far_off_as_the_answer_says() {
    let cases: Vec<Case> = (0..LOGS)
        .map(|index| Case {
            group: Group::Clean,
            rig: rig::Machine::throttle(),
            declared: None,
            effects: Vec::new(),
            strength: 1.0,
            motion: Motion::Sines,
            seed: 61_300 + index,
        })
        .collect();
    let directory = tempfile::tempdir().unwrap();
    let traced = trace_all(&cases, directory.path(), || ()).unwrap();
    let deviations = || traced.iter().flat_map(|traced| &traced.deviations);
    let names: HashSet<&str> = deviations().map(|found| found.name.as_str()).collect();
    assert_eq!(names, HashSet::from(["inertia", "viscous", "coulomb"]));
    let mut distances: Vec<f64> = deviations().map(|found| found.deviation.abs()).collect();
    distances.sort_by(f64::total_cmp);
    assert!(distances.len() > 50, "{}", distances.len());
    let within = distances.iter().filter(|distance| **distance < 1.96);
    let share = within.count() as f64 / distances.len() as f64;
    let median = distances[distances.len() / 2];
    assert!(share >= LEAST_SHARE, "{share} {distances:?}");
    assert!(median >= LEAST_MEDIAN, "{median} {distances:?}");
}
