//! From candidates to a verdict: refit on one half of the log, judge on the other.
//!
//! A round screens every effect, refits the best of them together with the base on every second
//! block of the training log and measures the error on the blocks between; then the other way
//! round. The effect that lowers the held-out error most is taken, if the gain is significant,
//! large enough and common to most blocks; then the next round starts from the model with it. Where
//! declared numbers that are not to be fitted do as well as that effect once they are, they are wrong:
//! they are freed, and no effect is taken. In the end each effect that was taken before others is chosen
//! anew beside these, all must hold against their own absence, and what they leave against [`unknown`]
//! structure.

use super::current_sensor::{Reading, Readings};
use super::fit::Fit;
use super::held_out::{Comparison, HeldOut, LARGEST_RATIO, Refusal, Total, compare};
use super::judging::{
    Leader, THROUGHOUT, compare_in_short_windows, compare_where_it_shows, is_rounding, judge,
    judge_effect, wins_on_its_restarts,
};
use super::model::{Base, Model};
use super::replay::{Data, Schedule};
use super::screen::{Candidate, MOST_CANDIDATES, Screening};
use super::unknown::{self, Unknown};
use super::verdict::{Accepted, Consideration, Decision, Residual, Subject, Trace};
use super::workbench::{Options, Workbench};
use crate::effect::Id;
use crate::effect::learned_map::Kind;
use crate::effect::twins::twins;
use heapless::Vec;

/// Rounds of the selection: most effects that one run adds.
pub const ROUNDS: usize = 4;

/// Fewest windows that a model can be chosen and fitted on.
pub const LEAST_WINDOWS: usize = 4;

/// Candidates refitted in a round for their scores.
const SHORTLIST: usize = 8;

/// Room for those that are refitted whatever their score, besides.
const MOST_REFITTED: usize = SHORTLIST + Id::BENDING;

/// Looks of a round: at the candidates, and at the declared numbers.
const MOST_LOOKS: usize = MOST_CANDIDATES + 1;

/// A candidate, or a map, under this score is not refitted.
pub(super) const LEAST_SCORE: f32 = 0.01;

/// A candidate under this identifiability is absorbed by the base.
const LEAST_IDENTIFIABILITY: f32 = 0.05;

/// A candidate, or a map, whose score is under this share of that of one that has passed is not refitted:
/// what the candidate explains is left for a later round.
pub(super) const FAR_BEHIND: f32 = 0.1;

/// Cosine beyond which a log cannot tell two effects apart.
const EQUIVALENT: f32 = 0.9;

/// Cosine beyond which two effects are the same model and only one is refitted.
const IDENTICAL: f32 = 0.9995;

/// An effect whose held-out error is beyond this multiple of the accepted one's is told from it,
/// however alike the two sensitivities are.
const TOLD_APART: f64 = 1.5;

/// Candidates whose held-out errors are within this ratio of the best one's are equally good: the
/// one with the fewest parameters is taken.
const EQUALLY_GOOD: f64 = 1.1;

/// Most exchanges of an effect for a twin of it.
const MOST_EXCHANGES: usize = 2;

/// An effect with a memory whose held-out error is within this ratio of the best one's may still be
/// the better one: the restarts were chosen for a model without it.
const CONTESTED: f64 = 3.0;

/// A fit of the whole log whose error falls to this multiple of what the held-out one falls to was caught
/// on its way.
const CAUGHT: f64 = 2.0;

/// Share of a declared number from which on a fitted one makes it wrong: finer than a data sheet.
const LEAST_OFF: f32 = 0.02;

/// Standard deviations that an effect's strength must be from zero.
const LEAST_CERTAINTY: f64 = 3.0;

/// A windowed error beyond so many counts of the sensor is not the sensor's.
const SENSOR_COUNTS: f64 = 3.0;

/// A windowed error beyond so many counts of the sensor, and beyond this share of the stroke, is too large for
/// what is linear in an effect to say much of it.
const STRUCTURED_COUNTS: f64 = 10.0;
const STRUCTURED_STROKE: f64 = 0.003;

