//! Excitations scaled to what the machine has been shown to take.

use model_core::gap::model::Model;
use model_core::gap::replay::{MARGIN, Row, Runner, Schedule, Settings, samples};
use model_core::gap::workbench::Workbench;
use model_core::plant::parameters::{Drive, Parameters};
use rayon::prelude::*;

use super::Bounds;
use super::candidates::Candidate;
use super::excitation::{SHAPES, Shape};
use crate::gap::series::Series;
use crate::quantity::significant;

/// Shares of the greatest input that are tried; beyond friction, of what it leaves.
const AMPLITUDES: [f64; 3] = [1.0, 0.7, 0.4];

/// Share of the greatest input up to which friction may take it where an input beyond it is tried.
const MOST_FRICTION: f64 = 0.9;

/// Greatest speed, in multiples of the greatest that was seen.
const FASTER: f32 = 1.5;

/// Share of the range of positions by which a candidate may leave it on either side, where no stop is
/// declared: a machine that follows none of them exactly still stays within a quarter.
const WIDER: f32 = 0.15;

/// Share of the stroke that is kept from a declared stop, unless the logs went nearer.
const CLEARANCE: f32 = 0.03;

/// Shortest and longest experiment, s; in between it is as long as the longest log.
const SHORTEST: f32 = 5.0;
const LONGEST: f32 = 10.0;

/// Rest before the input begins and after it ends, s.
const REST: f32 = 0.1;

/// Each trial of a period is this much shorter than the one before, and none is shorter than so many
/// samples.
const SHORTER: f64 = 0.75;
const SHORTEST_PERIOD: f64 = 40.0;

/// Samples over which a speed is taken.
const SPEED_SPAN: usize = 4;

/// The longest period that the limits allow and these shares of it are tried.
const PERIODS: [f64; 3] = [1.0, 0.65, 0.4];

/// Share of the greatest speed that was seen from which on the machine slides clearly, and shares of
/// the acting time for which it has to in either direction.
const CLEAR_SPEED: f32 = 0.05;
const LEAST_SLIDING: f32 = 0.1;

/// Least travel of a variant as a share of that of the one that travels farthest.
const STEADY: f32 = 0.5;

/// What the machine has been shown to take, and where the experiment starts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Sampling period, s.
    pub period: f32,
    /// Where the machine rests before it, rad or m.
    pub start: f32,
    input: f32,
    /// Input that sliding friction takes.
    friction: f64,
    position: (f32, f32),
    /// Greatest speed in the logs.
    seen_speed: f32,
    /// Samples.
    length: usize,
}

/// What a candidate makes of an input.
#[derive(Debug, Clone)]
pub(super) struct Course {
    /// Reported position.
    pub position: Vec<f32>,
    /// Current as it is measured; empty without a winding.
    pub current: Vec<f32>,
}

/// An input but for its period.
#[derive(Debug, Clone, Copy)]
struct Kind {
    shape: &'static Shape,
    amplitude: f64,
    /// What is added in the direction of the shape: friction takes it.
    friction: f64,
}

/// An input within the limits.
#[derive(Debug, Clone)]
pub(super) struct Trial {
    kind: Kind,
    period_s: f64,
    /// The input.
    pub input: Vec<f32>,
    /// What each candidate makes of it: as it is fitted, then each of its variants.
    pub courses: Vec<Vec<Course>>,
}

impl Trial {
    /// The input in words.
    pub fn description(&self) -> String {
        let beyond = if self.kind.friction > 0.0 {
            " beyond friction"
        } else {
            ""
        };
        format!(
            "{}{beyond}, up to {} with a period of {} s",
            self.kind.shape.name,
            significant(self.kind.friction + self.kind.amplitude, 3),
            significant(self.period_s, 3)
        )
    }
}

