//! What settles which of several things it is that the logs do not tell apart: an experiment, the same motion again, or a changed
//! machine.

use model_core::effect::Id;

use super::is_same_law;
use super::next::{Step, said};
use crate::gap::experiment::NextExperiment;
use crate::gap::outcome::{FoundEffect, Outcome};
use crate::quantity::Scale;

/// The experiment that settles a doubt: to be played, to be looked for, or none.
pub(super) fn experiment(next: Option<&NextExperiment>, unit: &str) -> Option<Step> {
    let next = next.filter(|next| !next.needs_another_machine())?;
    let doubt = next.question();
    if !next.looked {
        return Some(said(&format!(
            "run it again with --experiment FILE, which writes an input that settles {doubt}, if one is found"
        )));
    }
    let (Some(_), Some(start), Some(duration)) =
        (&next.excitation, next.start_position, next.duration_s)
    else {
        return Some(said(&format!(
            "no input was found that settles {doubt}, {}",
            next.limits.in_words(unit)
        )));
    };
    let file = next.file.as_deref().unwrap_or("the input of the report");
    let seconds = Scale::of("s", [duration]).quantity(duration);
    let start = Scale::of(unit, [start]).quantity(start);
    let may = if next.confirmed {
        "settles"
    } else {
        "may settle"
    };
    Some(said(&format!(
        "play {file} in open loop from rest at {start} ({seconds}), and give its log with another --train: \
         it {may} {doubt}",
    )))
}

/// What settles whether a load acted while the logs were recorded, which no input does.
pub(super) fn repeated(outcome: &Outcome) -> Option<Step> {
    let load = Id::ExternalLoad.description().id;
    let mut effects = outcome.effects.iter();
    let may_be =
        |effect: &FoundEffect| effect.id == load || effect.equivalent.iter().any(|id| id == load);
    effects.any(may_be).then(|| {
        said(
            "record the same motion again and give it with another --train: a load that acted once is not in that log",
        )
    })
}

/// What settles which of two effects it is that are one law of the motion: no input does, a change of the machine may.
pub(super) fn changed(outcome: &Outcome) -> Option<Step> {
    let next = outcome.next_experiment.as_ref();
    let near = next.map_or(&[][..], |next| &next.same_law);
    let pairs = outcome.effects.iter().flat_map(|effect| {
        let others = effect.equivalent.iter().chain(near);
        let others = others.filter(|other| is_same_law(outcome, effect, other));
        others.map(|other| [Id::from_id(&effect.id), Id::from_id(other)])
    });
    let change = |pair: [Option<Id>; 2]| {
        let has = |id: Id| pair.contains(&Some(id));
        if has(Id::Gravity) && has(Id::Cogging) {
            Some(
                "to tell gravity from cogging, turn the machine so that its axis stands upright, and trace a log of that alone: gravity is \
                 gone there, cogging is not",
            )
        } else if has(Id::OffsetTorque) && has(Id::AsymmetricCoulomb) {
            Some(
                "to tell a load's pull from friction, take the load off or turn the machine over, and trace a log of that alone",
            )
        } else {
            None
        }
    };
    pairs.filter_map(change).next().map(said)
}
