//! The whole identification: starts, the best of them improved, the number of clusters chosen.

use std::ops::RangeInclusive;

use model_core::numeric::random::Random;
use model_core::plant::piecewise_affine::{MOST_CELLS, PiecewiseAffine};
use rayon::prelude::*;

use super::borders::{self, Partition};
use super::k_means;
use super::levenberg_marquardt::{Budget, Problem, minimise};
use super::model::{Cell, Model};
use super::parallel::Parallel;
use super::penalty::Penalty;
use super::reading::{Reading, Space};
use super::series::{Data, Part, Series, Step};
use super::series_parallel;
use crate::failure::Failure;
use crate::log::Log;

/// Points that are clustered, at most; more say nothing new.
const POINTS: usize = 4000;

/// Length of a block of the data, of which every fifth is held out, s. Long enough for the plate to
/// come to rest, so that few of a block's errors stem from the block before.
const BLOCK_S: f64 = 2.0;

/// Shortest training data, s: every kind of motion has to be in both parts.
const SHORTEST_S: f64 = 20.0;

/// Of a number of clusters' starts, so many are identified in parallel.
const SHORTLIST: usize = 3;

/// Numbers of clusters whose borders are moved to the end.
const FINALISTS: usize = 5;

/// Levenberg-Marquardt from a start, and at the end.
const IMPROVE: Budget = Budget {
    iterations: 25,
    gain: 1e-3,
};
const FINISH: Budget = Budget {
    iterations: 50,
    gain: 1e-5,
};

/// Rounds of moving borders: for every number of clusters, for the finalists, for the chosen model.
const ROUNDS: [usize; 3] = [6, 12, 12];

/// Errors beyond this share of the position's standard deviation weigh more. Fourteen stands, largest error on
/// validation data: 4.3° at worst, 6.2° without.
const LARGE: f64 = 0.08;

/// A further cluster must lower the held-out error by this share.
const WORTHWHILE: f64 = 0.01;

/// What is wanted of the identification.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// How the paper is read.
    pub reading: Reading,
    /// Whether the borders of the clusters are moved to lower the error, or stay as k-means put them
    /// (the paper).
    pub move_borders: bool,
    /// Numbers of clusters that are tried, within 1 to 10. The paper: 2 to 10.
    pub clusters: RangeInclusive<usize>,
    /// Starts of k-means for each. The paper: 10.
    pub starts: usize,
    /// Sample time of the model, s; a multiple of the logs' period.
    ///
    /// 10 ms is half of the mechanical time constant of a throttle (20 ms) and many of its electrical ones,
    /// so that two past outputs are state enough. The shorter it is, the more of the difference of two
    /// positions is noise. Fourteen stands, validation data, mean NRMSE and worst error: 0.030 and 5.2° at
    /// 5 ms, 0.032 and 4.3° at 10 ms, 0.041 and 8.4° at 20 ms.
    pub period_s: f64,
    /// Seed of the starts.
    pub seed: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            reading: Reading::default(),
            move_borders: true,
            clusters: 2..=MOST_CELLS,
            starts: 10,
            period_s: 0.01,
            seed: 1,
        }
    }
}

/// What came of a number of clusters: rms of the free-run error on the held-out parts of the training
/// data, rad or m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Number of clusters.
    pub clusters: usize,
    /// With the least squares of series-parallel identification.
    pub series_parallel: f64,
    /// After parallel identification.
    pub parallel: f64,
    /// After the borders were moved.
    pub moved: Option<f64>,
}

impl Candidate {
    /// The last of its errors.
    pub fn error(&self) -> f64 {
        self.moved.unwrap_or(self.parallel)
    }
}

/// An identified model.
#[derive(Debug, Clone, PartialEq)]
pub struct Identified {
    /// The model, fitted to all of the training data in the end.
    pub model: PiecewiseAffine,
    /// How the paper was read.
    pub reading: Reading,
    /// m of [`Reading::Balance`], input for each rad or m; 0 in the other readings.
    pub slope: f64,
    /// Every number of clusters.
    pub candidates: Vec<Candidate>,
}