/// Effects that leave more than this share of the held-out error are challenged by learned maps, as
/// are those that leave an error beyond the sensor's and those that are the first terms of any law.
const POOR_EXPLANATION: f64 = 0.3;

/// Effects that leave less than this share of the held-out error, the product over the channels, do not stand
/// in for anything else. What they leave is no reason to look beyond the scores, however far beyond the
/// sensor's it is.
const NOTHING_LEFT: f64 = 1e-3;

/// Maps that challenge effects that leave little: those that explain most of what is left without.
const MAPS_BESIDE_EFFECTS: usize = 3;

/// A map that brings the held-out error below this share of what the effects leave replaces them:
/// the catalogue's best guess is then not what the machine has.
const CLEARLY_BETTER: f64 = 0.5;

/// Traces the gap between `model` and the logs of `data`, over windows of one length. `observe` is told of every look
/// at every candidate, round by round.
///
/// `None` if the model cannot be built or there is no whole window.
#[inline(never)]
pub(super) fn trace_over<S: Schedule>(
    data: &Data,
    schedule: &S,
    model: &Model,
    options: &Options,
    observe: &mut dyn FnMut(&Consideration),
) -> Option<Trace> {
    let mut workbench = Workbench::new(*data, schedule, model, options)?;
    let mut before = fit_base(&mut workbench)?;
    let mut found = Found {
        after: before.clone(),
        accepted: Vec::new(),
        held_out: None,
        left: 1.0,
    };
    found.search(&mut workbench, 1, observe)?;
    if found.is_more(&workbench) || !workbench.readings.is_empty() {
        // Both models are judged on the same restarts, so the first is fitted to these too.
        let fitted = workbench.hold_freed();
        before = workbench.best_fit(&[&before.model, model])?;
        workbench.base = fitted;
    }
    let mut unknown = look_beneath(&mut workbench, &before.model, &mut found, observe)?;
    if let Some(learned) = &mut unknown {
        found.outdone_by(learned, observe);
        take_map(&mut workbench, learned, &mut found)?;
        if look_again(&mut workbench, &mut found, observe)? {
            observe(&learned.dropped());
            unknown = None;
        } else {
            take_map_again(&mut workbench, learned, &mut found)?;
        }
    }
    if !stands(&mut workbench, &before.model, &mut found, observe)? {
        unknown = None;
        found.after = before.clone();
    }
    conclude(&mut workbench, before, found, unknown)
}

/// What is said of what was found. Where nothing is proven, numbers that were freed are taken back.
#[inline(never)]
pub(super) fn conclude(
    workbench: &mut Workbench<impl Schedule>,
    mut before: Fit,
    mut found: Found,
    unknown: Option<Unknown>,
) -> Option<Trace> {
    if hold_readings(workbench, &mut found)? {
        let needed = &workbench.readings;
        let start = before.model.with_readings(needed, workbench.declared);
        let fitted = workbench.hold_freed();
        before = workbench.fit(&start)?;
        workbench.base = fitted;
    }
    let mut end = end_at(workbench, &mut found)?;
    if workbench.has_freed()
        && found.accepted.is_empty()
        && unknown.is_none()
        && end.proves_nothing()
    {
        // Something is missing that nobody found, and the numbers may stand in for it.
        workbench.hold_freed();
        found.after = before.clone();
        end = end_at(workbench, &mut found)?;
    }
    if unknown.is_none() && !found.is_more(workbench) {
        before = found.after.clone();
    }
    let End { residual, farthest } = end;
    Some(Trace {
        residual,
        farthest,
        base: workbench.base.clone(),
        readings: workbench.readings.clone(),
        settings: workbench.data.settings,
        simulated: workbench.simulated,
        before,
        after: found.after,
        accepted: found.accepted,
        unknown,
        unconfirmed: false,
    })
}

/// What the final model leaves.
struct End {
    residual: Residual,
    /// A number that is where no data sheet would let it be.
    farthest: Option<Base>,
}

impl End {
    /// Whether "nothing is missing" cannot be said of the model.
    fn proves_nothing(&self) -> bool {
        self.residual.is_unexplained() || self.farthest.is_some()
    }
}

