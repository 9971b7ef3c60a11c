//! From estimates to alerts: a threshold, its errors, and the life that is left.
//!
//! Healthy actuators differ, and one differs from day to day: the friction of each log scatters by 4 %
//! around 0.12 N·m. The *threshold* is an upper tolerance limit of a healthy population, learnt
//! before anything else is seen: with 95 % confidence no more than 1 % of the healthy exceed it. A
//! *false alarm* is a healthy log above it, a *missed detection* a worn one below.
//!
//! For the *life* that is left a maintenance computer goes log by log: two estimates above the
//! threshold, one after the other, are an *alert*; from then on a robust line through the latest
//! estimates says when friction will reach the level of failure.

use model_core::numeric::invalid_parameter::InvalidParameter;
use model_core::plant::parameters::Parameters;
use rayon::prelude::*;
use rig::Random;

use super::estimate::{self, Options};
use super::stand::{Friction, Input, LEVELS, Stand};
use super::statistics::{moments, robust_line, tolerance_factor};

/// Standard deviation of the friction from log to log, as a share.
pub const SCATTER: f64 = 0.04;

/// Share of the healthy that the threshold leaves below it.
pub const CONTENT: f64 = 0.99;

/// Confidence in that.
pub const CONFIDENCE: f64 = 0.95;

/// Growths of friction that are to be detected, as shares.
pub const GROWTHS: [f64; 5] = [0.05, 0.1, 0.15, 0.2, 0.5];

/// Logs of a wearing actuator.
pub const LOGS: usize = 60;

/// Failure, N·m: half of the motor's peak torque, about the paper's faulty case.
pub const FAILURE: f64 = 0.72;

/// Estimates that the line is laid through: the latest ones since the alert, at most and at least.
const LINE: (usize, usize) = (15, 5);

/// Logs of each growth per log of the healthy population.
const WORN_SHARE: f64 = 0.5;

/// What the threshold is and how often it errs.
#[derive(Debug, Clone, PartialEq)]
pub struct Detection {
    /// N·m.
    pub threshold: f64,
    /// Healthy logs that it was learnt from.
    pub learnt_from: usize,
    /// Other healthy logs.
    pub healthy: usize,
    /// Share of them above it.
    pub false_alarms: f64,
    /// For each of [`GROWTHS`]: logs, share of them below it.
    pub missed: Vec<(f64, usize, f64)>,
}

/// One actuator on its way to failure.
#[derive(Debug, Clone, PartialEq)]
pub struct Life {
    /// Seed.
    pub seed: u64,
    /// Friction, N·m, log by log.
    pub truth: Vec<f64>,
    /// Its estimates.
    pub estimates: Vec<f64>,
    /// Log at which its wear began.
    pub onset: usize,
    /// Log of the alert.
    pub alert: Option<usize>,
    /// First log at which the wear alone, without scatter, is at [`FAILURE`].
    pub failure: usize,
    /// The line after each log since the alert, as far as there is one that rises.
    pub predicted: Vec<Prediction>,
}

/// A robust line through the latest estimates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// After which log.
    pub log: usize,
    /// Friction of the line at log 0, N·m.
    pub level: f64,
    /// Its growth a log, N·m.
    pub growth: f64,
    /// Where it reaches [`FAILURE`].
    pub failure_log: f64,
}

impl Life {
    /// Logs from the alert to failure.
    pub fn lead(&self) -> Option<f64> {
        self.alert.map(|alert| self.failure as f64 - alert as f64)
    }

    /// Error of the predicted log of failure when this share of the time from alert to failure is over, or as soon
    /// after that as there is a line.
    pub fn error_at(&self, share: f64) -> Option<f64> {
        let lead = self.lead()?;
        let log = self.alert? + (share * lead).round() as usize;
        let found = self.predicted.iter().find(|it| it.log >= log);
        found.map(|it| it.failure_log - self.failure as f64)
    }
}

/// Friction of a log: the level with its scatter.
fn scattered(level: f64, seed: u64) -> Friction {
    let mut random = Random::new(seed ^ 0x5eed_0003);
    // Cut off at three deviations: no log of a healthy actuator is that of another.
    let scatter = random.normal().clamp(-3.0, 3.0);
    Friction::drawn(level * (1.0 + SCATTER * scatter), seed)
}

