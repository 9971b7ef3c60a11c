//! Which candidates of a round are refitted, and which of them is chosen.

use super::criterion::{
    CONTESTED, EQUALLY_GOOD, EQUIVALENT, FAR_BEHIND, IDENTICAL, NOTHING_LEFT, PRESUMED, SHORTLIST,
    TOLD_APART,
};
use super::found::Found;
use super::held_out::{Comparison, HeldOut, Refusal};
use super::judging::{Leader, THROUGHOUT, compare_in_short_windows, judge, judge_effect};
use super::model::Model;
use super::replay::Schedule;
use super::round::Round;
use super::screen::{Candidate, MOST_CANDIDATES, Screening};
use super::verdict::{Accepted, Consideration, Decision, Subject};
use super::workbench::Workbench;
use crate::effect::Id;
use heapless::Vec;

/// Places of candidates that are refitted.
type Shortlist = Vec<usize, MOST_CANDIDATES>;

/// Where an effect that comes and goes leads, which has been proven in short windows: proves there too what
/// follows held-out blocks better, but not in enough of them. The best of all that are proven leads then.
#[inline(never)]
fn prove_rivals(
    workbench: &mut Workbench<impl Schedule>,
    model: &Model,
    screened: &Screening,
    (shortlist, models): (&[usize], usize),
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
            .filter(|held_out| unproven && held_out.ratio < limit && !effect.id.is_stateful())
        else {
            continue;
        };
        let with = workbench.start(model, effect)??;
        let proven = Comparison {
            ratio: held_out.ratio,
            ..compare_in_short_windows(workbench, (model, &with), THROUGHOUT)?
        };
        if proven.refusal(models * screened.tries(index)).is_none() {
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

/// Those of the refitted effects that came nearest to being found and were not, the nearest first.
fn nearest(
    candidates: &[Candidate],
    shortlist: &[usize],
    looks: &[Consideration],
) -> Vec<Candidate, PRESUMED> {
    let ratio = |index: &usize| {
        let refused = matches!(looks[*index].decision, Decision::Refused(_));
        looks[*index].held_out.filter(|_| refused)
    };
    let mut refused: Vec<(f64, usize), MOST_CANDIDATES> = shortlist
        .iter()
        .filter_map(|index| Some((ratio(index)?.ratio, *index)))
        .collect();
    refused.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let first = refused.iter().take(PRESUMED);
    first.map(|(_, index)| candidates[*index]).collect()
}

/// Candidates of which a linear look says that a refit is worth its time.
fn spoken_for(candidates: &[Candidate], looks: &[Consideration]) -> Shortlist {
    let mut shortlist = Shortlist::new();
    let mut scored = 0;
    for (index, look) in looks.iter().enumerate() {
        let biases_base = candidates[index].effect.id.biases_base();
        if look.decision == Decision::NotShortlisted && (biases_base || scored < SHORTLIST) {
            let _ = shortlist.push(index);
            scored += usize::from(!biases_base);
        }
    }
    shortlist
}

/// Candidates that a linear look speaks against.
fn spoken_against(looks: &[Consideration]) -> Shortlist {
    let linear = [
        Decision::ScoreTooLow,
        Decision::WrongSign,
        Decision::Absorbed,
    ];
    (0..looks.len())
        .filter(|&index| linear.contains(&looks[index].decision))
        .collect()
}

/// Refits of candidates beside a model.
struct Refits<'a> {
    screened: &'a Screening,
    model: &'a Model,
    smaller: &'a HeldOut,
    /// Looks that share the significance with each of a round.
    models: usize,
    /// Whether scores say which of the candidates explain hardly anything.
    scores_count: bool,
}

impl Refits<'_> {
    /// Judges those of the list.
    fn judge(
        &self,
        workbench: &mut Workbench<impl Schedule>,
        shortlist: &[usize],
        looks: &mut [Consideration],
        leader: &mut Leader,
    ) -> Option<()> {
        for &index in shortlist {
            if let Some(spared) = self.spared(index, shortlist, looks) {
                looks[index].decision = spared;
                continue;
            }
            let effect = self.screened.candidates[index].effect;
            let tries = self.models * self.screened.tries(index);
            let (model, smaller) = (self.model, self.smaller);
            // Passed is Accepted for now; who wins is known when all have been refitted.
            looks[index].decision =
                match judge_effect(workbench, model, smaller, effect, tries, leader)? {
                    Ok((comparison, refusal)) => {
                        looks[index].held_out = Some(comparison);
                        refusal.map_or(Decision::Accepted, Decision::Refused)
                    }
                    Err(decision) => decision,
                };
        }
        Some(())
    }

    /// Why a candidate needs no refit, if so.
    fn spared(
        &self,
        index: usize,
        shortlist: &[usize],
        looks: &[Consideration],
    ) -> Option<Decision> {
        let Screening {
            candidates,
            collinearity,
            ..
        } = self.screened;
        let own = &candidates[index];
        let id = own.effect.id;
        let ahead = shortlist.iter().find(|&&other| {
            looks[other].decision == Decision::Accepted
                && self.scores_count
                && !id.biases_base()
                && own.score < FAR_BEHIND * candidates[other].score
        });
        if let Some(&other) = ahead {
            return Some(Decision::FarBehind {
                of: Subject::Effect(candidates[other].effect.id),
            });
        }
        // Of effects that are one model here, the catalogue's first is refitted for all.
        let same = shortlist.iter().find(|&&other| {
            (candidates[other].effect.id as usize) < id as usize
                && collinearity[index][other] > IDENTICAL
                && collinearity[other][index] > IDENTICAL
        });
        same.map(|&other| Decision::SameAs {
            other: candidates[other].effect.id,
        })
    }
}

