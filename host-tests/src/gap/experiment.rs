//! The next experiment: which input would tell apart what the logs do not.
//!
//! A log may leave several explanations standing: effects that are one model on its motion, an effect
//! that a fitted parameter imitates, several learned maps that come equally near. Or nothing was found,
//! and could not have been, for the fitted parameters absorb what an effect does on this motion: such an
//! effect is a candidate beside the model without any, as strong as it may be unseen, half of its typical
//! size at most. Each candidate is fitted to the logs (`candidates`), and the usual excitations of the
//! field (`excitation`) are scaled to what the machine has been shown to take (`limits`). A good
//! experiment
//!
//! * is steady: with every fitted number off by up to a twentieth (`variants`), the machine still stays
//!   within the limits, slides clearly in both directions and goes about the same way. Where the input
//!   hardly passes breakaway, small errors decide whether anything moves, and the log says nothing;
//! * sets the candidates apart, and each of them from the model without any (`separation`): its log,
//!   were one candidate true, every other one would follow badly however it were refitted. That is
//!   T-optimality (A. C. Atkinson, V. V. Fedorov, *The Design of Experiments for Discriminating Between
//!   Two Rival Models*, Biometrika 62, 1975), over a list of excitations instead of all inputs, by the
//!   worst of the variants;
//! * has been rehearsed (`rehearsal`): the logs that it would leave are traced beside the known ones, and
//!   name the candidates that it is said to tell apart and nothing that was never in doubt; and alone,
//!   where what can be told so counts for the choice and is said. Where none passes, the one that
//!   promises most is proposed and said to be unconfirmed.
//!
//! What is not allowed for: a machine that is none of the candidates; an effect that comes to light
//! beside them only in the experiment. Where several of the effects that were found are in doubt, the
//! first of them is taken: the next logs are traced anew in any case.

mod candidates;
mod excitation;
mod limits;
mod rehearsal;
mod separation;
mod variants;

use std::fmt::Write as _;

use rayon::prelude::*;
use serde::Serialize;

use self::candidates::{Candidate, Candidates, Reason};
use self::limits::{Limits, Trial, Tryout};
use self::rehearsal::Rehearsal;
use self::separation::{Bench, Separation};
use super::answer::listed;
use super::engine::{Found, with_workbench};
use crate::failure::Failure;
use crate::log::Log;
use crate::machine::Machine;
use crate::outputs::INPUT_HEADER;
use crate::quantity::decimal;
use crate::quantity::{Scale, significant};

/// Steady trials of which linear theory judges the candidates as they are fitted: those that set them
/// furthest apart before anything is refitted. Of these, those that are judged by all variants; and of
/// these, those that are rehearsed.
const LINEARISED: usize = 32;
const VARIED: usize = 12;
const REHEARSED: usize = 3;

/// The experiment that would tell candidates apart, or that none was found that would.
#[derive(Debug, Clone, Serialize)]
pub struct NextExperiment {
    /// What may be true: what was named, those equivalent to it and those near it; where nothing was
    /// found, `no effect` and those of `absorbed` that were set against it.
    pub candidates: Vec<String>,
    /// Those that the answer calls equivalent to what it names.
    pub equivalent: Vec<String>,
    /// Others that, refitted, follow the logs about as well: with a mean square error of at most 1.5
    /// times that of what was named.
    pub near: Vec<String>,
    /// Those of either that are one law with what was named, and so no candidates: no input tells them apart, only a changed machine.
    pub same_law: Vec<String>,
    /// Identifiability of what was named, where it is so low that fitted parameters may be it; else
    /// null.
    pub low_identifiability: Option<f64>,
    /// Where nothing was found: what the logs would not have shown.
    pub absorbed: Vec<Absorbed>,
    /// Whether an experiment was looked for.
    pub looked: bool,
    /// Those of them that the experiment tells from one other at least.
    pub separates: Vec<String>,
    /// Pairs that it would leave as they are.
    pub leaves: Vec<[String; 2]>,
    /// Whether a rehearsal confirms it: tracings of the logs that the candidates would leave name them.
    pub confirmed: bool,
    /// Whether its log tells as many apart alone; else it has to be given beside the others.
    pub alone: bool,
    /// The input in words; null where none was looked for, or no excitation within the limits separates
    /// any two.
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

/// An effect that the logs would not show, for the fitted parameters absorb it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Absorbed {
    /// The catalogue's id.
    pub id: String,
    /// How strong it may be there, unseen.
    pub parameters: Vec<Quantity>,
}

/// A number with its unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quantity {
    /// Name of the parameter.
    pub name: String,
    /// Its value, SI.
    pub value: f64,
    /// Its unit.
    pub unit: String,
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

