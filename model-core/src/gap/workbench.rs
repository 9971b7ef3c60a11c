//! What every step of the tracing works with: the data, the schedule, the declared model, and the
//! count of what was simulated.

use super::covariance::Information;
use super::current_sensor::Readings;
use super::fit::{self, Effort, Fit, Target, Variables};
use super::held_out::{
    HeldOut, LARGEST_RATIO, MOST_BLOCKS, Mask, compare, is_hopeless_within, windows_per_block,
};
use super::log::Log;
use super::model::{Base, Model, Numbers};
use super::replay::{
    self, Contrasts, Data, Fold, HALF_WIDTHS, Replays, Schedule, Settings, WindowError, samples,
};
use super::scope::scope;
use super::screen::{self, Candidate, Screening};
use super::span::best_span;
use super::verdict::FARTHEST;
use crate::effect::learned_map::Ranges;
use crate::effect::{Active, Id, MOST_PARAMETERS, Scope};
use crate::numeric::random::Random;
use crate::plant::parameters::Drive;
use crate::unit::Dimension;

/// Effort of a fit that is kept, and of one that is not: inside cross-validation, whose errors are
/// compared to a tenth, or from one of several starts.
const FULL: Effort = Effort {
    steps: 100,
    converged: 1e-6,
};
const ROUGH: Effort = Effort {
    steps: 30,
    converged: 1e-4,
};

/// Counts of the sensor that are added to every held-out position error: below that an error is the
/// sensor's, and on a motion that repeats it repeats in every block.
const FLOOR_COUNTS: f32 = 2.0;

/// The same where no resolution is declared, as a share of the stroke, and for the current, as a
/// share of its rms: finer than any encoder and any shunt in the field.
const FLOOR_STROKE: f32 = 1e-5;
const FLOOR_CURRENT: f32 = 1e-3;

/// Least travel of a clear motion, as a share of the stroke.
const CLEAR_STROKE: f32 = 5e-4;

/// Length of a replay window for screening, s.
const SCREEN_WINDOW: f32 = 0.04;

/// Least windows for screening in one for judging: 0.2 s over 0.04 s, as where a log is long.
const SHORTER: usize = 5;

/// Fewest samples in a window for screening.
const LEAST_SCREENED: usize = 4;

/// A tried strength whose error, before anything is fitted to it, is beyond this multiple of what the
/// model has without is hopeless. Large, for a base that has settled without it has bent to that.
const WORTH_A_FIT: f64 = 10.0;

/// A number of the base that is fitted to more than this multiple of what is declared, or to less than
/// this part of it, is bent.
const BENT: f32 = 2.0;

/// Share of the windows from which on what acts in them acts always: what tells it from an effect
/// without edges is too little to be more than noise.
const MOST_FILLED: f32 = 0.9;

/// Samples under which an edge in time is left to a fit.
const FINEST_EDGE: f32 = 4.0;

/// How far starts lie around a fit that is to settle, either way: of the base in shares of its scale, of
/// the effects in shares of their values.
const BASE_REACH: f32 = 0.02;
const EFFECT_REACH: f32 = 0.25;

/// Most starts, and how many have to come to nothing, which is less than this share of the cost.
const MOST_STARTS: u32 = 8;
const IDLE_STARTS: u32 = 3;
const SETTLED: f64 = 1e-3;

const SETTLING_SEED: u64 = 1;

/// Most turns of looking for edges and fitting to them.
const MOST_TURNS: u32 = 3;

/// Windows of the judging length that a long prediction lasts.
const LONG: usize = 10;

/// Shares of the scales of a current's sensor within which it is a good one: 1 % of gain, 0.6 % of offset, a fifth of a
/// sample. A shunt with its amplifier comes no nearer.
const GOOD_SENSOR: f64 = 0.2;

/// Length of a held-out block, s.
const BLOCK: f32 = 0.5;

/// How the tracing runs.
#[derive(Debug, Clone, Copy)]
pub struct Options<'a> {
    /// Parameters of the declared actuator that may be re-estimated.
    pub base: &'a [Base],
    /// Sizes to scale by.
    pub scope: Scope,
    /// Ranges to lay learned maps over.
    pub ranges: Ranges,
    /// Most samples in a window for screening.
    pub screen_window: usize,
    /// Samples that a block of held-out windows should have.
    pub block: usize,
}

