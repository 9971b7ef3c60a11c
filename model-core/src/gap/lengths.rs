//! What a log shows over predictions of one length it has to show over another length too.
//!
//! A model is judged by how well it predicts a log over windows of one length, and nothing says which: over 0.2 s
//! friction shows well, over 0.05 s what acts on a light rotor does, before it has left the measured way. An effect
//! that the machine has lowers the error over either. What only makes up for something else (a wrong number, a
//! late channel, a law of another form) does so over the length that it was fitted to. So a log is traced over
//! two neighbouring lengths, and what is found over both is said: stability selection (N. Meinshausen, P. Bühlmann,
//! *Stability selection*, 2010), with lengths of prediction in the place of random halves of the data. A search over one of
//! them may miss what the other finds, so what one has found is fitted over the windows of the other before it is refused.

use super::criterion::EQUALLY_GOOD;
use super::current_sensor::Reading;
use super::found::Found;
use super::held_out::{HeldOut, Refusal, compare};
use super::mechanism;
use super::model::{Base, Model, Numbers};
use super::replay::{Data, Schedule};
use super::select::{LEAST_WINDOWS, conclude, trace_over};
use super::standing::{look_beneath, stands, take_map};
use super::verdict::{Accepted, Consideration, Decision, Trace, Verdict};
use super::workbench::{Options, Workbench};
use heapless::Vec;

/// Fewest samples in a window: as many as a restart with the narrowest smoothing takes in.
const LEAST_SAMPLES: usize = 5;

/// Traces the gap between `model` and the logs of `data`. `observe` is told of every look at every
/// candidate, round by round.
///
/// What is found over the windows of `data` is said if it is found over windows half as long too, or predicts as well
/// over these as what is found there, and clearly better than what both have in common. A learned law goes by the name of
/// the effect that it is another law of, where there is one. Where nothing is proven over the windows of `data`, though
/// the model does not follow the log, the same is asked of half and a quarter of them. An effect over a variable on
/// the one hand, and on the other a law over it that no effect of the catalogue is, are an unknown effect
/// that depends on that variable. A log of which the shorter window has fewer than five samples is traced over one length.
///
/// `None` if the model cannot be built or there is no whole window.
pub fn trace<S: Schedule>(
    data: &Data,
    schedule: &S,
    model: &Model,
    options: &Options,
    mut observe: impl FnMut(&Consideration),
) -> Option<Trace> {
    let mut last = 0;
    let mut data = *data;
    let mut samples = 0;
    let mut over = |data: &Data,
                    base: &[Base],
                    observe: &mut dyn FnMut(&Consideration),
                    traced: &mut Option<Trace>| {
        let options = Options { base, ..*options };
        trace_over(data, schedule, model, &options, observe, traced)?;
        samples += traced.as_ref()?.simulated * data.settings.window as u64;
        Some(())
    };
    let mut traced = None;
    over(
        &data,
        options.base,
        &mut |look| {
            last = last.max(look.round);
            observe(look);
        },
        &mut traced,
    )?;
    let said = traced.as_mut()?;
    let mut other = None;
    // What is found over half of the windows is asked over a quarter of them, or is not said.
    let quarter = data.settings.window / 4 >= LEAST_SAMPLES;
    if said.verdict() == Verdict::NothingProven && quarter && shorten(&mut data) {
        let base: Numbers = said.fitted().iter().copied().collect();
        let mut tell = |look: &Consideration| {
            let round = last + look.round;
            observe(&Consideration { round, ..*look });
        };
        let _ = over(&data, &base, &mut tell, &mut other);
        if let Some(shorter) = other.as_mut().filter(|shorter| shorter.has_found()) {
            core::mem::swap(said, shorter);
        }
        other = None;
    }
    if said.has_found() && shorten(&mut data) {
        let _ = over(&data, said.fitted(), &mut |_| (), &mut other);
    }
    // Where the shorter windows cannot be replayed at all, they speak for nothing and against nothing.
    if let Some(other) = &mut other {
        data.settings = said.settings;
        let base: Numbers = said.fitted().iter().copied().collect();
        let options = Options {
            base: &base,
            ..*options
        };
        let window = data.settings.window as u64;
        let mut workbench = Workbench::new(data, schedule, model, &options)?;
        keep(&mut workbench, said, other, &mut observe)?;
        samples += workbench.simulated * window;
    }
    said.simulated = samples / said.settings.window as u64;
    mechanism::name(&data, schedule, model, options, said)?;
    traced
}

