//! Fits of a model to all of the log, and which numbers they move.

use super::Workbench;
use crate::gap::criterion::LARGEST_RATIO;
use crate::gap::fit::{self, Effort, Fit, Target};
use crate::gap::model::{Base, Model, Numbers};
use crate::gap::replay::{self, Fold, Schedule};
use crate::numeric::random::Random;
use crate::plant::parameters::Drive;

/// Effort of a fit that is kept.
pub(super) const FULL: Effort = Effort {
    steps: 100,
    converged: 1e-6,
};

/// Effort of a fit inside cross-validation, whose errors are compared to a tenth, and from one of several starts.
pub(super) const ROUGH: Effort = Effort {
    steps: 30,
    converged: 1e-4,
};

/// How far from a fit further starts lie, either way, of the base, in shares of its scale.
const BASE_REACH: f32 = 0.02;

/// The same of the effects, in shares of their values.
const EFFECT_REACH: f32 = 0.25;

/// Most starts.
const MOST_STARTS: u32 = 8;

/// Starts one after the other that have to come to nothing for no more to follow.
const IDLE_STARTS: u32 = 3;

/// A start that lowers the cost by less than this share has come to nothing.
const IMPROVED: f64 = 1e-3;

/// Seed of the starts.
const STARTS_SEED: u64 = 1;

