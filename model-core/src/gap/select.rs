//! From candidates to a verdict: refit on one half of the log, judge on the other.
//!
//! A round screens every effect, refits the best of them together with the base on every second
//! block of the training log and measures the error on the blocks between; then the other way
//! round. The effect that lowers the held-out error most is taken, if the gain is significant,
//! large enough and common to most blocks; then the next round starts from the model with it. Where
//! declared numbers that are not to be fitted do as well as that effect once they are, they are wrong:
//! they are freed, and no effect is taken. In the end each effect that was taken before others is chosen
//! anew beside these, all must hold against their own absence, a periodic one has the overtones that the log asks for, and
//! what they leave is held against [`unknown`](super::unknown) structure.

use super::alternatives::{add_overtones, tolerated};
use super::criterion::CLEARLY_BETTER;
use super::fit::Fit;
use super::found::Found;
use super::held_out::{Total, compare};
use super::judging::judge;
use super::model::{Base, Model, Numbers};
use super::numbers::{free_numbers, free_sensor, hold_readings};
use super::replay::{Data, Schedule, WindowStart};
use super::round::{Round, consider, take_winner};
use super::standing::{drop_replaced, look_beneath, stands, take_map, take_map_again};
use super::unknown::Unknown;
use super::verdict::{Consideration, Decision, ROUNDS, Residual, Trace};
use super::workbench::{Options, Workbench};
use crate::effect::Id;
use heapless::Vec;

/// Fewest windows that a model can be chosen and fitted on.
pub const LEAST_WINDOWS: usize = 4;

/// Traces the gap between `model` and the logs of `data`, over windows of one length. `observe` is told of every look
/// at every candidate, round by round. Where the log's input turns out late, it begins anew with that as a number of every fit:
/// all that was fitted and found before was fitted to other inputs.
///
/// The tracing is left in `traced`, so that no frame under which a model is fitted holds another one.
///
/// `None` if the model cannot be built or there is no whole window.
#[inline(never)]
pub(super) fn trace_over<S: Schedule>(
    data: &Data,
    schedule: &S,
    model: &Model,
    options: &Options,
    observe: &mut dyn FnMut(&Consideration),
    traced: &mut Option<Trace>,
) -> Option<()> {
    *traced = None;
    let in_vain = trace_with(data, schedule, model, options, observe, traced)?;
    if traced.is_some() {
        return Some(());
    }
    let mut base: Numbers = options.base.iter().copied().collect();
    let _ = base.push(Base::InputLead);
    let options = Options {
        base: &base,
        ..*options
    };
    trace_with(data, schedule, model, &options, observe, traced)?;
    traced.as_mut()?.simulated += in_vain;
    Some(())
}

/// Windows that it has simulated. It leaves no tracing where the log's input turns out late, which fits with these options do
/// not know.
#[inline(never)]
fn trace_with<S: Schedule>(
    data: &Data,
    schedule: &S,
    model: &Model,
    options: &Options,
    observe: &mut dyn FnMut(&Consideration),
    traced: &mut Option<Trace>,
) -> Option<u64> {
    let mut workbench = Workbench::new(*data, schedule, model, options)?;
    let mut before = fit_base(&mut workbench)?;
    let mut found = Found::nothing(&before);
    found.search(&mut workbench, 1, observe)?;
    if !workbench.has_found_input_late() && found.add_pair(&mut workbench, ROUNDS, observe)? {
        found.search(&mut workbench, ROUNDS + 1, observe)?;
    }
    if workbench.has_found_input_late() {
        return Some(workbench.simulated);
    }
    if found.is_more(&workbench) || !workbench.readings.is_empty() {
        // Both models are judged on the same restarts, so the first is fitted to these too.
        let fitted = workbench.hold_freed();
        before = workbench.best_fit(&[&before.model, model])?;
        workbench.base = fitted;
    }
    drop_stand_ins(&mut workbench, &mut before, &mut found)?;
    let unknown = challenge(&mut workbench, &before, &mut found, observe)?;
    if workbench.has_found_input_late() {
        return Some(workbench.simulated);
    }
    conclude(&mut workbench, &mut before, &mut found, unknown, traced)?;
    Some(workbench.simulated)
}