/// Puts the numbers of the final model where a data sheet would let them be, as far as the log does, and says what
/// it leaves.
#[inline(never)]
fn end_at(workbench: &mut Workbench<impl Schedule>, found: &mut Found) -> Option<End> {
    let (after, farthest) = workbench.within_data_sheet(found.after.clone())?;
    found.after = after;
    let model = &found.after.model;
    let residual = Residual {
        position_rms: workbench.position_rms(model)?,
        floor: workbench.least_error(model)?,
    };
    Some(End { residual, farthest })
}

// The steps below are functions of their own on the stack too: what one of them needs, the next one
// may use again.

/// Fits the declared model.
#[inline(never)]
fn fit_base(workbench: &mut Workbench<impl Schedule>) -> Option<Fit> {
    let declared = workbench.declared;
    let window = workbench.data.settings.window;
    // How replays restart comes before any fit, which would else bend the parameters to restarts
    // that are wrong. Then short windows: far from the truth, they are the smoother problem.
    workbench.restart(declared)?;
    let mut fitted = declared.clone();
    for window in [workbench.screen_window(), window, window] {
        workbench.weigh(&fitted, window)?;
        fitted = workbench.fit_windows(&fitted, window)?.model;
    }
    workbench.restart(&fitted)?;
    let near = workbench.approach(declared);
    let best = workbench.best_fit(&[&fitted, declared, near.as_ref().unwrap_or(declared)])?;
    Some(workbench.settle(best))
}

/// What has been found so far.
pub(super) struct Found {
    /// The model with the effects.
    pub after: Fit,
    pub accepted: Vec<Accepted, ROUNDS>,
    /// Held-out errors of that model, where they are known.
    pub held_out: Option<HeldOut>,
    /// Share of the held-out error that the effects leave, as far as it is known; what they were chosen anew
    /// beside is not in it.
    pub left: f64,
}

impl Found {
    /// Adds one effect after the other, and drops what the later ones replace. `first`: number of the
    /// first round.
    fn search(
        &mut self,
        workbench: &mut Workbench<impl Schedule>,
        first: usize,
        observe: &mut dyn FnMut(&Consideration),
    ) -> Option<()> {
        for round in first..first + ROUNDS {
            if !add_effect(workbench, round, self, observe)? {
                break;
            }
        }
        self.exchange(workbench, first + ROUNDS - 1, observe)?;
        drop_replaced(workbench, self, observe)
    }

    /// Takes each effect that was chosen without the later ones out again, and has one chosen beside these:
    /// what was taken first may have been the best there was for two. `round`: what looks at it tell.
    fn exchange(
        &mut self,
        workbench: &mut Workbench<impl Schedule>,
        round: usize,
        observe: &mut dyn FnMut(&Consideration),
    ) -> Option<()> {
        let mut place = 0;
        for _ in 1..self.accepted.len() {
            let out = self.accepted[place].candidate;
            match self.choose_anew(workbench, place, round)? {
                Some(taken) => {
                    let by = taken.subject;
                    observe(&out.look(round, Decision::Outdone { by }));
                    observe(&taken);
                }
                None => place += 1,
            }
        }
        Some(())
    }

    /// Takes what a round chooses beside all others in place of the effect at this place, if it follows the
    /// log better, or as well with fewer parameters. The look at it; `None` inside if nothing changes.
    // What is kept lies below a whole round: no more than what cannot be had again.
    #[inline(never)]
    fn choose_anew(
        &mut self,
        workbench: &mut Workbench<impl Schedule>,
        place: usize,
        round: usize,
    ) -> Option<Option<Consideration>> {
        let (data, base) = (workbench.data, workbench.base.clone());
        let readings = workbench.readings.clone();
        let (kept, left) = (self.after.clone(), self.left);
        let out = self.accepted.remove(place);
        let others = self.accepted.len();
        let slot = workbench.declared.effects.len() + place;
        self.do_without(workbench, slot)?;
        let mut taken = None;
        add_effect(workbench, round, self, &mut |look| {
            if matches!(
                look.decision,
                Decision::Accepted | Decision::InPlaceOf { .. }
            ) {
                taken = Some(*look);
            }
        })?;
        if self.accepted.len() > others
            && self.replaces(workbench, (&kept.model, &data, out.candidate.effect.id))?
        {
            return Some(taken);
        }
        self.accepted.truncate(others);
        let _ = self.accepted.insert(place, out);
        (self.after, self.left) = (kept, left);
        self.held_out = None;
        workbench.data = data;
        workbench.base = base;
        workbench.readings = readings;
        Some(None)
    }

