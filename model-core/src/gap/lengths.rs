//! What a log shows over predictions of one length it has to show over another length too.
//!
//! A model is judged by how well it predicts a log over windows of one length, and nothing says which: over 0.2 s
//! friction shows well, over 0.05 s what acts on a light rotor does, before it has left the measured way. An effect
//! that the machine has lowers the error over either. What only makes up for something else (a wrong number, a
//! late channel, a law of another form) does so over the length that it was fitted to. So a log is traced over
//! two neighbouring lengths, and what is found over both is said: stability selection (N. Meinshausen, P. Bühlmann,
//! *Stability selection*, 2010), with lengths of prediction in the place of random halves of the data.

use super::current_sensor::Reading;
use super::found::Found;
use super::held_out::{Refusal, compare};
use super::mechanism;
use super::model::{Base, Model, Numbers};
use super::replay::{Data, Schedule};
use super::select::{conclude, trace_over};
use super::standing::{look_beneath, stands, take_map};
use super::verdict::{Accepted, Consideration, Decision, Trace, Verdict};
use super::workbench::{Options, Workbench};

/// Fewest samples in a window: as many as a restart with the narrowest smoothing takes in.
const LEAST_SAMPLES: usize = 5;

/// Traces the gap between `model` and the logs of `data`. `observe` is told of every look at every
/// candidate, round by round.
///
/// What is found over the windows of `data` is said if it is found over windows half as long too, or if it predicts
/// clearly better over these than what is found there instead. A learned law goes by the name of the effect that it is
/// another law of, where there is one. Where nothing is proven over the windows of `data`, though
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
    let mut over = |data: &Data, base: &[Base], observe: &mut dyn FnMut(&Consideration)| {
        let options = Options { base, ..*options };
        let trace = trace_over(data, schedule, model, &options, observe)?;
        samples += trace.simulated * data.settings.window as u64;
        Some(trace)
    };
    let mut said = over(&data, options.base, &mut |look| {
        last = last.max(look.round);
        observe(look);
    })?;
    // What is found over half of the windows is asked over a quarter of them, or is not said.
    let quarter = data.settings.window / 4 >= LEAST_SAMPLES;
    if said.verdict() == Verdict::NothingProven && quarter && shorten(&mut data) {
        let shorter = over(&data, said.fitted(), &mut |look| {
            let round = last + look.round;
            observe(&Consideration { round, ..*look });
        });
        if let Some(shorter) = shorter.filter(Trace::has_found) {
            said = shorter;
        }
    }
    let mut other = None;
    if said.has_found() && shorten(&mut data) {
        other = over(&data, said.fitted(), &mut |_| ());
    }
    // Where the shorter windows cannot be replayed at all, they speak for nothing and against nothing.
    if let Some(mut other) = other {
        if says_more_than(&said, &other) {
            // A law over that variable is what both have in common.
            for accepted in &said.accepted {
                observe(&accepted.refused());
            }
            core::mem::swap(&mut said, &mut other);
        } else {
            data.settings = said.settings;
            let base: Numbers = said.fitted().iter().copied().collect();
            let options = Options {
                base: &base,
                ..*options
            };
            let mut workbench = Workbench::new(data, schedule, model, &options)?;
            keep(&mut workbench, &mut said, &other, &mut observe)?;
            samples += workbench.simulated * data.settings.window as u64;
        }
    }
    said.simulated = samples / said.settings.window as u64;
    mechanism::name(&data, schedule, model, options, &mut said)?;
    Some(said)
}

/// Whether what one tracing has found is clearly better than what another one has found over the windows of that other
/// one, too.
///
/// `None` if a model cannot be built.
#[inline(never)]
fn beats(workbench: &mut Workbench<impl Schedule>, trace: &Trace, other: &Trace) -> Option<bool> {
    let mut others = workbench.over(other.settings)?;
    others.base = other.base.clone();
    others.readings = other.readings.clone();
    let of_other = others.held_out(&other.after.model)?;
    others.base = trace.base.clone();
    others.readings = trace.readings.clone();
    let fit = others.fit(&trace.after.model)?;
    let own = others.held_out(&fit.model)?;
    workbench.count(others.simulated, other.settings.window);
    Some(compare(&of_other, &own).refusal(1).is_none())
}

/// Takes out of a tracing what another one does not confirm, and fits the rest anew; nothing, where both have found
/// something and that of the former is clearly better over the windows of either: the other has missed it. `workbench`:
/// with the log as it was cut and weighed for the former.
///
/// `None` if the model cannot be built.
#[inline(never)]
fn keep(
    workbench: &mut Workbench<impl Schedule>,
    trace: &mut Trace,
    other: &Trace,
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
    if other.has_found() && beats(workbench, trace, other).unwrap_or(false) {
        return Some(());
    }
    let declared = workbench.declared;
    // A number that is taken back may have made up for an error of the current's sensor, so the sensor's numbers that
    // either tracing freed are fitted again.
    workbench.readings = Reading::ALL
        .into_iter()
        .filter(|reading| trace.readings.contains(reading) || other.readings.contains(reading))
        .collect();
    let before = if workbench.readings.len() > trace.readings.len() {
        workbench.best_fit(&[&trace.before.model, declared])?
    } else {
        trace.before.clone()
    };
    let mut found = Found {
        after: trace.after.clone(),
        accepted: trace.accepted.clone(),
        held_out: None,
        left: 1.0,
    };
    let first = declared.effects.len();
    for place in (0..found.accepted.len()).rev() {
        if !confirmed(&found.accepted[place]) {
            observe(&found.accepted.remove(place).refused());
            found.after.model.effects.remove(first + place);
        }
    }
    for number in trace.freed() {
        if freed(number) {
            let _ = workbench.base.push(*number);
        } else {
            found.after.model.set(*number, declared.get(*number));
        }
    }
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
        found = Found::nothing(&before);
    }
    let concluded = conclude(workbench, before, found, unknown)?;
    *trace = Trace {
        unconfirmed: !stands,
        ..concluded
    };
    Some(())
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
