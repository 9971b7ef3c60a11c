//! Whether what was found may be said, and whether a law lies beneath it that the catalogue does not have.

use super::criterion::{
    CLEARLY_BETTER, LARGEST_RATIO, MAPS_BESIDE_EFFECTS, NOTHING_LEFT, POOR_EXPLANATION,
    SENSOR_COUNTS,
};
use super::found::Found;
use super::held_out::{Refusal, compare};
use super::judging::{compare_where_it_shows, judge};
use super::model::Model;
use super::replay::Schedule;
use super::unknown::{self, Unknown};
use super::verdict::{Accepted, Consideration, Decision};
use super::workbench::Workbench;
use crate::effect::learned_map::Kind;

/// Whether what was found may be said: no strength is uncertain beside all others, it needs no number that no data
/// sheet would allow, and nothing that was fitted to held-out blocks of one length predicts clearly worse over
/// shorter or longer ones. Effects go one by one, an uncertain one before the last one, until the rest may be said; all go
/// where together they [explain too little](explains_too_little).
#[inline(never)]
pub(super) fn stands(
    workbench: &mut Workbench<impl Schedule>,
    before: &Model,
    found: &mut Found,
    observe: &mut dyn FnMut(&Consideration),
) -> Option<bool> {
    loop {
        let is_map = found.after.model.map.is_some();
        if !is_map && !found.is_more(workbench) {
            return Some(true);
        }
        let (after, farthest) = workbench.within_limits(found.after.clone())?;
        found.after = after;
        let uncertain = found.uncertain(workbench)?;
        let refusal = if uncertain.is_some() {
            Refusal::Uncertain
        } else if let Some(number) = farthest {
            Refusal::Implausible(number)
        } else if workbench.is_clearly_worse(&found.after.model, before)? {
            Refusal::WorseElsewhere
        } else if explains_too_little(workbench, before, found)? {
            for refused in &found.accepted {
                let decision = Decision::Refused(Refusal::ExplainsTooLittle);
                observe(&refused.candidate.look(found.accepted.len() + 1, decision));
            }
            workbench.hold_freed();
            return Some(false);
        } else {
            return Some(true);
        };
        let Some(last) = found.accepted.len().checked_sub(1) else {
            // A map, or numbers of the machine file.
            workbench.hold_freed();
            return Some(false);
        };
        let place = uncertain.unwrap_or(last);
        let refused = found.accepted.remove(place).candidate;
        observe(&refused.look(last + 1, Decision::Refused(refusal)));
        if found.accepted.is_empty() {
            workbench.hold_freed();
            return Some(false);
        }
        let slot = workbench.declared.effects.len() + place;
        found.do_without(workbench, slot)?;
    }
}

/// Whether the model does not follow the log with what was found, and that leaves most of the held-out error: its cause may
/// then be another one, which what was found resembles. `before`: the base fit.
#[inline(never)]
fn explains_too_little(
    workbench: &mut Workbench<impl Schedule>,
    before: &Model,
    found: &mut Found,
) -> Option<bool> {
    if !workbench.residual(&found.after.model)?.is_unexplained() {
        return Some(false);
    }
    let fitted = workbench.hold_freed();
    let without = workbench.held_out(before)?;
    workbench.base = fitted;
    let with = judge(workbench, &mut found.held_out, &found.after.model)?;
    Some(compare(&without, with).ratio > POOR_EXPLANATION)
}

