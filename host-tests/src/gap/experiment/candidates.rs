//! What the logs leave standing, each fitted to them.

use model_core::effect::Id;
use model_core::effect::learned_map::{Kind, LearnedMap};
use model_core::gap::model::Model;
use model_core::gap::replay::Schedule;
use model_core::gap::verdict::{Consideration, Decision, Subject, Trace};
use model_core::gap::workbench::Workbench;

use crate::gap::answer;

/// A model whose mean square error is beyond this multiple of the named one's is told from it: the
/// selection's own limit.
const TOLD_APART: f64 = 1.5;

/// Identifiability under which an effect may be what a fitted parameter is, or what another effect is
/// that scores at least [`NEAR_SCORE`] of it.
const LOW_IDENTIFIABILITY: f32 = 0.2;
const NEAR_SCORE: f32 = 0.5;

/// Most candidates that are set against each other.
const MOST: usize = 4;

/// Name of the model without the effect.
pub(super) const NOTHING: &str = "no effect";

/// What may be true instead of what was named.
#[derive(Debug, Default)]
pub(super) struct Doubt {
    /// Place of the effect among the accepted ones; `None` of an unknown effect.
    accepted: Option<usize>,
    /// What the answer calls equivalent to it.
    equivalent: Vec<Id>,
    /// Others that may follow the logs about as well.
    effects: Vec<Id>,
    maps: Vec<Kind>,
    /// Whether a refit of the base without the effect may do: its identifiability is low.
    nothing: bool,
}

/// Why a candidate is one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Reason {
    /// The answer names it.
    Named,
    /// The answer calls it equivalent to the one that it names.
    Equivalent,
    /// Refitted, it follows the logs about as well.
    Near,
}

/// A model that the logs leave standing.
#[derive(Debug)]
pub(super) struct Candidate {
    /// The effect's id, or `map:VARIABLE`.
    pub name: String,
    /// What a tracing would have to find, were it true; `None` of [`NOTHING`].
    pub subject: Option<Subject>,
    /// Why it is one.
    pub reason: Reason,
    /// Fitted to the training logs.
    pub model: Model,
}

/// What stands against each other.
#[derive(Debug)]
pub(super) struct Candidates {
    /// The named one first, then those that the answer calls equivalent to it.
    pub all: Vec<Candidate>,
    /// Those that the answer calls equivalent to the named one.
    pub equivalent: Vec<String>,
    /// The model without any of them, fitted to the training logs.
    pub without: Model,
    /// Identifiability of the named effect, where it is low.
    pub low_identifiability: Option<f32>,
}

/// What is in doubt after a tracing; `None` where nothing is.
pub(super) fn doubt(trace: &Trace, looks: &[Consideration]) -> Option<Doubt> {
    if let Some(unknown) = &trace.unknown {
        return doubt_of_map(unknown.kind, looks);
    }
    let doubts = (0..trace.accepted.len()).map(|place| doubt_of_effect(trace, looks, place));
    doubts
        .into_iter()
        .find(|doubt| doubt.nothing || !doubt.equivalent.is_empty() || !doubt.effects.is_empty())
}

fn doubt_of_effect(trace: &Trace, looks: &[Consideration], place: usize) -> Doubt {
    let accepted = &trace.accepted[place];
    let own = accepted.candidate.effect.id;
    let low = accepted.candidate.identifiability < LOW_IDENTIFIABILITY;
    let mut doubt = Doubt {
        accepted: Some(place),
        equivalent: accepted.equivalent.to_vec(),
        nothing: low,
        ..Doubt::default()
    };
    let taken = looks.iter().find(|look| {
        look.subject == Subject::Effect(own)
            && matches!(look.decision, Decision::Accepted)
            && look.held_out.is_some()
    });
    let Some(taken) = taken else {
        return doubt;
    };
    let others = || {
        looks.iter().filter_map(|look| match look.subject {
            Subject::Effect(id)
                if look.round == taken.round && id != own && !trace.after.model.has(id) =>
            {
                Some((id, look))
            }
            _ => None,
        })
    };
    // As near on held-out blocks, whatever else was held against it: a short log proves little.
    let limit = TOLD_APART * taken.held_out.map_or(0.0, |held_out| held_out.ratio);
    let near = |look: &Consideration| look.held_out.is_some_and(|other| other.ratio <= limit);
    for (id, look) in others() {
        let scores = low && look.score >= NEAR_SCORE * taken.score;
        if near(look) || scores {
            doubt.effects.push(id);
        }
    }
    let same: Vec<Id> = others()
        .filter(|(_, look)| match look.decision {
            Decision::SameAs { other } => {
                doubt.effects.contains(&other) || doubt.equivalent.contains(&other)
            }
            _ => false,
        })
        .map(|(id, _)| id)
        .collect();
    doubt.effects.extend(same);
    let Doubt {
        equivalent,
        effects,
        ..
    } = &mut doubt;
    effects.retain(|id| !trace.after.model.has(*id) && !equivalent.contains(id));
    doubt
}

