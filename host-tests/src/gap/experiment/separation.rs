//! How far an experiment sets candidates apart.
//!
//! Each candidate in turn is taken for the machine: its log of the experiment is made, with the
//! sensor's resolution and noise, and the others are refitted to the training logs and this one
//! together. What their error is then above the true one's, by sample of the experiment and in
//! multiples of the noise, is the distance. Base parameters, strengths and shapes are all refitted: an
//! effect that a refit imitates is not separated.

use model_core::gap::ensemble::{Ensemble, Store};
use model_core::gap::fit::{self, Effort, MOST_VARIABLES, Matrix};
use model_core::gap::log::Log as CoreLog;
use model_core::gap::replay::{self, Data, Fold, InOrder, Schedule, Sums};
use model_core::gap::workbench::Workbench;
use model_core::numeric::cholesky::Cholesky;
use model_core::numeric::random::Random;
use rayon::prelude::*;

use super::candidates::Candidate;
use super::limits::{Course, Trial};
use crate::gap::engine::AllCores;
use crate::gap::metrics::differentiate;
use crate::gap::series::Series;

/// Counts of the sensor below which the selection tells nothing apart: they are a part of the noise.
const FLOOR_COUNTS: f32 = 2.0;

/// Share of the windowed error that is noise of the sensor itself where it is above a count; the rest
/// comes from restarts.
const SENSOR_SHARE: f32 = 0.5;

/// Mean square over all logs, in squares of the noise, by which a separated candidate's error is
/// above the true one's: the error at least doubles, where the selection asks for half as much again.
const SEPARATED: f64 = 1.0;

/// Weight that holds a variable which nothing determines.
const LEAST_WEIGHT: f64 = 3.0;

/// Effort of a refit: what is compared differs by a multiple.
const EFFORT: Effort = Effort {
    steps: 30,
    converged: 1e-3,
};

/// All windows as one fold.
const ALL: (Fold, usize) = (Fold::All, 1);

/// Adds the floor that the selection adds to the noise of the position.
pub(super) fn weigh(workbench: &mut Workbench<impl Schedule>) {
    let settings = &mut workbench.data.settings;
    let noise = 1.0 / settings.position_weight;
    let floor = FLOOR_COUNTS * settings.resolution;
    settings.position_weight = 1.0 / (noise * noise + floor * floor).sqrt();
}

/// Squared distances of candidates: of the one in a row, taken for the machine, from those in the
/// columns.
#[derive(Debug, Clone)]
pub(super) struct Separation {
    squares: Vec<Vec<f64>>,
    /// Square from which two are separated.
    limit: f64,
}

impl Separation {
    fn distance(&self, a: usize, b: usize) -> f64 {
        self.squares[a][b].min(self.squares[b][a]).max(0.0).sqrt()
    }

    fn is_separated(&self, a: usize, b: usize) -> bool {
        self.distance(a, b).powi(2) >= self.limit
    }

    fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let count = self.squares.len();
        (0..count).flat_map(move |a| (a + 1..count).map(move |b| (a, b)))
    }

    /// Least distance of a separated pair; where there is none, the greatest of all.
    pub fn least(&self) -> f64 {
        let separated = self.pairs().filter(|&(a, b)| self.is_separated(a, b));
        let least = separated
            .map(|(a, b)| self.distance(a, b))
            .min_by(f64::total_cmp);
        least.unwrap_or_else(|| {
            let all = self.pairs().map(|(a, b)| self.distance(a, b));
            all.fold(0.0, f64::max)
        })
    }

    /// By how many pairs it separates, then by how far.
    pub fn rank(&self) -> (usize, f64) {
        let separated = self.pairs().filter(|&(a, b)| self.is_separated(a, b));
        (separated.count(), self.least())
    }

    /// By how far it separates all pairs together, before refits have the last word: a pair that just
    /// passes the limit counts for little beside one that is far beyond it.
    pub fn promise(&self) -> f64 {
        let logarithm = |(a, b)| (self.distance(a, b).powi(2) / self.limit).ln_1p();
        self.pairs().map(logarithm).sum()
    }

    /// Whether it separates every pair.
    pub fn is_complete(&self) -> bool {
        self.left().next().is_none()
    }

    /// Whether it separates any pair.
    pub fn separates_any(&self) -> bool {
        self.pairs().any(|(a, b)| self.is_separated(a, b))
    }

    /// Candidates that are told from another one.
    pub fn separated(&self) -> Vec<usize> {
        let count = self.squares.len();
        let told = |&a: &usize| (0..count).any(|b| b != a && self.is_separated(a, b));
        (0..count).filter(told).collect()
    }

    /// Pairs that are not told apart.
    pub fn left(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.pairs().filter(|&(a, b)| !self.is_separated(a, b))
    }
}

