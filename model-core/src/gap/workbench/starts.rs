//! Where a fit with one effect more starts.

use super::Workbench;
use super::fits::ROUGH;
use crate::effect::{Active, Id};
use crate::gap::criterion::{BIASED, UNSURE, WORTH_A_FIT};
use crate::gap::fit::Fit;
use crate::gap::model::{Base, Model};
use crate::gap::replay::Schedule;
use crate::gap::screen;
use crate::numeric::random::Random;

/// Models that a search for a start of the base tries.
const DRAWS: u32 = 128;

/// Each draw is spread so many times as far as the one before; the last one a fiftieth as far as the first.
const CLOSER: f32 = 0.97;

/// Seed of the search.
const SEARCH_SEED: u64 = 2;

impl<S: Schedule> Workbench<'_, S> {
    /// A model that follows the log better than the declared one, by a random search of its fitted numbers, each
    /// by as much as it may be off, and of the strengths of effects: where the machine sticks or turns at other times than the model,
    /// no slope leads from the declared numbers to the true ones. Each number is drawn about the best one so far, from a log-normal
    /// law with the factor by which it may be off, which closes in on it. `None` if no draw is better.
    #[inline(never)]
    pub fn search_around(&mut self, start: &Model) -> Option<Model> {
        let mut random = Random::new(SEARCH_SEED, 0);
        let mut best = None;
        let mut least_cost = self.cost(start)?;
        let mut reach = 1.0;
        let variables = self.variables(start);
        for _ in 0..DRAWS {
            let center: &Model = best.as_ref().unwrap_or(start);
            let mut drawn = center.clone();
            let mut moved = |factor: f32| libm::expf(reach * libm::logf(factor) * random.normal());
            for strength in variables.iter().filter(|it| it.is_strength(start)) {
                let value = strength.get(center) * moved(UNSURE);
                strength.set(&mut drawn, strength.within_bounds(value));
            }
            for &number in &self.base {
                let declared = self.declared.get(number);
                let factor = self.options.factor(number, declared);
                let limits = self.options.limits(number, declared);
                let (Some(factor), Some([least, largest])) = (factor, limits) else {
                    continue;
                };
                let value = center.get(number) * moved(factor);
                drawn.set(number, value.max(least).min(largest));
            }
            // Beyond the plant's range there is nothing to try.
            if let Some(cost) = self.cost_below(least_cost, &drawn) {
                (best, least_cost) = (Some(drawn), cost);
            }
            reach *= CLOSER;
        }
        best
    }

    /// The model, where a fit of more than its base starts: as it is, or from the declared base.
    #[inline(never)]
    pub fn remove_bias(&mut self, model: &Model) -> Option<Model> {
        self.nearest(model.clone(), &self.with_declared_base(model))
    }

    /// The start of a fit: a model, or what another one comes to in short windows or in a search. What lacks something
    /// has a biased base, by a factor of twenty where the machine sticks and the model slides, and no fit comes back
    /// from there. Of two that may be it, that is taken of which a rough fit follows the log better.
    fn nearest(&mut self, near: Model, unbiased: &Model) -> Option<Model> {
        match self.nearer(&near, unbiased)? {
            Some(far) => Some(self.best_with(&[&near, &far], ROUGH)?.model),
            None => Some(near),
        }
    }

    /// What short windows or a search make of another model, if it follows the log better than this one.
    #[inline(never)]
    fn nearer(&mut self, near: &Model, unbiased: &Model) -> Option<Option<Model>> {
        let mut least = self.cost(near)?;
        let mut nearer = None;
        for search in [Self::approach, Self::search_around] {
            let Some(far) = search(self, unbiased) else {
                continue;
            };
            if let Some(cost) = self.cost_below(least, &far) {
                (nearer, least) = (Some(far), cost);
            }
        }
        Some(nearer)
    }

    /// The model with an effect, fitted from the strength at which it follows the log best beside the fitted base,
    /// and from that beside the declared one: a base that was fitted without a large backlash is biased by that, and
    /// leaves the backlash nothing to explain. Of the two that is taken of which a rough fit follows the log better.
    ///
    /// `None` inside if no strength comes near to what the model does without.
    #[inline(never)]
    fn try_strengths(&mut self, model: &Model, id: Id) -> Option<Option<Model>> {
        let without = self.cost(model)?;
        match self.best_strengths(model, id, without)? {
            Some(started) => self.settle(&started, without).map(Some),
            None => Some(None),
        }
    }

    /// Where [`Self::try_strengths`] starts its fit.
    #[inline(never)]
    fn best_strengths(&mut self, model: &Model, id: Id, without: f64) -> Option<Option<Model>> {
        let near = self.best_strength(model, id, without);
        let far = self.best_strength(&self.with_declared_base(model), id, without);
        match (&near, &far) {
            (Some(near), Some(far)) => Some(Some(self.best_with(&[near, far], ROUGH)?.model)),
            _ => Some(near.or(far)),
        }
    }

    /// A model fitted from where it is; from elsewhere too if it then follows the log worse than this cost: with more to fit
    /// that can only be a local minimum.
    #[inline(never)]
    fn settle(&mut self, start: &Model, without: f64) -> Option<Model> {
        let fit = self.fit(start)?;
        let is_worse = fit.cost > without;
        Some(if is_worse { self.multi_start(fit) } else { fit }.model)
    }

    /// The model with an effect at that of the strengths that its fits start from at which it follows the log
    /// best. `None` if none of them comes near to this cost.
    #[inline(never)]
    fn best_strength(&mut self, model: &Model, id: Id, without: f64) -> Option<Model> {
        let mut best: Option<Model> = None;
        let mut least = WORTH_A_FIT * without;
        for values in (0..).map_while(|index| id.start(&self.options.scope, index)) {
            let tried = screen::with_effect(model, Active { id, values })?;
            // Beyond the plant's range there is nothing to try.
            if let Some(cost) = self.cost_below(least, &tried) {
                (best, least) = (Some(tried), cost);
            }
        }
        best
    }

    /// The model with its base as it is declared.
    pub(super) fn with_declared_base(&self, model: &Model) -> Model {
        let mut unbiased = model.clone();
        for &parameter in &self.base {
            unbiased.set(parameter, self.declared.get(parameter));
        }
        unbiased
    }

    /// Whether the fit has moved a number of the base to a multiple or a part of what is declared: it
    /// may then stand in for what is missing, in a valley from which no fit with the effect comes back.
    fn is_biased(&self, model: &Model) -> bool {
        self.base.iter().any(|&parameter| {
            let (fitted, declared) = (model.get(parameter), self.declared.get(parameter));
            let moved = fitted / declared;
            declared > 0.0 && !(1.0 / BIASED..=BIASED).contains(&moved)
        })
    }

    /// The model with an effect, where a fit of it starts: beside the base as it is, or where the declared one
    /// comes to with it. With one that acts for a while it has been fitted already.
    ///
    /// `None` inside if it is hopeless or the model is full.
    #[inline(never)]
    pub fn start(&mut self, model: &Model, effect: Active) -> Option<Option<Model>> {
        if effect.id.biases_base() {
            return self.try_strengths(model, effect.id);
        }
        match screen::with_effect(model, effect) {
            Some(larger) => self.start_beside(model, larger, effect),
            None => Some(None),
        }
    }

    /// A model with one effect more than `model`, where a fit of it starts whose base is the fitted or the declared one. As
    /// [`Self::start`].
    #[inline(never)]
    fn start_beside(
        &mut self,
        model: &Model,
        larger: Model,
        effect: Active,
    ) -> Option<Option<Model>> {
        let is_biased = self.is_biased(model);
        let unbiased = self.with_declared_base(&larger);
        if effect.law().span().is_some() {
            let mut best: Option<Fit> = None;
            for start in [Some(&larger), is_biased.then_some(&unbiased)]
                .into_iter()
                .flatten()
            {
                let fit = self.fit_edges(start)?;
                let least = best.as_ref().map_or(f64::INFINITY, |best| best.cost);
                best = fit.filter(|fit| fit.cost < least).or(best);
            }
            return Some(best.map(|fit| fit.model));
        }
        let near = self.take_along(model, larger)?;
        self.nearest(near, &unbiased).map(Some)
    }

    /// A model fitted in short windows, which hardly know where the machine sticks. `None` if it leaves the
    /// plant's range.
    // A fit, which is not to lie below the rest of the tracing.
    #[inline(never)]
    pub fn approach(&mut self, start: &Model) -> Option<Model> {
        let fit = self.fit_with(start, self.screen_window(), ROUGH)?;
        // A breakaway level has no slope where nothing sticks.
        if !self.base.contains(&Base::Static) {
            return Some(fit.model);
        }
        self.lower_breakaway(fit.model)
    }

    /// A model, with its breakaway level at the Coulomb level where it follows the log better so. `None` if it leaves the
    /// plant's range.
    #[inline(never)]
    fn lower_breakaway(&mut self, model: Model) -> Option<Model> {
        let mut lower = model.clone();
        lower.set(Base::Static, lower.get(Base::Coulomb));
        let cost = self.cost(&model)?;
        let lower = Some(lower).filter(|lower| self.cost_below(cost, lower).is_some());
        Some(lower.unwrap_or(model))
    }

    /// A model with an effect at its strength from a screening, which is that beside a base that moves along:
    /// with such a base, where it follows the log better so, and worse beside the base of the model without.
    ///
    /// The base moves along in short windows, where sticking that comes and goes makes hardly any local minimum.
    #[inline(never)]
    fn take_along(&mut self, without: &Model, larger: Model) -> Option<Model> {
        let cost = self.cost(&larger)?;
        if cost <= self.cost(without)? {
            return Some(larger);
        }
        let moved = self.fit_with(&larger, self.screen_window(), ROUGH);
        let follows = |moved: &Model| self.cost_below(cost, moved).is_some();
        Some(moved.map(|fit| fit.model).filter(follows).unwrap_or(larger))
    }
}