impl<S: Schedule> Workbench<'_, S> {
    /// Fits a model to all of the log.
    pub fn fit(&mut self, model: &Model) -> Option<Fit> {
        let fit = self.fit_windows(model, self.data.settings.window)?;
        let Some(lifted) = self.lifted(&fit.model)? else {
            return Some(fit);
        };
        let again = self.fit_windows(&lifted, self.data.settings.window)?;
        Some(if again.cost < fit.cost { again } else { fit })
    }

    /// A model whose breakaway level lies on the Coulomb level, with one that is as much above that as the declared one is, where the
    /// log is followed better so. No slope leads there: the Coulomb level has gone above it, and then a little more or less of it
    /// changes nothing.
    #[inline(never)]
    fn lifted(&mut self, model: &Model) -> Option<Option<Model>> {
        let coulomb = model.get(Base::Coulomb);
        if !self.base.contains(&Base::Static) || model.get(Base::Static) > coulomb {
            return Some(None);
        }
        let above = self.declared.get(Base::Static) / self.declared.get(Base::Coulomb);
        if !(above > 1.0 && above.is_finite()) {
            return Some(None);
        }
        let mut lifted = model.clone();
        lifted.set(Base::Static, above * coulomb);
        let cost = self.cost(model)?;
        let is_better = self.cost_below(cost, &lifted).is_some();
        Some(is_better.then_some(lifted))
    }

    /// Fits a model to all of the log in windows of another length.
    pub fn fit_windows(&mut self, model: &Model, window: usize) -> Option<Fit> {
        self.fit_with(model, window, FULL)
    }

    pub(super) fn fit_with(&mut self, model: &Model, window: usize, effort: Effort) -> Option<Fit> {
        let data = self.data.with_window(window);
        let all = (Fold::All, 1);
        let variables = self.variables(model);
        let fit = fit::fit(&data, self.schedule, all, model, &variables, effort)?;
        self.count(fit.simulated, window);
        Some(fit)
    }

    /// Fits a model to all of the log from several starts and keeps the best one. One of them is the
    /// model that is compared with: the fit is never worse than that.
    pub fn best_fit(&mut self, starts: &[&Model]) -> Option<Fit> {
        self.best_with(starts, FULL)
    }

    #[inline(never)]
    pub(super) fn best_with(&mut self, starts: &[&Model], effort: Effort) -> Option<Fit> {
        let window = self.data.settings.window;
        let mut best: Option<Fit> = None;
        for start in starts {
            let fit = self.fit_with(start, window, effort)?;
            if best.as_ref().is_none_or(|best| fit.cost < best.cost) {
                best = Some(fit);
            }
        }
        best
    }

    /// The best of fits that start around this one, until none has come below it for a while.
    ///
    /// A window in which the machine sticks where it slid, or turns sooner, makes the cost jump: a descent
    /// may end in front of any such jump. From a little beside, it passes most of them.
    // A model beside the fit's own, which is not to lie below the rest of the tracing.
    #[inline(never)]
    pub fn multi_start(&mut self, fit: Fit) -> Fit {
        let mut random = Random::new(STARTS_SEED, 0);
        let window = self.data.settings.window;
        let mut best = fit;
        let (mut starts, mut idle) = (0, 0);
        while starts < MOST_STARTS && idle < IDLE_STARTS {
            let beside = self.beside(&best.model, &mut random);
            starts += 1;
            idle += 1;
            // Beyond the plant's range there is nothing.
            let Some(rough) = self.fit_with(&beside, window, ROUGH) else {
                continue;
            };
            if rough.cost < best.cost {
                let clearly = best.cost * (1.0 - IMPROVED);
                best = self.fit(&rough.model).unwrap_or(rough);
                if best.cost < clearly {
                    idle = 0;
                }
            }
        }
        best
    }

    /// A model somewhere around this one. Edges in time stay: a fit does not find them again.
    fn beside(&self, model: &Model, random: &mut Random) -> Model {
        let mut beside = model.clone();
        let comes_and_goes = |slot: usize| model.effects[slot].law().span().is_some();
        for variable in &self.variables(model) {
            let value = variable.get(model);
            let reach = match variable.target {
                Target::Base(_) => BASE_REACH * variable.scale,
                Target::Current(_) => 0.0,
                Target::Effect { slot, .. }
                    if variable.is_strength_of(model, slot) || !comes_and_goes(slot) =>
                {
                    EFFECT_REACH * value
                }
                Target::Effect { .. } | Target::Knot(_) => 0.0,
            };
            let moved = value + reach * (2.0 * random.uniform() - 1.0);
            variable.set(&mut beside, variable.within_bounds(moved));
        }
        beside
    }

    /// A fit with every number within its [`limits`](super::Options::limits), if the log is followed as well so, else the
    /// fit as it is, with a number that the log has elsewhere.
    ///
    /// A log that does not tell viscous friction from an effect leaves the number anywhere, at zero too.
    #[inline(never)]
    pub fn within_limits(&mut self, fit: Fit) -> Option<(Fit, Option<Base>)> {
        let (declared, options) = (self.declared, self.options);
        let limit = |model: &Model, number: Base| {
            let [least, largest] = options.limits(number, declared.get(number))?;
            let fitted = model.get(number);
            let limit = fitted.max(least).min(largest);
            (limit != fitted).then_some(limit)
        };
        let base = self.base.clone();
        let beyond = |model: &Model| {
            let mut numbers = base.iter().copied();
            numbers.find(|&number| limit(model, number).is_some())
        };
        let Some(farthest) = beyond(&fit.model) else {
            return Some((fit, None));
        };
        let mut start = fit.model.clone();
        for &number in &base {
            start.set(
                number,
                limit(&fit.model, number).unwrap_or(fit.model.get(number)),
            );
        }
        self.base
            .retain(|&number| limit(&fit.model, number).is_none());
        let held = self.fit(&start);
        self.base = base.clone();
        let held = held?;
        // What is held may have sent another number there.
        let follows = beyond(&held.model).is_none()
            && self.error_ratio(&held.model, &fit.model)? > LARGEST_RATIO;
        Some(if follows {
            (held, None)
        } else {
            (fit, Some(farthest))
        })
    }

    /// Numbers of the declared actuator that fits leave alone and that may be wrong.
    pub fn held_numbers(&self) -> Numbers {
        let plant = &self.declared.plant;
        let held = Base::WITHOUT_EFFECT.into_iter();
        held.filter(|number| !self.base.contains(number))
            .filter(|number| !number.is_of_motor() || matches!(plant.drive, Drive::Voltage { .. }))
            .collect()
    }

    /// Whether fits move more than what the options say.
    pub fn has_freed(&self) -> bool {
        self.base.len() > self.options.base.len()
    }

    /// Whether what fits move beyond that is the lead of the log's input.
    pub fn has_found_input_late(&self) -> bool {
        self.base[self.options.base.len()..].contains(&Base::InputLead)
    }

    /// Has fits move no more than what the options say. Gives what they moved.
    pub fn hold_freed(&mut self) -> Numbers {
        let moved = self.base.clone();
        self.base.truncate(self.options.base.len());
        moved
    }

    /// The fit of a model from the best of what rough ones of the whole log and of every second block come
    /// to: where the machine sticks, one may stop in a local minimum that another has passed.
    #[inline(never)]
    pub fn fit_past_blocks(&mut self, model: &Model) -> Option<Fit> {
        let (data, schedule, block) = (self.data, self.schedule, self.block);
        let variables = self.variables(model);
        let mut best = self.fit_with(model, data.settings.window, ROUGH)?;
        for fold in [Fold::Even, Fold::Odd] {
            let fit = fit::fit(&data, schedule, (fold, block), model, &variables, ROUGH)?;
            self.simulated += fit.simulated;
            if let Some(cost) = self.cost_below(best.cost, &fit.model) {
                best = Fit { cost, ..fit };
            }
        }
        self.fit(&best.model)
    }

    /// Frees these numbers, and fits a model with them.
    #[inline(never)]
    pub fn free(&mut self, model: &Model, numbers: &[Base]) -> Option<Fit> {
        let _ = self.base.extend_from_slice(numbers);
        let start = self.remove_bias(model)?;
        let fitted = self
            .best_with(&[&start, &self.with_declared_base(model)], ROUGH)?
            .model;
        self.restart(&fitted)?;
        let fit = self.fit(&fitted)?;
        Some(self.multi_start(fit))
    }

    /// Sum of a model's squared weighted residuals.
    // A simulator is not to lie below a fit.
    #[inline(never)]
    pub(super) fn cost(&mut self, model: &Model) -> Option<f64> {
        let data = self.data;
        let simulator = model.build(data.logs.first()?.period).ok()?;
        let (cost, windows) = replay::cost(&data, self.schedule, (Fold::All, 1), &simulator);
        self.count(windows as u64, data.settings.window);
        Some(cost)
    }

    /// The same, if it is below `limit`. Most of what a search tries is far above it, which a few windows show.
    #[inline(never)]
    pub(super) fn cost_below(&mut self, limit: f64, model: &Model) -> Option<f64> {
        let data = self.data;
        let simulator = model.build(data.logs.first()?.period).ok()?;
        let all = (Fold::All, 1);
        self.count(data.windows_in_fold(all) as u64, data.settings.window);
        replay::cost_below(limit, &data, self.schedule, all, &simulator)
    }
}