/// Held-out errors of what a tracing has come to, over its own windows: those of the workbench.
///
/// `None` if the model cannot be built.
#[inline(never)]
fn own_errors(workbench: &mut Workbench<impl Schedule>, trace: &Trace) -> Option<HeldOut> {
    move_as(workbench, trace);
    workbench.held_out(&trace.after.model)
}

/// Has fits move what those of a tracing do.
fn move_as(workbench: &mut Workbench<impl Schedule>, trace: &Trace) {
    workbench.base = trace.base.clone();
    workbench.readings = trace.readings.clone();
}

/// Held-out errors of a model that a tracing has come to, fitted anew over other windows than its own: those of the
/// workbench.
///
/// `None` if the model cannot be built.
#[inline(never)]
fn refitted_errors(
    workbench: &mut Workbench<impl Schedule>,
    trace: &Trace,
    model: &Model,
) -> Option<HeldOut> {
    move_as(workbench, trace);
    let fit = workbench.fit(model)?;
    workbench.held_out(&fit.model)
}

/// What a tracing has found but for what another one does not confirm.
fn confirmed_part(trace: &Trace, other: &Trace, declared: &Model) -> Model {
    let mut model = trace.after.model.clone();
    model.map = None;
    for (place, accepted) in trace.accepted.iter().enumerate().rev() {
        if !other.confirms(accepted) {
            model.effects.remove(declared.effects.len() + place);
        }
    }
    for number in trace.freed() {
        if !other.freed().contains(number) {
            model.set(*number, declared.get(*number));
        }
    }
    model
}

/// What a tracing has found, over the windows of another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Elsewhere {
    /// It predicts clearly better than what the other one has found; or clearly better than what both have found and as well
    /// as what the other one has found instead, which is clearly worse over the windows of the former.
    Holds,
    /// It predicts clearly better than what both have found, and over the windows of neither better or worse than what the
    /// other one has found instead.
    Alike,
    /// Neither.
    Fails,
}

/// How what a tracing has found does over the windows of another one.
///
/// `None` if a model cannot be built.
#[inline(never)]
fn elsewhere(
    workbench: &mut Workbench<impl Schedule>,
    trace: &Trace,
    other: &Trace,
) -> Option<Elsewhere> {
    let mut others = workbench.over(other.settings)?;
    let of_other = own_errors(&mut others, other)?;
    let own = refitted_errors(&mut others, trace, &trace.after.model)?;
    let instead = compare(&of_other, &own);
    let is_better = instead.refusal(1).is_none();
    let is_as_good = !is_better && instead.ratio <= EQUALLY_GOOD && {
        let part = confirmed_part(trace, other, workbench.declared);
        let of_part = refitted_errors(&mut others, trace, &part)?;
        compare(&of_part, &own).refusal(1).is_none()
    };
    workbench.count(others.simulated, other.settings.window);
    if is_better {
        return Some(Elsewhere::Holds);
    }
    if !is_as_good {
        return Some(Elsewhere::Fails);
    }
    let mut windows = workbench.over(trace.settings)?;
    let of_other = refitted_errors(&mut windows, other, &other.after.model)?;
    let own = own_errors(&mut windows, trace)?;
    workbench.count(windows.simulated, trace.settings.window);
    let instead = compare(&of_other, &own);
    Some(if instead.refusal(1).is_none() {
        Elsewhere::Holds
    } else if instead.ratio <= EQUALLY_GOOD {
        Elsewhere::Alike
    } else {
        Elsewhere::Fails
    })
}

/// Makes the one effect of a tracing that another one does not confirm equivalent to the one that this has instead. Whether
/// there is one of each.
fn make_equivalent(trace: &mut Trace, other: &Trace) -> bool {
    let mut instead = other.accepted.iter().filter(|it| !trace.confirms(it));
    let (Some(instead), None) = (instead.next(), instead.next()) else {
        return false;
    };
    let instead = instead.candidate.effect.id;
    let mut own = trace.accepted.iter_mut().filter(|it| !other.confirms(it));
    let (Some(own), None) = (own.next(), own.next()) else {
        return false;
    };
    own.equivalent.push(instead).is_ok()
}

