//! Numbers of the machine file and of the current's sensor that are freed where they explain what is left.

use super::alternatives::other_law;
use super::criterion::{EQUALLY_GOOD, LEAST_OFF};
use super::current_sensor::{Reading, Readings};
use super::fit::Fit;
use super::found::Found;
use super::held_out::{Comparison, HeldOut, compare};
use super::judging::judge;
use super::model::{Base, Model};
use super::replay::Schedule;
use super::round::Round;
use super::verdict::{Decision, Subject};
use super::workbench::Workbench;
use heapless::Vec;

/// Frees gain, offset and lag of the current's sensor, if they explain what is left as well as the best effect does;
/// or one number of the machine file, if that does what several of them do: a current that seems too large and late is
/// that of another resistance. What it has freed. From then on they are numbers of every fit: what they explain is no
/// effect's.
#[inline(never)]
pub(super) fn free_sensor(
    workbench: &mut Workbench<impl Schedule>,
    round: &mut Round,
    found: &mut Found,
) -> Option<Option<Subject>> {
    if !workbench.readings.is_empty() || !workbench.has_sensor() {
        return Some(None);
    }
    let model = &found.after.model;
    let smaller = judge(workbench, &mut found.held_out, model)?;
    workbench.readings = Readings::from_array(Reading::ALL);
    let with = workbench.held_out(model)?;
    let comparison = compare(smaller, &with);
    if comparison.refusal(1).is_some() || comparison.ratio > EQUALLY_GOOD * round.least {
        workbench.readings.clear();
        return Some(None);
    }
    let fitted = workbench.fit(model)?.model;
    if workbench.is_good_sensor(&fitted) {
        workbench.readings.clear();
        return Some(None);
    }
    let all = workbench.readings.clone();
    let needed = needed_readings(workbench, &fitted, &all, &with)?;
    workbench.readings.clear();
    if needed.len() > 1
        && let Some((fit, comparison)) = number_instead(workbench, found, &with)?
    {
        round.look_at(Subject::Numbers, comparison, Decision::Accepted);
        found.after = fit;
        found.held_out = None;
        return Some(Some(Subject::Numbers));
    }
    workbench.readings = all;
    workbench.restart(&fitted)?;
    found.after = workbench.fit(&fitted)?;
    found.held_out = None;
    Some(Some(Subject::Sensor))
}

/// The fewest of these numbers of the current's sensor with which held-out blocks are followed about as well as with
/// all of them. `with`: the errors with all.
fn needed_readings(
    workbench: &mut Workbench<impl Schedule>,
    model: &Model,
    freed: &Readings,
    with: &HeldOut,
) -> Option<Readings> {
    fewest(freed, EQUALLY_GOOD, |some| {
        workbench.readings = some.clone();
        let model = model.with_readings(some, workbench.declared);
        Some(compare(with, &workbench.held_out(&model)?).ratio)
    })
}

/// A fit that has freed one number of the machine file, with which held-out blocks are followed about as well as with the
/// current's sensor; `None` inside if none does that. `with`: the errors with the sensor's numbers.
#[inline(never)]
fn number_instead(
    workbench: &mut Workbench<impl Schedule>,
    found: &mut Found,
    with: &HeldOut,
) -> Option<Option<(Fit, Comparison)>> {
    let model = &found.after.model;
    let smaller = judge(workbench, &mut found.held_out, model)?;
    let (chosen, fixed) = (workbench.data, workbench.base.len());
    for number in workbench.held_numbers() {
        let without = workbench.held_out_freeing(model, &[number])?;
        if compare(with, &without).ratio > EQUALLY_GOOD {
            continue;
        }
        let fit = workbench.free(model, &[number])?;
        if is_off(workbench.declared, &fit.model, number) {
            return Some(Some((fit, compare(smaller, &without))));
        }
        workbench.base.truncate(fixed);
        workbench.data = chosen;
    }
    Some(None)
}