impl Limits {
    /// The limits that the training logs and the declared stops set; the named model says where the
    /// machine rests.
    pub fn of(workbench: &Workbench<impl Schedule>, model: &Model) -> Self {
        let logs = workbench.data.logs;
        let plant = model.bound_plant();
        let ranges = &workbench.options.ranges;
        let (mut lowest, mut highest) = (f32::MAX, f32::MIN);
        let mut input = 0.0f32;
        for log in logs {
            for position in log.position.iter() {
                (lowest, highest) = (lowest.min(position), highest.max(position));
            }
            input = log.input.iter().fold(input, |most, u| most.max(u.abs()));
        }
        let seen = highest - lowest;
        let stroke = plant.upper_stop - plant.lower_stop;
        let clearance = CLEARANCE * if stroke.is_finite() { stroke } else { seen };
        let lower = if plant.lower_stop.is_finite() {
            (plant.lower_stop + clearance).min(lowest)
        } else {
            lowest - WIDER * seen
        };
        let upper = if plant.upper_stop.is_finite() {
            (plant.upper_stop - clearance).max(highest)
        } else {
            highest + WIDER * seen
        };
        let start = if plant.spring > 0.0 || plant.spring_preload > 0.0 {
            plant
                .spring_rest
                .max(plant.lower_stop)
                .min(plant.upper_stop)
        } else {
            0.5 * (lowest + highest)
        };
        let period = logs[0].period;
        let longest = logs.iter().map(|log| log.samples()).max().unwrap_or(0);
        Self {
            period,
            start,
            input,
            friction: f64::from(plant.coulomb.forward.max(plant.coulomb.backward))
                / f64::from(torque_per_input(&plant)),
            position: (lower.min(start), upper.max(start)),
            seen_speed: ranges.velocity.1.max(-ranges.velocity.0),
            length: longest.clamp(samples(SHORTEST, period, 1), samples(LONGEST, period, 1)),
        }
    }

    /// For the answer.
    pub fn bounds(&self) -> Bounds {
        let decimal = crate::quantity::decimal;
        Bounds {
            input: decimal(self.input),
            lowest_position: decimal(self.position.0),
            highest_position: decimal(self.position.1),
            speed: decimal(FASTER * self.seen_speed),
        }
    }

    /// What is tried.
    fn kinds(&self) -> Vec<Kind> {
        let most = f64::from(self.input);
        let beyond =
            (self.friction > 0.0 && self.friction < MOST_FRICTION * most).then_some(self.friction);
        let levels = std::iter::once(0.0).chain(beyond);
        let kinds = levels.flat_map(|friction| {
            SHAPES.iter().flat_map(move |shape| {
                AMPLITUDES.map(|share| Kind {
                    shape,
                    amplitude: share * (most - friction),
                    friction,
                })
            })
        });
        kinds.collect()
    }

    /// An input of a kind and a period.
    fn input(&self, kind: &Kind, period_s: f64) -> Vec<f32> {
        let rest = samples(REST, self.period, 2 * MARGIN);
        let acting = self.length.saturating_sub(2 * rest).max(1);
        let step = f64::from(self.period);
        (0..self.length)
            .map(|sample| {
                if sample < rest || sample >= rest + acting {
                    return 0.0;
                }
                let time = (sample - rest) as f64 * step;
                let share = time / (acting as f64 * step);
                let value = (kind.shape.at)(time / period_s, share);
                let friction = if value == 0.0 {
                    0.0
                } else {
                    kind.friction.copysign(value)
                };
                let value = (kind.amplitude * value + friction) as f32;
                value.clamp(-self.input, self.input)
            })
            .collect()
    }

    /// Whether a machine slides clearly, both ways and for long enough.
    fn slides(&self, course: &Course) -> bool {
        let clear = CLEAR_SPEED * self.seen_speed * SPEED_SPAN as f32 * self.period;
        let least = (LEAST_SLIDING * course.position.len() as f32) as usize;
        let moved = || {
            let pairs = course.position.iter().zip(&course.position[SPEED_SPAN..]);
            pairs.map(|(before, after)| after - before)
        };
        moved().filter(|moved| *moved > clear).count() >= least
            && moved().filter(|moved| *moved < -clear).count() >= least
    }

    /// Whether the last of these positions is within the limits, by itself and after those before it.
    fn allow(&self, positions: &[f32]) -> bool {
        let (lower, upper) = self.position;
        let Some((last, before)) = positions.split_last() else {
            return true;
        };
        let past = before.iter().rev().nth(SPEED_SPAN - 1).unwrap_or(last);
        let farthest = FASTER * self.seen_speed * SPEED_SPAN as f32 * self.period;
        (lower..=upper).contains(last) && (last - past).abs() <= farthest
    }
}

/// Torque or force of a motor at rest for one unit of input.
fn torque_per_input(plant: &Parameters) -> f32 {
    match plant.drive {
        Drive::Voltage {
            resistance,
            torque_constant,
            ..
        } => (plant.gain * torque_constant / resistance).abs(),
        Drive::Torque => plant.gain.abs(),
    }
}