/// Holds what was found against laws that the catalogue does not have, and keeps of it what may be said. The law, if it takes
/// the place of the effects. `before`: the base fit. Where the log's input turns out late, it stops.
#[inline(never)]
fn challenge(
    workbench: &mut Workbench<impl Schedule>,
    before: &Fit,
    found: &mut Found,
    observe: &mut dyn FnMut(&Consideration),
) -> Option<Option<Unknown>> {
    let mut unknown = None;
    for challenged in [true, false] {
        unknown = look_beneath(workbench, &before.model, found, observe)?;
        if let Some(learned) = &mut unknown {
            found.outdone_by(learned, observe);
            take_map(workbench, learned, found)?;
            if challenged {
                let found_more = look_again(workbench, found, observe)?;
                if workbench.has_found_input_late() {
                    break;
                }
                if found_more {
                    observe(&learned.dropped());
                    unknown = None;
                } else {
                    take_map_again(workbench, learned, found)?;
                }
            }
        }
        let taken = found.accepted.len();
        let stands = stands(workbench, &before.model, found, observe)?;
        if !stands {
            found.forget(before);
        }
        if stands && found.accepted.len() == taken {
            break;
        }
        // Effects that may not be said do not stand before a law: what lies beneath the rest is asked once more.
        if unknown.take().is_some() {
            break;
        }
    }
    Some(unknown)
}

/// What is said of what was found, left in `traced`. Where nothing is proven, numbers that were freed are taken back.
#[inline(never)]
pub(super) fn conclude(
    workbench: &mut Workbench<impl Schedule>,
    before: &mut Fit,
    found: &mut Found,
    unknown: Option<Unknown>,
    traced: &mut Option<Trace>,
) -> Option<()> {
    if hold_readings(workbench, found)? {
        let needed = &workbench.readings;
        let start = before.model.with_readings(needed, workbench.declared);
        let fitted = workbench.hold_freed();
        *before = workbench.fit(&start)?;
        workbench.base = fitted;
    }
    if unknown.is_none() {
        drop_stand_ins(workbench, before, found)?;
    }
    let end = end_at(workbench, found)?;
    if unknown.is_none() && !found.is_more(workbench) {
        before.clone_from(&found.after);
    }
    let End { residual, farthest } = end;
    *traced = Some(Trace {
        residual,
        farthest,
        base: workbench.base.clone(),
        first_freed: workbench.options.base.len(),
        readings: workbench.readings.clone(),
        settings: workbench.data.settings,
        simulated: workbench.simulated,
        before: before.clone(),
        after: found.after.clone(),
        accepted: found.accepted.clone(),
        unknown,
        unconfirmed: false,
    });
    Some(())
}

/// Holds numbers again that were freed, if nothing else was found and the model still does not follow the log: they may only
/// make up for what is missing. `before`, the base fit, then starts its windows as it follows the log best.
#[inline(never)]
fn drop_stand_ins(
    workbench: &mut Workbench<impl Schedule>,
    before: &mut Fit,
    found: &mut Found,
) -> Option<()> {
    let only_numbers = workbench.has_freed() && found.accepted.is_empty();
    if !only_numbers || !end_at(workbench, found)?.proves_nothing() {
        return Some(());
    }
    workbench.hold_freed();
    workbench.restart(&before.model)?;
    let declared = workbench.declared;
    *before = workbench.best_fit(&[&before.model, declared])?;
    found.forget(before);
    Some(())
}

/// What the final model leaves.
struct End {
    residual: Residual,
    /// A number that the log has beyond its limits.
    farthest: Option<Base>,
}

impl End {
    /// Whether "nothing is missing" cannot be said of the model.
    fn proves_nothing(&self) -> bool {
        self.residual.is_unexplained() || self.farthest.is_some()
    }
}

/// Puts the numbers of the final model within their limits, as far as the log lets them be there, and says what
/// it leaves.
#[inline(never)]
fn end_at(workbench: &mut Workbench<impl Schedule>, found: &mut Found) -> Option<End> {
    let (after, farthest) = workbench.within_limits(found.after.clone())?;
    found.after = after;
    found.held_out = None;
    let residual = workbench.residual(&found.after.model)?;
    Some(End { residual, farthest })
}

// The steps below are functions of their own on the stack too: what one of them needs, the next one
// may use again.

