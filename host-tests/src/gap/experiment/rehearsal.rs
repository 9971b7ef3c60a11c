//! Rehearsals of an experiment: the logs that it would leave, traced as a user's are.
//!
//! Each candidate in turn, as it is fitted and with its numbers a little off, is taken for the machine.
//! Two candidates are told apart where the tracing names the true one of them and not the other,
//! whichever of them it is and whichever numbers are off. One that is named for another (a spring
//! that rests far away is an offset) is not told from it. A trial in which anything else is named beside
//! the known logs, which nothing had in doubt, is not proposed; one that tells less alone is said to need
//! them.

use model_core::effect::Id;
use model_core::gap::lengths;
use model_core::gap::log::Log as CoreLog;
use model_core::gap::model::Model;
use model_core::gap::replay::Data;
use model_core::gap::verdict::{Subject, Trace};
use model_core::gap::workbench::Options;

use super::candidates::Candidate;
use super::limits::Trial;
use super::separation::{Bench, Separation};
use crate::gap::engine::AllCores;

/// Which candidates an experiment tells from which.
#[derive(Debug, Clone)]
pub(super) struct Rehearsal {
    /// By the true one and the other, beside the training logs.
    beside: Vec<Vec<bool>>,
    /// The same by its log alone, whichever numbers are off.
    alone: Vec<Vec<bool>>,
    /// Whether tracings say so, not linear theory alone.
    pub confirmed: bool,
}

impl Rehearsal {
    /// What linear theory expects.
    fn expected(count: usize, separation: &Separation) -> Self {
        let told: Vec<Vec<bool>> = (0..count)
            .map(|a| (0..count).map(|b| separation.separates(a, b)).collect())
            .collect();
        Self {
            alone: told.clone(),
            beside: told,
            confirmed: true,
        }
    }

    /// What stands where no rehearsal confirms it; `None` where linear theory expects nothing either.
    pub fn unconfirmed(count: usize, separation: &Separation) -> Option<Self> {
        let expected = Self {
            alone: vec![vec![false; count]; count],
            confirmed: false,
            ..Self::expected(count, separation)
        };
        (expected.rank().0 > 0).then_some(expected)
    }

    /// Pairs that it tells apart.
    pub fn told(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        pairs(self.beside.len()).filter(|&pair| tells(&self.beside, pair))
    }

    /// Pairs that it does not.
    pub fn left(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        pairs(self.beside.len()).filter(|&pair| !tells(&self.beside, pair))
    }

    /// Whether its log alone tells as many apart.
    pub fn does_alone(&self) -> bool {
        self.told().all(|pair| tells(&self.alone, pair))
    }

    /// By how many pairs it tells apart, then by how many it does so alone.
    pub fn rank(&self) -> (usize, usize) {
        let alone = self.told().filter(|&pair| tells(&self.alone, pair));
        (self.told().count(), alone.count())
    }

    /// Whether a candidate is told from any other one.
    pub fn settles(&self, place: usize) -> bool {
        self.told().any(|(a, b)| place == a || place == b)
    }
}

fn pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |a| (a + 1..count).map(move |b| (a, b)))
}

fn tells(told: &[Vec<bool>], (a, b): (usize, usize)) -> bool {
    told[a][b] && told[b][a]
}

/// Rehearses a trial. `None` where it turns out no better than one of this rank, or where something is
/// named beside the known logs that is not there.
pub(super) fn rehearse(
    bench: &Bench,
    candidates: &[Candidate],
    (trial, separation): (&Trial, &Separation),
    known: (usize, usize),
) -> Option<Rehearsal> {
    let count = candidates.len();
    // What a map has learned of one log is hardly what the machine has: its rehearsal would say little.
    let is_map = |place: usize| matches!(candidates[place].subject, Some(Subject::Map(_)));
    let mut rehearsal = Rehearsal::expected(count, separation);
    let is_better = |rehearsal: &Rehearsal| rehearsal.rank() > known;
    if !is_better(&rehearsal) {
        return None;
    }
    let judge = |trace: &Option<Trace>, truth: usize, told: &mut Vec<Vec<bool>>| {
        for (other, told) in told[truth].iter_mut().enumerate() {
            let is_told = |trace| is_told(trace, &candidates[truth], &candidates[other]);
            *told &= trace.as_ref().is_some_and(is_told);
        }
    };
    let truths = || (0..count).filter(|&place| !is_map(place));
    let log = |variant: usize, truth: usize| {
        let course = &trial.courses[variant][truth];
        bench.log_of(trial, course, (count * variant + truth) as u64)
    };
    for truth in truths() {
        let series = log(0, truth);
        let known = bench.workbench.data.logs.iter().copied();
        let both: Vec<CoreLog> = known.chain([series.log()]).collect();
        let trace = traced(bench, &both);
        let model = &candidates[truth].model;
        if trace
            .as_ref()
            .is_some_and(|trace| names_what_is_not_there(trace, model, candidates))
        {
            return None;
        }
        judge(&trace, truth, &mut rehearsal.beside);
        if !is_better(&rehearsal) {
            return None;
        }
    }
    for variant in 0..trial.courses.len() {
        for truth in truths() {
            let series = log(variant, truth);
            let trace = traced(bench, &[series.log()]);
            judge(&trace, truth, &mut rehearsal.alone);
            if rehearsal.rank().1 == 0 {
                return Some(rehearsal);
            }
            if !is_better(&rehearsal) {
                return None;
            }
        }
    }
    Some(rehearsal)
}

fn traced(bench: &Bench, logs: &[CoreLog]) -> Option<Trace> {
    let workbench = bench.workbench;
    let known = workbench.options;
    let resolution = workbench.data.settings.resolution;
    let data = Data::new(logs, resolution)?;
    let declared = workbench.declared;
    let options = Options {
        unsure: known.unsure,
        ..Options::new(&data, declared, &workbench.base, known.scope.rotary)?
    };
    lengths::trace(&data, &AllCores, declared, &options, |_| ())
}

/// An accepted effect and those that the log cannot tell from it.
fn classes(trace: &Trace) -> impl Iterator<Item = Vec<Id>> + '_ {
    trace.accepted.iter().map(|accepted| {
        let own = accepted.candidate.effect.id;
        let equivalent = accepted.equivalent.iter().copied();
        std::iter::once(own).chain(equivalent).collect()
    })
}

/// Whether a trace names an effect that neither the model has nor a candidate is.
fn names_what_is_not_there(trace: &Trace, model: &Model, candidates: &[Candidate]) -> bool {
    let in_doubt = |id: Id| {
        let mut subjects = candidates.iter().map(|candidate| candidate.subject);
        subjects.any(|subject| subject == Some(Subject::Effect(id)))
    };
    let is_there = |id: &Id| model.has(*id) || in_doubt(*id);
    classes(trace).any(|class| !class.iter().any(is_there))
}

/// Whether a trace names what is true, and does not name the other one with it. With nothing true,
/// nothing is to be named.
fn is_told(trace: &Trace, truth: &Candidate, other: &Candidate) -> bool {
    if truth.subject.is_none() {
        return trace.accepted.is_empty() && trace.unknown.is_none();
    }
    let names = |class: &[Id], candidate: &Candidate| {
        let mut ids = class.iter().map(|id| Subject::Effect(*id));
        ids.any(|subject| candidate.subject == Some(subject))
    };
    classes(trace).any(|class| names(&class, truth) && !names(&class, other))
}