impl Course {
    /// The way that the machine goes, rad or m.
    fn travel(&self) -> f32 {
        let pairs = self.position.iter().zip(&self.position[1..]);
        pairs.map(|(before, after)| (after - before).abs()).sum()
    }
}

/// Makes trials of excitations.
pub(super) struct Tryout<'a> {
    pub limits: &'a Limits,
    pub settings: Settings,
    pub has_winding: bool,
}

impl Tryout<'_> {
    /// What a model makes of an input from rest; `None` if it leaves the limits.
    fn course(&self, model: &Model, input: &[f32]) -> Option<Course> {
        let limits = self.limits;
        let simulator = model.build(limits.period).ok()?;
        let rows = input.len();
        // A log of nothing but the input: a residual is then the value itself.
        let blank = Series {
            label: String::new(),
            period: limits.period,
            input: input.to_vec(),
            position: vec![limits.start; rows],
            current: self.has_winding.then(|| vec![0.0; rows]),
            velocity: None,
            brake: None,
            load: None,
            enabled: None,
        };
        let log = blank.log();
        let reading = simulator.current_lateness();
        let mut runner = Runner::new(&simulator, &log, MARGIN, &self.settings);
        let mut position = blank.position.clone();
        let mut current = blank.current.clone().unwrap_or_default();
        for index in MARGIN..rows - 1 {
            let (_, predicted) = runner.advance(&Row::new(&log, index));
            position[index + 1] = runner.reported();
            if !limits.allow(&position[..index + 2]) {
                return None;
            }
            if let Some(measured) = current.get_mut(reading.sample(index, rows)) {
                *measured = predicted;
            }
        }
        let finite = current.iter().all(|value| value.is_finite());
        finite.then_some(Course { position, current })
    }

    fn trial(&self, candidates: &[Candidate], kind: &Kind, period_s: f64) -> Option<Trial> {
        let input = self.limits.input(kind, period_s);
        let mut nominal = Vec::new();
        for candidate in candidates {
            nominal.push(self.course(&candidate.model, &input)?);
        }
        Some(Trial {
            kind: *kind,
            period_s,
            input,
            courses: vec![nominal],
        })
    }

    /// Every excitation that the limits allow, at the longest period that they do and at shorter ones.
    pub fn trials(&self, candidates: &[Candidate]) -> Vec<Trial> {
        let limits = self.limits;
        let step = f64::from(limits.period);
        let longest = 0.5 * limits.length as f64 * step;
        let shortest = SHORTEST_PERIOD * step;
        let found = limits.kinds().into_par_iter().map(|kind| {
            let periods = std::iter::successors(Some(longest), |period| Some(period * SHORTER));
            let first = periods
                .take_while(|period| *period >= shortest)
                .find_map(|period| self.trial(candidates, &kind, period));
            let Some(first) = first else {
                return Vec::new();
            };
            let others = PERIODS[1..]
                .iter()
                .map(|share| share * first.period_s)
                .filter(|period| *period >= shortest)
                .filter_map(|period| self.trial(candidates, &kind, period));
            let others: Vec<Trial> = others.collect();
            std::iter::once(first).chain(others).collect()
        });
        found.flatten_iter().collect()
    }

    /// The trial with the courses of the variants, the first of which are the candidates themselves.
    /// `None` where any of them leaves the limits, or where one that is no map hardly moves or goes
    /// another way than the rest: then small errors of the numbers decide what the machine does.
    pub fn steady(&self, mut trial: Trial, variants: &[Vec<Model>]) -> Option<Trial> {
        for models in &variants[trial.courses.len()..] {
            let mut courses = Vec::new();
            for model in models {
                courses.push(self.course(model, &trial.input)?);
            }
            trial.courses.push(courses);
        }
        let all = || {
            let courses = trial.courses.iter().zip(variants);
            courses.flat_map(|(courses, models)| {
                let both = courses.iter().zip(models);
                both.filter(|(_, model)| model.map.is_none())
            })
        };
        let (mut shortest, mut farthest) = (f32::MAX, 0.0f32);
        for (course, _) in all() {
            let travel = course.travel();
            (shortest, farthest) = (shortest.min(travel), farthest.max(travel));
        }
        let slides = all().all(|(course, _)| self.limits.slides(course));
        (slides && shortest >= STEADY * farthest).then_some(trial)
    }
}
