//! Whether a model with an effect is better than the one without, where it has not been fitted.

use super::held_out::{Comparison, HeldOut, LARGEST_RATIO, Refusal, compare, compare_within};
use super::model::Model;
use super::replay::Schedule;
use super::workbench::Workbench;
use crate::effect::{Active, Id};

/// An effect with a memory that leaves no more than this share of the held-out error is judged on its own
/// restarts too before it is called not significant: a few windows that restart wrongly may outweigh all
/// others.
const LITTLE_LEFT: f64 = 0.3;

/// A span that every window has something in common with.
pub const THROUGHOUT: (f32, f32) = (f32::NEG_INFINITY, f32::INFINITY);

/// Held-out errors of a model, where they are not known already.
#[inline(never)]
pub fn judge<'k>(
    workbench: &mut Workbench<impl Schedule>,
    known: &'k mut Option<HeldOut>,
    model: &Model,
) -> Option<&'k HeldOut> {
    if known.is_none() {
        *known = Some(workbench.held_out(model)?);
    }
    known.as_ref()
}

/// Whether the first of two effects, which has a memory, is the better one where replays restart as
/// suits it.
#[inline(never)]
pub fn wins_on_its_restarts(
    workbench: &mut Workbench<impl Schedule>,
    model: &Model,
    [rival, leading]: [Active; 2],
) -> Option<bool> {
    let chosen = workbench.data;
    let own = workbench.start(model, rival)??;
    workbench.restart(&own)?;
    let rival = workbench.held_out(&own)?;
    let leading = workbench.start(model, leading)??;
    let leading = workbench.held_out(&leading)?;
    workbench.data = chosen;
    Some(compare(&leading, &rival).ratio < 1.0)
}

/// The model with the effect that has passed with the least held-out error, where a fit of it starts, and
/// that error over the one without.
pub type Leader = Option<(f64, Model)>;

/// Refits a model with an effect and compares it on held-out blocks, as one of `looks`. One that passes
/// with less error than the leader takes its place.
///
/// `None` inside if it is hopeless.
#[inline(never)]
pub fn judge_effect(
    workbench: &mut Workbench<impl Schedule>,
    model: &Model,
    smaller: &HeldOut,
    effect: Active,
    looks: usize,
    leader: &mut Leader,
) -> Option<Option<(Comparison, Option<Refusal>)>> {
    let mut larger = HeldOut::new();
    let Some(with) = workbench.held_out_with(model, effect, smaller, &mut larger)? else {
        return Some(None);
    };
    let slot = with.effects.len() - 1;
    let mut comparison =
        compare_where_it_shows(workbench, (model, smaller), (&with, &larger), slot)?;
    let mut refusal = comparison.refusal(looks);
    if refusal.is_none() && effect.id.remembers() {
        let beside = compare_beside(workbench, model, effect.id, &larger)?;
        refusal = beside.refusal(looks);
        if refusal.is_some() {
            comparison = beside;
        }
    }
    let unsettled = match refusal {
        Some(Refusal::GainTooSmall) => true,
        Some(Refusal::NotSignificant { .. }) => comparison.ratio <= LITTLE_LEFT,
        _ => false,
    };
    if effect.id.remembers() && unsettled {
        let restarted = compare_restarted(workbench, model, &with)?;
        if restarted.refusal(looks).is_none() {
            (comparison, refusal) = (restarted, None);
        }
    }
    let leads = |(least, _): &(f64, Model)| comparison.ratio < *least;
    if refusal.is_none() && leader.as_ref().is_none_or(leads) {
        *leader = Some((comparison.ratio, with));
    }
    Some(Some((comparison, refusal)))
}

/// Compares two models, each with its held-out errors, where the effect in a slot of the larger one
/// may show. The ratio is that of the whole log.
#[inline(never)]
pub fn compare_where_it_shows(
    workbench: &mut Workbench<impl Schedule>,
    (without, smaller): (&Model, &HeldOut),
    (with, larger): (&Model, &HeldOut),
    slot: usize,
) -> Option<Comparison> {
    let effect = with.effects[slot];
    let mask = workbench.blocks_of(effect.id);
    let whole = compare_within(smaller, larger, &mask);
    // What gains too little on the whole is refused, however well it does while it acts.
    let Some(span) = effect.law().span().filter(|_| whole.ratio <= LARGEST_RATIO) else {
        return Some(whole);
    };
    Some(Comparison {
        ratio: whole.ratio,
        ..compare_in_short_windows(workbench, (without, with), span)?
    })
}

/// Compares two models in the short windows that have something in common with a span.
#[inline(never)]
pub fn compare_in_short_windows(
    workbench: &mut Workbench<impl Schedule>,
    (without, with): (&Model, &Model),
    span: (f32, f32),
) -> Option<Comparison> {
    let (mut before, mut after) = (HeldOut::new(), HeldOut::new());
    workbench.held_out_in(without, span, &mut before)?;
    workbench.held_out_in(with, span, &mut after)?;
    Some(compare(&before, &after))
}

/// Compares the held-out errors of a model with an effect that has a memory with those of the model
/// without it, whose replays start as its own do: that may be all that is better.
#[inline(never)]
fn compare_beside(
    workbench: &mut Workbench<impl Schedule>,
    model: &Model,
    id: Id,
    larger: &HeldOut,
) -> Option<Comparison> {
    let mut beside = HeldOut::new();
    workbench.held_out_beside(model, id, &mut beside)?;
    Some(compare_within(&beside, larger, &workbench.blocks_of(id)))
}

/// Compares the held-out errors of a model and of that with an effect besides, which has a memory, where
/// replays restart as suits the latter: few that restart as suits the model without may outweigh all others.
#[inline(never)]
fn compare_restarted(
    workbench: &mut Workbench<impl Schedule>,
    model: &Model,
    with: &Model,
) -> Option<Comparison> {
    let chosen = workbench.data;
    workbench.restart(with)?;
    let larger = workbench.held_out(with)?;
    let restarted = compare_beside(workbench, model, with.effects.last()?.id, &larger);
    workbench.data = chosen;
    restarted
}
