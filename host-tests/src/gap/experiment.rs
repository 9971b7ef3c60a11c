//! The next experiment: which input would tell apart what the logs do not.
//!
//! A log may leave several explanations standing: effects that are one model on its motion, an effect
//! that a fitted parameter imitates, several learned maps that come equally near. Then each of them is
//! fitted to the logs (`candidates`), the usual excitations of the field (`excitation`) are scaled
//! to what the machine has been shown to take (`limits`), and the one that sets the candidates apart
//! best is proposed (`separation`): the one whose log, were one candidate true, every other one would
//! follow worst however it were refitted. That is T-optimality (A. C. Atkinson, V. V. Fedorov, *The
//! Design of Experiments for Discriminating Between Two Rival Models*, Biometrika 62, 1975), over a
//! list of excitations instead of all inputs.
//!
//! What is not allowed for: a machine that is none of the candidates; an effect that comes to light
//! beside them only in the experiment. Where several of the effects that were found are in doubt, the
//! first of them is taken: the next logs are traced anew in any case.

mod candidates;
mod excitation;
mod limits;
mod separation;

use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::Path;

use serde::Serialize;

use self::candidates::Candidate;
use self::limits::{Limits, Trial};
use self::separation::{Bench, Separation};
use super::engine::{Found, with_workbench};
use super::metrics::decimal;
use crate::failure::Failure;
use crate::log::Log;
use crate::machine::Machine;
use crate::quantity::significant;
use crate::whole_file;

/// Excitations that are judged by linear theory, those that set the candidates furthest apart before
/// anything is refitted; and of these, those that are judged by refits.
const LINEARISED: usize = 24;
const REFITTED: usize = 3;

/// Distance, in multiples of the noise, from which on nothing better is looked for where every pair is
/// separated.
const CLEAR: f64 = 5.0;

/// The experiment that would tell candidates apart, or that none was found that would.
#[derive(Debug, Clone, Serialize)]
pub struct NextExperiment {
    /// What the logs cannot tell apart, what was named first.
    pub candidates: Vec<String>,
    /// Those of them that the experiment tells from one other at least.
    pub separates: Vec<String>,
    /// Pairs that it would leave as they are.
    pub leaves: Vec<[String; 2]>,
    /// The input in words; null where no excitation within the limits separates any two.
    pub excitation: Option<String>,
    /// Least distance of two candidates that it separates, in multiples of the measurement's noise.
    pub separation: Option<f64>,
    /// How long it takes, s.
    pub duration_s: Option<f64>,
    /// Where the machine is to rest before it, rad or m.
    pub start_position: Option<f64>,
    /// The CSV with the input, where one was written.
    pub file: Option<String>,
    /// Within what it was looked for.
    pub limits: Bounds,
    /// What to play and what to expect.
    #[serde(skip)]
    pub plan: Option<Plan>,
}

/// Within what an experiment stays.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bounds {
    /// Greatest magnitude of the input: what the training logs show that the machine takes.
    pub input: f64,
    /// Lowest position that a candidate may reach, rad or m.
    pub lowest_position: f64,
    /// Highest position that a candidate may reach, rad or m.
    pub highest_position: f64,
    /// Greatest speed that a candidate may reach, rad/s or m/s.
    pub speed: f64,
}

/// An input and what the candidates make of it.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Sampling period, s: that of the logs.
    pub period_s: f64,
    /// The input, held from its sample to the next.
    pub input: Vec<f32>,
    /// Positions that each candidate predicts, from rest and without restarts.
    pub predicted: Vec<(String, Vec<f32>)>,
}

impl Plan {
    /// The input as CSV with the columns `time_s` and `input`.
    pub fn to_csv(&self) -> String {
        let mut text = String::from("time_s,input\n");
        for (row, input) in self.input.iter().enumerate() {
            // Twelve decimals spare the reader 0.30000000000000004.
            let time_s = (row as f64 * self.period_s * 1e12).round() / 1e12;
            let _ = writeln!(text, "{time_s:?},{input:?}");
        }
        text
    }
}

impl NextExperiment {
    /// Writes the input to a file and remembers its name; nothing where there is no input.
    ///
    /// # Errors
    /// Those of writing the file.
    pub fn write(&mut self, path: &Path) -> io::Result<()> {
        if let Some(plan) = &self.plan {
            whole_file::write(path, |partial| fs::write(partial, plan.to_csv()))?;
            self.file = Some(path.display().to_string());
        }
        Ok(())
    }

