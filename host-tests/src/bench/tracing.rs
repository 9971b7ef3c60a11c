//! How long a tracing takes: on each machine of `cargo hil bench gap`, a log with nothing missing, with
//! some effects that cost more than others, and with friction in a band of speeds, which the catalogue
//! does not have.

use std::path::PathBuf;

use rig::{Effect, EffectKind};
use serde::Serialize;

use super::Extent;
use crate::failure::Failure;
use crate::gap::engine;
use crate::gap_benchmark::cases::{self, Case, Group, Motion};
use crate::workspace;

/// What is recorded on each machine.
pub(super) const EFFECTS: [&[EffectKind]; 6] = [
    &[],
    &[EffectKind::Presliding],
    &[EffectKind::Stribeck],
    &[EffectKind::Cogging],
    &[EffectKind::Compliance],
    &[EffectKind::SpeedBand],
];

/// Seed of the first log; the others follow.
const SEED: u64 = 31_000;

/// Cost of tracing one log.
#[derive(Debug, Clone, Serialize)]
pub struct Tracing {
    /// The machine.
    pub machine: String,
    /// What it has beyond its machine file.
    pub effects: Vec<String>,
    /// Wall-clock seconds, all cores.
    pub seconds: f64,
    /// Samples of the log.
    pub samples: usize,
    /// Replays of the whole log.
    pub simulations: u64,
    /// Samples simulated in a second by each core; a sample is one step of the plant or, under held
    /// effects, two with a predictor each.
    pub samples_per_second_and_core: f64,
    /// Effects found.
    pub found: Vec<String>,
}

/// Where the machine files are left.
pub(super) fn directory() -> PathBuf {
    workspace::results().join("bench-gap")
}

/// Traces as many logs of each machine as are asked for, once.
pub(super) fn measure(extent: Extent) -> Result<Vec<Tracing>, Failure> {
    let directory = directory();
    let mut tracings = Vec::new();
    for rig in cases::machines() {
        for kinds in EFFECTS.into_iter().take(extent.traced) {
            let nominal = |&kind| Effect::nominal(kind, &rig);
            let case = Case {
                group: if kinds.is_empty() {
                    Group::Clean
                } else {
                    Group::Named
                },
                rig: rig.clone(),
                declared: None,
                effects: kinds.iter().map(nominal).collect(),
                strength: 1.0,
                motion: Motion::Sines,
                seed: SEED + tracings.len() as u64,
            };
            let machine = case.machine_file(&directory)?;
            let logs = [case.log_lasting(extent.gap_s)];
            let report = engine::run(&machine, &logs, || Ok(Vec::new()), |_| ())?;
            let cost = &report.outcome.cost;
            let simulated = cost.simulations as f64 * cost.samples as f64;
            tracings.push(Tracing {
                machine: rig.name.to_owned(),
                effects: kinds.iter().map(|&kind| cases::label(kind)).collect(),
                seconds: cost.seconds,
                samples: cost.samples,
                simulations: cost.simulations,
                samples_per_second_and_core: simulated
                    / (cost.seconds * rayon::current_num_threads() as f64),
                found: report
                    .outcome
                    .effects
                    .into_iter()
                    .map(|effect| effect.id)
                    .collect(),
            });
        }
    }
    Ok(tracings)
}