/// What either of two tracings has found in one model, if what each adds to the other one predicts clearly better over the
/// windows of that other one, too. `workbench`: as in [`keep`].
///
/// `None` if a model cannot be built; `None` inside if neither adds an effect, or what it adds does not show.
#[inline(never)]
fn joined(
    workbench: &mut Workbench<impl Schedule>,
    trace: &Trace,
    other: &Trace,
) -> Option<Option<Found>> {
    let mut accepted = trace.accepted.clone();
    let mut model = trace.after.model.clone();
    let first = workbench.declared.effects.len();
    for (place, added) in other.accepted.iter().enumerate() {
        let effect = other.after.model.effects[first + place];
        if !trace.confirms(added)
            && (accepted.push(added.clone()).is_err() || model.effects.push(effect).is_err())
        {
            return Some(None);
        }
    }
    let own = trace.accepted.len();
    if own == 0 || accepted.len() == own || trace.unknown.is_some() || other.unknown.is_some() {
        return Some(None);
    }
    let mut others = workbench.over(other.settings)?;
    let larger = refitted_errors(&mut others, trace, &model)?;
    let smaller = own_errors(&mut others, other)?;
    workbench.count(others.simulated, other.settings.window);
    if compare(&smaller, &larger).refusal(1).is_some() {
        return Some(None);
    }
    let smaller = own_errors(workbench, trace)?;
    let after = workbench.fit(&model)?;
    let held_out = workbench.held_out(&after.model)?;
    let comparison = compare(&smaller, &held_out);
    for added in &mut accepted[own..] {
        (added.p_value, added.ratio) = (comparison.p_value, comparison.ratio);
    }
    Some(comparison.refusal(1).is_none().then_some(Found {
        after,
        accepted,
        held_out: Some(held_out),
        left: 1.0,
        nearest: Vec::new(),
        models: 1,
    }))
}

/// Says what either of two tracings has found in place of the first one, if both [show](joined) and may be said. Whether they
/// may.
#[inline(never)]
fn join(
    workbench: &mut Workbench<impl Schedule>,
    trace: &mut Trace,
    other: &Trace,
    observe: &mut dyn FnMut(&Consideration),
) -> Option<bool> {
    let fitted = workbench.base.clone();
    let own = trace.accepted.len();
    if let Some(mut found) = joined(workbench, trace, other)?
        && stands(workbench, &trace.before.model, &mut found, observe)?
        && found.accepted.len() > own
    {
        for added in found.accepted.iter().filter(|it| !trace.confirms(it)) {
            observe(&added.candidate.look(own + 1, Decision::Accepted));
        }
        let mut joined = None;
        let mut before = trace.before.clone();
        conclude(workbench, &mut before, &mut found, None, &mut joined)?;
        *trace = joined?;
        return Some(true);
    }
    workbench.base = fitted;
    Some(false)
}

/// Makes what two tracings have found one answer, in place of the first one. It is what either has found, where
/// [both](join) show over the windows of the other; what the first one has found, where the other has found
/// something else and that of the first one [holds](Elsewhere::Holds) over its windows, or is as good as that. Else what the
/// other does not confirm is taken out and the rest fitted anew. Where the other has learned a law over the variable of an
/// effect, that law is what both have in common. `workbench`: with the log as it was cut and weighed for the first one.
///
/// `None` if the model cannot be built.
#[inline(never)]
fn keep(
    workbench: &mut Workbench<impl Schedule>,
    trace: &mut Trace,
    other: &mut Trace,
    observe: &mut dyn FnMut(&Consideration),
) -> Option<()> {
    let freed = |number: &Base| other.freed().contains(number);
    let confirmed = |accepted: &Accepted| other.confirms(accepted);
    let mut map = trace.unknown.iter();
    if map.all(|it| other.confirms_map(it.kind))
        && trace.freed().iter().all(freed)
        && trace.accepted.iter().all(confirmed)
    {
        return Some(());
    }
    if join(workbench, trace, other, observe)? {
        return Some(());
    }
    // Where the other has proven nothing, the effect was refused there, by tests that this comparison does not repeat.
    if other.has_found() {
        match elsewhere(workbench, trace, other) {
            Some(Elsewhere::Holds) => return Some(()),
            Some(Elsewhere::Alike) if make_equivalent(trace, other) => return Some(()),
            _ => {}
        }
    }
    if says_more_than(trace, other) {
        for accepted in &trace.accepted {
            observe(&accepted.refused());
        }
        core::mem::swap(trace, other);
        return Some(());
    }
    take_out(workbench, trace, other, observe)
}

