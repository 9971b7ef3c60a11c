//! What else an effect that was found could be: a twin of it, only the way out of a local minimum, or another law of what
//! was found before it.

use super::criterion::{
    EQUALLY_GOOD, LARGEST_RATIO, LEAST_CERTAINTY, POOR_EXPLANATION, TOLD_APART,
};
use super::found::Found;
use super::held_out::{HeldOut, Refusal, compare};
use super::judging::{is_rounding, judge};
use super::model::{Base, Model};
use super::replay::Schedule;
use super::verdict::{Accepted, Decision};
use super::workbench::Workbench;
use crate::effect::Id;
use crate::effect::harmonic::with_overtones;
use crate::effect::learned_map::LearnedMap;
use crate::effect::twins::twins;

/// Most exchanges of an effect for a twin of it.
const MOST_EXCHANGES: usize = 2;

/// What speaks against the effect in a slot of a fitted model, though held-out blocks are followed better with
/// it: it is within half a count of the sensor; a fit without it, from where the one with it has come to, does
/// as well, for it only helped out of the local minimum of the fit before; or its strength is uncertain. That is asked
/// here only of an effect that leaves most of the error: what is still missing makes the strength of one that
/// takes most of it uncertain too. In the end [`stands`] asks it of all.
#[inline(never)]
pub(super) fn doubt(
    workbench: &mut Workbench<impl Schedule>,
    with: &Model,
    slot: usize,
) -> Option<Option<Decision>> {
    if is_rounding(&with.effects[slot], workbench.data.settings.resolution) {
        return Some(Some(Decision::BelowResolution));
    }
    let mut without = with.clone();
    without.effects.remove(slot);
    let without = workbench.fit(&without)?.model;
    let ratio = workbench.error_ratio(&without, with)?;
    Some(if ratio > LARGEST_RATIO {
        Some(Decision::Refused(Refusal::NotNeeded))
    } else if ratio > POOR_EXPLANATION && workbench.certainty(with, slot)? < LEAST_CERTAINTY {
        Some(Decision::Refused(Refusal::Uncertain))
    } else {
        None
    })
}

/// Puts a twin in the place of an effect that was found before the last one, if the log is followed as well with
/// the twin and without the last one: the last one only made up for what is not alike in the two. `with`: the
/// fit with all of them. Whether a twin was put there.
#[inline(never)]
pub(super) fn exchange_for_twin(
    workbench: &mut Workbench<impl Schedule>,
    with: &Model,
    found: &mut Found,
) -> Option<bool> {
    let first = workbench.declared.effects.len();
    for place in 0..found.accepted.len() {
        let known = with.effects[first + place];
        for twin in twins(&known) {
            if !is_allowed_beside(workbench, with, twin.id) {
                continue;
            }
            let mut other = with.clone();
            other.effects.pop();
            other.effects[first + place] = twin;
            let other = workbench.fit(&other)?;
            if workbench.error_ratio(&other.model, with)? > LARGEST_RATIO {
                let accepted = &mut found.accepted[place];
                accepted.equivalent.retain(|id| *id != twin.id);
                let _ = accepted.equivalent.push(known.id);
                accepted.candidate.effect = other.model.effects[first + place];
                found.after = other;
                found.held_out = None;
                return Some(true);
            }
        }
    }
    Some(false)
}

/// An effect that was found before, if the log does not tell what is found next from a freer law of that effect: the same
/// mechanism with knots over its variable, or, if it is periodic, with overtones. A mechanism hardly has the very law of the
/// catalogue, and what another law leaves goes by the name of some second effect, or of a wrong number, then.
/// `with`: the fit with what is found next, which has freed these numbers.
#[inline(never)]
pub(super) fn other_law(
    workbench: &mut Workbench<impl Schedule>,
    with: &Model,
    numbers: &[Base],
    found: &Found,
) -> Option<Option<Id>> {
    let mut held_out = None;
    let first = workbench.declared.effects.len();
    let before = &found.after.model;
    for (slot, known) in before.effects.iter().enumerate().skip(first) {
        let Some(start) = with_freer_law(workbench, before, slot) else {
            continue;
        };
        let freer = held_out_once_fitted(workbench, start)?;
        let fixed = workbench.base.len();
        let _ = workbench.base.extend_from_slice(numbers);
        let ratio = compare(judge(workbench, &mut held_out, with)?, &freer).ratio;
        workbench.base.truncate(fixed);
        if ratio <= TOLD_APART {
            return Some(Some(known.id));
        }
    }
    Some(None)
}

