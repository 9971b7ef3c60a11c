//! Whether a model with an effect is better than the one without, where it has not been fitted.

use super::criterion::{LARGEST_RATIO, LEAST_COUNTS, LITTLE_LEFT};
use super::held_out::{Comparison, HeldOut, Refusal, compare, compare_within};
use super::model::Model;
use super::replay::Schedule;
use super::verdict::Decision;
use super::workbench::Workbench;
use crate::effect::{Active, Id};

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

/// Whether an effect is a reading error, or a play, that the rounding of the sensor makes too.
pub fn is_rounding(effect: &Active, resolution: f32) -> bool {
    let strengths = &effect.values[..effect.id.strengths()];
    let square: f32 = strengths.iter().map(|strength| strength * strength).sum();
    let rounding = LEAST_COUNTS * resolution;
    effect.id.misreads() && square < rounding * rounding
}

/// Refits a model with an effect and compares it on held-out blocks, as one of `looks`. One that passes
/// with less error than the leader takes its place.
///
/// `Err` inside where it is not compared, with the reason.
#[inline(never)]
pub fn judge_effect(
    workbench: &mut Workbench<impl Schedule>,
    model: &Model,
    smaller: &HeldOut,
    effect: Active,
    looks: usize,
    leader: &mut Leader,
) -> Option<Result<(Comparison, Option<Refusal>), Decision>> {
    let chosen = workbench.data;
    if !workbench.restart_as_with(model, effect.id)? {
        return judge_on_these_starts(workbench, model, smaller, effect, looks, leader);
    }
    let smaller = workbench.held_out(model)?;
    let judged = judge_on_these_starts(workbench, model, &smaller, effect, looks, leader);
    workbench.data = chosen;
    judged
}

/// The same with windows that start as they do.
fn judge_on_these_starts(
    workbench: &mut Workbench<impl Schedule>,
    model: &Model,
    smaller: &HeldOut,
    effect: Active,
    looks: usize,
    leader: &mut Leader,
) -> Option<Result<(Comparison, Option<Refusal>), Decision>> {
    let Some(with) = workbench.start(model, effect)? else {
        return Some(Err(Decision::Hopeless));
    };
    if is_rounding(with.effects.last()?, workbench.data.settings.resolution) {
        return Some(Err(Decision::BelowResolution));
    }
    let mut larger = HeldOut::new();
    workbench.held_out_with(&with, smaller, &mut larger)?;
    let slot = with.effects.len() - 1;
    let mut comparison =
        compare_where_it_shows(workbench, (model, smaller), (&with, &larger), slot)?;
    let mut refusal = comparison.refusal(looks);
    if refusal.is_none() && effect.id.is_stateful() {
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
    if effect.id.is_stateful() && unsettled {
        let restarted = compare_restarted(workbench, model, &with)?;
        if restarted.refusal(looks).is_none() {
            (comparison, refusal) = (restarted, None);
        }
    }
    let leads = |(least, _): &(f64, Model)| comparison.ratio < *least;
    if refusal.is_none() && leader.as_ref().is_none_or(leads) {
        *leader = Some((comparison.ratio, with));
    }
    Some(Ok((comparison, refusal)))
}

/// Compares two models, each with its held-out errors, where the effect in a slot of the larger one
/// may show. The ratio is that of the whole log: of a load that lies within one half of the blocks it is that of
/// a start which has seen it, for the other half says nothing of its strength. What proves it are the short
/// windows of [`compare_in_short_windows`], of which either half has some of it.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_play_and_an_eccentricity_of_less_than_half_a_count_are_rounding() {
        let is = |id: Id, values: [f32; 3], resolution: f32| {
            is_rounding(&Active::new(id, values), resolution)
        };
        assert!(is(Id::Backlash, [0.49, 0.0, 0.0], 1.0));
        assert!(!is(Id::Backlash, [0.51, 0.0, 0.0], 1.0));
        // The two strengths of an eccentricity are those of its cosine and its sine.
        assert!(is(Id::EncoderEccentricity, [0.34, -0.34, 6.3], 1.0));
        assert!(!is(Id::EncoderEccentricity, [0.37, -0.37, 6.3], 1.0));
        // A torque is no reading, and without a known resolution there is no count.
        assert!(!is(Id::OffsetTorque, [0.01, 0.0, 0.0], 1.0));
        assert!(!is(Id::Backlash, [1e-9, 0.0, 0.0], 0.0));
    }
}