/// Takes what another tracing does not confirm out of a tracing and fits the rest anew. `workbench`: as in [`keep`].
///
/// `None` if the model cannot be built.
#[inline(never)]
fn take_out(
    workbench: &mut Workbench<impl Schedule>,
    trace: &mut Trace,
    other: &Trace,
    observe: &mut dyn FnMut(&Consideration),
) -> Option<()> {
    let freed = |number: &Base| other.freed().contains(number);
    let confirmed = |accepted: &Accepted| other.confirms(accepted);
    let declared = workbench.declared;
    // A number that is taken back may have made up for an error of the current's sensor, so the sensor's numbers that
    // either tracing freed are fitted again.
    workbench.readings = Reading::ALL
        .into_iter()
        .filter(|reading| trace.readings.contains(reading) || other.readings.contains(reading))
        .collect();
    let mut before = if workbench.readings.len() > trace.readings.len() {
        workbench.best_fit(&[&trace.before.model, declared])?
    } else {
        trace.before.clone()
    };
    let mut found = Found::nothing(&trace.after);
    found.after.model = confirmed_part(trace, other, declared);
    for accepted in &trace.accepted {
        if confirmed(accepted) {
            let _ = found.accepted.push(accepted.clone());
        } else {
            observe(&accepted.refused());
        }
    }
    workbench
        .base
        .extend(trace.freed().iter().copied().filter(freed));
    if let Some(unknown) = trace.unknown.take() {
        observe(&Consideration {
            decision: Decision::Refused(Refusal::OverOneLength),
            ..unknown.dropped()
        });
    }
    let mut unknown = None;
    let stands = found.is_more(workbench) && {
        found.after = workbench.fit(&found.after.model)?;
        // What is left without the others may be the law of something else.
        let beneath = look_beneath(workbench, &before.model, &mut found, observe)?;
        unknown = beneath.filter(|it| other.confirms_map(it.kind));
        if let Some(learned) = &mut unknown {
            found.outdone_by(learned, observe);
            take_map(workbench, learned, &mut found)?;
        }
        stands(workbench, &before.model, &mut found, observe)?
    };
    if !stands {
        unknown = None;
        workbench.hold_freed();
        found.forget(&before);
    }
    let mut concluded = None;
    conclude(workbench, &mut before, &mut found, unknown, &mut concluded)?;
    *trace = concluded?;
    trace.unconfirmed = !stands;
    Some(())
}

/// The same logs in windows half and twice as long, where there are enough of these to fit a model to.
pub fn half_and_twice<'a>(data: &Data<'a>) -> [Option<Data<'a>>; 2] {
    let own = data.settings.window;
    [own / 2, 2 * own].map(|window| {
        let cut = data.with_window(window.max(LEAST_SAMPLES));
        (cut.windows() >= LEAST_WINDOWS).then_some(cut)
    })
}

/// Cuts a log into windows half as long, if these are long enough. Whether they are.
fn shorten(data: &mut Data) -> bool {
    let half = data.settings.window / 2;
    let long_enough = half >= LEAST_SAMPLES;
    if long_enough {
        *data = data.with_window(half);
    }
    long_enough
}

/// Whether a tracing names an effect where the other one has learned a law over the variable of that effect, which
/// none of the catalogue is.
fn says_more_than(said: &Trace, other: &Trace) -> bool {
    let learned = other.unknown.as_ref();
    said.unknown.is_none() && learned.is_some_and(|unknown| said.confirms_map(unknown.kind))
}