impl<'a> Options<'a> {
    /// The lengths that the tracing was developed with, and the sizes that the logs say are
    /// sensible. `base`: what may be re-estimated; `rotary`: the coordinate is an angle.
    ///
    /// `None` if there is no log or the model cannot be built.
    pub fn new(data: &Data, model: &Model, base: &'a [Base], rotary: bool) -> Option<Self> {
        let (scope, ranges) = scope(data, model, rotary)?;
        Some(Self {
            base,
            scope,
            ranges,
            screen_window: samples(SCREEN_WINDOW, scope.period, LEAST_SCREENED),
            block: samples(BLOCK, scope.period, 1),
        })
    }
}

/// The data as it is cut and weighed now, and all that does not change on the way.
pub struct Workbench<'a, S> {
    /// The training logs.
    pub data: Data<'a>,
    /// The model as the user declares it.
    pub declared: &'a Model,
    /// How the tracing runs.
    pub options: &'a Options<'a>,
    /// Numbers of the declared actuator that fits move: those of the options, and behind them those
    /// that were freed.
    pub base: Numbers,
    /// Numbers of the current's sensor that fits move.
    pub readings: Readings,
    /// Windows of the judging length simulated, each copy counted.
    pub simulated: u64,
    schedule: &'a S,
    /// Windows in a block of the cross-validation.
    block: usize,
}

impl<'a, S: Schedule> Workbench<'a, S> {
    /// `None` where there is no whole window.
    pub fn new(
        mut data: Data<'a>,
        schedule: &'a S,
        declared: &'a Model,
        options: &'a Options<'a>,
    ) -> Option<Self> {
        let travel = CLEAR_STROKE * options.scope.stroke;
        data.settings.clear_travel = data.settings.clear_travel.max(travel);
        let moved_alone = |log: &Log| log.current.is_none() && log.velocity.is_some();
        data.settings.velocity_channel = data.logs.iter().all(moved_alone);
        (data.windows() > 0).then(|| Self {
            data,
            declared,
            options,
            base: options.base.iter().copied().collect(),
            readings: Readings::new(),
            simulated: 0,
            schedule,
            block: windows_per_block(&data, options.block),
        })
    }

    /// The same logs, cut and weighed in another way.
    ///
    /// `None` where there is no whole window.
    pub fn over(&self, settings: Settings) -> Option<Self> {
        let data = Data {
            settings,
            ..self.data
        };
        Self::new(data, self.schedule, self.declared, self.options)
    }

    /// Samples in a window for screening.
    pub fn screen_window(&self) -> usize {
        let shorter = self.data.settings.window / SHORTER;
        self.options.screen_window.min(shorter).max(LEAST_SCREENED)
    }

    /// What a fit of the model may move.
    pub fn variables(&self, model: &Model) -> Variables {
        let moving = (&self.base[..], &self.readings[..]);
        fit::variables(self.declared, model, moving, &self.options.scope)
    }

    /// Whether the current of a winding was measured.
    pub fn has_sensor(&self) -> bool {
        let measured = self.data.logs.iter().any(|log| log.current.is_some());
        measured && matches!(self.declared.plant.drive, Drive::Voltage { .. })
    }

    /// Whether the current's sensor of a model errs by less than the best ones do.
    pub fn is_good_sensor(&self, model: &Model) -> bool {
        let variables = self.variables(model);
        let mut own = variables
            .iter()
            .filter(|variable| matches!(variable.target, Target::Current(_)));
        own.all(|variable| variable.departure(model).abs() < GOOD_SENSOR)
    }

    /// Fits a model to all of the log.
    pub fn fit(&mut self, model: &Model) -> Option<Fit> {
        self.fit_windows(model, self.data.settings.window)
    }

    /// Fits a model to all of the log in windows of another length.
    pub fn fit_windows(&mut self, model: &Model, window: usize) -> Option<Fit> {
        self.fit_with(model, window, FULL)
    }

