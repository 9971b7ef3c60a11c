//! What is found is fitted as well as a fit from the truth: the cost has many small valleys, for a window
//! in which the machine sticks where it slid makes it jump.

use host_tests::gap_benchmark::cases::{Case, Group, Motion};
use host_tests::gap_benchmark::judgement::Judgement;
use host_tests::gap_benchmark::trace_all;
use rig::{Effect, EffectKind, Machine};

/// Effects whose fits cross such jumps.
const KINDS: [EffectKind; 3] = [
    EffectKind::Stribeck,
    EffectKind::Cogging,
    EffectKind::InputDelay,
];

/// Logs of each.
const LOGS: u64 = 4;

#[test]
fn a_found_effect_is_fitted_as_well_as_from_the_truth() {
    let rig = Machine::force_slide();
    let cases: Vec<Case> = KINDS
        .iter()
        .flat_map(|&kind| (0..LOGS).map(move |log| (kind, log)))
        .enumerate()
        .map(|(index, (kind, _))| Case {
            group: Group::Named,
            rig: rig.clone(),
            declared: None,
            effects: vec![Effect::nominal(kind, &rig)],
            strength: 1.0,
            motion: Motion::Sines,
            seed: 71_400 + index as u64,
        })
        .collect();
    let directory = tempfile::tempdir().unwrap();
    let traced = trace_all(&cases, directory.path(), || ()).unwrap();
    let right: Vec<_> = traced
        .iter()
        .filter(|traced| traced.judgement == Judgement::Right)
        .collect();
    assert!(3 * right.len() >= 2 * traced.len(), "{traced:#?}");
    for traced in right {
        let ratio = traced.after_over_oracle.unwrap();
        assert!(ratio < 1.03, "{ratio} {:?}", traced.case);
    }
}