impl Bounds {
    /// Within what nothing was found, and what would widen that. `unit`: that of positions.
    pub(super) fn in_words(&self, unit: &str) -> String {
        let number = |value: f64| significant(value, 3);
        format!(
            "with an input up to {}, positions from {} to {} {unit} and a speed up to {} {unit}/s, as in the training \
             logs; another --train that goes further widens these limits",
            number(self.input),
            number(self.lowest_position),
            number(self.highest_position),
            number(self.speed),
        )
    }
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
        let mut text = format!("{INPUT_HEADER}\n");
        for (row, input) in self.input.iter().enumerate() {
            // Twelve decimals spare the reader 0.30000000000000004.
            let time_s = (row as f64 * self.period_s * 1e12).round() / 1e12;
            let _ = writeln!(text, "{time_s:?},{input:?}");
        }
        text
    }
}

impl NextExperiment {
    /// What may be true, with no experiment yet that was looked for or found.
    pub fn open(candidates: Vec<String>, limits: Bounds) -> Self {
        Self {
            candidates,
            equivalent: Vec::new(),
            near: Vec::new(),
            same_law: Vec::new(),
            low_identifiability: None,
            absorbed: Vec::new(),
            looked: false,
            separates: Vec::new(),
            leaves: Vec::new(),
            confirmed: false,
            alone: false,
            excitation: None,
            separation: None,
            duration_s: None,
            start_position: None,
            file: None,
            limits,
            plan: None,
        }
    }

    /// What is in doubt and what would settle it. `unit`: that of positions.
    pub fn sentences(&self, unit: &str) -> String {
        let doubt = self.doubt();
        if self.needs_another_machine() {
            return format!(
                "{doubt} No input would tell them apart: they are one law of the position."
            );
        }
        let settle = match self.absorbed.len() {
            0 => "tell them apart",
            1 => "show it",
            _ => "show them",
        };
        if !self.looked {
            return format!(
                "{doubt} --experiment FILE, or --report DIR, looks for an input that would {settle}, and may find none."
            );
        }
        let number = |value: f64| significant(value, 3);
        let (Some(excitation), Some(separation), Some(duration), Some(start)) = (
            &self.excitation,
            self.separation,
            self.duration_s,
            self.start_position,
        ) else {
            return format!(
                "{doubt} No input that was tried would {settle}, even where fitted numbers are off by a \
                 twentieth, {}.",
                self.limits.in_words(unit)
            );
        };
        let pairs = self.leaves.iter();
        let left: Vec<String> = pairs
            .map(|[a, b]| format!("{} from {}", self.in_words(a), self.in_words(b)))
            .collect();
        let left = if left.is_empty() {
            String::new()
        } else {
            format!(", but not {}", listed(&left))
        };
        let alone = if self.alone {
            ""
        } else {
            "; alone it may mislead"
        };
        let would = if self.confirmed {
            "would tell"
        } else {
            "may tell, though no rehearsal of it does"
        };
        format!(
            "{doubt} An experiment in open loop {would}: {excitation}, {} s from rest at {} {unit}. \
             Give its log together with these{alone}. That tells {} apart by {} times the noise{left}.",
            number(duration),
            number(start),
            self.all_in_words(&self.separates),
            number(separation),
        )
    }

    /// What the logs leave open, as the answer has it: what it calls equivalent, what is low.
    pub(super) fn doubt(&self) -> String {
        if !self.absorbed.is_empty() {
            let absorbed: Vec<String> = self.absorbed.iter().map(Absorbed::in_words).collect();
            return format!(
                "These logs would not show {}: other fitted numbers make up for it.",
                any_of(&absorbed)
            );
        }
        let named = &self.candidates[0];
        let mut doubts = Vec::new();
        if !self.equivalent.is_empty() {
            let equivalent = self.all_in_words(&self.equivalent);
            doubts.push(format!("The logs cannot tell {named} from {equivalent}."));
        }
        doubts.extend(self.rivals());
        doubts.join(" ")
    }

    /// Whether all that is in doubt is one law: no input settles it.
    pub(super) fn needs_another_machine(&self) -> bool {
        !self.same_law.is_empty() && self.candidates.len() < 2
    }

    /// What is in doubt, as a part of a sentence.
    pub(super) fn question(&self) -> String {
        if !self.absorbed.is_empty() {
            let ids: Vec<String> = self.absorbed.iter().map(|one| one.id.clone()).collect();
            return format!(
                "whether {} acts too, which these logs would not show",
                any_of(&ids)
            );
        }
        // Those among the equivalent ones that no experiment settles are no part of its question.
        let rivals = self.equivalent.iter().chain(&self.near);
        let rivals = rivals.filter(|rival| self.candidates.contains(rival));
        let mut rivals: Vec<String> = rivals.map(|rival| self.in_words(rival)).collect();
        if rivals.is_empty() {
            rivals.push("fitted numbers that are off".to_owned());
        }
        let named = self.candidates.first().map(|named| self.in_words(named));
        format!(
            "whether it is {} or {}",
            named.unwrap_or_default(),
            any_of(&rivals)
        )
    }