/// A model in which the law of the effect in a slot is freer: with overtones if it may have them, else with knots.
///
/// `None` if there is no map that acts as it does.
fn with_freer_law(
    workbench: &Workbench<impl Schedule>,
    model: &Model,
    slot: usize,
) -> Option<Model> {
    if let Some(freer) = with_overtones_in(model, slot) {
        return Some(freer);
    }
    let kind = model.effects[slot].id.map()?;
    Some(Model {
        map: Some(LearnedMap::flat(kind, &workbench.options.ranges)),
        ..model.clone()
    })
}

/// A model in which the effect in a slot has overtones, as a fit with them starts; `None` if it may have none, or has some.
fn with_overtones_in(model: &Model, slot: usize) -> Option<Model> {
    let started = with_overtones(&model.effects[slot])?;
    let mut with = model.clone();
    with.effects[slot] = started;
    Some(with)
}

/// Gives each effect that may have overtones those that were fitted, if held-out data are followed better with them, as
/// one asks of an effect.
#[inline(never)]
pub(super) fn add_overtones(
    workbench: &mut Workbench<impl Schedule>,
    found: &mut Found,
) -> Option<()> {
    let first = workbench.declared.effects.len();
    for slot in first..first + found.accepted.len() {
        let Some(started) = with_overtones_in(&found.after.model, slot) else {
            continue;
        };
        let fitted = workbench.fit(&started)?;
        let with = workbench.held_out(&fitted.model)?;
        let without = judge(workbench, &mut found.held_out, &found.after.model)?;
        if compare(without, &with).refusal(1).is_none() {
            found.after = fitted;
            found.held_out = Some(with);
        }
    }
    Some(())
}

/// Held-out errors of a model once it is fitted to all blocks, from where each fit to a half of them starts.
#[inline(never)]
fn held_out_once_fitted(
    workbench: &mut Workbench<impl Schedule>,
    mut model: Model,
) -> Option<HeldOut> {
    model = workbench.fit(&model)?.model;
    workbench.held_out(&model)
}

/// Whether a model lacks an effect that its coordinate may have.
fn is_allowed_beside(workbench: &Workbench<impl Schedule>, model: &Model, id: Id) -> bool {
    let has = model.effects.iter().any(|effect| effect.id == id);
    !has && (workbench.options.scope.rotary || !id.description().rotary_only)
}

/// A model whose last effect has been found, beside those with its twins: which of them the log does
/// not tell from it, and one in its place that follows the log better, or as well with fewer parameters. By
/// itself a twin may not have been found, where a fit from the base alone does not come to it.
#[inline(never)]
pub(super) fn ask_twins(
    workbench: &mut Workbench<impl Schedule>,
    winner: &mut Accepted,
    mut fitted: Model,
) -> Option<Model> {
    // Each exchange leaves fewer parameters or less error, so that hardly any goes back to the first one.
    for _ in 0..=MOST_EXCHANGES {
        let effect = *fitted.effects.last()?;
        let mut better = None;
        for twin in twins(&effect) {
            if !is_allowed_beside(workbench, &fitted, twin.id) {
                continue;
            }
            let mut other = fitted.clone();
            *other.effects.last_mut()? = twin;
            let other = workbench.fit(&other)?.model;
            let ratio = workbench.error_ratio(&fitted, &other)?;
            winner.equivalent.retain(|id| *id != twin.id);
            if ratio <= tolerated(twin.id, effect.id) {
                better = Some(other);
                break;
            }
            if ratio <= TOLD_APART {
                let _ = winner.equivalent.push(twin.id);
            }
        }
        let Some(other) = better else {
            break;
        };
        let _ = winner.equivalent.push(effect.id);
        fitted = other;
        winner.candidate.effect = *fitted.effects.last()?;
    }
    Some(fitted)
}

/// Multiple of the error with an effect up to which another one is taken in its place: as well with fewer
/// parameters, better with as many or more.
pub(super) fn tolerated(other: Id, than: Id) -> f64 {
    if other.parameters() < than.parameters() {
        EQUALLY_GOOD
    } else {
        1.0 / EQUALLY_GOOD
    }
}