fn doubt_of_map(kind: Kind, looks: &[Consideration]) -> Option<Doubt> {
    let ratio = |look: &Consideration| look.held_out.map(|held_out| held_out.ratio);
    let own = looks
        .iter()
        .find(|look| look.subject == Subject::Map(kind))
        .and_then(ratio)?;
    let mut doubt = Doubt::default();
    let near = |look: &&Consideration| ratio(look).is_some_and(|other| other <= TOLD_APART * own);
    for look in looks.iter().filter(near) {
        match look.subject {
            Subject::Map(other) if other != kind => doubt.maps.push(other),
            Subject::Effect(id) if look.round == 1 => doubt.effects.push(id),
            _ => {}
        }
    }
    (!doubt.maps.is_empty() || !doubt.effects.is_empty()).then_some(doubt)
}

/// The candidates, each fitted to the logs as the named one is: the named one, those that the answer
/// calls equivalent to it, and of the others those that follow the logs about as well. `None` where
/// there is none beside the named one.
pub(super) fn fitted(
    workbench: &mut Workbench<impl Schedule>,
    trace: &Trace,
    doubt: &Doubt,
) -> Option<Candidates> {
    let named = trace.after.model.clone();
    let mut without = match doubt.accepted {
        Some(place) => {
            let mut without = named.clone();
            without
                .effects
                .remove(workbench.declared.effects.len() + place);
            without
        }
        None => trace.before.model.clone(),
    };
    without = workbench.fit(&without)?.model;
    let accepted = doubt.accepted.map(|place| &trace.accepted[place].candidate);
    let subject = match (accepted, &trace.unknown) {
        (Some(accepted), _) => Subject::Effect(accepted.effect.id),
        (None, Some(unknown)) => Subject::Map(unknown.kind),
        (None, None) => return None,
    };
    let mut starts: Vec<(Option<Subject>, Reason, Model)> = Vec::new();
    let screening = workbench.screen(&without, |_| ())?;
    for candidate in &screening.candidates {
        let id = candidate.effect.id;
        let reason = if doubt.equivalent.contains(&id) {
            Reason::Equivalent
        } else if doubt.effects.contains(&id) {
            Reason::Near
        } else {
            continue;
        };
        if let Some(larger) = workbench.start(&without, candidate.effect)? {
            starts.push((Some(Subject::Effect(id)), reason, larger));
        }
    }
    for &kind in &doubt.maps {
        let map = Some(LearnedMap::flat(kind, &workbench.options.ranges));
        let larger = Model {
            map,
            ..without.clone()
        };
        starts.push((Some(Subject::Map(kind)), Reason::Near, larger));
    }
    if doubt.nothing {
        starts.push((None, Reason::Near, without.clone()));
    }
    let named = workbench.fit(&named)?;
    let samples = (workbench.data.windows() * workbench.data.settings.window) as f64;
    let limit = TOLD_APART * named.cost.max(samples);
    let mut others: Vec<(f64, Candidate)> = Vec::new();
    for (subject, reason, start) in starts {
        let Some(fit) = workbench.fit(&start) else {
            continue;
        };
        if reason == Reason::Equivalent || fit.cost <= limit {
            others.push((fit.cost, Candidate::new(subject, reason, fit.model)));
        }
    }
    others.sort_by(|(a_cost, a), (b_cost, b)| {
        let reason = a.reason.cmp(&b.reason);
        reason.then(a_cost.total_cmp(b_cost))
    });
    let mut all = vec![Candidate::new(Some(subject), Reason::Named, named.model)];
    all.extend(others.into_iter().map(|(_, candidate)| candidate));
    all.truncate(MOST);
    (all.len() > 1).then_some(Candidates {
        all,
        equivalent: doubt.equivalent.iter().copied().map(name_of).collect(),
        without,
        low_identifiability: accepted
            .filter(|_| doubt.nothing)
            .map(|accepted| accepted.identifiability),
    })
}

impl Candidate {
    fn new(subject: Option<Subject>, reason: Reason, model: Model) -> Self {
        let name = subject.map_or(NOTHING.to_owned(), answer::subject);
        Self {
            name,
            subject,
            reason,
            model,
        }
    }
}

fn name_of(id: Id) -> String {
    id.description().id.to_owned()
}
