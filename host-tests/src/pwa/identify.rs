//! From logs to a model: clusters, sub-models, boundaries, and how many of them.

use model_core::numeric::random::Random;
use model_core::plant::piecewise_affine::{MOST_CELLS, PiecewiseAffine};
use rayon::prelude::*;

use super::k_means;
use super::levenberg_marquardt::Fit;
use super::model::{Affine, Cells};
use super::parallel::Parallel;
use super::reading::{Plane, Reading};
use super::sampled::Sampled;
use super::{series_parallel, soft};
use crate::failure::Failure;
use crate::log::Log;

/// Share of each log, from its end, that numbers of clusters are compared on.
const HELD_OUT: f64 = 0.25;
/// Least-squares models of a number of clusters, the best in free run, that are fitted in parallel
/// for the choice of the number and for the model. The others are dropped.
const FINALISTS: [usize; 2] = [2, 6];
/// Most steps of the parallel identification.
const STEPS: [usize; 2] = [20, 60];
/// Fewest periods of a log.
const LEAST_PERIODS: usize = 100;
/// A sample is at an end of the stroke if it is this share of the stroke away from it.
const AT_END: f64 = 3e-3;

/// How to identify.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Which regressor.
    pub reading: Reading,
    /// Period of the model, s, a multiple of the logs'.
    pub period: f64,
    /// Fewest and most clusters.
    pub clusters: (usize, usize),
    /// Starts of k-means for each number of clusters.
    pub starts: u64,
    /// Whether boundaries are fitted after k-means drew them.
    pub refine: bool,
    /// What the starts follow from.
    pub seed: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            reading: Reading::Balance,
            period: 0.01,
            clusters: (2, MOST_CELLS),
            starts: 10,
            refine: true,
            seed: 1,
        }
    }
}

/// A number of clusters and how good it is, rms errors in free run, unit of the position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// How many.
    pub clusters: usize,
    /// By least squares, on the data that was fitted.
    pub series_parallel: f64,
    /// After parallel identification, on the same.
    pub parallel: f64,
    /// The same model on the held-out parts.
    pub held_out: f64,
}

/// What came of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Identified {
    /// The model.
    pub model: PiecewiseAffine,
    /// Which regressor it uses.
    pub reading: Reading,
    /// All numbers of clusters that were tried, the fewest first.
    pub trials: Vec<Trial>,
    /// Input that balances the spring, per rad or m.
    pub slope: f64,
}

/// The training data at the model's period.
struct Data {
    logs: Vec<Sampled>,
    samples: Vec<(Affine, f64)>,
    limits: (f64, f64),
    plane: Plane,
}

/// Identifies a model on logs of one actuator.
///
/// # Errors
/// Options or logs that no model can be had from, with a remedy.
pub fn identify(train: &[&Log], options: &Options) -> Result<Identified, Failure> {
    let (fewest, most) = options.clusters;
    if fewest < 1 || fewest > most || most > MOST_CELLS || options.starts == 0 {
        return Err(Failure::other(format!(
            "{fewest} to {most} clusters from {} starts: expected 1 to {MOST_CELLS}, at least one start",
            options.starts
        )));
    }
    let logs = sampled(train, options.period)?;
    let (limits, samples) = stroke(&logs)?;
    let slope = balance(&samples, limits);
    let plane = Plane::new(options.reading, &samples, slope);
    let fitted: Vec<Sampled> = logs.iter().map(|log| log.part(0, kept(log))).collect();
    let held_out: Vec<Sampled> = logs
        .iter()
        .map(|log| log.part(kept(log), log.periods()))
        .collect();
    let all = Data {
        logs,
        samples,
        limits,
        plane,
    };
    let part = Data {
        samples: stroke_samples(&fitted, limits),
        logs: fitted,
        ..all
    };
    let trials: Vec<Trial> = (fewest..=most)
        .into_par_iter()
        .map(|clusters| {
            let (first, best) = part.fit(clusters, options, FINALISTS[0], STEPS[0]);
            Trial {
                clusters,
                series_parallel: rms(first, &part.logs),
                parallel: rms(best.cost, &part.logs),
                held_out: rms(best.cells.cost(&held_out), &held_out),
            }
        })
        .collect();
    let chosen = trials
        .iter()
        .min_by(|a, b| a.held_out.total_cmp(&b.held_out))
        .map_or(fewest, |trial| trial.clusters);
    let (_, best) = all.fit(chosen, options, FINALISTS[1], STEPS[1]);
    let model = best
        .cells
        .build(options.period)
        .map_err(|error| Failure::other(format!("no model came of these logs: {error}")))?;
    Ok(Identified {
        model,
        reading: options.reading,
        trials,
        slope,
    })
}

/// Periods of a log that are fitted; the others are held out.
fn kept(log: &Sampled) -> usize {
    ((1.0 - HELD_OUT) * log.periods() as f64) as usize
}

/// Root of the mean of squares that sum up to this.
fn rms(cost: f64, logs: &[Sampled]) -> f64 {
    let periods: usize = logs.iter().map(Sampled::periods).sum();
    (cost / periods as f64).sqrt()
}

