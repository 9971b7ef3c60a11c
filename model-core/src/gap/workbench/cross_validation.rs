//! Errors of a model on the blocks that it was not fitted to.

use super::fits::ROUGH;
use super::{LONG, Workbench};
use crate::effect::{Active, Id};
use crate::gap::criterion::{FLOOR_COUNTS, FLOOR_CURRENT, FLOOR_STROKE};
use crate::gap::fit;
use crate::gap::held_out::{HeldOut, MOST_BLOCKS, Mask, compare, is_hopeless_within};
use crate::gap::log::Log;
use crate::gap::model::{Base, Model};
use crate::gap::replay::{self, Data, Fold, Replays, Schedule, WindowError};
use crate::gap::screen;

impl<S: Schedule> Workbench<'_, S> {
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
        let nothing = Active::new(id, []);
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
        let everywhere = !id.is_stateful();
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

    /// Held-out errors of a model of which the fits move these numbers besides.
    #[inline(never)]
    pub fn held_out_freeing(&mut self, model: &Model, numbers: &[Base]) -> Option<HeldOut> {
        let fixed = self.base.len();
        let _ = self.base.extend_from_slice(numbers);
        let start = self.remove_bias(model);
        let held_out = start.and_then(|start| self.held_out(&start));
        self.base.truncate(fixed);
        held_out
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
        let window = |at| data.window(Data::number_in_fold(fold, at));
        let replays = Replays::whole(data, &simulator, &window);
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
}
