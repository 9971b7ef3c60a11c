//! What the logs leave standing, each fitted to them.

use model_core::effect::learned_map::{Kind, LearnedMap};
use model_core::effect::twins::{are_one_law, are_one_model};
use model_core::effect::{Active, Id, Scope};
use model_core::gap::criterion::LARGEST_RATIO;
use model_core::gap::fit::Fit;
use model_core::gap::model::Model;
use model_core::gap::screen;
use model_core::gap::verdict::{Consideration, Decision, Subject, Trace};
use model_core::gap::workbench::Workbench;

use super::variants::OFF;
use super::{Absorbed, Quantity};
use crate::gap::answer;
use crate::gap::engine::AllCores;
use crate::quantity::decimal;

/// A model whose mean square error is beyond this multiple of the named one's is told from it: the
/// selection's own limit.
const TOLD_APART: f64 = 1.5;

/// Identifiability under which an effect may be what a fitted parameter is, or what another effect is
/// that scores at least [`NEAR_SCORE`] of it.
const LOW_IDENTIFIABILITY: f32 = 0.2;
const NEAR_SCORE: f32 = 0.5;

/// Shares of its typical size, the one that its fit is scaled by, at which an effect that fitted
/// parameters absorb is tried, the largest first: half of it matters, an eighth hardly does.
const STRENGTHS: [f32; 3] = [0.5, 0.25, 0.125];

/// Most candidates that are set against each other.
const MOST: usize = 4;

/// Name of the model without the effect.
pub(super) const NOTHING: &str = "no effect";

/// What may be true instead of what was named.
#[derive(Debug, Default)]
pub(super) struct Doubt {
    /// Place of the effect among the accepted ones; `None` of an unknown effect, and where nothing was
    /// found.
    accepted: Option<usize>,
    /// What the answer calls equivalent to it.
    equivalent: Vec<Id>,
    /// Others that may follow the logs about as well.
    effects: Vec<Id>,
    maps: Vec<Kind>,
    /// Whether a refit of the base without the effect may do: its identifiability is low.
    nothing: bool,
    /// Where nothing was found: what the fitted parameters would have absorbed.
    absorbed: Vec<Id>,
}

/// Why a candidate is one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Reason {
    /// The answer names it, or that nothing is missing.
    Named,
    /// The answer calls it equivalent to the one that it names.
    Equivalent,
    /// Refitted, it follows the logs about as well.
    Near,
    /// The logs would not show it: the refitted base does what it does.
    Absorbed,
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
    /// Fitted to the training logs; of an absorbed effect, the base beside it.
    pub model: Model,
}

/// What stands against each other.
#[derive(Debug)]
pub(super) struct Candidates {
    /// The named one first, then those that the answer calls equivalent to it.
    pub all: Vec<Candidate>,
    /// Those that the answer calls equivalent to the named one.
    pub equivalent: Vec<String>,
    /// Those that are one law with the named one, as far as a fit knows its numbers. They are no candidates: no input tells them
    /// apart.
    pub same_law: Vec<String>,
    /// The model without any of them, fitted to the training logs.
    pub without: Model,
    /// Identifiability of the named effect, where it is low.
    pub low_identifiability: Option<f32>,
    /// Where nothing was found: what may be there all the same.
    pub absorbed: Vec<Absorbed>,
}

/// What is in doubt after a tracing; `None` where nothing is.
pub(super) fn doubt(trace: &Trace, looks: &[Consideration]) -> Option<Doubt> {
    if let Some(unknown) = &trace.unknown {
        let mut doubt = doubt_of_map(unknown.kind, looks)?;
        // The formula of the effect that the map is another law of is no other answer.
        if let Some(mechanism) = &unknown.mechanism {
            let own = mechanism.accepted.candidate.effect.id;
            doubt.effects.retain(|id| *id != own);
        }
        return (!doubt.maps.is_empty() || !doubt.effects.is_empty()).then_some(doubt);
    }
    if trace.accepted.is_empty() {
        return doubt_of_nothing(looks);
    }
    let to_come = (0..trace.accepted.len())
        .filter(|&place| !is_past(Subject::Effect(trace.accepted[place].candidate.effect.id)));
    let doubts = to_come.map(|place| doubt_of_effect(trace, looks, place));
    doubts.into_iter().find(|doubt| {
        let own = doubt
            .accepted
            .map(|place| trace.accepted[place].candidate.effect.id);
        let may_be = |id: &Id| {
            !is_past(Subject::Effect(*id)) && own.is_none_or(|own| !are_one_model(own, *id))
        };
        doubt.nothing || doubt.equivalent.iter().any(may_be) || !doubt.effects.is_empty()
    })
}

