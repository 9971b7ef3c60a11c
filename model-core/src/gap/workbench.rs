//! What every step of the tracing works with: the data, the schedule, the declared model, and the
//! count of what was simulated.

use super::covariance::Information;
use super::criterion::{
    BLOCK, DECLARED_WEIGHT, FARTHEST, FLOOR_STROKE, GOOD_SENSOR, STRUCTURED_COUNTS,
    STRUCTURED_STROKE, UNSURE,
};
use super::current_sensor::Readings;
use super::fit::{self, Target, Variable, Variables};
use super::held_out::windows_per_block;
use super::log::Log;
use super::model::{Base, Model, Numbers};
use super::replay::{self, Contrasts, Data, HALF_WIDTHS, Schedule, Settings, WindowStart, samples};
use super::scope::scope;
use super::screen::{self, Candidate, Screening};
use super::verdict::Residual;
use crate::effect::learned_map::Ranges;
use crate::effect::{Id, Scope};
use crate::plant::parameters::Drive;
use crate::unit::Dimension;
use heapless::Vec;

mod cross_validation;
mod fits;
mod spans;
mod starts;

/// Least travel of a clear motion, as a share of the stroke.
const CLEAR_STROKE: f32 = 5e-4;

/// Length of a replay window for screening, s.
const SCREEN_WINDOW: f32 = 0.04;

/// Least windows for screening in one for judging: 0.2 s over 0.04 s, as where a log is long.
const SHORTER: usize = 5;

/// Fewest samples in a window for screening.
const LEAST_SCREENED: usize = 4;

/// Windows of the judging length that a long prediction lasts.
const LONG: usize = 10;

/// How the tracing runs.
#[derive(Debug, Clone, Copy)]
pub struct Options<'a> {
    /// Parameters of the declared actuator that may be re-estimated.
    pub base: &'a [Base],
    /// By what factor declared numbers may be off, a standard deviation of their logarithm; [`UNSURE`] of all others.
    pub unsure: &'a [(Base, f32)],
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
            unsure: &[],
            scope,
            ranges,
            screen_window: samples(SCREEN_WINDOW, scope.period, LEAST_SCREENED),
            block: samples(BLOCK, scope.period, 1),
        })
    }

    /// The least and the largest value that a fit may leave a number at, three standard deviations either way; `None` of one
    /// that is declared as none, or that says where something is.
    pub fn limits(&self, number: Base, declared: f32) -> Option<[f32; 2]> {
        let factor = self.factor(number, declared)?;
        let farthest = (factor * factor * factor).min(FARTHEST);
        Some([declared / farthest, farthest * declared])
    }

    /// By what factor a number may be off, a standard deviation; `None` as of [`limits`](Self::limits).
    pub fn factor(&self, number: Base, declared: f32) -> Option<f32> {
        let is_limited = declared > 0.0 && number.dimension() != Dimension::Position;
        let stated = self.unsure.iter().find(|(own, _)| *own == number);
        is_limited.then_some(stated.map_or(UNSURE, |&(_, factor)| factor))
    }

    /// Standard deviation of what a number of the actuator is declared as, in scales of its variable, where a fit has come to
    /// `value`: that of its logarithm, times the value. None of others.
    pub fn error(&self, variable: &Variable, value: f32) -> f64 {
        let (Target::Base(number), Some(declared)) = (variable.target, variable.declared) else {
            return 0.0;
        };
        let share = f64::from(declared.max(value) / variable.scale);
        let factor = self.factor(number, declared).map(f64::from);
        factor.map_or(libm::sqrt(1.0 / DECLARED_WEIGHT), |it| {
            share * libm::log(it)
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

    /// Root mean square of the position error that is left to the best of models: that of the sensor's rounding, and
    /// that of the restarts, by which windows differ that restart from a state smoothed over the next fewer
    /// or the next more samples; rad or m.
    #[inline(never)]
    pub fn least_error(&mut self, model: &Model) -> Option<f64> {
        let data = self.data;
        let simulator = model.build(data.logs.first()?.period).ok()?;
        let (mut apart, mut samples) = (0.0, 0);
        for other in data.with_neighbouring_restarts().iter().flatten() {
            let job = Contrasts {
                data: [&data, other],
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

    /// What a model leaves, and what the sensor and the restarts leave to any model.
    pub fn residual(&mut self, model: &Model) -> Option<Residual> {
        Some(Residual {
            position_rms: self.position_rms(model)?,
            floor: self.least_error(model)?,
        })
    }

    /// Error beyond which it has a cause, whether anything is found for it or not, rad or m.
    pub fn structured_error(&self) -> f64 {
        let sensor = STRUCTURED_COUNTS * f64::from(self.data.settings.resolution);
        let stroke = STRUCTURED_STROKE * f64::from(self.options.scope.stroke);
        sensor.max(stroke)
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
        let starts = self.window_starts(model.has(Id::Compliance));
        self.restart_with(model, &starts)
    }

    /// How windows of these logs may get their starting state. A model with a shaft starts from no simulation.
    pub fn window_starts(&self, has_shaft: bool) -> Vec<WindowStart, 3> {
        let measured = self.data.logs.iter().all(|log| log.velocity.is_some());
        [
            (WindowStart::Slope, true),
            (WindowStart::Simulated, !has_shaft),
            (WindowStart::Measured, measured),
        ]
        .into_iter()
        .filter_map(|(start, may)| may.then_some(start))
        .collect()
    }

    /// Lets windows start as those of a model with this effect do, so that a model without it is compared with one that
    /// has it on equal starts.
    pub fn restart_as_with(&mut self, model: &Model, effect: Id) -> Option<bool> {
        let has_shaft = effect == Id::Compliance;
        let starts = self.window_starts(has_shaft);
        let is_as_now = starts.contains(&self.data.settings.window_start);
        if !is_as_now {
            self.restart_with(model, &starts)?;
        }
        Some(!is_as_now)
    }

    /// As [`restart`](Self::restart), choosing among these ways to start a window only.
    pub fn restart_with(&mut self, model: &Model, starts: &[WindowStart]) -> Option<()> {
        let window = self.screen_window();
        let mut best: Option<(Data<'a>, f64)> = None;
        for &window_start in starts {
            for half_width in HALF_WIDTHS {
                let mut tried = self.data;
                tried.settings.half_width = half_width;
                tried.settings.window_start = window_start;
                let error = self.misfit(&tried.with_window(window), model)?;
                if best.is_none_or(|(_, least)| error < least || least.is_nan()) {
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

    /// How far a model is from logs that are cut in this way: the root mean square of its windowed position error, times that of
    /// the velocity where that is the second channel.
    pub fn misfit(&mut self, data: &Data, model: &Model) -> Option<f64> {
        let (position, second) = self.residuals(data, model)?;
        Some(if data.settings.velocity_channel {
            position * second
        } else {
            position
        })
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
        let others = data.with_neighbouring_restarts();
        let restarts = information.allow_for_others(&others, self.schedule, model, &variables)?;
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
