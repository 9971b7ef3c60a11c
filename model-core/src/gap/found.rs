//! What a tracing has found so far.

use super::criterion::{LEAST_CERTAINTY, PRESUMED};
use super::current_sensor::Readings;
use super::fit::Fit;
use super::held_out::HeldOut;
use super::model::Numbers;
use super::replay::{Data, Schedule};
use super::screen::Candidate;
use super::unknown::Unknown;
use super::verdict::{Accepted, Consideration, Decision, ROUNDS, Subject};
use super::workbench::Workbench;
use heapless::Vec;

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
    /// Effects of the last round that came nearest to being found and were not, the nearest first.
    pub nearest: Vec<Candidate, PRESUMED>,
    /// So many models an effect is looked for beside at once: they share the significance.
    pub models: usize,
}

/// What a search changes, to be had again where it was in vain.
// It lies below a whole round: no more than what cannot be had again.
pub(super) struct Kept<'d> {
    /// How the logs were cut and restarted.
    pub data: Data<'d>,
    base: Numbers,
    readings: Readings,
    /// The fit.
    pub after: Fit,
    left: f64,
}

impl Found {
    /// What a search will change.
    pub fn keep<'d>(&self, workbench: &Workbench<'d, impl Schedule>) -> Kept<'d> {
        Kept {
            data: workbench.data,
            base: workbench.base.clone(),
            readings: workbench.readings.clone(),
            after: self.after.clone(),
            left: self.left,
        }
    }

    /// Has all of that as it was again, but for the effects.
    pub fn take_again<'d>(&mut self, kept: Kept<'d>, workbench: &mut Workbench<'d, impl Schedule>) {
        workbench.data = kept.data;
        workbench.base = kept.base;
        workbench.readings = kept.readings;
        (self.after, self.left) = (kept.after, kept.left);
        self.held_out = None;
    }

    /// Nothing: the fit of the base.
    pub fn nothing(base: &Fit) -> Self {
        Self {
            after: base.clone(),
            accepted: Vec::new(),
            held_out: None,
            left: 1.0,
            nearest: Vec::new(),
            models: 1,
        }
    }

    /// Nothing, in the place of what was found.
    // Not a value that is built beside it, on the stack of all fits.
    pub fn forget(&mut self, base: &Fit) {
        self.after.clone_from(base);
        self.accepted.clear();
        self.held_out = None;
        self.left = 1.0;
        self.nearest.clear();
        self.models = 1;
    }

    /// Fits the model without the effect in a slot.
    #[inline(never)]
    pub fn do_without(
        &mut self,
        workbench: &mut Workbench<impl Schedule>,
        slot: usize,
    ) -> Option<()> {
        self.after.model.effects.remove(slot);
        self.after = workbench.fit(&self.after.model)?;
        self.held_out = None;
        self.left = 1.0;
        Some(())
    }

    /// Place of the first effect whose strength may be none.
    #[inline(never)]
    pub fn uncertain(&self, workbench: &mut Workbench<impl Schedule>) -> Option<Option<usize>> {
        let first = workbench.declared.effects.len();
        for place in 0..self.accepted.len() {
            if workbench.certainty(&self.after.model, first + place)? < LEAST_CERTAINTY {
                return Some(Some(place));
            }
        }
        Some(None)
    }

    /// Whether two of its effects act in the same way over one variable.
    pub fn has_two_of_one_variable(&self) -> bool {
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
