//! Numbers of the machine file and of the current's sensor that are freed where they explain what is left.

use super::criterion::{EQUALLY_GOOD, LEAST_OFF};
use super::current_sensor::{Reading, Readings};
use super::found::Found;
use super::held_out::compare;
use super::judging::judge;
use super::model::Base;
use super::replay::Schedule;
use super::round::Round;
use super::verdict::{Consideration, Decision, Subject};
use super::workbench::Workbench;
use heapless::Vec;

/// Frees gain, offset and lag of the current's sensor, if they explain what is left as well as the best effect does.
/// Whether they do. From then on they are numbers of every fit: what they explain is no effect's.
#[inline(never)]
pub(super) fn free_sensor(
    workbench: &mut Workbench<impl Schedule>,
    round: &Round,
    found: &mut Found,
) -> Option<bool> {
    if !workbench.readings.is_empty() || !workbench.has_sensor() {
        return Some(false);
    }
    let model = &found.after.model;
    let smaller = judge(workbench, &mut found.held_out, model)?;
    workbench.readings = Readings::from_array(Reading::ALL);
    let comparison = compare(smaller, &workbench.held_out(model)?);
    if comparison.refusal(1).is_some() || comparison.ratio > EQUALLY_GOOD * round.least {
        workbench.readings.clear();
        return Some(false);
    }
    let fitted = workbench.fit(model)?.model;
    if workbench.is_good_sensor(&fitted) {
        workbench.readings.clear();
        return Some(false);
    }
    workbench.restart(&fitted)?;
    found.after = workbench.fit(&fitted)?;
    found.held_out = None;
    Some(true)
}

/// Holds those numbers of the current's sensor again without which held-out blocks are followed nearly as well; all of
/// them, if they are a good sensor's beside what was found, or their gain is not significant. Whether any is held.
#[inline(never)]
pub(super) fn hold_readings(
    workbench: &mut Workbench<impl Schedule>,
    found: &mut Found,
) -> Option<bool> {
    if workbench.readings.is_empty() {
        return Some(false);
    }
    let is_good = workbench.is_good_sensor(&found.after.model);
    let freed = workbench.readings.clone();
    let with = workbench.held_out(&found.after.model)?;
    let mut with_some = |some: &Readings| {
        workbench.readings = some.clone();
        let model = &found.after.model;
        workbench.held_out(&model.with_readings(some, workbench.declared))
    };
    let without = with_some(&Readings::new())?;
    let needed = if is_good || compare(&without, &with).refusal(1).is_some() {
        Readings::new()
    } else {
        fewest(&freed, EQUALLY_GOOD, |some| {
            Some(compare(&with, &with_some(some)?).ratio)
        })?
    };
    let is_held = needed.len() < freed.len();
    workbench.readings = needed;
    if is_held {
        let model = &found.after.model;
        let model = model.with_readings(&workbench.readings, workbench.declared);
        found.after = workbench.fit(&model)?;
        found.held_out = None;
    }
    Some(is_held)
}

/// Frees the numbers that the base holds, if they explain what is left as well as the best effect does.
/// Whether they do: a number that is a little off is commoner than an effect that nobody declared.
#[inline(never)]
pub(super) fn free_numbers(
    workbench: &mut Workbench<impl Schedule>,
    round: &mut Round,
    found: &mut Found,
) -> Option<bool> {
    let held = workbench.held_numbers();
    if held.is_empty() {
        return Some(false);
    }
    let model = &found.after.model;
    let smaller = judge(workbench, &mut found.held_out, model)?;
    let comparison = compare(smaller, &workbench.held_out_freeing(model, &held)?);
    let refusal = comparison.refusal(held.len());
    let _ = round.looks.push(Consideration {
        round: round.number,
        subject: Subject::Numbers,
        score: (1.0 - comparison.ratio).max(0.0) as f32,
        identifiability: 1.0,
        held_out: Some(comparison),
        decision: refusal.map_or(Decision::Accepted, Decision::Refused),
    });
    if refusal.is_some() || comparison.ratio > EQUALLY_GOOD * round.least {
        return Some(false);
    }
    let limit = EQUALLY_GOOD * comparison.ratio;
    let mut numbers = fewest(&held, limit, |tried| {
        let larger = workbench.held_out_freeing(model, tried)?;
        Some(compare(smaller, &larger).ratio)
    })?;
    let (chosen, fixed) = (workbench.data, workbench.base.len());
    while !numbers.is_empty() {
        let fit = workbench.free(&found.after.model, &numbers)?;
        let declared = workbench.declared;
        let off = |number: Base| (fit.model.get(number) - declared.get(number)).abs();
        let is_off = |number: &Base| off(*number) >= LEAST_OFF * declared.get(*number).abs();
        if numbers.iter().all(is_off) {
            found.after = fit;
            found.held_out = None;
            return Some(true);
        }
        numbers.retain(is_off);
        workbench.base.truncate(fixed);
        workbench.data = chosen;
    }
    if let Some(look) = round.looks.last_mut() {
        look.decision = Decision::NearDeclared;
    }
    Some(false)
}

/// The fewest of these that bring the held-out error under this ratio once they are free, chosen one after the other.
/// `ratio`: what some of them bring it to.
#[inline(never)]
fn fewest<T: Copy + PartialEq, const N: usize>(
    all: &Vec<T, N>,
    limit: f64,
    mut ratio: impl FnMut(&Vec<T, N>) -> Option<f64>,
) -> Option<Vec<T, N>> {
    let mut freed = Vec::new();
    let mut reached = f64::INFINITY;
    while freed.len() < all.len() && reached > limit {
        let mut best: Option<(T, f64)> = None;
        for &one in all.iter().filter(|one| !freed.contains(*one)) {
            let mut tried = freed.clone();
            let _ = tried.push(one);
            let now = ratio(&tried)?;
            if best.is_none_or(|(_, least)| now < least) {
                best = Some((one, now));
            }
        }
        let (one, least) = best?;
        let _ = freed.push(one);
        reached = least;
    }
    Some(freed)
}