/// Identifies a model from logs of one machine, the first rows of which show it at rest. The same logs
/// and options give the same model, on any number of cores.
///
/// # Errors
/// Logs from which nothing can be identified: none, too short, without motion, with a period of which the
/// sample time is no multiple; options that cannot be.
pub fn identify(train: &[&Log], options: &Options) -> Result<Identified, Failure> {
    let task = Task::new(train, options)?;
    let starts: Vec<Trial> = task.starts();
    let mut trials: Vec<(Candidate, Trial)> = task.improved(starts);
    if options.move_borders {
        task.move_borders(&mut trials, ROUNDS[0]);
        trials.sort_by(|a, b| a.0.error().total_cmp(&b.0.error()));
        let finalists = FINALISTS.min(trials.len());
        task.move_borders(&mut trials[..finalists], ROUNDS[1]);
        trials.sort_by_key(|trial| trial.0.clusters);
    }
    let least = trials
        .iter()
        .map(|trial| trial.0.error())
        .fold(f64::INFINITY, f64::min);
    let chosen = trials
        .iter()
        .find(|trial| (1.0 - WORTHWHILE) * trial.0.error() <= least)
        .ok_or_else(|| Failure::other("no number of clusters to choose from"))?;
    let finished = task.finished(&chosen.1);
    Ok(Identified {
        model: finished
            .model
            .core()
            .map_err(|error| Failure::other(format!("no model came of these logs: {error}")))?,
        reading: options.reading,
        slope: finished.partition.slope(),
        candidates: trials.iter().map(|trial| trial.0).collect(),
    })
}

/// A model and the partition that its cells come from.
#[derive(Debug, Clone)]
struct Trial {
    model: Model,
    partition: Partition,
}

/// Data and options, checked.
struct Task<'a> {
    options: &'a Options,
    data: Data,
    /// The measured steps of the part that is fitted.
    steps: Vec<Step>,
    space: Space,
    limits: (f64, f64),
    penalty: Penalty,
}

