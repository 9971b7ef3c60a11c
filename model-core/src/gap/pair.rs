//! Two effects that are found together: while one of them is missing, the other one may lower the error by too little to be proven.

use super::criterion::{BESIDE, LARGEST_RATIO, PRESUMED};
use super::found::Found;
use super::model::Model;
use super::replay::Schedule;
use super::screen::{Candidate, MOST_CANDIDATES, with_effect};
use super::verdict::{Accepted, Consideration, Decision};
use super::workbench::Workbench;
use crate::effect::Active;
use heapless::Vec;

impl Found {
    /// Adds two effects that are found beside each other, where none is found alone and the model does not follow the log.
    /// Of those that came nearest the one with which two follow the log best is presumed, and another one looked for beside it, as
    /// one of so many looks; then what was presumed has to be found beside that one. Whether there are two.
    #[inline(never)]
    pub(super) fn add_pair(
        &mut self,
        workbench: &mut Workbench<impl Schedule>,
        round: usize,
        observe: &mut dyn FnMut(&Consideration),
    ) -> Option<bool> {
        if !self.accepted.is_empty() || !workbench.residual(&self.after.model)?.is_unexplained() {
            return Some(false);
        }
        let Some(presumed) = self.most_promising(workbench)? else {
            return Some(false);
        };
        self.models = PRESUMED;
        let is_pair = self.pair_with(workbench, &presumed, round, observe)?;
        self.models = 1;
        Some(is_pair)
    }

    /// Of the effects that came nearest the one with which, and with another one beside it, the model follows the log best.
    #[inline(never)]
    fn most_promising(
        &mut self,
        workbench: &mut Workbench<impl Schedule>,
    ) -> Option<Option<Candidate>> {
        let model = &self.after.model;
        let alone = workbench.position_rms(model)?;
        let mut least = LARGEST_RATIO * alone * alone;
        let mut best = None;
        for candidate in &self.nearest {
            let Some(start) = workbench.start(model, candidate.effect)? else {
                continue;
            };
            let error = error_with_one_more(workbench, &start)?;
            if error * error < least {
                (least, best) = (error * error, Some(*candidate));
            }
        }
        Some(best)
    }

    /// Two effects of which this one led to the other. Whether there are; if not, nothing changes.
    #[inline(never)]
    fn pair_with(
        &mut self,
        workbench: &mut Workbench<impl Schedule>,
        presumed: &Candidate,
        round: usize,
        observe: &mut dyn FnMut(&Consideration),
    ) -> Option<bool> {
        let kept = self.keep(workbench);
        let slot = workbench.declared.effects.len();
        let mut looks = [None; 2];
        if self.presume(workbench, presumed)? {
            looks[0] = self.found_in(workbench, round)?;
            if looks[0].is_some() {
                self.accepted.remove(0);
                self.do_without(workbench, slot)?;
                looks[1] = self.found_in(workbench, round)?;
            }
        }
        if let [Some(one), Some(other)] = looks {
            observe(&one);
            observe(&other);
            return Some(true);
        }
        self.accepted.clear();
        self.take_again(kept, workbench);
        Some(false)
    }

    /// Fits the model with an effect that has not been found. Whether there is a start for it.
    #[inline(never)]
    fn presume(
        &mut self,
        workbench: &mut Workbench<impl Schedule>,
        presumed: &Candidate,
    ) -> Option<bool> {
        workbench.restart_as_with(&self.after.model, presumed.effect.id)?;
        let Some(start) = workbench.start(&self.after.model, presumed.effect)? else {
            return Some(false);
        };
        self.after = workbench.fit(&start)?;
        self.held_out = None;
        let _ = self.accepted.push(Accepted {
            candidate: *presumed,
            p_value: 1.0,
            ratio: 1.0,
            equivalent: Vec::new(),
        });
        Some(true)
    }
}

/// Least error that a model comes to with one of the effects that score best beside those which it has: by rough fits in short windows,
/// which show what may be gained.
#[inline(never)]
fn error_with_one_more(workbench: &mut Workbench<impl Schedule>, start: &Model) -> Option<f64> {
    let mut least = f64::INFINITY;
    let Some(model) = workbench.approach(start) else {
        return Some(least);
    };
    for effect in best_scored(workbench, &model)? {
        let larger = with_effect(&model, effect);
        if let Some(fitted) = larger.and_then(|larger| workbench.approach(&larger)) {
            least = least.min(workbench.position_rms(&fitted)?);
        }
    }
    Some(least)
}

/// The effects that score best beside those which a model has.
// What is screened is not to lie below a fit.
#[inline(never)]
fn best_scored(
    workbench: &mut Workbench<impl Schedule>,
    model: &Model,
) -> Option<Vec<Active, BESIDE>> {
    let screened = workbench.screen(model, |_| ())?;
    let resolution = workbench.data.settings.resolution;
    let candidates = screened.candidates.iter();
    let mut worth: Vec<&Candidate, MOST_CANDIDATES> = candidates
        .filter(|candidate| {
            let look = candidate.first_look(1, resolution);
            look.decision == Decision::NotShortlisted && !candidate.effect.id.biases_base()
        })
        .collect();
    worth.sort_unstable_by(|a, b| b.score.total_cmp(&a.score));
    let best = worth.iter().take(BESIDE);
    Some(best.map(|candidate| candidate.effect).collect())
}
