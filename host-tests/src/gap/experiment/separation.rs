//! How far an experiment sets candidates apart.
//!
//! Each candidate in turn is taken for the machine: its log of the experiment is made, with the
//! sensor's resolution and noise, and the others are refitted to the training logs and this one
//! together. What their error is then above the true one's, by sample of the experiment and in
//! multiples of the noise, is the distance. Base parameters, strengths and shapes are all refitted: an
//! effect that a refit imitates is not separated.

use model_core::gap::ensemble::{Ensemble, Store};
use model_core::gap::fit::{self, MOST_VARIABLES, Matrix};
use model_core::gap::model::Model;
use model_core::gap::replay::{self, Data, Fold, InOrder, Schedule, Sums};
use model_core::gap::workbench::Workbench;
use model_core::numeric::cholesky::Cholesky;
use model_core::numeric::random::Random;

use super::candidates::Candidates;
use super::limits::{Course, Trial};
use super::variants;
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

/// Mean square from which on more is worth no more.
const CLEAR: f64 = 25.0;

/// Weight that holds a variable which nothing determines.
const LEAST_WEIGHT: f64 = 3.0;

/// All windows as one fold.
const ALL: (Fold, usize) = (Fold::All, 1);

/// Adds the floor that the selection adds to the noise of the position.
pub(super) fn weigh(workbench: &mut Workbench<impl Schedule>) {
    let settings = &mut workbench.data.settings;
    let noise = 1.0 / settings.position_weight;
    let floor = FLOOR_COUNTS * settings.resolution;
    settings.position_weight = 1.0 / (noise * noise + floor * floor).sqrt();
}

/// How far an experiment sets candidates apart: squares of distances, by the one that is taken for
/// the machine and the one that is refitted to its log, the last of which is the model without any.
/// The least of all variants.
#[derive(Debug, Clone)]
pub(super) struct Separation {
    /// Refitted to the log of the experiment.
    alone: Vec<Vec<f64>>,
    /// Refitted to that and the training logs.
    beside: Vec<Vec<f64>>,
    /// The candidate without an effect, where it is one of them.
    nothing: Option<usize>,
}

impl Separation {
    /// The distance of two candidates beside the training logs, whichever of them is the machine. Of one
    /// without an effect only the other's log tells: at no strength every effect follows its own.
    pub fn distance(&self, a: usize, b: usize) -> f64 {
        let (of_a, of_b) = (self.beside[a][b], self.beside[b][a]);
        let square = if self.nothing == Some(a) {
            of_b
        } else if self.nothing == Some(b) {
            of_a
        } else {
            of_a.min(of_b)
        };
        square.max(0.0).sqrt()
    }

    /// Whether it is far enough for refits to tell them apart.
    pub fn separates(&self, a: usize, b: usize) -> bool {
        self.distance(a, b).powi(2) >= SEPARATED
    }

    /// By how far it separates all of them together: what is clear already counts no more.
    pub fn promise(&self) -> f64 {
        let squares = self.alone.iter().chain(&self.beside).flatten();
        squares.map(|square| square.clamp(0.0, CLEAR).ln_1p()).sum()
    }
}

/// What experiments are judged with.
pub(super) struct Bench<'b, 'a> {
    pub workbench: &'b Workbench<'a, AllCores>,
    /// Each candidate as it is fitted, then its variants.
    pub variants: Vec<Vec<Model>>,
    /// The model without any of the candidates, and its variants.
    without: Vec<Model>,
    /// What the training logs say about the variables of each candidate, and of the model without.
    known: Vec<Matrix>,
    /// The candidate without an effect, where it is one of them.
    nothing: Option<usize>,
}

impl<'b, 'a> Bench<'b, 'a> {
    /// `None` if a candidate cannot be built.
    pub fn new(workbench: &'b Workbench<'a, AllCores>, candidates: &Candidates) -> Option<Self> {
        let by_candidate: Vec<Vec<Model>> = candidates
            .all
            .iter()
            .map(|candidate| variants::of(workbench, &candidate.model))
            .collect();
        let variants = (0..=variants::VARIANTS).map(|variant| {
            let models = by_candidate.iter().map(|models| models[variant].clone());
            models.collect()
        });
        let mut bench = Self {
            workbench,
            variants: variants.collect(),
            without: variants::of(workbench, &candidates.without),
            known: Vec::new(),
            nothing: candidates.all.iter().position(|it| it.subject.is_none()),
        };
        for place in 0..=candidates.all.len() {
            let model = bench.rival(0, place);
            let sums = bench.sums(&workbench.data, &AllCores, model)?;
            let known = sums.normal(workbench.variables(model).len());
            bench.known.push(known);
        }
        Some(bench)
    }