/// Fits the declared model, before any effect is looked for.
///
/// `None` if a model cannot be built.
#[inline(never)]
pub fn fit_base(workbench: &mut Workbench<impl Schedule>) -> Option<Fit> {
    let mut best: Option<(Data, Fit, f64)> = None;
    let has_shaft = workbench.declared.has(Id::Compliance);
    for start in workbench.window_starts(has_shaft) {
        let fit = fit_base_from(workbench, start)?;
        let data = workbench.data;
        let error = workbench.misfit(&data, &fit.model)?;
        let is_best = |(.., least): &(Data, Fit, f64)| error < *least || least.is_nan();
        if best.as_ref().is_none_or(is_best) {
            best = Some((data, fit, error));
        }
    }
    let (data, fit, _) = best?;
    workbench.data = data;
    Some(workbench.multi_start(fit))
}

/// The declared model, fitted with windows that get their starting state in this way. Which way is best shows only after a fit.
#[inline(never)]
fn fit_base_from(workbench: &mut Workbench<impl Schedule>, start: WindowStart) -> Option<Fit> {
    let declared = workbench.declared;
    let window = workbench.data.settings.window;
    // How replays restart comes before any fit, which would else bias the parameters by
    // wrong restarts. Then short windows: far from the truth, they are the smoother problem.
    workbench.restart_with(declared, &[start])?;
    let mut fitted = declared.clone();
    for window in [workbench.screen_window(), window, window] {
        workbench.weigh(&fitted, window)?;
        fitted = workbench.fit_windows(&fitted, window)?.model;
    }
    workbench.restart_with(&fitted, &[start])?;
    let near = workbench.approach(declared);
    let far = workbench.search_around(declared);
    let starts = [Some(&fitted), Some(declared), near.as_ref(), far.as_ref()];
    let starts: Vec<&Model, 4> = starts.into_iter().flatten().collect();
    workbench.best_fit(&starts)
}

impl Found {
    /// Adds one effect after the other, drops what the later ones replace, and gives the periodic ones the overtones that
    /// the log asks for. `first`: number of the first round.
    fn search(
        &mut self,
        workbench: &mut Workbench<impl Schedule>,
        first: usize,
        observe: &mut dyn FnMut(&Consideration),
    ) -> Option<()> {
        for round in first..first + ROUNDS {
            if self.accepted.is_full() || !add_effect(workbench, round, self, observe)? {
                break;
            }
            if workbench.has_found_input_late() {
                return Some(());
            }
        }
        self.exchange(workbench, first + ROUNDS - 1, observe)?;
        drop_replaced(workbench, self, observe)?;
        add_overtones(workbench, self)
    }

    /// The look at what a round has found, if it has found an effect.
    pub(super) fn found_in(
        &mut self,
        workbench: &mut Workbench<impl Schedule>,
        round: usize,
    ) -> Option<Option<Consideration>> {
        let others = self.accepted.len();
        let mut taken = None;
        add_effect(workbench, round, self, &mut |look| {
            if matches!(
                look.decision,
                Decision::Accepted | Decision::InPlaceOf { .. }
            ) {
                taken = Some(*look);
            }
        })?;
        Some(taken.filter(|_| self.accepted.len() > others))
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
    #[inline(never)]
    fn choose_anew(
        &mut self,
        workbench: &mut Workbench<impl Schedule>,
        place: usize,
        round: usize,
    ) -> Option<Option<Consideration>> {
        let kept = self.keep(workbench);
        let out = self.accepted.remove(place);
        let others = self.accepted.len();
        let slot = workbench.declared.effects.len() + place;
        self.do_without(workbench, slot)?;
        let taken = self.found_in(workbench, round)?;
        if taken.is_some()
            && self.replaces(
                workbench,
                (&kept.after.model, &kept.data, out.candidate.effect.id),
            )?
        {
            return Some(taken);
        }
        self.accepted.truncate(others);
        let _ = self.accepted.insert(place, out);
        self.take_again(kept, workbench);
        Some(None)
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
    if let Some(freed) = free_sensor(workbench, &mut round, found)? {
        round.tell(freed, observe);
        return Some(true);
    }
    if let Some(freed) = free_numbers(workbench, &mut round, found)? {
        round.tell(freed, observe);
        return Some(true);
    }
    take_winner(workbench, &mut round, found, observe)
}

/// Looks for effects beside the base that was fitted with a learned map: one that was fitted alone may be biased by
/// what is missing, so that little was left to be seen of that. Whether effects are found that follow the
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
