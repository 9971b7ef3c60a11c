//! What the settings of the annealing do, on one log: the paper says that its result depends strongly on
//! the initial temperature, the interval of re-annealing and the bounds.
//!
//! On the paper's case, by annealing alone, many searches each. With the 82 evaluations of the campaign
//! it is never re-annealed: that takes as many accepted steps as the interval has. In 500 it is, and only
//! then no search of a free run is lost (0.4 % off at worst, 22 % without).

use model_core::gap::log::Log;
use model_core::identify::annealing::{self, Cooling, StepFunction};
use model_core::numeric::invalid_parameter::InvalidParameter;
use model_core::plant::parameters::Parameters;
use rayon::prelude::*;

use super::campaign::Spread;
use super::estimate::{self, Estimate, Options};

/// Accepted steps between two re-annealings, where they are to happen.
const INTERVAL: u32 = 25;

/// Evaluations of a long search: MATLAB's order, and the core's default.
const LONG: u32 = 500;

/// What one setting came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// What is set otherwise than in the campaign.
    pub name: &'static str,
    /// Relative errors in windows.
    pub windows: Spread,
    /// Relative errors in one free run, the paper's.
    pub free_run: Spread,
    /// Of each search.
    pub evaluations: u32,
    /// Mean number of accepted steps, in windows.
    pub accepted: f64,
    /// Mean number of re-annealings, in windows.
    pub reannealings: f64,
}

/// The settings.
fn all() -> Vec<(&'static str, annealing::Parameters<1>)> {
    let usual = Options::default().annealing;
    let long = annealing::Parameters {
        evaluations: LONG,
        ..usual
    };
    let with = |change: fn(&mut annealing::Parameters<1>), mut from: annealing::Parameters<1>| {
        change(&mut from);
        from
    };
    vec![
        ("as in the campaign", usual),
        ("T₀ 0.1", with(|it| it.initial_temperature = 0.1, usual)),
        ("T₀ 100", with(|it| it.initial_temperature = 100.0, usual)),
        (
            "upper bound 6 N·m",
            with(|it| it.upper = [4.0 * estimate::UPPER], usual),
        ),
        (
            "Boltzmann steps",
            with(|it| it.step = StepFunction::Boltzmann, usual),
        ),
        ("cooling T₀/k", with(|it| it.cooling = Cooling::Fast, usual)),
        (
            "Boltzmann steps, cooling T₀/ln k",
            with(
                |it| {
                    it.step = StepFunction::Boltzmann;
                    it.cooling = Cooling::Boltzmann;
                },
                usual,
            ),
        ),
        (
            "re-annealed after 10",
            with(|it| it.reannealing_interval = Some(10), usual),
        ),
        (
            "500 evaluations, never re-annealed",
            with(|it| it.reannealing_interval = None, long),
        ),
        ("500, re-annealed after 100", long),
        ("500, re-annealed after 25", reannealed_often()),
    ]
}

fn reannealed_often() -> annealing::Parameters<1> {
    annealing::Parameters {
        evaluations: LONG,
        reannealing_interval: Some(INTERVAL),
        ..Options::default().annealing
    }
}

/// By annealing alone.
fn alone(annealing: annealing::Parameters<1>, window: Option<f32>) -> Options {
    Options {
        annealing,
        window,
        polish: 0,
        ..Options::default()
    }
}

/// A search long enough to be re-annealed more than once: the paper's Fig. 14 as it looks then.
///
/// # Errors
/// What the core refuses.
pub fn reannealed(model: &Parameters, log: &Log, seed: u64) -> Result<Estimate, InvalidParameter> {
    let options = alone(reannealed_often(), Options::default().window);
    estimate::one(model, log, &options, seed)
}

/// Tries every setting on a log with this Coulomb level, N·m, once for each seed.
///
/// # Errors
/// What the core refuses.
pub fn compare(
    model: &Parameters,
    log: &Log,
    truth: f64,
    seeds: impl Iterator<Item = u64>,
) -> Result<Vec<Row>, InvalidParameter> {
    let seeds: Vec<u64> = seeds.collect();
    let search = |annealing, window| -> Result<Vec<Estimate>, InvalidParameter> {
        let options = alone(annealing, window);
        let each = seeds.par_iter();
        each.map(|&seed| estimate::one(model, log, &options, seed))
            .collect()
    };
    let spread = |found: &[Estimate]| {
        Spread::of(
            found
                .iter()
                .map(|it| f64::from(it.levels.coulomb) / truth - 1.0),
        )
    };
    all()
        .into_iter()
        .map(|(name, annealing)| {
            let found = search(annealing, Options::default().window)?;
            let free = search(annealing, None)?;
            let mean = |of: fn(&Estimate) -> u32| {
                found.iter().map(|it| f64::from(of(it))).sum::<f64>() / found.len() as f64
            };
            Ok(Row {
                name,
                windows: spread(&found),
                free_run: spread(&free),
                evaluations: annealing.evaluations,
                accepted: mean(|it| it.accepted),
                reannealings: mean(|it| it.reannealings),
            })
        })
        .collect()
}