    /// What beside its equivalents may be true instead of what was named, a sentence each.
    pub(super) fn rivals(&self) -> Vec<String> {
        let mut doubts = Vec::new();
        let Some(named) = self.candidates.first() else {
            return doubts;
        };
        if let Some(identifiability) = self.low_identifiability {
            doubts.push(format!(
                "The fitted numbers, set a little differently, do {:.0} % of what {named} does: take its size with care.",
                (100.0 * (1.0 - identifiability)).min(MOST_SAID)
            ));
        }
        let others = self
            .same_law
            .iter()
            .filter(|name| !self.equivalent.contains(name));
        let near: Vec<String> = self
            .near
            .iter()
            .chain(others)
            .map(|name| self.in_words(name))
            .collect();
        if !near.is_empty() {
            doubts.push(format!(
                "It may also be {}, not {}: the logs cannot tell.",
                any_of(&near),
                self.in_words(named)
            ));
        }
        doubts
    }

    /// A candidate in a sentence.
    fn in_words(&self, name: &str) -> String {
        if name != candidates::NOTHING {
            name.to_owned()
        } else if self.absorbed.len() > 1 {
            "the model without them".to_owned()
        } else {
            "the model without it".to_owned()
        }
    }

    fn all_in_words(&self, names: &[String]) -> String {
        let names: Vec<String> = names.iter().map(|name| self.in_words(name)).collect();
        listed(&names)
    }
}

impl Absorbed {
    /// With its strength, in a sentence, in the units of a workshop. The catalogue reports that first.
    fn in_words(&self) -> String {
        match self.parameters.first() {
            Some(size) => format!("{} ({})", self.id, size.in_words()),
            None => self.id.clone(),
        }
    }
}

/// Most per cent that is said of what other numbers do: all of it, none does.
const MOST_SAID: f64 = 99.0;

impl Quantity {
    fn in_words(&self) -> String {
        let prefixed = |value: f64, unit: &str| {
            let scale = Scale::of(unit, [value]);
            (significant(value * scale.factor, 2), scale.unit)
        };
        let (value, unit) = match self.unit.as_str() {
            // A ratio.
            "1" => (significant(100.0 * self.value, 2), "%".to_owned()),
            "1/s" => (significant(100.0 * self.value, 2), "% a second".to_owned()),
            "rad" => return format!("{}°", significant(self.value.to_degrees(), 2)),
            "m" => (significant(1e3 * self.value, 2), "mm".to_owned()),
            "N·m/rad" => {
                let (value, unit) = prefixed(self.value.to_radians(), "N·m");
                (value, format!("{unit} a degree"))
            }
            "N/m" => {
                let (value, unit) = prefixed(1e-3 * self.value, "N");
                (value, format!("{unit} a millimetre"))
            }
            unit => prefixed(self.value, unit),
        };
        format!("{value} {unit}")
    }
}

/// `a`, `a or b`, `a, b or c`
pub(super) fn any_of(names: &[String]) -> String {
    match names {
        [rest @ .., last] if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => names.concat(),
    }
}

/// The experiment that would tell apart what the training logs do not; `None` where they leave
/// nothing in doubt. Without doubt it costs nothing, else many times what the tracing did.
///
/// # Errors
/// Those of laying out the logs, which were traced before.
pub fn next(
    machine: &Machine,
    train: &[Log],
    found: &Found,
) -> Result<Option<NextExperiment>, Failure> {
    with_doubt(machine, train, found, true)
}

/// What the training logs do not tell apart, with no experiment looked for.
///
/// # Errors
/// As [`next`].
pub fn doubt(
    machine: &Machine,
    train: &[Log],
    found: &Found,
) -> Result<Option<NextExperiment>, Failure> {
    with_doubt(machine, train, found, false)
}

fn with_doubt(
    machine: &Machine,
    train: &[Log],
    found: &Found,
    look: bool,
) -> Result<Option<NextExperiment>, Failure> {
    let Some(doubt) = candidates::doubt(&found.trace, &found.looks) else {
        return Ok(None);
    };
    with_workbench(machine, train, |workbench| {
        workbench.data.settings = found.settings;
        workbench.base = found.trace.base.clone();
        separation::weigh(workbench);
        let Some(candidates) = candidates::fitted(workbench, &found.trace, &doubt) else {
            return Some(None);
        };
        let limits = Limits::of(workbench, &candidates.all[0].model);
        let best = if look && candidates.all.len() > 1 {
            best(
                &Bench::new(workbench, &candidates)?,
                &candidates.all,
                &limits,
            )
        } else {
            None
        };
        Some(Some(proposal(&candidates, &limits, look, best)))
    })
}