    /// What is in doubt and what would settle it, in two sentences. `unit`: that of positions.
    pub fn sentences(&self, unit: &str) -> String {
        let (named, others) = self.candidates.split_at(1);
        let doubt = format!("The logs cannot tell {} from {}.", named[0], listed(others));
        let number = |value: f64| significant(value, 3);
        let (Some(excitation), Some(separation), Some(duration), Some(start)) = (
            &self.excitation,
            self.separation,
            self.duration_s,
            self.start_position,
        ) else {
            let bounds = &self.limits;
            return format!(
                "{doubt} No excitation that was tried would, with an input up to {}, a position \
                 from {} to {} {unit} and a speed up to {} {unit}/s; wider limits, another sensor \
                 or a brake may.",
                number(bounds.input),
                number(bounds.lowest_position),
                number(bounds.highest_position),
                number(bounds.speed),
            );
        };
        let pairs = self.leaves.iter();
        let left: Vec<String> = pairs.map(|[a, b]| format!("{a} from {b}")).collect();
        let left = if left.is_empty() {
            String::new()
        } else {
            format!(", but not {}", listed(&left))
        };
        format!(
            "{doubt} An experiment in open loop would: {excitation}, {} s from rest at {} {unit}; it \
             sets {} apart by {} times the noise{left}.",
            number(duration),
            number(start),
            listed(&self.separates),
            number(separation),
        )
    }
}

/// `a`, `a and b`, `a, b and c`
fn listed(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [rest @ .., last] => format!("{} and {last}", rest.join(", ")),
    }
}

/// The experiment that would tell apart what the training logs do not; `None` where they leave
/// nothing in doubt. Without doubt it costs nothing.
///
/// # Errors
/// Those of laying out the logs, which were traced before.
pub fn next(
    machine: &Machine,
    train: &[Log],
    found: &Found,
) -> Result<Option<NextExperiment>, Failure> {
    let Some(doubt) = candidates::doubt(&found.trace, &found.looks) else {
        return Ok(None);
    };
    with_workbench(machine, train, |workbench| {
        workbench.data.settings = found.settings;
        separation::weigh(workbench);
        let Some(candidates) = candidates::fitted(workbench, &found.trace, &doubt) else {
            return Some(None);
        };
        let limits = Limits::of(workbench, &candidates[0].model);
        let trials = limits::trials(workbench, &candidates, &limits);
        let bench = Bench::new(workbench, &candidates)?;
        let best = best(&bench, trials);
        Some(Some(proposal(&candidates, &limits, best)))
    })
}

/// The trial that separates best: those that promise most by linear theory, judged by refits.
fn best(bench: &Bench, trials: Vec<Trial>) -> Option<(Trial, Separation)> {
    let far_apart = most_promising(bench.unfitted(trials), LINEARISED);
    let promising = most_promising(bench.linear(far_apart), REFITTED);
    let mut best: Option<(Trial, Separation)> = None;
    for trial in promising {
        let Some(separation) = bench.refitted(&trial) else {
            continue;
        };
        let known = best.as_ref().map(|(_, known)| known.rank());
        if known.is_none_or(|known| separation.rank() > known) {
            let clear = separation.is_complete() && separation.least() >= CLEAR;
            best = Some((trial, separation));
            if clear {
                break;
            }
        }
    }
    best.filter(|(_, separation)| separation.separates_any())
}

/// So many of the trials that promise most, the best first.
fn most_promising(mut judged: Vec<(Trial, Separation)>, count: usize) -> Vec<Trial> {
    judged.sort_by(|(_, a), (_, b)| b.promise().total_cmp(&a.promise()));
    judged.truncate(count);
    judged.into_iter().map(|(trial, _)| trial).collect()
}

fn proposal(
    candidates: &[Candidate],
    limits: &Limits,
    best: Option<(Trial, Separation)>,
) -> NextExperiment {
    let names: Vec<String> = candidates.iter().map(|it| it.name.clone()).collect();
    let nothing = NextExperiment {
        candidates: names.clone(),
        separates: Vec::new(),
        leaves: Vec::new(),
        excitation: None,
        separation: None,
        duration_s: None,
        start_position: None,
        file: None,
        limits: limits.bounds(),
        plan: None,
    };
    let Some((trial, separation)) = best else {
        return nothing;
    };
    let name = |place: usize| names[place].clone();
    let period_s = decimal(limits.period);
    NextExperiment {
        separates: separation.separated().into_iter().map(name).collect(),
        leaves: separation.left().map(|(a, b)| [name(a), name(b)]).collect(),
        excitation: Some(trial.description()),
        separation: Some(separation.least()),
        duration_s: Some(trial.input.len() as f64 * period_s),
        start_position: Some(decimal(limits.start)),
        plan: Some(Plan {
            period_s,
            predicted: names
                .iter()
                .cloned()
                .zip(trial.courses.into_iter().map(|course| course.position))
                .collect(),
            input: trial.input,
        }),
        ..nothing
    }
}