    /// Fits the model without the effect in a slot.
    #[inline(never)]
    fn do_without(&mut self, workbench: &mut Workbench<impl Schedule>, slot: usize) -> Option<()> {
        self.after.model.effects.remove(slot);
        self.after = workbench.fit(&self.after.model)?;
        self.held_out = None;
        self.left = 1.0;
        Some(())
    }

    /// Whether the effect that was accepted last is to replace another one, given with the model that has it
    /// and the data cut for that: on the restarts of either model, for each favours its own.
    #[inline(never)]
    fn replaces<'d>(
        &mut self,
        workbench: &mut Workbench<'d, impl Schedule>,
        (model, data, out): (&Model, &Data<'d>, Id),
    ) -> Option<bool> {
        let id = self.accepted.last()?.candidate.effect.id;
        if id == out {
            return Some(false);
        }
        let limit = tolerated(id, out);
        let chosen = workbench.data;
        for restarts in [*data, chosen] {
            workbench.data = restarts;
            let before = workbench.held_out(model)?;
            let now = workbench.held_out(&self.after.model)?;
            if compare(&before, &now).ratio > limit {
                workbench.data = chosen;
                return Some(false);
            }
            self.held_out = Some(now);
        }
        Some(true)
    }

    /// Place of the first effect whose strength may be none.
    #[inline(never)]
    fn uncertain(&self, workbench: &mut Workbench<impl Schedule>) -> Option<Option<usize>> {
        let first = workbench.declared.effects.len();
        for place in 0..self.accepted.len() {
            if workbench.certainty(&self.after.model, first + place)? < LEAST_CERTAINTY {
                return Some(Some(place));
            }
        }
        Some(None)
    }

    /// Whether two of its effects act in the same way over one variable.
    fn has_two_of_one_variable(&self) -> bool {
        let map = |accepted: &Accepted| accepted.candidate.effect.id.map();
        let effects = self.accepted.iter().enumerate();
        effects.into_iter().any(|(place, one)| {
            let others = &self.accepted[place + 1..];
            map(one).is_some() && others.iter().any(|other| map(one) == map(other))
        })
    }

    /// Tells that a learned map explains more than all effects.
    pub fn outdone_by(&self, learned: &Unknown, observe: &mut dyn FnMut(&Consideration)) {
        let by = Subject::Map(learned.kind);
        for effect in &self.accepted {
            observe(&effect.candidate.look(1, Decision::Outdone { by }));
        }
    }

    /// Whether there is more in it than the base.
    pub fn is_more(&self, workbench: &Workbench<impl Schedule>) -> bool {
        !self.accepted.is_empty() || workbench.has_freed()
    }
}

/// One round. Whether it has found something.
#[inline(never)]
fn add_effect(
    workbench: &mut Workbench<impl Schedule>,
    round: usize,
    found: &mut Found,
    observe: &mut dyn FnMut(&Consideration),
) -> Option<bool> {
    let mut round = Round::new(round);
    consider(workbench, &mut round, found, observe)?;
    if free_sensor(workbench, &round, found)? {
        round.tell(Subject::Sensor, observe);
        return Some(true);
    }
    if free_numbers(workbench, &mut round, found)? {
        round.tell(Subject::Numbers, observe);
        return Some(true);
    }
    take_winner(workbench, &mut round, found, observe)
}