/// The training logs and the candidates, against which experiments are judged.
pub(super) struct Bench<'b, 'a> {
    workbench: &'b Workbench<'a, AllCores>,
    candidates: &'b [Candidate],
    /// What the training logs say about each candidate's variables.
    known: Vec<Matrix>,
}

impl<'b, 'a> Bench<'b, 'a> {
    /// `None` if a candidate cannot be built.
    pub fn new(
        workbench: &'b Workbench<'a, AllCores>,
        candidates: &'b [Candidate],
    ) -> Option<Self> {
        let mut bench = Self {
            workbench,
            candidates,
            known: Vec::new(),
        };
        for place in 0..candidates.len() {
            let sums = bench.sums(&workbench.data, &AllCores, place)?;
            bench.known.push(sums.normal(bench.variables(place)));
        }
        Some(bench)
    }

    fn variables(&self, place: usize) -> usize {
        self.workbench
            .variables(&self.candidates[place].model)
            .len()
    }

    /// Residual and sensitivities of a candidate on a log.
    fn sums(&self, data: &Data, schedule: &impl Schedule, place: usize) -> Option<Sums> {
        let model = &self.candidates[place].model;
        let period = data.logs.first()?.period;
        let store = Store::new();
        let mut ensemble = Ensemble::new();
        ensemble.start(&store, model, period).ok()?;
        let variables = self.workbench.variables(model);
        fit::perturb(&mut ensemble, &store, model, &variables, period)?;
        let mut sums = Sums::default();
        sums.replay(data, schedule, ALL, &ensemble);
        Some(sums)
    }

    /// The log that a candidate would leave.
    fn log_of(&self, trial: &Trial, course: &Course, seed: u64) -> Series {
        let data = &self.workbench.data;
        let settings = &data.settings;
        let mut random = Random::new(seed, 1);
        let noise = SENSOR_SHARE / settings.position_weight;
        let resolution = settings.resolution;
        // The error of a sensor with nothing but a resolution is what its rounding makes.
        let scatter = if noise > 2.0 * FLOOR_COUNTS * resolution {
            noise
        } else {
            0.0
        };
        let mut sensed = |position: f32| {
            let position = position + scatter * random.normal();
            if resolution > 0.0 {
                (position / resolution).round() * resolution
            } else {
                position
            }
        };
        let position: Vec<f32> = course.position.iter().map(|&it| sensed(it)).collect();
        let has_velocity = data.logs.iter().all(|log| log.velocity.is_some());
        let has_current = !course.current.is_empty();
        let flow = if settings.current_weight > 0.0 && has_current {
            1.0 / settings.current_weight
        } else {
            0.0
        };
        let period = data.logs[0].period;
        let velocity = has_velocity.then(|| {
            let position: Vec<f64> = course.position.iter().map(|&it| f64::from(it)).collect();
            let slopes = differentiate(&position, f64::from(period));
            slopes.into_iter().map(|slope| slope as f32).collect()
        });
        Series {
            label: String::new(),
            period,
            input: trial.input.clone(),
            position,
            current: has_current.then(|| {
                let currents = course.current.iter();
                currents.map(|it| it + flow * random.normal()).collect()
            }),
            velocity,
            brake: None,
        }
    }