/// Estimates of the Coulomb level from sweeps, N·m, one for each level and seed.
fn estimates(
    stand: &Stand,
    model: &Parameters,
    plan: Vec<(f64, u64)>,
) -> Result<Vec<f64>, InvalidParameter> {
    plan.into_par_iter()
        .map(|(level, seed)| {
            let recorded = stand.record(Input::Sweep, scattered(level, seed), seed)?;
            let log = recorded.log(false);
            let found = estimate::one(model, &log, &Options::default(), seed)?;
            Ok(found.levels.coulomb.into())
        })
        .collect()
}

/// Learns the threshold from `count` healthy logs, and tries it on as many others and on worn ones.
///
/// # Errors
/// What the core refuses.
pub fn detect(
    stand: &Stand,
    model: &Parameters,
    count: usize,
    seed: u64,
) -> Result<Detection, InvalidParameter> {
    let healthy = LEVELS[0];
    let worn_count = (WORN_SHARE * count as f64).ceil() as usize;
    let of = |level: f64, block: u64| -> Result<Vec<f64>, InvalidParameter> {
        let first = (seed * 100 + block) * 10_000;
        let logs = if level > healthy { worn_count } else { count };
        let plan = (0..logs as u64).map(|number| (level, first + number));
        estimates(stand, model, plan.collect())
    };
    let (mean, deviation) = moments(&of(healthy, 0)?);
    let threshold = mean + tolerance_factor(count, CONTENT, CONFIDENCE) * deviation;
    let above = |values: &[f64]| {
        let above = values.iter().filter(|value| **value > threshold).count();
        above as f64 / values.len() as f64
    };
    let false_alarms = above(&of(healthy, 1)?);
    let missed = GROWTHS
        .iter()
        .zip(2..)
        .map(|(growth, block)| {
            let worn = of(healthy * (1.0 + growth), block)?;
            Ok((*growth, worn_count, 1.0 - above(&worn)))
        })
        .collect::<Result<_, InvalidParameter>>()?;
    Ok(Detection {
        threshold,
        learnt_from: count,
        healthy: count,
        false_alarms,
        missed,
    })
}

/// Lets an actuator wear, log by log: healthy up to the onset, then ever faster.
///
/// # Errors
/// What the core refuses.
pub fn wear(
    stand: &Stand,
    model: &Parameters,
    threshold: f64,
    seed: u64,
) -> Result<Life, InvalidParameter> {
    let mut random = Random::new(seed ^ 0x5eed_0004);
    let onset = 8 + (8.0 * random.uniform()) as usize;
    let exponent = 1.0 + 0.4 * random.uniform();
    let failure = 48 + (10.0 * random.uniform()) as usize;
    let healthy = LEVELS[0];
    let level = |log: usize| {
        let worn = log.saturating_sub(onset) as f64 / (failure - onset) as f64;
        healthy + (FAILURE - healthy) * worn.powf(exponent)
    };
    let seed_of = |log: usize| (seed + 1000) * 1_000_000 + log as u64;
    let truth = (0..LOGS).map(|log| scattered(level(log), seed_of(log)).coulomb);
    let plan = (0..LOGS).map(|log| (level(log), seed_of(log))).collect();
    let estimates = estimates(stand, model, plan)?;
    let alert = (1..LOGS).find(|&log| estimates[log].min(estimates[log - 1]) > threshold);
    let mut predicted = Vec::new();
    for log in alert.unwrap_or(LOGS)..failure {
        // The first of the two estimates of the alert is the first that is worn for certain.
        let from = (log + 1)
            .saturating_sub(LINE.0)
            .max(alert.unwrap_or(LOGS).saturating_sub(1));
        if log + 1 - from < LINE.1 {
            continue;
        }
        let points: Vec<(f64, f64)> = (from..=log)
            .map(|log| (log as f64, estimates[log]))
            .collect();
        if let Some((level, growth)) = robust_line(&points)
            && growth > 0.0
        {
            predicted.push(Prediction {
                log,
                level,
                growth,
                failure_log: (FAILURE - level) / growth,
            });
        }
    }
    Ok(Life {
        seed,
        truth: truth.collect(),
        estimates,
        onset,
        alert,
        failure,
        predicted,
    })
}