    fn fit_with(&mut self, model: &Model, window: usize, effort: Effort) -> Option<Fit> {
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
    fn best_with(&mut self, starts: &[&Model], effort: Effort) -> Option<Fit> {
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
    pub fn settle(&mut self, fit: Fit) -> Fit {
        let mut random = Random::new(SETTLING_SEED, 0);
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
                let clearly = best.cost * (1.0 - SETTLED);
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

    /// Fits a model on every second block and measures it on the blocks between, and the other way
    /// round.
    pub fn held_out(&mut self, model: &Model) -> Option<HeldOut> {
        self.held_out_while(model, &|_| true)
    }

    /// The same as long as it is worth it: of a model of which the first half of the blocks says no, the
    /// others stay empty.
    pub fn held_out_while(
        &mut self,
        model: &Model,
        is_worth_it: &dyn Fn(&HeldOut) -> bool,
    ) -> Option<HeldOut> {
        let mut blocks = HeldOut::new();
        self.held_out_moving(model, model, &mut blocks, is_worth_it)?;
        Some(blocks)
    }

    /// The same with an effect that the model lacks, at no strength: without what it does, but with
    /// replays that start as its own do.
    #[inline(never)]
    pub fn held_out_beside(&mut self, model: &Model, id: Id, blocks: &mut HeldOut) -> Option<()> {
        let nothing = Active {
            id,
            values: [0.0; MOST_PARAMETERS],
        };
        let moving = screen::with_effect(model, nothing)?;
        self.held_out_moving(&moving, model, blocks, &|_| true)
    }

    /// The blocks in which an effect may show: all of them, but for one with a memory those in which
    /// the machine turns or rests.
    #[inline(never)]
    pub fn blocks_of(&self, id: Id) -> Mask {
        let data = &self.data;
        let mut mask = Mask::new();
        let count = data.windows().div_ceil(self.block).min(MOST_BLOCKS);
        let everywhere = !id.remembers();
        let _ = mask.resize(count, everywhere);
        if !everywhere {
            for number in 0..data.windows() {
                let turns = data
                    .window(number)
                    .is_some_and(|at| replay::turns(data, at));
                if let Some(block) = mask.get_mut(number / self.block).filter(|_| turns) {
                    *block = true;
                }
            }
        }
        mask
    }

    /// Held-out errors of a model in the short windows in which an effect with this span acts, in as
    /// many parts as there is room for. Short, because a load that lasts for a second fills few long
    /// ones.
    #[inline(never)]
    pub fn held_out_in(
        &mut self,
        model: &Model,
        span: (f32, f32),
        blocks: &mut HeldOut,
    ) -> Option<()> {
        let chosen = self.data;
        let window = self.screen_window();
        self.weigh(model, window)?;
        let data = self.data.with_window(window);
        self.data = chosen;
        let spans = [span];
        let acting = || data.overlapping(&spans);
        let count = acting().count();
        let part = count.div_ceil(MOST_BLOCKS).max(1);
        let place = |number: usize| {
            let place = acting().position(|acting| acting == number)?;
            Some(place / part)
        };
        blocks.clear();
        let _ = blocks.resize(count.div_ceil(part), WindowError::default());
        let block = (chosen.settings.window / window).max(1);
        let models = (model, model);
        let simulated = self.cross_validate((&data, block), models, blocks, place, &|_| true)?;
        self.count(simulated, window);
        Some(())
    }

    /// Held-out errors of a model of which the fits move what another one has.
    // Not part of a frame under which a start is looked for.
    #[inline(never)]
    fn held_out_moving(
        &mut self,
        model: &Model,
        moving: &Model,
        blocks: &mut HeldOut,
        is_worth_it: &dyn Fn(&HeldOut) -> bool,
    ) -> Option<()> {
        let (data, block) = (self.data, self.block);
        blocks.clear();
        let count = data.windows().div_ceil(block).min(MOST_BLOCKS);
        let _ = blocks.resize(count, WindowError::default());
        let models = (model, moving);
        let place = |number: usize| Some(number / block);
        self.simulated +=
            self.cross_validate((&data, block), models, blocks, place, is_worth_it)?;
        Some(())
    }

    /// Whether a model predicts clearly worse than another one over short windows, in which torque is all
    /// that acts, or over long ones: by the test that an effect has to pass, turned round.
    #[inline(never)]
    pub fn is_clearly_worse(&mut self, model: &Model, other: &Model) -> Option<bool> {
        let longest = self.data.logs.iter().map(Log::samples).max()?;
        // A log that holds fewer than two dozen long windows is cut into shorter ones.
        let window = self.data.settings.window;
        let long = (LONG * window).min(longest / 24).max(window);
        for window in [self.screen_window(), long] {
            let (mut own, mut others) = (HeldOut::new(), HeldOut::new());
            self.errors_over(window, model, &mut own)?;
            self.errors_over(window, other, &mut others)?;
            if compare(&own, &others).refusal(1).is_none() {
                return Some(true);
            }
        }
        Some(false)
    }

    /// A model's errors in windows of another length, in as many parts as there is room for.
    #[inline(never)]
    fn errors_over(&mut self, window: usize, model: &Model, blocks: &mut HeldOut) -> Option<()> {
        let data = self.data.with_window(window);
        let part = data.windows().div_ceil(MOST_BLOCKS).max(1);
        blocks.clear();
        let _ = blocks.resize(data.windows().div_ceil(part), WindowError::default());
        let floor = self.floor(&data);
        let place = |number: usize| Some(number / part);
        let windows = self.measure((&data, (Fold::All, 1)), model, &floor, blocks, &place)?;
        self.count(windows, window);
        Some(())
    }

    /// Root mean square of the position error that is left to the best of models: that of the sensor's rounding, and
    /// that of the restarts, by which windows differ that restart from a state smoothed over the next fewer
    /// or the next more samples; rad or m.
    #[inline(never)]
    pub fn least_error(&mut self, model: &Model) -> Option<f64> {
        let data = self.data;
        let simulator = model.build(data.logs.first()?.period).ok()?;
        let chosen = |half_width: &usize| *half_width == data.settings.half_width;
        let place = HALF_WIDTHS.iter().position(chosen).unwrap_or(0);
        let neighbours = [place.checked_sub(1), Some(place + 1)];
        let (mut apart, mut samples) = (0.0, 0);
        let neighbours = neighbours.into_iter().flatten();
        for &half_width in neighbours.filter_map(|place| HALF_WIDTHS.get(place)) {
            let mut other = data;
            other.settings.half_width = half_width;
            let job = Contrasts {
                data: [&data, &other],
                simulators: [&simulator, &simulator],
            };
            self.schedule.run_job(data.windows(), &job, |_, contrast| {
                apart += f64::from(contrast.apart);
                samples += data.settings.window;
            });
            self.count(2 * data.windows() as u64, data.settings.window);
        }
        // What is rounded to a count is spread evenly over it.
        let rounding = f64::from(self.data.settings.resolution) / libm::sqrt(12.0);
        let sensor = rounding.max(f64::from(FLOOR_STROKE * self.options.scope.stroke));
        Some(libm::sqrt(apart / samples.max(1) as f64 + sensor * sensor))
    }

    /// A fit with every number where a data sheet would let it be, if the log is followed as well so, else the fit
    /// as it is, with a number that the log has elsewhere.
    ///
    /// A log that does not tell viscous friction from an effect leaves the number anywhere, at zero too.
    #[inline(never)]
    pub fn within_data_sheet(&mut self, fit: Fit) -> Option<(Fit, Option<Base>)> {
        let declared = self.declared;
        let limit = |model: &Model, number: Base| {
            let (declared, fitted) = (declared.get(number), model.get(number));
            let limit = fitted.max(declared / FARTHEST).min(FARTHEST * declared);
            let is_checked = declared > 0.0 && number.dimension() != Dimension::Position;
            (is_checked && limit != fitted).then_some(limit)
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

    /// Has fits move no more than what the options say. Gives what they moved.
    pub fn hold_freed(&mut self) -> Numbers {
        let moved = self.base.clone();
        self.base.truncate(self.options.base.len());
        moved
    }

    /// The fit of a model from the best of what rough ones of the whole log and of every second block come
    /// to: where the machine sticks, one may be caught that another has passed.
    #[inline(never)]
    pub fn fit_past_blocks(&mut self, model: &Model) -> Option<Fit> {
        let (data, schedule, block) = (self.data, self.schedule, self.block);
        let variables = self.variables(model);
        let mut best = self.fit_with(model, data.settings.window, ROUGH)?;
        for fold in [Fold::Even, Fold::Odd] {
            let fit = fit::fit(&data, schedule, (fold, block), model, &variables, ROUGH)?;
            self.simulated += fit.simulated;
            let cost = self.cost(&fit.model)?;
            if cost < best.cost {
                best = Fit { cost, ..fit };
            }
        }
        self.fit(&best.model)
    }

    /// Held-out errors of a model of which the fits move these numbers besides.
    #[inline(never)]
    pub fn held_out_freeing(&mut self, model: &Model, numbers: &[Base]) -> Option<HeldOut> {
        let fixed = self.base.len();
        let _ = self.base.extend_from_slice(numbers);
        let start = self.unbend(model);
        let held_out = start.and_then(|start| self.held_out(&start));
        self.base.truncate(fixed);
        held_out
    }

    /// The model, where a fit of more than its base starts: as it is, or from the declared base.
    #[inline(never)]
    pub fn unbend(&mut self, model: &Model) -> Option<Model> {
        self.nearest(model.clone(), &self.unbent(model))
    }

    /// The start of a fit: a model, or what another one comes to in short windows. What lacks something bends its
    /// base to it, by a factor of twenty where the machine sticks and the model slides, and no fit comes back from
    /// there. Of two that may be it, that is taken of which a rough fit follows the log better.
    fn nearest(&mut self, near: Model, unbent: &Model) -> Option<Model> {
        let cost = self.cost(&near)?;
        let far = self.approach(unbent);
        match far.filter(|far| self.cost(far).is_some_and(|far| far < cost)) {
            Some(far) => Some(self.best_with(&[&near, &far], ROUGH)?.model),
            None => Some(near),
        }
    }

    /// Frees these numbers, and fits a model with them.
    #[inline(never)]
    pub fn free(&mut self, model: &Model, numbers: &[Base]) -> Option<Fit> {
        let _ = self.base.extend_from_slice(numbers);
        let start = self.unbend(model)?;
        let fitted = self.best_with(&[&start, &self.unbent(model)], ROUGH)?.model;
        self.restart(&fitted)?;
        let fit = self.fit(&fitted)?;
        Some(self.settle(fit))
    }

    /// Fits a model, of which the fits move what another one has, on every second block of windows and
    /// adds the errors on the blocks between, each window's at its place; then, if these say that it is
    /// worth it, the other way round. Gives the windows simulated.
    fn cross_validate(
        &self,
        (data, block): (&Data, usize),
        (model, moving): (&Model, &Model),
        blocks: &mut HeldOut,
        place: impl Fn(usize) -> Option<usize>,
        is_worth_it: &dyn Fn(&HeldOut) -> bool,
    ) -> Option<u64> {
        let variables = self.variables(moving);
        let floor = self.floor(data);
        let mut simulated = 0;
        for (train, test) in [(Fold::Even, Fold::Odd), (Fold::Odd, Fold::Even)] {
            let fold = (train, block);
            let fit = fit::fit(data, self.schedule, fold, model, &variables, ROUGH)?;
            let tested = (data, (test, block));
            let measured = self.measure(tested, &fit.model, &floor, blocks, &place)?;
            simulated += fit.simulated + measured;
            if !is_worth_it(blocks) {
                break;
            }
        }
        Some(simulated)
    }

    /// Position error that is the sensor's, rad or m.
    fn least_position(&self) -> f32 {
        let counts = FLOOR_COUNTS * self.data.settings.resolution;
        counts.max(FLOOR_STROKE * self.options.scope.stroke)
    }

    /// What is added to the held-out error of every window.
    fn floor(&self, data: &Data) -> WindowError {
        let scope = &self.options.scope;
        let position_floor = self.least_position();
        let current_floor = FLOOR_CURRENT
            * if data.settings.velocity_channel {
                scope.speed
            } else {
                scope.torque / self.declared.plant.torque_per_current()
            };
        let window = data.settings.window as f32;
        WindowError {
            position: position_floor * position_floor * window,
            current: current_floor * current_floor * window,
            largest: 0.0,
        }
    }

    /// Adds a model's errors, and the floor, to the blocks at the places of the windows that take
    /// part in a fold. Gives the windows replayed.
    #[inline(never)]
    fn measure(
        &self,
        (data, (fold, block)): (&Data, (Fold, usize)),
        model: &Model,
        floor: &WindowError,
        blocks: &mut HeldOut,
        place: &impl Fn(usize) -> Option<usize>,
    ) -> Option<u64> {
        let simulator = model.build(data.logs.first()?.period).ok()?;
        let fold = (fold, block);
        let measured = data.windows_in_fold(fold);
        let replays = Replays {
            data,
            simulator: &simulator,
            window: &|at| data.window(Data::number_in_fold(fold, at)),
        };
        self.schedule.run_job(measured, &replays, |at, replayed| {
            let error = &replayed.error;
            let sum = place(Data::number_in_fold(fold, at)).and_then(|place| blocks.get_mut(place));
            if let Some(sum) = sum {
                sum.position += error.position + floor.position;
                sum.current += error.current + floor.current;
            }
        });
        Some(measured as u64)
    }

    /// The model with an effect, fitted from the strength at which it follows the log best beside the fitted base,
    /// and from that beside the declared one: a base that was fitted without a large play has bent to it, and leaves
    /// the play nothing to explain. Of the two that is taken of which a rough fit follows the log better.
    ///
    /// `None` inside if no strength comes near to what the model does without.
    #[inline(never)]
    fn try_strengths(&mut self, model: &Model, id: Id) -> Option<Option<Model>> {
        let without = self.cost(model)?;
        let near = self.best_strength(model, id, without);
        let unbent = self.unbent(model);
        let far = self.best_strength(&unbent, id, without);
        let started = match (&near, &far) {
            (Some(near), Some(far)) => self.best_with(&[near, far], ROUGH)?.model,
            (Some(only), None) | (None, Some(only)) => only.clone(),
            (None, None) => return Some(None),
        };
        let fit = self.fit(&started)?;
        // With more to fit it can only be worse where it was caught on its way.
        let settled = if fit.cost > without {
            self.settle(fit)
        } else {
            fit
        };
        Some(Some(settled.model))
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
            let Some(cost) = self.cost(&tried) else {
                continue;
            };
            if cost < least {
                (best, least) = (Some(tried), cost);
            }
        }
        best
    }

    /// The model with its base as it is declared.
    fn unbent(&self, model: &Model) -> Model {
        let mut unbent = model.clone();
        for &parameter in &self.base {
            unbent.set(parameter, self.declared.get(parameter));
        }
        unbent
    }

    /// Whether the fit has moved a number of the base to a multiple or a part of what is declared: it
    /// may then stand in for what is missing, in a valley from which no fit with the effect comes back.
    fn is_bent(&self, model: &Model) -> bool {
        self.base.iter().any(|&parameter| {
            let (fitted, declared) = (model.get(parameter), self.declared.get(parameter));
            let moved = fitted / declared;
            declared > 0.0 && !(1.0 / BENT..=BENT).contains(&moved)
        })
    }

    /// The model with an effect, where a fit of it starts: beside the base as it is, or where the declared one
    /// comes to with it. With one that acts for a while it has been fitted already.
    ///
    /// `None` inside if it is hopeless or the model is full.
    #[inline(never)]
    pub fn start(&mut self, model: &Model, effect: Active) -> Option<Option<Model>> {
        if effect.id.bends_base() {
            return self.try_strengths(model, effect.id);
        }
        let Some(larger) = screen::with_effect(model, effect) else {
            return Some(None);
        };
        let bent = self.is_bent(model);
        let unbent = self.unbent(&larger);
        if effect.law().span().is_some() {
            let mut best: Option<Fit> = None;
            for start in [Some(&larger), bent.then_some(&unbent)]
                .into_iter()
                .flatten()
            {
                let fit = self.settle_span(start)?;
                let least = best.as_ref().map_or(f64::INFINITY, |best| best.cost);
                best = fit.filter(|fit| fit.cost < least).or(best);
            }
            return Some(best.map(|fit| fit.model));
        }
        let near = self.take_along(model, larger)?;
        self.nearest(near, &unbent).map(Some)
    }

    /// A model fitted in short windows, which hardly know where the machine sticks. `None` if it leaves the
    /// plant's range.
    // A fit, which is not to lie below the rest of the tracing.
    #[inline(never)]
    pub fn approach(&mut self, start: &Model) -> Option<Model> {
        let fit = self.fit_with(start, self.screen_window(), ROUGH)?;
        let model = fit.model;
        // A breakaway level has no slope where nothing sticks.
        if !self.base.contains(&Base::Static) {
            return Some(model);
        }
        let mut lower = model.clone();
        lower.set(Base::Static, lower.get(Base::Coulomb));
        let cost = self.cost(&model)?;
        let lower = Some(lower).filter(|lower| self.cost(lower).is_some_and(|lower| lower < cost));
        Some(lower.unwrap_or(model))
    }

    /// A model with an effect at its strength from a screening, which is that beside a base that moves along:
    /// with such a base, where it follows the log better so, and worse beside the base of the model without.
    ///
    /// The base moves along in short windows, where a fit is hardly caught by sticking that comes and goes.
    #[inline(never)]
    fn take_along(&mut self, without: &Model, larger: Model) -> Option<Model> {
        let cost = self.cost(&larger)?;
        if cost <= self.cost(without)? {
            return Some(larger);
        }
        let moved = self.fit_with(&larger, self.screen_window(), ROUGH);
        let follows = |moved: &Model| self.cost(moved).is_some_and(|moved| moved < cost);
        Some(moved.map(|fit| fit.model).filter(follows).unwrap_or(larger))
    }

    /// The fit of a model whose last effect acts for a while, from where that while follows the log best.
    /// `None` inside if no window is followed better, or nearly all are.
    ///
    /// A derivative does not carry an edge beyond the window that it is in: near the window's end an
    /// edge changes nothing that the window sees. So the edges are looked for, and everything is fitted
    /// to them, in turns.
    #[inline(never)]
    fn settle_span(&mut self, model: &Model) -> Option<Option<Fit>> {
        let mut best: Option<Fit> = None;
        for _ in 0..MOST_TURNS {
            let last = best.as_ref().map_or(model, |fit| &fit.model);
            let Some(found) = self.find_span(last)? else {
                break;
            };
            if best.is_some() && self.is_near(&found, last) {
                break;
            }
            let moved = self.move_edges(found)?;
            let fit = self.fit(&moved)?;
            if best.as_ref().is_some_and(|best| fit.cost >= best.cost) {
                break;
            }
            best = Some(fit);
        }
        Some(best)
    }

    /// The model with its last effect acting where the log is followed best by that, to a window. `None`
    /// inside where that is nowhere, or nearly always.
    // Two simulators, which are not to lie below a fit.
    #[inline(never)]
    fn find_span(&mut self, model: &Model) -> Option<Option<Model>> {
        let data = self.data;
        let period = data.logs.first()?.period;
        let mut without = model.clone();
        let effect = without.effects.pop()?;
        let acting = |(begin, end): (f32, f32)| {
            let mut acting = effect;
            let shapes = &mut acting.values[effect.id.strengths()..];
            (shapes[0], shapes[1]) = (end, end - begin);
            screen::with_effect(&without, acting)
        };
        let throughout = acting((0.0, 2.0 * self.options.scope.seconds))?;
        let (without, throughout) = (without.build(period).ok()?, throughout.build(period).ok()?);
        let (span, windows) = best_span(&data, self.schedule, (&without, &throughout));
        self.count(windows, data.settings.window);
        let comes_and_goes = |span: &(f32, f32)| {
            let filled = data.overlapping(&[*span]).count();
            (filled as f32) < MOST_FILLED * data.windows() as f32
        };
        Some(span.filter(comes_and_goes).and_then(acting))
    }

    /// Whether the last effects of two models act at the same time, to a window.
    fn is_near(&self, a: &Model, b: &Model) -> bool {
        let span = |model: &Model| model.effects.last().and_then(|effect| effect.law().span());
        let window = self.data.settings.window as f32 * self.options.scope.period;
        span(a).zip(span(b)).is_some_and(|(a, b)| {
            let apart = (a.0 - b.0).abs().max((a.1 - b.1).abs());
            apart <= window
        })
    }

    /// The model with the edges of its last effect's span moved, within a window, to where the log is
    /// followed best. Elsewhere they change nothing.
    #[inline(never)]
    fn move_edges(&mut self, mut best: Model) -> Option<Model> {
        let slot = best.effects.len() - 1;
        let shapes = best.effects[slot].id.strengths();
        let (begin, end) = best.effects[slot].law().span()?;
        let window = self.data.settings.window as f32 * self.options.scope.period;
        let near = |edge: f32| (edge - window, edge + window);
        let edges = [near(begin), near(end)];
        let mut least = self.cost_within(&best, edges)?;
        let mut step = 0.5 * window;
        while step > FINEST_EDGE * self.options.scope.period {
            for (begin, end) in [(-step, 0.0), (step, 0.0), (0.0, -step), (0.0, step)] {
                let mut tried = best.clone();
                let values = &mut tried.effects[slot].values;
                values[shapes] += end;
                values[shapes + 1] += end - begin;
                if values[shapes] <= 0.0 || values[shapes + 1] <= 0.0 {
                    continue;
                }
                let cost = self.cost_within(&tried, edges)?;
                if cost < least {
                    (best, least) = (tried, cost);
                }
            }
            step *= 0.5;
        }
        Some(best)
    }

    /// Sum of a model's squared weighted residuals in the windows that have something in common with one
    /// of two spans.
    #[inline(never)]
    fn cost_within(&mut self, model: &Model, spans: [(f32, f32); 2]) -> Option<f64> {
        let data = self.data;
        let simulator = model.build(data.logs.first()?.period).ok()?;
        let numbers = || data.overlapping(&spans);
        let windows = numbers().count();
        let replays = Replays {
            data: &data,
            simulator: &simulator,
            window: &|place| data.window(numbers().nth(place)?),
        };
        let mut total = 0.0;
        self.schedule.run_job(windows, &replays, |_, replayed| {
            total += f64::from(replayed.cost);
        });
        self.count(windows as u64, data.settings.window);
        Some(total)
    }

    /// Held-out errors of a model with an effect, its last one, beside those without it, `smaller`. Where there
    /// is nothing to gain in the first half of the blocks, though the effect may show in these, the others
    /// stay empty.
    #[inline(never)]
    pub fn held_out_with(
        &mut self,
        larger: &Model,
        smaller: &HeldOut,
        blocks: &mut HeldOut,
    ) -> Option<()> {
        let effect = larger.effects.last()?;
        // What comes and goes may do so in the other half alone.
        let comes_and_goes = effect.law().span().is_some();
        let shown_in = self.blocks_of(effect.id);
        self.held_out_moving(larger, larger, blocks, &|tested| {
            comes_and_goes || !is_hopeless_within(smaller, tested, &shown_in)
        })
    }

    /// Sum of a model's squared weighted residuals.
    fn cost(&mut self, model: &Model) -> Option<f64> {
        let data = self.data;
        let simulator = model.build(data.logs.first()?.period).ok()?;
        let (cost, windows) = replay::cost(&data, self.schedule, (Fold::All, 1), &simulator);
        self.count(windows as u64, data.settings.window);
        Some(cost)
    }

    /// Screens all effects that the fitted model lacks, on short windows. `passed_over` is told of
    /// those that are not among the best.
    pub fn screen(
        &mut self,
        model: &Model,
        passed_over: impl FnMut(&Candidate),
    ) -> Option<Screening> {
        let window = self.screen_window();
        let data = self.data.with_window(window);
        let scope = &self.options.scope;
        let variables = self.variables(model);
        let schedule = self.schedule;
        let screened = screen::screen(&data, schedule, model, &variables, scope, passed_over);
        self.count(screened.as_ref()?.simulated, window);
        screened
    }

    /// Scores the flat map of a model, on short windows.
    pub fn map_score(&mut self, model: &Model) -> Option<f32> {
        let window = self.screen_window();
        let data = self.data.with_window(window);
        let variables = self.variables(model);
        let (score, simulated) = screen::map_score(&data, self.schedule, model, &variables)?;
        self.count(simulated, window);
        Some(score)
    }

    /// Restarts replays from the state that short ones of the model follow best: a quiet sensor
    /// wants little smoothing, a coarse one much. Then weighs the channels.
    pub fn restart(&mut self, model: &Model) -> Option<()> {
        let window = self.screen_window();
        let measured = self.data.logs.iter().all(|log| log.velocity.is_some());
        let sources: &[bool] = if measured { &[false, true] } else { &[false] };
        let mut best: Option<(Data<'a>, f64)> = None;
        for &measured_velocity in sources {
            for half_width in HALF_WIDTHS {
                let mut tried = self.data;
                tried.settings.half_width = half_width;
                tried.settings.measured_velocity = measured_velocity;
                let (position, second) = self.residuals(&tried.with_window(window), model)?;
                let error = if self.data.settings.velocity_channel {
                    position * second
                } else {
                    position
                };
                if best.is_none_or(|(_, least)| error < least) {
                    best = Some((tried, error));
                }
            }
        }
        self.data = best?.0;
        self.weigh(model, self.data.settings.window)
    }

    /// Weighs each channel by one over its residual, but not finer than the sensor.
    pub fn weigh(&mut self, model: &Model, window: usize) -> Option<()> {
        let (position, current) = self.residuals(&self.data.with_window(window), model)?;
        let settings = &mut self.data.settings;
        let floor = f64::from(0.3 * settings.resolution).max(1e-9);
        settings.position_weight = (1.0 / position.max(floor)) as f32;
        settings.current_weight = if current > 0.0 {
            (1.0 / current) as f32
        } else {
            0.0
        };
        Some(())
    }

    /// Root mean square of a model's windowed position error.
    pub fn position_rms(&mut self, model: &Model) -> Option<f64> {
        let data = self.data;
        self.residuals(&data, model).map(|(position, _)| position)
    }

    /// Mean square error of a model over that of another one, product over the channels, as held-out errors
    /// are compared.
    pub fn error_ratio(&mut self, other: &Model, model: &Model) -> Option<f64> {
        let data = self.data;
        let (before, after) = (self.residuals(&data, other)?, self.residuals(&data, model)?);
        let floor = f64::from(data.settings.resolution) / libm::sqrt(12.0);
        let square = |(position, second): (f64, f64)| {
            let position = position * position + floor * floor;
            if second > 0.0 {
                position * second * second
            } else {
                position
            }
        };
        Some(square(after) / square(before))
    }

    /// How many standard deviations the strengths of the effect in this slot are from zero, jointly.
    pub fn certainty(&mut self, model: &Model, slot: usize) -> Option<f64> {
        let variables = self.variables(model);
        let data = self.data;
        let mut information = Information::default();
        let jackknife = information.gather(&data, self.schedule, model, &variables)?;
        let restarts = information.allow_for_restarts(&data, self.schedule, model, &variables)?;
        self.count(jackknife + restarts, data.settings.window);
        Some(information.certainty(model, &variables, slot))
    }

    /// Root mean squares of the two channels' residuals over all windows.
    #[inline(never)]
    fn residuals(&mut self, data: &Data, model: &Model) -> Option<(f64, f64)> {
        let simulator = model.build(data.logs.first()?.period).ok()?;
        let total = replay::total_error(data, self.schedule, &simulator);
        self.count(total.windows as u64, data.settings.window);
        Some((total.position_rms(), total.current_rms()))
    }

    /// Counts windows of this length, each copy of a model.
    pub fn count(&mut self, windows: u64, length: usize) {
        self.simulated += windows * length as u64 / self.data.settings.window as u64;
    }
}