/// Whether a number is so far from what is declared that it counts as wrong.
fn is_off(declared: &Model, fitted: &Model, number: Base) -> bool {
    let declared = declared.get(number);
    (fitted.get(number) - declared).abs() >= LEAST_OFF * declared.abs()
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
    let model = &found.after.model;
    let with = workbench.held_out(model)?;
    let freed = core::mem::take(&mut workbench.readings);
    let without = model.with_readings(&workbench.readings, workbench.declared);
    let without = workbench.held_out(&without)?;
    let needed = if is_good || compare(&without, &with).refusal(1).is_some() {
        Readings::new()
    } else {
        needed_readings(workbench, model, &freed, &with)?
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

/// Whether an earlier input than the log has explains what is left, to this ratio at most; then it is a number that fits move, and
/// the tracing has to begin anew. `smaller`: the errors without.
#[inline(never)]
fn free_lead(
    workbench: &mut Workbench<impl Schedule>,
    round: &mut Round,
    (model, smaller): (&Model, &HeldOut),
    most: f64,
) -> Option<bool> {
    let lead = Base::InputLead;
    if workbench.base.contains(&lead) {
        return Some(false);
    }
    let comparison = compare(smaller, &workbench.held_out_freeing(model, &[lead])?);
    let refusal = comparison.refusal(1);
    let decision = refusal.map_or(Decision::Accepted, Decision::Refused);
    round.look_at(Subject::Input, comparison, decision);
    let is_late = refusal.is_none() && comparison.ratio <= most;
    if is_late {
        let _ = workbench.base.push(lead);
        if let Some(look) = round.look_of(Subject::Input) {
            look.round = 1;
        }
    }
    Some(is_late)
}

/// Frees the lead of the log's input, or the numbers that the base holds, if they explain what is left as well as the best
/// effect does: the one number, where it does so as well as the others. Which of them it has freed: a number that is a little off, or
/// a logger that is late, is commoner than an effect that nobody declared.
#[inline(never)]
pub(super) fn free_numbers(
    workbench: &mut Workbench<impl Schedule>,
    round: &mut Round,
    found: &mut Found,
) -> Option<Option<Subject>> {
    let held = workbench.held_numbers();
    let model = &found.after.model;
    let smaller = judge(workbench, &mut found.held_out, model)?;
    let mut least = round.least;
    let mut numbers = None;
    if !held.is_empty() {
        let comparison = compare(smaller, &workbench.held_out_freeing(model, &held)?);
        let refusal = comparison.refusal(held.len());
        let decision = refusal.map_or(Decision::Accepted, Decision::Refused);
        round.look_at(Subject::Numbers, comparison, decision);
        if refusal.is_none() && comparison.ratio <= EQUALLY_GOOD * least {
            least = least.min(comparison.ratio);
            numbers = Some(comparison);
        }
    }
    if free_lead(workbench, round, (model, smaller), EQUALLY_GOOD * least)? {
        return Some(Some(Subject::Input));
    }
    let Some(comparison) = numbers else {
        return Some(None);
    };
    let limit = EQUALLY_GOOD * comparison.ratio;
    let mut numbers = fewest(&held, limit, |tried| {
        let larger = workbench.held_out_freeing(model, tried)?;
        Some(compare(smaller, &larger).ratio)
    })?;
    let (chosen, fixed) = (workbench.data, workbench.base.len());
    while !numbers.is_empty() {
        let fit = workbench.free(&found.after.model, &numbers)?;
        let declared = workbench.declared;
        let is_off = |number: &Base| is_off(declared, &fit.model, *number);
        if numbers.iter().all(is_off) {
            let freed = workbench.base.clone();
            workbench.base.truncate(fixed);
            if let Some(other) = other_law(workbench, &fit.model, &numbers, found)? {
                workbench.data = chosen;
                if let Some(look) = round.look_of(Subject::Numbers) {
                    look.decision = Decision::LawOf { other };
                }
                return Some(None);
            }
            workbench.base = freed;
            found.after = fit;
            found.held_out = None;
            return Some(Some(Subject::Numbers));
        }
        numbers.retain(is_off);
        workbench.base.truncate(fixed);
        workbench.data = chosen;
    }
    if let Some(look) = round.look_of(Subject::Numbers) {
        look.decision = Decision::NearDeclared;
    }
    Some(None)
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