/// The logs at the model's period.
fn sampled(train: &[&Log], period: f64) -> Result<Vec<Sampled>, Failure> {
    if train.is_empty() {
        return Err(Failure::other("no log to identify on; give one at least"));
    }
    train
        .iter()
        .map(|log| {
            let rows = rows(log, period)?;
            let sampled = Sampled::new(log, rows);
            if sampled.periods() < LEAST_PERIODS {
                return Err(Failure::other(format!(
                    "{}: {} periods of {period} s, expected at least {LEAST_PERIODS}; record longer",
                    log.path.display(),
                    sampled.periods()
                )));
            }
            Ok(sampled)
        })
        .collect()
}

/// Rows of a log in a period.
///
/// # Errors
/// A period that is no multiple of the log's.
pub fn rows(log: &Log, period: f64) -> Result<usize, Failure> {
    let rows = (period / log.period_s).round();
    if rows >= 1.0 && (rows * log.period_s / period - 1.0).abs() < 1e-3 {
        Ok(rows as usize)
    } else {
        Err(Failure::other(format!(
            "{}: a row every {} s; a model of {period} s needs a log whose period divides its own",
            log.path.display(),
            log.period_s
        )))
    }
}

/// The stroke that the logs show, and the samples within it.
#[allow(clippy::type_complexity)]
fn stroke(logs: &[Sampled]) -> Result<((f64, f64), Vec<(Affine, f64)>), Failure> {
    let mut positions: Vec<f64> = logs.iter().flat_map(|log| log.position.clone()).collect();
    positions.sort_by(f64::total_cmp);
    let (first, last) = (positions[0], positions[positions.len() - 1]);
    let margin = AT_END * (last - first);
    // Noise reaches beyond a stop on which the actuator lies: the median of those near it does not.
    let near = |end: f64| {
        let near = |position: &&f64| (**position - end).abs() <= margin;
        let near: Vec<&f64> = positions.iter().filter(near).collect();
        *near[near.len() / 2]
    };
    let limits = (near(first), near(last));
    let samples = stroke_samples(logs, limits);
    if samples.len() < LEAST_PERIODS || limits.0 >= limits.1 {
        return Err(Failure::other(format!(
            "the logs hold {} samples between the ends of the stroke, expected at least \
             {LEAST_PERIODS}; drive the actuator along its stroke",
            samples.len()
        )));
    }
    Ok((limits, samples))
}

/// Samples that a stop does not explain: both positions within the stroke, or a motion that lasts.
fn stroke_samples(logs: &[Sampled], limits: (f64, f64)) -> Vec<(Affine, f64)> {
    let margin = AT_END * (limits.1 - limits.0);
    let within = |position: f64| position > limits.0 + margin && position < limits.1 - margin;
    let useful = |(x, growth): &(Affine, f64)| within(x[0]) && within(x[0] + growth);
    logs.iter()
        .flat_map(Sampled::pairs)
        .filter(useful)
        .collect()
}

/// Slope of the line on which spring and motor balance: of an affine model, with a step at zero
/// velocity for the friction, of the samples that move.
fn balance(samples: &[(Affine, f64)], limits: (f64, f64)) -> f64 {
    let least = AT_END * (limits.1 - limits.0);
    let rows: Vec<(Vec<f64>, f64)> = samples
        .iter()
        .filter(|(x, _)| x[1].abs() > least)
        .map(|(x, growth)| (vec![x[0], x[1], x[2], x[1].signum(), 1.0], *growth))
        .collect();
    let model = series_parallel::least_squares(&rows, 5);
    let slope = -model[0] / model[2];
    if slope.is_finite() { slope } else { 0.0 }
}

impl Data {
    /// The best model with so many clusters, and the free-run cost of the best by least squares.
    fn fit(
        &self,
        clusters: usize,
        options: &Options,
        finalists: usize,
        steps: usize,
    ) -> (f64, Fit) {
        let points: Vec<_> = self
            .samples
            .iter()
            .map(|(x, _)| self.plane.point(x))
            .collect();
        let problem = Parallel {
            logs: &self.logs,
            fitted: options.reading.fitted(),
        };
        let mut starts: Vec<Fit> = (0..options.starts)
            .into_par_iter()
            .map(|start| {
                let mut random = Random::new(options.seed, (start << 8) + clusters as u64);
                let centres = k_means::cluster(&points, clusters, &mut random);
                let mut cells = Cells {
                    partition: centres.iter().map(|c| self.plane.region(c)).collect(),
                    submodels: vec![[0.0; 4]; clusters],
                    limits: self.limits,
                };
                series_parallel::fit(&mut cells, options.reading, &self.samples);
                Fit::new(&problem, cells)
            })
            .collect();
        starts.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let first = starts[0].cost;
        starts.truncate(finalists);
        let finished: Vec<Fit> = starts
            .into_par_iter()
            .map(|start| self.finish(start, &problem, options, steps))
            .collect();
        let best = finished
            .into_iter()
            .min_by(|a, b| a.cost.total_cmp(&b.cost));
        (first, best.expect("at least one start"))
    }

    /// Parallel identification of a start; with boundaries fitted too where that is better.
    fn finish(&self, start: Fit, problem: &Parallel, options: &Options, steps: usize) -> Fit {
        let fixed = start.run(problem, steps);
        if !options.refine {
            return fixed;
        }
        let cells = soft::refine(&self.logs, options.reading, fixed.cells.clone());
        let refined = Fit::new(problem, cells).run(problem, steps);
        if refined.cost < fixed.cost {
            refined
        } else {
            fixed
        }
    }
}