/// Judges the candidates of a round.
#[inline(never)]
pub(super) fn refit(
    workbench: &mut Workbench<impl Schedule>,
    round: &mut Round,
    found: &mut Found,
    screened: &Screening,
) -> Option<()> {
    let candidates = &screened.candidates;
    let resolution = workbench.data.settings.resolution;
    let number = round.number;
    let looks = &mut round.looks;
    let leader = &mut round.leader;
    let first = |candidate: &Candidate| candidate.first_look(number, resolution);
    looks.extend(candidates.iter().map(first));
    let model = &found.after.model;
    let leaves_much = found.left > NOTHING_LEFT;
    // Where the machine sticks while the model slides, what is linear in an effect says little of it.
    let structured = leaves_much && workbench.position_rms(model)? > workbench.structured_error();
    let mut refits = Refits {
        screened,
        model,
        smaller: judge(workbench, &mut found.held_out, model)?,
        models: found.models,
        scores_count: !structured,
    };
    let mut shortlist = spoken_for(candidates, looks);
    refits.judge(workbench, &shortlist, looks, leader)?;
    // What is linear is so beside a base that was fitted without the effect, and may have taken its place. Where nothing passes
    // and the model does not follow the log, it decides nothing.
    let none_passes = |look: &Consideration| look.decision != Decision::Accepted;
    if leaves_much && looks.iter().all(none_passes) && workbench.residual(model)?.is_unexplained() {
        let others = spoken_against(looks);
        refits.scores_count = false;
        refits.judge(workbench, &others, looks, leader)?;
        shortlist.extend(others);
    }
    let refitted = (&shortlist[..], found.models);
    prove_rivals(workbench, model, screened, refitted, looks, leader)?;
    found.nearest = nearest(candidates, &shortlist, looks);
    choose(round, screened, &shortlist)
}

/// Of those that passed the one that lowers the error most, with those that the log does not tell from it.
fn choose(round: &mut Round, screened: &Screening, shortlist: &[usize]) -> Option<()> {
    let Screening {
        candidates,
        collinearity,
        ..
    } = screened;
    let looks = &round.looks;
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
            .filter(|&&other| other != best && collinearity[best][other] > EQUIVALENT)
            .map(|&other| candidates[other].effect.id)
            .filter(|&id| !told_apart(id))
            .collect(),
    };
    let rival = shortlist.iter().find_map(|&index| {
        let is_stateful = candidates[index].effect.id.is_stateful();
        let near = |held_out: &Comparison| held_out.ratio <= CONTESTED * least;
        let held_out = passed(index).filter(near)?;
        (index != best && is_stateful).then(|| accept(index, held_out))
    });
    round.winner = Some(accept(best, comparison));
    round.rival = rival;
    round.least = least;
    Some(())
}
