//! The campaign: levels of friction × inputs × seeds, and the errors of the estimates.

use std::time::Instant;

use model_core::numeric::invalid_parameter::InvalidParameter;
use model_core::plant::parameters::Parameters;
use rayon::prelude::*;

use super::estimate::{self, Options};
use super::stand::{Friction, Input, LEVELS, Stand};
use super::statistics::quantile;

/// One log and what was estimated from it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Case {
    /// How it was driven.
    pub input: Input,
    /// Seed of bench, noise and search.
    pub seed: u64,
    /// Number of the level in [`LEVELS`].
    pub level: usize,
    /// The truth, N·m.
    pub truth: Friction,
    /// One number: Coulomb level, N·m.
    pub coulomb: f64,
    /// Two numbers: Coulomb level, N·m.
    pub separate_coulomb: f64,
    /// Two numbers: breakaway level, N·m.
    pub separate_breakaway: f64,
    /// Replays for the one number, by annealing and by golden section.
    pub evaluations: (u32, u32),
    /// The same for the two numbers.
    pub separate_evaluations: (u32, u32),
    /// Wall-clock time of the estimate of the one number, s.
    pub seconds: f64,
}

impl Case {
    /// Relative error of the one number.
    pub fn error(&self) -> f64 {
        self.coulomb / self.truth.coulomb - 1.0
    }

    /// Relative errors of the two numbers.
    pub fn separate_errors(&self) -> (f64, f64) {
        (
            self.separate_coulomb / self.truth.coulomb - 1.0,
            self.separate_breakaway / self.truth.breakaway - 1.0,
        )
    }
}

/// Median, 95 % quantile and maximum of magnitudes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Median.
    pub median: f64,
    /// 95 % quantile.
    pub most: f64,
    /// Maximum.
    pub worst: f64,
}

impl Spread {
    /// Of the magnitudes of some errors.
    pub fn of(errors: impl Iterator<Item = f64>) -> Self {
        let magnitudes: Vec<f64> = errors.map(f64::abs).collect();
        let [median, most, worst] = [0.5, 0.95, 1.0].map(|share| quantile(&magnitudes, share));
        Self {
            median,
            most,
            worst,
        }
    }
}

/// Runs the campaign, all cores.
///
/// # Errors
/// What the core refuses.
pub fn run(
    stand: &Stand,
    model: &Parameters,
    inputs: &[Input],
    seeds: impl Iterator<Item = u64> + Clone,
) -> Result<Vec<Case>, InvalidParameter> {
    let mut plan = Vec::new();
    for &input in inputs {
        for level in 0..LEVELS.len() {
            plan.extend(seeds.clone().map(|seed| (input, level, seed)));
        }
    }
    plan.into_par_iter()
        .map(|(input, level, seed)| case(stand, model, input, level, seed))
        .collect()
}

fn case(
    stand: &Stand,
    model: &Parameters,
    input: Input,
    level: usize,
    seed: u64,
) -> Result<Case, InvalidParameter> {
    // Each level has benches of its own.
    let seed = seed * LEVELS.len() as u64 + level as u64;
    let truth = Friction::drawn(LEVELS[level], seed);
    let recorded = stand.record(input, truth, seed)?;
    let log = recorded.log(false);
    let options = Options::default();
    let began = Instant::now();
    let one = estimate::one(model, &log, &options, seed)?;
    let seconds = began.elapsed().as_secs_f64();
    let two = estimate::two(model, &log, &options, seed)?;
    Ok(Case {
        input,
        seed,
        level,
        truth,
        coulomb: one.levels.coulomb.into(),
        separate_coulomb: two.levels.coulomb.into(),
        separate_breakaway: two.levels.breakaway.into(),
        evaluations: (one.annealing_evaluations, one.polish_evaluations),
        separate_evaluations: (two.annealing_evaluations, two.polish_evaluations),
        seconds,
    })
}
