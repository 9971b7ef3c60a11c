//! One round: every effect is screened, the best are refitted and judged, and one is taken.

use super::alternatives::{ask_twins, doubt, exchange_for_twin, other_law};
use super::criterion::{LEAST_IDENTIFIABILITY, LEAST_SCORE, LOCAL_MINIMUM};
use super::found::Found;
use super::held_out::{Comparison, Refusal};
use super::judging::{Leader, is_rounding, wins_on_its_restarts};
use super::model::Model;
use super::refit::refit;
use super::replay::Schedule;
use super::screen::{Candidate, MOST_CANDIDATES};
use super::verdict::{Accepted, Consideration, Decision, Subject};
use super::workbench::Workbench;
use heapless::Vec;

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
    pub leader: Leader,
    pub winner: Option<Accepted>,
    /// An effect with a memory that comes near to it, and may win where replays restart as suits it.
    pub rival: Option<Accepted>,
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