impl<'a> Task<'a> {
    fn new(train: &[&Log], options: &'a Options) -> Result<Self, Failure> {
        let refuse = |message: String| Err(Failure::other(message));
        let (fewest, most) = (*options.clusters.start(), *options.clusters.end());
        if fewest < 1 || most > MOST_CELLS || fewest > most || options.starts == 0 {
            return refuse(format!(
                "{fewest} to {most} clusters with {} starts; give 1 to {MOST_CELLS} and a start at least",
                options.starts
            ));
        }
        let mut series = Vec::new();
        for log in train {
            series.push(Series::of(log, options.period_s)?);
        }
        let data = Data {
            series,
            block: (BLOCK_S / options.period_s).ceil() as usize,
        };
        let length = data.count(Part::All) as f64 * options.period_s;
        if length < SHORTEST_S {
            return refuse(format!(
                "{length:.1} s of training data; a piecewise affine model needs at least {SHORTEST_S} s"
            ));
        }
        if data.count(Part::HeldOut) == 0 {
            return refuse(format!(
                "no training log is longer than {} s; give longer ones, or nothing can be held out",
                4.0 * BLOCK_S
            ));
        }
        let positions = || data.series.iter().flat_map(|series| &series.position);
        let count = positions().count() as f64;
        let mean = positions().sum::<f64>() / count;
        let variance = positions().map(|y| (y - mean).powi(2)).sum::<f64>() / count;
        let range = positions().fold((f64::INFINITY, f64::NEG_INFINITY), |range, &position| {
            (range.0.min(position), range.1.max(position))
        });
        if variance.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
            return refuse("the machine does not move in the training data".to_owned());
        }
        let steps = data.steps(Part::Fit);
        Ok(Self {
            space: options.reading.space(&steps),
            steps,
            limits: range,
            penalty: Penalty::with_scale(LARGE * variance.sqrt()),
            data,
            options,
        })
    }

    /// What is minimised on a part of the data.
    fn problem(&self, part: Part) -> Parallel<'_> {
        Parallel {
            data: &self.data,
            part,
            penalty: self.penalty,
            reading: self.options.reading,
        }
    }

    /// Root of the mean squared error on the held-out parts, large errors weighing more.
    fn held_out(&self, model: &Model) -> f64 {
        let cost = self.problem(Part::HeldOut).cost(model, f64::INFINITY);
        (cost / self.data.count(Part::HeldOut) as f64).sqrt()
    }

    /// The clusterings with least squares in each cell: the best few of each number of clusters, by the
    /// cost of their free run.
    fn starts(&self) -> Vec<Trial> {
        let stride = self.steps.len().div_ceil(POINTS);
        let points: Vec<k_means::Point> = self
            .steps
            .iter()
            .step_by(stride)
            .map(|step| self.space.point(&step.regressor))
            .collect();
        let numbers = self.options.clusters.clone();
        numbers
            .into_par_iter()
            .flat_map(|clusters| {
                let mut starts: Vec<(f64, Trial)> = (0..self.options.starts)
                    .into_par_iter()
                    .map(|number| self.start(&points, clusters, number))
                    .collect();
                starts.sort_by(|a, b| a.0.total_cmp(&b.0));
                starts.truncate(SHORTLIST);
                starts.into_par_iter().map(|(_, trial)| trial)
            })
            .collect()
    }

    /// One clustering with least squares in each cell, and the cost of its free run.
    fn start(&self, points: &[k_means::Point], clusters: usize, number: usize) -> (f64, Trial) {
        let stream = (number * (MOST_CELLS + 1) + clusters) as u64;
        let mut random = Random::new(self.options.seed, stream);
        let centres = k_means::centres(points, clusters, &mut random);
        let partition = Partition::of(self.space, centres);
        let cell = |region| Cell {
            region,
            growth: self.options.reading.fixed(),
        };
        let mut model = Model {
            period_s: self.options.period_s,
            lower: self.limits.0,
            upper: self.limits.1,
            cells: partition.regions().into_iter().map(cell).collect(),
        };
        series_parallel::fit(&mut model, self.options.reading, &self.steps);
        let cost = self.problem(Part::Fit).cost(&model, f64::INFINITY);
        (cost, Trial { model, partition })
    }

    /// The starts after parallel identification: of each number of clusters the best.
    fn improved(&self, starts: Vec<Trial>) -> Vec<(Candidate, Trial)> {
        let trials: Vec<(Candidate, Trial)> = starts
            .into_par_iter()
            .map(|start| {
                let model = minimise(&self.problem(Part::Fit), &start.model, IMPROVE);
                let candidate = Candidate {
                    clusters: model.cells.len(),
                    series_parallel: self.held_out(&start.model),
                    parallel: self.held_out(&model),
                    moved: None,
                };
                let partition = start.partition;
                (candidate, Trial { model, partition })
            })
            .collect();
        let mut best: Vec<(Candidate, Trial)> = Vec::new();
        for trial in trials {
            match best.last_mut() {
                Some(last) if last.0.clusters == trial.0.clusters => {
                    if trial.0.parallel < last.0.parallel {
                        *last = trial;
                    }
                }
                _ => best.push(trial),
            }
        }
        best
    }

    /// Moves the borders of each.
    fn move_borders(&self, trials: &mut [(Candidate, Trial)], rounds: usize) {
        trials.par_iter_mut().rev().for_each(|(candidate, trial)| {
            let start = (&trial.model, &trial.partition);
            let (model, partition) = borders::improve(&self.problem(Part::Fit), start, rounds);
            candidate.moved = Some(self.held_out(&model));
            *trial = Trial { model, partition };
        });
    }

    /// The chosen model, fitted to all of the data.
    fn finished(&self, trial: &Trial) -> Trial {
        let problem = self.problem(Part::All);
        let mut model = minimise(&problem, &trial.model, FINISH);
        let mut partition = trial.partition.clone();
        if self.options.move_borders {
            (model, partition) = borders::improve(&problem, (&model, &partition), ROUNDS[2]);
            model = minimise(&problem, &model, FINISH);
        }
        Trial { model, partition }
    }
}