/// What is proposed.
struct Best {
    trial: Trial,
    rehearsal: Rehearsal,
    separation: Separation,
}

/// The trial that tells most of the candidates apart: of those that are steady, those that promise most
/// by linear theory are rehearsed.
fn best(bench: &Bench, candidates: &[Candidate], limits: &Limits) -> Option<Best> {
    let data = &bench.workbench.data;
    let tryout = Tryout {
        limits,
        settings: data.settings,
        has_winding: data.logs.iter().all(|log| log.current.is_some()),
    };
    let trials = tryout.trials(candidates).into_par_iter();
    let steady = trials.filter_map(|trial| tryout.steady(trial, &bench.variants));
    let far_apart = most_promising(steady.collect(), LINEARISED, |trial| bench.unfitted(trial));
    let promising = most_promising(trials_of(far_apart), VARIED, |trial| bench.linear(trial, 1));
    let all = bench.variants.len();
    let rehearsed = most_promising(trials_of(promising), REHEARSED, |trial| {
        bench.linear(trial, all)
    });
    // Where no rehearsal is passed, what promises most is proposed all the same, and said to be that.
    let unconfirmed = rehearsed.first().and_then(|(trial, separation)| {
        Some(Best {
            trial: trial.clone(),
            rehearsal: Rehearsal::unconfirmed(candidates.len(), separation)?,
            separation: separation.clone(),
        })
    });
    let mut best: Option<Best> = None;
    for (trial, separation) in rehearsed {
        let known = best.as_ref().map_or((0, 0), |best| best.rehearsal.rank());
        let judged = (&trial, &separation);
        if let Some(rehearsal) = rehearsal::rehearse(bench, candidates, judged, known) {
            best = Some(Best {
                trial,
                rehearsal,
                separation,
            });
        }
    }
    best.or(unconfirmed)
}

/// So many of the trials that promise most, the best first.
fn most_promising(
    trials: Vec<Trial>,
    count: usize,
    judge: impl Fn(&Trial) -> Option<Separation> + Sync,
) -> Vec<(Trial, Separation)> {
    let judged = trials.into_par_iter().filter_map(|trial| {
        let separation = judge(&trial)?;
        Some((trial, separation))
    });
    let mut judged: Vec<(Trial, Separation)> = judged.collect();
    judged.sort_by(|(_, a), (_, b)| b.promise().total_cmp(&a.promise()));
    judged.truncate(count);
    judged
}

fn trials_of(judged: Vec<(Trial, Separation)>) -> Vec<Trial> {
    judged.into_iter().map(|(trial, _)| trial).collect()
}

fn proposal(
    candidates: &Candidates,
    limits: &Limits,
    looked: bool,
    best: Option<Best>,
) -> NextExperiment {
    let all = &candidates.all;
    let near = all.iter().filter(|it| it.reason == Reason::Near);
    let names: Vec<String> = all.iter().map(|it| it.name.clone()).collect();
    let nothing = NextExperiment {
        equivalent: candidates.equivalent.clone(),
        near: near.map(|it| it.name.clone()).collect(),
        same_law: candidates.same_law.clone(),
        low_identifiability: candidates.low_identifiability.map(decimal),
        absorbed: candidates.absorbed.clone(),
        looked,
        ..NextExperiment::open(names.clone(), limits.bounds())
    };
    let Some(best) = best else {
        return nothing;
    };
    let Best {
        trial,
        rehearsal,
        separation,
    } = best;
    let description = trial.description();
    let name = |place: usize| names[place].clone();
    let settled = (0..names.len()).filter(|&place| rehearsal.settles(place));
    let alone = rehearsal.does_alone();
    let distances = rehearsal.told().map(|(a, b)| separation.distance(a, b));
    let period_s = decimal(limits.period);
    let predicted = trial.courses.into_iter().next().unwrap_or_default();
    NextExperiment {
        separates: settled.map(name).collect(),
        leaves: rehearsal.left().map(|(a, b)| [name(a), name(b)]).collect(),
        confirmed: rehearsal.confirmed,
        alone,
        excitation: Some(description),
        separation: distances.min_by(f64::total_cmp),
        duration_s: Some(trial.input.len() as f64 * period_s),
        start_position: Some(decimal(limits.start)),
        plan: Some(Plan {
            period_s,
            predicted: names
                .iter()
                .cloned()
                .zip(predicted.into_iter().map(|course| course.position))
                .collect(),
            input: trial.input,
        }),
        ..nothing
    }
}
