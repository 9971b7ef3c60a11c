//! One round: every effect is screened, the best are refitted and judged, and one is taken.

use super::alternatives::{ask_twins, doubt, exchange_for_twin, other_law};
use super::criterion::{
    CONTESTED, EQUALLY_GOOD, EQUIVALENT, FAR_BEHIND, IDENTICAL, LEAST_IDENTIFIABILITY, LEAST_SCORE,
    LOCAL_MINIMUM, NOTHING_LEFT, PRESUMED, SHORTLIST, TOLD_APART,
};
use super::found::Found;
use super::held_out::{Comparison, Refusal};
use super::judging::{
    Leader, THROUGHOUT, compare_in_short_windows, is_rounding, judge, judge_effect,
    wins_on_its_restarts,
};
use super::model::Model;
use super::replay::Schedule;
use super::screen::{Candidate, MOST_CANDIDATES, Screening};
use super::standing::structure;
use super::verdict::{Accepted, Consideration, Decision, Subject};
use super::workbench::Workbench;
use crate::effect::Id;
use heapless::Vec;

/// Room for those that are refitted whatever their score, besides.
const MOST_REFITTED: usize = SHORTLIST + Id::BIASING;

/// Looks of a round: at the candidates, at the declared numbers, and at the log's input.
const MOST_LOOKS: usize = MOST_CANDIDATES + 2;

/// Adds the effect that a round has found to what has been found. Whether there is one.
#[inline(never)]
pub(super) fn take_winner(
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
    let chosen = workbench.data;
    workbench.restart_as_with(&found.after.model, effect.id)?;
    let leads = |(_, model): &&(f64, Model)| {
        let last = model.effects.last();
        last.is_some_and(|last| last.id == effect.id)
    };
    let fitted = match round.leader.as_ref().filter(leads) {
        Some((_, started)) => workbench.fit(started)?.model,
        None => match workbench.start(&found.after.model, effect)? {
            Some(started) => workbench.fit(&started)?.model,
            None => {
                workbench.data = chosen;
                return Some(false);
            }
        },
    };
    let fell = workbench.error_ratio(&found.after.model, &fitted)?;
    let fitted = if fell > LOCAL_MINIMUM * round.least {
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
    workbench.restart(&fitted)?;
    let after = workbench.fit(&fitted)?;
    let after = workbench.multi_start(after);
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
    if let Some(other) = other_law(workbench, &after.model, &[], found)? {
        workbench.data = chosen;
        observe(
            &winner
                .candidate
                .look(round.number, Decision::LawOf { other }),
        );
        return Some(false);
    }
    found.left *= winner.ratio;
    let _ = found.accepted.push(winner);
    found.held_out = None;
    found.after = after;
    Some(true)
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
    pub fn look(&self, round: usize, decision: Decision) -> Consideration {
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
    pub(super) fn first_look(&self, round: usize, resolution: f32) -> Consideration {
        let decision = if self.effect.id.biases_base() {
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

/// What a round has looked at and decided. In one place: on the chip there is no room for copies.
pub(super) struct Round {
    /// From 1.
    pub number: usize,
    pub looks: Vec<Consideration, MOST_LOOKS>,
    leader: Leader,
    winner: Option<Accepted>,
    /// An effect with a memory that comes near to it, and may win where replays restart as suits it.
    rival: Option<Accepted>,
    /// Least held-out error of those that passed, over that without; infinite if none has.
    pub least: f64,
}

impl Round {
    pub fn new(number: usize) -> Self {
        Self {
            number,
            looks: Vec::new(),
            leader: None,
            winner: None,
            rival: None,
            least: f64::INFINITY,
        }
    }

    /// Adds a look at numbers of the machine file or of the log.
    pub fn look_at(&mut self, subject: Subject, comparison: Comparison, decision: Decision) {
        let _ = self.looks.push(Consideration {
            round: self.number,
            subject,
            score: (1.0 - comparison.ratio).max(0.0) as f32,
            identifiability: 1.0,
            held_out: Some(comparison),
            decision,
        });
    }

    /// The look at this.
    pub fn look_of(&mut self, subject: Subject) -> Option<&mut Consideration> {
        self.looks.iter_mut().find(|look| look.subject == subject)
    }

    /// Tells of every look, now that it is known what was taken.
    pub fn tell(&mut self, taken: Subject, observe: &mut dyn FnMut(&Consideration)) {
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
pub(super) fn consider(
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
    let mut refused: Vec<(f64, usize), MOST_REFITTED> = shortlist
        .iter()
        .filter_map(|index| Some((ratio(index)?.ratio, *index)))
        .collect();
    refused.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let first = refused.iter().take(PRESUMED);
    first.map(|(_, index)| candidates[*index]).collect()
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
        collinearity,
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
        let biases_base = candidates[index].effect.id.biases_base();
        if looks[index].decision == Decision::NotShortlisted && (biases_base || scored < SHORTLIST)
        {
            let _ = shortlist.push(index);
            scored += usize::from(!biases_base);
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
                && !own.id.biases_base()
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
                && collinearity[index][other] > IDENTICAL
                && collinearity[other][index] > IDENTICAL
        });
        if let Some(&other) = same {
            looks[index].decision = Decision::SameAs {
                other: candidates[other].effect.id,
            };
            continue;
        }
        // Passed is Accepted for now; who wins is known when all have been refitted.
        let tries = found.models * screened.tries(index);
        looks[index].decision = match judge_effect(workbench, model, smaller, own, tries, leader)? {
            Ok((comparison, refusal)) => {
                looks[index].held_out = Some(comparison);
                refusal.map_or(Decision::Accepted, Decision::Refused)
            }
            Err(decision) => decision,
        };
    }
    let refitted = (&shortlist[..], found.models);
    prove_rivals(workbench, model, screened, refitted, looks, leader)?;
    found.nearest = nearest(candidates, &shortlist, looks);

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