    /// A variant of a candidate; behind the last of them, of the model without any.
    fn rival(&self, variant: usize, place: usize) -> &Model {
        let candidates = &self.variants[variant];
        candidates.get(place).unwrap_or(&self.without[variant])
    }

    /// Residual and sensitivities of a model on a log.
    fn sums(&self, data: &Data, schedule: &impl Schedule, model: &Model) -> Option<Sums> {
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

    /// The log that a machine of this course would leave.
    pub fn log_of(&self, trial: &Trial, course: &Course, seed: u64) -> Series {
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
            load: None,
            enabled: None,
        }
    }

    /// How far a trial sets the candidates apart as they are fitted. No refit brings them further apart.
    pub fn unfitted(&self, trial: &Trial) -> Option<Separation> {
        self.separation(trial, 1, |data, (variant, place)| {
            let simulator = self.rival(variant, place).build(data.logs.first()?.period);
            let (cost, _) = replay::cost(data, &InOrder, ALL, &simulator.ok()?);
            Some([cost, cost])
        })
    }

    /// How far a trial sets so many variants of the candidates apart by linear theory: the residual of
    /// each on the others' logs less what a step of Gauss and Newton takes off it.
    pub fn linear(&self, trial: &Trial, variants: usize) -> Option<Separation> {
        self.separation(trial, variants, |data, rival| self.remaining(data, rival))
    }

    /// By what the candidates, and the model without any, cost on each other's logs of a trial: alone
    /// and beside the training logs.
    fn separation(
        &self,
        trial: &Trial,
        variants: usize,
        cost: impl Fn(&Data, (usize, usize)) -> Option<[f64; 2]>,
    ) -> Option<Separation> {
        let count = self.variants[0].len();
        let unknown = vec![vec![f64::MAX; count + 1]; count];
        let mut separation = Separation {
            alone: unknown.clone(),
            beside: unknown,
            nothing: self.nothing,
        };
        for variant in 0..variants {
            for truth in 0..count {
                let course = &trial.courses[variant][truth];
                let series = self.log_of(trial, course, truth as u64);
                let logs = [series.log()];
                let data = Data {
                    logs: &logs,
                    ..self.workbench.data
                };
                let windows = data.windows();
                let samples = (windows * data.settings.window) as f64;
                // Where the training logs count as well, on which they are one, the error of all logs
                // has to be as large.
                let all = self.workbench.data.windows() + windows;
                let thinner = windows as f64 / all as f64;
                let own = cost(&data, (variant, truth))?;
                for other in 0..=count {
                    let (alone, beside) = if other == truth {
                        (0.0, 0.0)
                    } else {
                        let rival = cost(&data, (variant, other))?;
                        let above = |at: usize| (rival[at] - own[at]) / samples;
                        (above(0), thinner * above(1))
                    };
                    let least = &mut separation.alone[truth][other];
                    *least = least.min(alone);
                    let least = &mut separation.beside[truth][other];
                    *least = least.min(beside);
                }
            }
        }
        Some(separation)
    }

    /// Sum of a model's squared residuals once a step has been made: alone and beside the training
    /// logs.
    fn remaining(&self, data: &Data, (variant, place): (usize, usize)) -> Option<[f64; 2]> {
        let model = self.rival(variant, place);
        let sums = self.sums(data, &InOrder, model)?;
        let count = self.workbench.variables(model).len();
        let remaining = |known: Option<&Matrix>| {
            let mut matrix = sums.normal(count);
            let mut step = [0.0; MOST_VARIABLES];
            for row in 0..count {
                step[row] = sums.products.at(row + 1, 0);
                if let Some(known) = known {
                    let entries = matrix.row_mut(row).iter_mut();
                    for (entry, known) in entries.zip(known.row(row)) {
                        *entry += known;
                    }
                }
                matrix.row_mut(row)[row] += LEAST_WEIGHT;
            }
            Cholesky::new(matrix, count).forward(&mut step[..count]);
            let taken: f64 = step[..count].iter().map(|value| value * value).sum();
            sums.products.at(0, 0) - taken
        };
        Some([remaining(None), remaining(Some(&self.known[place]))])
    }
}