/// Frees gain, offset and lag of the current's sensor, if they explain what is left as well as the best effect does.
/// Whether they do. From then on they are numbers of every fit: what they explain is no effect's.
#[inline(never)]
fn free_sensor(
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
fn hold_readings(workbench: &mut Workbench<impl Schedule>, found: &mut Found) -> Option<bool> {
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
fn free_numbers(
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

/// Adds the effect that a round has found to what has been found. Whether there is one.
#[inline(never)]
fn take_winner(
    workbench: &mut Workbench<impl Schedule>,
    round: &mut Round,
    found: &mut Found,
    observe: &mut dyn FnMut(&Consideration),
) -> Option<bool> {
    let Round { winner, rival, .. } = round;
    if let (Some(leading), Some(rival)) = (winner.as_mut(), rival.take()) {
        let pair = [rival.candidate.effect, leading.candidate.effect];
        if wins_on_its_restarts(workbench, &found.after.model, pair)? {
            *leading = rival;
        }
    }
    let winner = winner.take();
    let taken = winner.as_ref().map_or(Subject::Numbers, |winner| {
        Subject::Effect(winner.candidate.effect.id)
    });
    round.tell(taken, observe);
    let Some(mut winner) = winner else {
        return Some(false);
    };
    let effect = winner.candidate.effect;
    let leads = |(_, model): &&(f64, Model)| {
        let last = model.effects.last();
        last.is_some_and(|last| last.id == effect.id)
    };
    let fitted = match round.leader.as_ref().filter(leads) {
        Some((_, started)) => workbench.fit(started)?.model,
        None => match workbench.start(&found.after.model, effect)? {
            Some(started) => workbench.fit(&started)?.model,
            None => return Some(false),
        },
    };
    let fell = workbench.error_ratio(&found.after.model, &fitted)?;
    let fitted = if fell > CAUGHT * round.least {
        workbench.fit_past_blocks(&fitted)?.model
    } else {
        fitted
    };
    let fitted = ask_twins(workbench, &mut winner, fitted)?;
    if winner.candidate.effect.id != effect.id {
        let other = effect.id;
        let look = winner
            .candidate
            .look(round.number, Decision::InPlaceOf { other });
        observe(&look);
    }
    // What is judged is the fit on its own restarts: on those of the model without, a window that restarts
    // wrongly may seem to decide all.
    let chosen = workbench.data;
    workbench.restart(&fitted)?;
    let after = workbench.fit(&fitted)?;
    let after = workbench.settle(after);
    let slot = after.model.effects.len() - 1;
    if let Some(decision) = doubt(workbench, &after.model, slot)? {
        workbench.data = chosen;
        observe(&winner.candidate.look(round.number, decision));
        return Some(false);
    }
    if exchange_for_twin(workbench, &after.model, found)? {
        let decision = Decision::Refused(Refusal::NotNeeded);
        observe(&winner.candidate.look(round.number, decision));
        return Some(true);
    }
    found.left *= winner.ratio;
    let _ = found.accepted.push(winner);
    found.held_out = None;
    found.after = after;
    Some(true)
}

/// What speaks against the effect in a slot of a fitted model, though held-out blocks are followed better with
/// it: it is within half a count of the sensor; a fit without it, from where the one with it has come to, does
/// as well, for it only helped out of where the fit before was caught; or its strength is uncertain. That is asked
/// here only of an effect that leaves most of the error: what is still missing makes the strength of one that
/// takes most of it uncertain too. In the end [`stands`] asks it of all.
#[inline(never)]
fn doubt(
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
fn exchange_for_twin(
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

/// Whether a model lacks an effect that its coordinate may have.
fn is_allowed_beside(workbench: &Workbench<impl Schedule>, model: &Model, id: Id) -> bool {
    let has = model.effects.iter().any(|effect| effect.id == id);
    !has && (workbench.options.scope.rotary || !id.description().rotary_only)
}

/// A model whose last effect has been found, beside those with its twins: which of them the log does
/// not tell from it, and one in its place that follows the log better, or as well with fewer parameters. By
/// itself a twin may not have been found, where a fit from the base alone does not come to it.
#[inline(never)]
fn ask_twins(
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
fn tolerated(other: Id, than: Id) -> f64 {
    if other.parameters() < than.parameters() {
        EQUALLY_GOOD
    } else {
        1.0 / EQUALLY_GOOD
    }
}

/// Whether what was found may be said: no strength is uncertain beside all others, it needs no number that no data
/// sheet would allow, and nothing that was fitted to held-out blocks of one length predicts clearly worse over
/// shorter or longer ones. Effects go one by one, an uncertain one before the last one, until the rest may be said.
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
        let (after, farthest) = workbench.within_data_sheet(found.after.clone())?;
        found.after = after;
        let uncertain = found.uncertain(workbench)?;
        let refusal = if uncertain.is_some() {
            Refusal::Uncertain
        } else if farthest.is_some() {
            Refusal::Implausible
        } else if workbench.is_clearly_worse(&found.after.model, before)? {
            Refusal::WorseElsewhere
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
    let structured = error > structure(workbench);
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
fn take_map_again(
    workbench: &mut Workbench<impl Schedule>,
    unknown: &Unknown,
    found: &mut Found,
) -> Option<()> {
    found.accepted.clear();
    workbench.hold_freed();
    found.after = workbench.fit(&unknown.start)?;
    Some(())
}

/// Looks for effects from the base that a learned map has freed: one that was fitted alone may have bent
/// to what is missing, so that little was left to be seen of it. Whether effects are found that follow the
/// log about as well as the map does.
#[inline(never)]
fn look_again(
    workbench: &mut Workbench<impl Schedule>,
    found: &mut Found,
    observe: &mut dyn FnMut(&Consideration),
) -> Option<bool> {
    let with_map = total_held_out(workbench, &found.after.model)?;
    found.after.model.map = None;
    found.search(workbench, ROUNDS + 1, observe)?;
    if found.accepted.is_empty() {
        return Some(false);
    }
    let expands = found.has_two_of_one_variable();
    let with = Total::of(judge(workbench, &mut found.held_out, &found.after.model)?);
    let most = if expands { 1.0 } else { 1.0 / CLEARLY_BETTER };
    Some(with.over(&with_map) <= most)
}

/// Held-out error of a model as a whole.
// Not part of a frame under which effects are looked for.
#[inline(never)]
fn total_held_out(workbench: &mut Workbench<impl Schedule>, model: &Model) -> Option<Total> {
    workbench.held_out(model).as_ref().map(Total::of)
}

/// Error beyond which it has a cause, whether anything is found for it or not, rad or m.
fn structure(workbench: &Workbench<impl Schedule>) -> f64 {
    let sensor = STRUCTURED_COUNTS * f64::from(workbench.data.settings.resolution);
    let stroke = STRUCTURED_STROKE * f64::from(workbench.options.scope.stroke);
    sensor.max(stroke)
}

impl Accepted {
    /// A look at it that says that it is found over predictions of one length alone.
    pub(super) fn refused(&self) -> Consideration {
        let decision = Decision::Refused(Refusal::OverOneLength);
        self.candidate.look(1, decision)
    }
}

impl Candidate {
    /// A look at it that was decided without a refit.
    fn look(&self, round: usize, decision: Decision) -> Consideration {
        Consideration {
            round,
            subject: Subject::Effect(self.effect.id),
            score: self.score,
            identifiability: self.identifiability,
            held_out: None,
            decision,
        }
    }

    /// What its scores say: whether it is worth a refit.
    fn first_look(&self, round: usize, resolution: f32) -> Consideration {
        let decision = if self.effect.id.bends_base() {
            Decision::NotShortlisted
        } else if self.identifiability < LEAST_IDENTIFIABILITY {
            Decision::Absorbed
        } else if !self.allowed {
            Decision::WrongSign
        } else if is_rounding(&self.effect, resolution) {
            Decision::BelowResolution
        } else if self.score < LEAST_SCORE {
            Decision::ScoreTooLow
        } else {
            Decision::NotShortlisted
        };
        self.look(round, decision)
    }
}

/// Tries to do without each effect and each freed number again: one taken early may have stood in for
/// what a later one explains.
#[inline(never)]
fn drop_replaced(
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

/// What a round has looked at and decided. In one place: on the chip there is no room for copies.
struct Round {
    /// From 1.
    number: usize,
    looks: Vec<Consideration, MOST_LOOKS>,
    leader: Leader,
    winner: Option<Accepted>,
    /// An effect with a memory that comes near to it, and may win where replays restart as suits it.
    rival: Option<Accepted>,
    /// Least held-out error of those that passed, over that without; infinite if none has.
    least: f64,
}

impl Round {
    fn new(number: usize) -> Self {
        Self {
            number,
            looks: Vec::new(),
            leader: None,
            winner: None,
            rival: None,
            least: f64::INFINITY,
        }
    }

    /// Tells of every look, now that it is known what was taken.
    fn tell(&mut self, taken: Subject, observe: &mut dyn FnMut(&Consideration)) {
        for look in &mut self.looks {
            if look.decision == Decision::Accepted && look.subject != taken {
                look.decision = Decision::Outdone { by: taken };
            }
            observe(look);
        }
    }
}

/// Screens the effects that a model lacks and judges the best of them.
#[inline(never)]
fn consider(
    workbench: &mut Workbench<impl Schedule>,
    round: &mut Round,
    found: &mut Found,
    observe: &mut dyn FnMut(&Consideration),
) -> Option<()> {
    let resolution = workbench.data.settings.resolution;
    let number = round.number;
    let passed_over = |candidate: &Candidate| observe(&candidate.first_look(number, resolution));
    let screened = workbench.screen(&found.after.model, passed_over)?;
    refit(workbench, round, found, &screened)
}

/// Where an effect that comes and goes leads, which has been proven in short windows: proves there too what
/// follows held-out blocks better, but not in enough of them. The best of all that are proven leads then.
#[inline(never)]
fn prove_rivals(
    workbench: &mut Workbench<impl Schedule>,
    model: &Model,
    screened: &Screening,
    shortlist: &[usize],
    looks: &mut [Consideration],
    leader: &mut Leader,
) -> Option<()> {
    let comes_and_goes = |(ratio, model): &(f64, Model)| {
        let effect = model.effects.last()?;
        effect.law().span().map(|_| *ratio)
    };
    let Some(limit) = leader.as_ref().and_then(comes_and_goes) else {
        return Some(());
    };
    for &index in shortlist {
        let effect = screened.candidates[index].effect;
        let look = &mut looks[index];
        let unproven = matches!(
            look.decision,
            Decision::Refused(Refusal::NotSignificant { .. })
        );
        let Some(held_out) = look
            .held_out
            .filter(|held_out| unproven && held_out.ratio < limit && !effect.id.remembers())
        else {
            continue;
        };
        let with = workbench.start(model, effect)??;
        let proven = Comparison {
            ratio: held_out.ratio,
            ..compare_in_short_windows(workbench, (model, &with), THROUGHOUT)?
        };
        if proven.refusal(screened.tries(index)).is_none() {
            look.held_out = Some(proven);
            look.decision = Decision::Accepted;
            if leader
                .as_ref()
                .is_none_or(|(least, _)| proven.ratio < *least)
            {
                *leader = Some((proven.ratio, with));
            }
        }
    }
    Some(())
}

/// Judges the candidates of a round.
#[inline(never)]
fn refit(
    workbench: &mut Workbench<impl Schedule>,
    round: &mut Round,
    found: &mut Found,
    screened: &Screening,
) -> Option<()> {
    let Screening {
        candidates,
        imitation,
        ..
    } = screened;
    let resolution = workbench.data.settings.resolution;
    let Round {
        number,
        looks,
        leader,
        ..
    } = round;
    let first = |candidate: &Candidate| candidate.first_look(*number, resolution);
    looks.extend(candidates.iter().map(first));
    let model = &found.after.model;
    let mut shortlist: Vec<usize, MOST_REFITTED> = Vec::new();
    let mut scored = 0;
    for index in 0..looks.len() {
        let bends_base = candidates[index].effect.id.bends_base();
        if looks[index].decision == Decision::NotShortlisted && (bends_base || scored < SHORTLIST) {
            let _ = shortlist.push(index);
            scored += usize::from(!bends_base);
        }
    }
    // Where the machine sticks while the model slides, what is linear in an effect says little of it.
    let structured =
        found.left > NOTHING_LEFT && workbench.position_rms(model)? > structure(workbench);
    for index in 0..looks.len() {
        if structured && looks[index].decision == Decision::ScoreTooLow && scored < SHORTLIST {
            let _ = shortlist.push(index);
            scored += 1;
        }
    }
    let smaller = judge(workbench, &mut found.held_out, model)?;
    for &index in &shortlist {
        let own = candidates[index].effect;
        let ahead = shortlist.iter().find(|&&other| {
            looks[other].decision == Decision::Accepted
                && !structured
                && !own.id.bends_base()
                && candidates[index].score < FAR_BEHIND * candidates[other].score
        });
        if let Some(&other) = ahead {
            looks[index].decision = Decision::FarBehind {
                of: Subject::Effect(candidates[other].effect.id),
            };
            continue;
        }
        // Of effects that are one model here, the catalogue's first is refitted for all.
        let same = shortlist.iter().find(|&&other| {
            (candidates[other].effect.id as usize) < own.id as usize
                && imitation[index][other] > IDENTICAL
                && imitation[other][index] > IDENTICAL
        });
        if let Some(&other) = same {
            looks[index].decision = Decision::SameAs {
                other: candidates[other].effect.id,
            };
            continue;
        }
        // Passed is Accepted for now; who wins is known when all have been refitted.
        let tries = screened.tries(index);
        looks[index].decision = match judge_effect(workbench, model, smaller, own, tries, leader)? {
            Ok((comparison, refusal)) => {
                looks[index].held_out = Some(comparison);
                refusal.map_or(Decision::Accepted, Decision::Refused)
            }
            Err(decision) => decision,
        };
    }
    prove_rivals(workbench, model, screened, &shortlist, looks, leader)?;

    let passed = |index: usize| {
        looks[index]
            .held_out
            .filter(|_| looks[index].decision == Decision::Accepted)
    };
    let ratios = |index: &usize| passed(*index).map(|held_out| held_out.ratio);
    let Some(least) = shortlist.iter().filter_map(ratios).min_by(f64::total_cmp) else {
        return Some(());
    };
    let parameters = |index: usize| candidates[index].effect.id.parameters();
    let (best, comparison) = shortlist
        .iter()
        .filter_map(|&index| passed(index).map(|held_out| (index, held_out)))
        .filter(|(_, held_out)| held_out.ratio <= EQUALLY_GOOD * least)
        .min_by(|a, b| {
            let fewer = parameters(a.0).cmp(&parameters(b.0));
            fewer.then(a.1.ratio.total_cmp(&b.1.ratio))
        })?;

    // The error of an effect that was not refitted is that of the one it is the same as.
    let error = |id: Id| {
        let find = |id: Id| {
            looks
                .iter()
                .find(|look| look.subject == Subject::Effect(id))
        };
        let look = find(id)?;
        let refitted = match look.decision {
            Decision::SameAs { other } => find(other)?,
            _ => look,
        };
        refitted.held_out.map(|held_out| held_out.ratio)
    };
    // What came to nothing before it was tested is told apart too.
    let came_to_nothing = |id: Id| {
        looks.iter().any(|look| {
            let nothing = [Decision::Hopeless, Decision::BelowResolution];
            look.subject == Subject::Effect(id) && nothing.contains(&look.decision)
        })
    };
    let told_apart =
        |id: Id| error(id).map_or_else(|| came_to_nothing(id), |ratio| ratio > TOLD_APART * least);
    let accept = |best: usize, comparison: Comparison| Accepted {
        candidate: candidates[best],
        p_value: comparison.p_value,
        ratio: comparison.ratio,
        equivalent: shortlist
            .iter()
            .filter(|&&other| other != best && imitation[best][other] > EQUIVALENT)
            .map(|&other| candidates[other].effect.id)
            .filter(|&id| !told_apart(id))
            .collect(),
    };
    let rival = shortlist.iter().find_map(|&index| {
        let remembers = candidates[index].effect.id.remembers();
        let near = |held_out: &Comparison| held_out.ratio <= CONTESTED * least;
        let held_out = passed(index).filter(near)?;
        (index != best && remembers).then(|| accept(index, held_out))
    });
    round.winner = Some(accept(best, comparison));
    round.rival = rival;
    round.least = least;
    Some(())
}