/// Does anything lie under it that the catalogue does not have? `before`: the base fit.
#[inline(never)]
pub(super) fn look_beneath(
    workbench: &mut Workbench<impl Schedule>,
    before: &Model,
    found: &mut Found,
    observe: &mut dyn FnMut(&Consideration),
) -> Option<Option<Unknown>> {
    let is_more = found.is_more(workbench);
    let expands = found.has_two_of_one_variable();
    let with = judge(workbench, &mut found.held_out, &found.after.model)?;
    let fitted = workbench.hold_freed();
    let (without, left, limit) = if is_more {
        let without = workbench.held_out(before)?;
        let left = compare(&without, with).ratio;
        // Two laws of one variable are the first terms of another one, unless they follow the log better.
        let limit = if expands { left } else { left * CLEARLY_BETTER };
        (without, left, limit)
    } else {
        (with.clone(), 1.0, LARGEST_RATIO)
    };
    let expanded = |accepted: &Accepted| accepted.candidate.effect.id.is_expansion();
    let error = workbench.position_rms(&found.after.model)?;
    let structured = error > workbench.structured_error();
    let sensor = SENSOR_COUNTS * f64::from(workbench.data.settings.resolution);
    let doubtful = left
        > if error > sensor {
            NOTHING_LEFT
        } else {
            POOR_EXPLANATION
        };
    let unknown = if doubtful || expands || found.accepted.iter().any(expanded) {
        // Wrong numbers that explain most of it are all there is.
        let alone = found.accepted.is_empty() && (!is_more || left > POOR_EXPLANATION);
        let structured = structured && alone;
        let most = if left > POOR_EXPLANATION {
            Kind::ALL.len()
        } else {
            MAPS_BESIDE_EFFECTS
        };
        let base = (before, &without);
        unknown::learn(workbench, base, (limit, most), structured, observe)?
    } else {
        None
    };
    workbench.base = fitted;
    Some(unknown)
}

/// Takes a learned map for all that is missing. A fit of it starts there from then on.
#[inline(never)]
pub(super) fn take_map(
    workbench: &mut Workbench<impl Schedule>,
    unknown: &mut Unknown,
    found: &mut Found,
) -> Option<()> {
    found.accepted.clear();
    found.held_out = None;
    found.left = 1.0;
    workbench.hold_freed();
    found.after = workbench.fit_past_blocks(&unknown.start)?;
    unknown.start.clone_from(&found.after.model);
    Some(())
}

/// Takes the map again, where nothing was found beside the base that it has freed.
#[inline(never)]
pub(super) fn take_map_again(
    workbench: &mut Workbench<impl Schedule>,
    unknown: &Unknown,
    found: &mut Found,
) -> Option<()> {
    found.accepted.clear();
    workbench.hold_freed();
    found.after = workbench.fit(&unknown.start)?;
    Some(())
}

/// Tries to do without each effect and each freed number again: one taken early may have stood in for
/// what a later one explains.
#[inline(never)]
pub(super) fn drop_replaced(
    workbench: &mut Workbench<impl Schedule>,
    found: &mut Found,
    observe: &mut dyn FnMut(&Consideration),
) -> Option<()> {
    let mut place = 0;
    while place < found.accepted.len() && (found.accepted.len() > 1 || workbench.has_freed()) {
        let mut smaller = found.after.model.clone();
        let slot = workbench.declared.effects.len() + place;
        smaller.effects.remove(slot);
        let without = workbench.held_out(&smaller)?;
        let model = &found.after.model;
        let with = judge(workbench, &mut found.held_out, model)?;
        let comparison =
            compare_where_it_shows(workbench, (&smaller, &without), (model, with), slot)?;
        if comparison.refusal(1).is_none() {
            place += 1;
            continue;
        }
        let dropped = found.accepted.remove(place).candidate;
        found.after = workbench.fit(&smaller)?;
        found.held_out = None;
        observe(&Consideration {
            held_out: Some(comparison),
            ..dropped.look(found.accepted.len() + 1, Decision::Dropped)
        });
    }
    let mut place = workbench.options.base.len();
    while place < workbench.base.len() && !found.accepted.is_empty() {
        judge(workbench, &mut found.held_out, &found.after.model)?;
        let number = workbench.base.remove(place);
        let mut smaller = found.after.model.clone();
        smaller.set(number, workbench.declared.get(number));
        let without = workbench.held_out(&smaller)?;
        let with = found.held_out.as_ref()?;
        if compare(&without, with).refusal(1).is_none() {
            let _ = workbench.base.insert(place, number);
            place += 1;
            continue;
        }
        found.after = workbench.fit(&smaller)?;
        found.held_out = None;
    }
    Some(())
}