    /// How far each trial sets the candidates apart as they are. No refit brings them further apart.
    pub fn unfitted(&self, trials: Vec<Trial>) -> Vec<(Trial, Separation)> {
        self.judged(trials, |data, place| {
            let model = &self.candidates[place].model;
            let simulator = model.build(data.logs.first()?.period).ok()?;
            Some(replay::cost(data, &InOrder, ALL, &simulator).0)
        })
    }

    /// How far each trial sets the candidates apart by linear theory: the residual of each on the
    /// others' logs less what a step of Gauss and Newton takes off it, within what the training logs
    /// leave open.
    pub fn linear(&self, trials: Vec<Trial>) -> Vec<(Trial, Separation)> {
        self.judged(trials, |data, place| self.remaining(data, place))
    }

    fn judged(
        &self,
        trials: Vec<Trial>,
        cost: impl Fn(&Data, usize) -> Option<f64> + Sync,
    ) -> Vec<(Trial, Separation)> {
        let judged = trials.into_par_iter().filter_map(|trial| {
            let separation = self.separation(&trial, &[], &cost)?;
            Some((trial, separation))
        });
        judged.collect()
    }

    /// By what the candidates cost on each other's logs of a trial, beside logs that are known.
    fn separation(
        &self,
        trial: &Trial,
        known: &[CoreLog],
        cost: impl Fn(&Data, usize) -> Option<f64>,
    ) -> Option<Separation> {
        let count = self.candidates.len();
        let mut squares = vec![vec![0.0; count]; count];
        let mut windows = 0;
        for (truth, course) in trial.courses.iter().enumerate() {
            let series = self.log_of(trial, course, truth as u64);
            let logs: Vec<CoreLog> = known.iter().copied().chain([series.log()]).collect();
            let on = |logs| Data {
                logs,
                ..self.workbench.data
            };
            let data = on(&logs);
            windows = data.windows() - on(known).windows();
            let samples = (windows * data.settings.window) as f64;
            let own = cost(&data, truth)?;
            for other in (0..count).filter(|other| *other != truth) {
                squares[truth][other] = (cost(&data, other)? - own) / samples;
            }
        }
        let limit = self.limit(windows);
        Some(Separation { squares, limit })
    }

    /// Sum of a candidate's squared residuals once a step has been made.
    fn remaining(&self, data: &Data, place: usize) -> Option<f64> {
        let sums = self.sums(data, &InOrder, place)?;
        let count = self.variables(place);
        let mut matrix = sums.normal(count);
        let mut step = [0.0; MOST_VARIABLES];
        for row in 0..count {
            step[row] = sums.products.at(row + 1, 0);
            for (entry, known) in matrix
                .row_mut(row)
                .iter_mut()
                .zip(self.known[place].row(row))
            {
                *entry += known;
            }
            matrix.row_mut(row)[row] += LEAST_WEIGHT;
        }
        Cholesky::new(matrix, count).forward(&mut step[..count]);
        let taken: f64 = step[..count].iter().map(|value| value * value).sum();
        Some(sums.products.at(0, 0) - taken)
    }

    /// How far a trial sets the candidates apart, by refits to the training logs and its own.
    pub fn refitted(&self, trial: &Trial) -> Option<Separation> {
        self.separation(trial, self.workbench.data.logs, |data, place| {
            let model = &self.candidates[place].model;
            let variables = self.workbench.variables(model);
            let fit = fit::fit(data, &AllCores, ALL, model, &variables, EFFORT)?;
            Some(fit.cost)
        })
    }

    /// The squared distance from which two candidates are separated by an experiment of so many
    /// windows: the training logs, on which they are one, count as well.
    fn limit(&self, windows: usize) -> f64 {
        let all = self.workbench.data.windows() + windows;
        SEPARATED * all as f64 / windows.max(1) as f64
    }
}
