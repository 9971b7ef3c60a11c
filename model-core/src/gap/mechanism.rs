//! Which effect of the catalogue a learned law is another law of.
//!
//! An effect is a mechanism over a variable, and a machine hardly has the very law that the catalogue has of it. A learned
//! law follows such a machine better than the effect does, and would leave it without a name.

use super::criterion::{SAME_MECHANISM, TOLD_APART};
use super::held_out::{Comparison, HeldOut, compare};
use super::judging::{Leader, judge_effect};
use super::model::Model;
use super::replay::{Data, Schedule};
use super::screen::Candidate;
use super::verdict::{Accepted, Trace};
use super::workbench::{Options, Workbench};
use crate::effect::learned_map::Kind;
use heapless::Vec;

/// Most effects of the catalogue that act in the same way over one variable.
const MOST_OF_ONE_KIND: usize = 4;

/// The effect that a learned law is another law of.
#[derive(Debug, Clone)]
pub struct Mechanism {
    /// What the test on held-out blocks says of the effect as the catalogue has it.
    pub accepted: Accepted,
    /// The base fit with that effect in place of the learned law: the formula that comes nearest to the law.
    pub nearest: Model,
}

/// Looks for the effect that a learned law is another law of: it acts as the law does over the same variable, is not itself
/// the first terms of any such law, and takes more than [`SAME_MECHANISM`] of that off the held-out error which the law
/// takes off.
///
/// The final model keeps the learned law. `None` if a model cannot be built.
#[inline(never)]
pub(super) fn name<S: Schedule>(
    data: &Data,
    schedule: &S,
    model: &Model,
    options: &Options,
    trace: &mut Trace,
) -> Option<()> {
    let Some(kind) = trace.unknown.as_ref().map(|unknown| unknown.kind) else {
        return Some(());
    };
    let data = Data {
        settings: trace.settings,
        ..*data
    };
    let mut workbench = Workbench::new(data, schedule, model, options)?;
    workbench.base.clone_from(&trace.base);
    workbench.readings.clone_from(&trace.readings);
    let before = &trace.before.model;
    let without = workbench.held_out(before)?;
    let law = workbench.held_out(&trace.after.model)?;
    // What the law leaves of the base is nearer to the truth than what was fitted without it.
    let bare = Model {
        map: None,
        ..trace.after.model.clone()
    };
    let most = 1.0 - SAME_MECHANISM * (1.0 - compare(&without, &law).ratio);
    if let Some((accepted, with)) = nearest(&mut workbench, [before, &bare], &without, kind)?
        && accepted.ratio < most
        && let Some(unknown) = &mut trace.unknown
    {
        unknown.mechanism = Some(Mechanism {
            accepted,
            nearest: workbench.fit(&with)?.model,
        });
    }
    trace.simulated += workbench.simulated;
    Some(())
}

/// Of the effects that act in one way over one variable the one that follows held-out blocks best, with the others that come
/// near to it, and the model with it where a fit of that starts. Fits start beside each of the bases.
///
/// `None` inside if none of them passes the test.
#[inline(never)]
fn nearest(
    workbench: &mut Workbench<impl Schedule>,
    bases: [&Model; 2],
    without: &HeldOut,
    kind: Kind,
) -> Option<Option<(Accepted, Model)>> {
    let is_law = |candidate: &&Candidate| {
        let id = candidate.effect.id;
        id.map() == Some(kind) && !id.is_expansion()
    };
    let mut passed: Vec<(Candidate, Comparison), MOST_OF_ONE_KIND> = Vec::new();
    let mut leader: Leader = None;
    for base in bases {
        let mut laws: Vec<Candidate, MOST_OF_ONE_KIND> = Vec::new();
        let screened = workbench.screen(base, |passed_over| {
            laws.extend(Some(passed_over).filter(is_law).copied());
        })?;
        laws.extend(screened.candidates.iter().filter(is_law).copied());
        for candidate in laws {
            let tries = screened.screened * candidate.tries as usize;
            let judged = judge_effect(
                workbench,
                base,
                without,
                candidate.effect,
                tries,
                &mut leader,
            )?;
            let Ok((comparison, None)) = judged else {
                continue;
            };
            let id = candidate.effect.id;
            match passed.iter_mut().find(|(it, _)| it.effect.id == id) {
                Some(known) if comparison.ratio < known.1.ratio => *known = (candidate, comparison),
                Some(_) => (),
                None => passed.extend([(candidate, comparison)]),
            }
        }
    }
    let Some((least, model)) = leader else {
        return Some(None);
    };
    let id = model.effects.last()?.id;
    let (candidate, comparison) = *passed.iter().find(|(it, _)| it.effect.id == id)?;
    let near = passed.iter().filter(|(other, comparison)| {
        other.effect.id != id && comparison.ratio <= TOLD_APART * least
    });
    let accepted = Accepted {
        candidate,
        p_value: comparison.p_value,
        ratio: comparison.ratio,
        equivalent: near.map(|(other, _)| other.effect.id).collect(),
    };
    Some(Some((accepted, model)))
}