/// Whether it acted at a time of these logs, and so in no other one: no input settles anything about it.
fn is_past(subject: Subject) -> bool {
    match subject {
        Subject::Effect(id) => Active::new(id, []).law().span().is_some(),
        Subject::Map(kind) => kind == Kind::TimeTorque,
        Subject::Numbers | Subject::Sensor | Subject::Input => false,
    }
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
        let to_come = looks.iter().filter(|look| !is_past(look.subject));
        to_come.filter_map(|look| match look.subject {
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

/// What the last round did not look at, for the fitted parameters do what it does.
fn doubt_of_nothing(looks: &[Consideration]) -> Option<Doubt> {
    let last = looks.iter().map(|look| look.round).max()?;
    let to_come = looks.iter().filter(|look| !is_past(look.subject));
    let absorbed = to_come.filter_map(|look| match look.subject {
        Subject::Effect(id) if look.round == last && look.decision == Decision::Absorbed => {
            Some(id)
        }
        _ => None,
    });
    let absorbed: Vec<Id> = absorbed.collect();
    (!absorbed.is_empty()).then(|| Doubt {
        absorbed,
        ..Doubt::default()
    })
}

/// What follows the logs about as well as a learned map; nothing in it where nothing does.
fn doubt_of_map(kind: Kind, looks: &[Consideration]) -> Option<Doubt> {
    if is_past(Subject::Map(kind)) {
        return None;
    }
    let ratio = |look: &Consideration| look.held_out.map(|held_out| held_out.ratio);
    let own = looks
        .iter()
        .find(|look| look.subject == Subject::Map(kind))
        .and_then(ratio)?;
    let mut doubt = Doubt::default();
    let near = |look: &&Consideration| {
        !is_past(look.subject) && ratio(look).is_some_and(|other| other <= TOLD_APART * own)
    };
    for look in looks.iter().filter(near) {
        match look.subject {
            Subject::Map(other) if other != kind => doubt.maps.push(other),
            Subject::Effect(id) if look.round == 1 => doubt.effects.push(id),
            _ => {}
        }
    }
    Some(doubt)
}

/// The candidates, each fitted to the logs as the named one is: the named one, those that the answer
/// calls equivalent to it, and of the others those that follow the logs about as well; but for those that are
/// one law with the named one. `None` where there is none beside the named one.
pub(super) fn fitted(
    workbench: &mut Workbench<AllCores>,
    trace: &Trace,
    doubt: &Doubt,
) -> Option<Candidates> {
    if !doubt.absorbed.is_empty() {
        return fitted_beside_absorbed(workbench, trace, &doubt.absorbed);
    }
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
        let is_named = |named: &screen::Candidate| are_one_model(named.effect.id, id);
        let reason = if is_past(Subject::Effect(id)) || accepted.is_some_and(is_named) {
            continue;
        } else if doubt.equivalent.contains(&id) {
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
    let mut same_law = Vec::new();
    let own = accepted.and_then(|own| effect_of(&named.model, own.effect.id).copied());
    for (subject, reason, start) in starts {
        let Some(fit) = workbench.fit(&start) else {
            continue;
        };
        let effect = match subject {
            Some(Subject::Effect(id)) => effect_of(&fit.model, id),
            _ => None,
        };
        let is_named = |(own, effect): (Active, &Active)| are_one_law(&own, effect, OFF);
        if own.zip(effect).is_some_and(is_named) {
            same_law.extend(effect.map(|effect| name_of(effect.id)));
            continue;
        }
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
    let is_in_doubt = all.len() > 1 || !same_law.is_empty();
    is_in_doubt.then_some(Candidates {
        all,
        equivalent: doubt.equivalent.iter().copied().map(name_of).collect(),
        same_law,
        without,
        low_identifiability: accepted
            .filter(|_| doubt.nothing)
            .map(|accepted| accepted.identifiability),
        absorbed: Vec::new(),
    })
}

/// The model in which nothing was missing, and beside it each absorbed effect as strong as it may be
/// without the logs showing it. `None` where they would show each of them.
fn fitted_beside_absorbed(
    workbench: &mut Workbench<AllCores>,
    trace: &Trace,
    absorbed: &[Id],
) -> Option<Candidates> {
    let base = workbench.fit(&trace.after.model)?;
    let shaped = shaped(workbench, &base.model, absorbed)?;
    let mut unseen: Vec<(f64, Absorbed, Candidate)> = Vec::new();
    for effect in shaped {
        if let Some((effect, fit)) = strongest_unseen(workbench, &base, effect)? {
            let subject = Some(Subject::Effect(effect.id));
            let rotary = workbench.options.scope.rotary;
            let described = Absorbed::new(&effect, &fit.model, rotary);
            let candidate = Candidate::new(subject, Reason::Absorbed, fit.model);
            unseen.push((fit.cost, described, candidate));
        }
    }
    unseen.sort_by(|(a, ..), (b, ..)| a.total_cmp(b));
    let mut all = vec![Candidate::new(None, Reason::Named, base.model.clone())];
    let mut absorbed = Vec::new();
    for (_, described, candidate) in unseen {
        absorbed.push(described);
        all.push(candidate);
    }
    all.truncate(MOST);
    (all.len() > 1).then_some(Candidates {
        all,
        equivalent: Vec::new(),
        same_law: Vec::new(),
        without: base.model,
        low_identifiability: None,
        absorbed,
    })
}

/// These effects with the shapes and the signs that the logs ask for. What has one strength alone, of a sign
/// that physics demands, has nothing to ask: mostly that spares a screening.
fn shaped(
    workbench: &mut Workbench<AllCores>,
    base: &Model,
    absorbed: &[Id],
) -> Option<Vec<Active>> {
    let has_one_form = |id: &Id| {
        let parameters = id.description().parameters;
        parameters.len() == 1 && !parameters[0].bounds.are_signed()
    };
    if absorbed.iter().all(has_one_form) {
        let plain = |&id: &Id| Active::new(id, []);
        return Some(absorbed.iter().map(plain).collect());
    }
    let mut found: Vec<Active> = Vec::new();
    let mut take = |effect: Active| {
        if absorbed.contains(&effect.id) {
            found.push(effect);
        }
    };
    let screening = workbench.screen(base, |passed_over| take(passed_over.effect))?;
    for candidate in &screening.candidates {
        take(candidate.effect);
    }
    Some(found)
}

/// An effect at the largest of the strengths at which, with the base refitted beside it, the logs are
/// followed so well that a tracing would not miss it: without it the error grows by less than what a
/// tracing asks of an effect. `None` inside where every one of them would show.
fn strongest_unseen(
    workbench: &Workbench<AllCores>,
    base: &Fit,
    effect: Active,
) -> Option<Option<(Active, Fit)>> {
    let scope = &workbench.options.scope;
    let samples = (workbench.data.windows() * workbench.data.settings.window) as f64;
    // Noise and the floor that the selection adds to it weigh one a sample together; a share of that is
    // what a tracing asks for.
    let limit = base.cost + (1.0 / LARGEST_RATIO - 1.0) * samples;
    for share in STRENGTHS {
        let effect = at_strength(effect, share, scope);
        // Declared, it stays as it is while the base is fitted.
        let Some(declared) = screen::with_effect(workbench.declared, effect) else {
            continue;
        };
        let Some(start) = screen::with_effect(&base.model, effect) else {
            continue;
        };
        let options = workbench.options;
        let mut beside = Workbench::new(workbench.data, &AllCores, &declared, options)?;
        beside.base = workbench.base.clone();
        // Beyond the plant's range there is no such machine.
        let fit = beside.fit(&start);
        if let Some(fit) = fit.filter(|fit| fit.cost <= limit) {
            return Some(Some((effect, fit)));
        }
    }
    Some(None)
}

/// An effect of the shape that a screening found, this share of its typical size strong, with the signs
/// that the logs ask for where physics allows them.
fn at_strength(mut effect: Active, share: f32, scope: &Scope) -> Active {
    let strengths = effect.id.strengths();
    let scale = |index: usize| effect.id.scale(scope, index);
    let mut direction: Vec<f32> = (0..strengths)
        .map(|index| effect.values[index] / scale(index))
        .collect();
    let size = direction.iter().map(|it| it * it).sum::<f32>().sqrt();
    for (value, parameter) in direction.iter_mut().zip(effect.id.description().parameters) {
        *value = if size == 0.0 {
            1.0
        } else if parameter.bounds.are_signed() {
            *value / size
        } else {
            (*value / size).abs()
        };
    }
    let values: Vec<f32> = direction
        .iter()
        .enumerate()
        .map(|(index, value)| share * value * scale(index))
        .collect();
    effect.values[..strengths].copy_from_slice(&values);
    effect
}

impl Absorbed {
    fn new(effect: &Active, model: &Model, rotary: bool) -> Self {
        let values = effect.report(&model.plant);
        let parameters = effect.reported().iter().zip(values);
        Self {
            id: effect.id.description().id.to_owned(),
            parameters: parameters
                .map(|((name, dimension), value)| Quantity {
                    name: (*name).to_owned(),
                    value: decimal(value),
                    unit: dimension.unit(rotary).to_owned(),
                })
                .collect(),
        }
    }
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

/// The last effect of this kind in a model: one that was found stands behind those that are declared.
fn effect_of(model: &Model, id: Id) -> Option<&Active> {
    model.effects.iter().rfind(|effect| effect.id == id)
}

fn name_of(id: Id) -> String {
    id.description().id.to_owned()
}
