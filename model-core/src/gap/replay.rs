//! Replay in windows, in lockstep with perturbed copies, into least-squares sums.
//!
//! Every window restarts from the measured state, or from one that is simulated from shortly before it, so that an error
//! does not grow beyond it and windows are independent: they may be worked on in any order and by several cores. Sums inside a
//! window are `f32`, sums over windows `f64` in the order of the log: the same bits on one core,
//! on many and on the chip.

use super::simulator::Simulator;
pub use contrast::Contrast;
pub(super) use contrast::Contrasts;
use core::slice;
pub(super) use data::HALF_WIDTHS;
pub use data::{Data, Fold, MARGIN, Settings, WINDOW, Window, WindowStart, samples};
use places::Places;
use restart::lead;
pub use restart::turns;
pub use runner::{Row, Runner};
pub use sums::{Sums, WindowSums, replay_windows};

mod contrast;
mod data;
mod places;
mod restart;
mod runner;
mod sums;

/// Errors of one window, in SI units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WindowError {
    /// Sum of the squared position residuals.
    pub position: f32,
    /// Sum of the squared current residuals.
    pub current: f32,
    /// Largest position residual.
    pub largest: f32,
}

/// What a replay of one window comes to.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Replayed {
    pub error: WindowError,
    /// Sum of the squared weighted residuals: the first of the window's sums.
    pub cost: f32,
}

impl Replayed {
    #[inline(always)]
    fn add(&mut self, (position, current): (f32, f32), settings: &Settings) {
        let error = &mut self.error;
        error.position += position * position;
        error.current += current * current;
        error.largest = error.largest.max(position.abs());
        let position = position * settings.position_weight;
        self.cost += position * position;
        if settings.current_weight > 0.0 {
            let current = current * settings.current_weight;
            self.cost += current * current;
        }
    }
}

/// Windows to be replayed.
pub(super) struct Replays<'a> {
    pub data: &'a Data<'a>,
    pub simulator: &'a Simulator,
    /// Where a window lies, by its number among them.
    pub window: &'a (dyn Fn(usize) -> Option<Window> + Sync),
    /// Where windows that are worked on together cost more than this, the rest of them is left out.
    pub limit: f64,
}

impl<'a> Replays<'a> {
    /// None of it left out.
    pub fn whole(
        data: &'a Data<'a>,
        simulator: &'a Simulator,
        window: &'a (dyn Fn(usize) -> Option<Window> + Sync),
    ) -> Self {
        Self {
            data,
            simulator,
            window,
            limit: f64::INFINITY,
        }
    }

    /// Sum of the squared weighted residuals over so many windows, in their order.
    pub fn cost(&self, schedule: &impl Schedule, windows: usize) -> f64 {
        let mut cost = 0.0;
        self.add_cost(schedule, windows, &mut cost);
        cost
    }

    /// Adds them to a sum one by one: the bits are those of one sum over all windows.
    fn add_cost(&self, schedule: &impl Schedule, windows: usize, cost: &mut f64) {
        schedule.run_job(windows, self, |_, replayed| {
            *cost += f64::from(replayed.cost);
        });
    }
}

impl Job for Replays<'_> {
    type Result = Replayed;

    fn lead(&self, number: usize) -> usize {
        let is_stateful = self.simulator.is_stateful();
        let window = (self.window)(number);
        window.map_or(0, |window| lead(self.data, window, is_stateful))
    }

    #[inline(always)]
    fn work<const N: usize>(&self, numbers: &[usize], results: &mut [Replayed]) {
        let at = |place: usize| (self.window)(numbers[place]);
        if N > 1 {
            replay_all::<N>(results, self, at);
        } else if let (Some(result), Some(window)) = (results.first_mut(), at(0)) {
            replay_one(result, self, window);
        }
    }
}

/// Steps after which a replay looks whether the rest may be left out.
const LOOKED_AFTER: usize = 8;

fn replay_one(result: &mut Replayed, replays: &Replays, window: Window) {
    let Replays {
        data,
        simulator,
        limit,
        ..
    } = replays;
    let log = &data.logs[window.log];
    let mut runner = Runner::new(simulator, log, window.start, &data.settings);
    for index in window.start..window.start + data.settings.window {
        result.add(runner.advance(&Row::new(log, index)), &data.settings);
        if index % LOOKED_AFTER == 0 && f64::from(result.cost) > *limit {
            break;
        }
    }
}

/// Replays as many windows as there are results, at most `N` and in lockstep.
#[inline(always)]
fn replay_all<const N: usize>(
    results: &mut [Replayed],
    replays: &Replays,
    at: impl Fn(usize) -> Option<Window>,
) {
    let Replays {
        data,
        simulator,
        limit,
        ..
    } = *replays;
    let simulators = slice::from_ref(simulator);
    let Some(mut places) = Places::<N>::new(data, results.len(), at, simulators) else {
        return;
    };
    let settings = &data.settings;
    let mut replays = [places.start(simulator)];
    let mut residuals = [([0.0; N], [0.0; N])];
    let (mut position, mut current, mut largest) = ([0.0; N], [0.0; N], [0.0; N]);
    let mut cost = [0.0; N];
    for step in 0..places.steps() {
        let so_far = || cost[..results.len()].iter().copied().map(f64::from).sum();
        if step % LOOKED_AFTER == 0 && limit < so_far() {
            break;
        }
        if places.step(&mut replays, &mut residuals).is_none() {
            continue;
        }
        let [(positions, currents)] = &residuals;
        for lane in 0..N {
            let mut replayed = Replayed {
                error: WindowError {
                    position: position[lane],
                    current: current[lane],
                    largest: largest[lane],
                },
                cost: cost[lane],
            };
            replayed.add((positions[lane], currents[lane]), settings);
            position[lane] = replayed.error.position;
            current[lane] = replayed.error.current;
            largest[lane] = replayed.error.largest;
            cost[lane] = replayed.cost;
        }
    }
    for (lane, result) in results.iter_mut().enumerate() {
        *result = Replayed {
            error: WindowError {
                position: position[lane],
                current: current[lane],
                largest: largest[lane],
            },
            cost: cost[lane],
        };
    }
}

/// What is to be done with windows.
pub trait Job: Sync {
    /// What a window gives.
    type Result: Default + Send;

    /// Steps that lead to a window. Those of one length are best worked on side by side: a short way
    /// waits for a long one.
    fn lead(&self, _number: usize) -> usize {
        0
    }

    /// Works on the windows of these numbers, in rising order and at most `N`, in lockstep; each has its
    /// result. The bits depend neither on `N` nor on what lies beside a window.
    fn work<const N: usize>(&self, numbers: &[usize], results: &mut [Self::Result]);
}

/// Who works on the windows: one core in order, or several.
pub trait Schedule {
    /// How many windows it works on at once.
    fn at_once(&self) -> usize {
        1
    }

    /// Calls `work` for 0 … `count` − 1 in any order, each time with a default result to fill in, and
    /// `fold` with the results in that order.
    fn run<R: Default + Send>(
        &self,
        count: usize,
        work: impl Fn(usize, &mut R) + Send + Sync,
        fold: impl FnMut(usize, &R),
    );

    /// The same with a job, of which several may be done in lockstep.
    fn run_job<J: Job>(&self, count: usize, job: &J, fold: impl FnMut(usize, &J::Result)) {
        let one = |number, result: &mut J::Result| {
            job.work::<1>(&[number], slice::from_mut(result));
        };
        self.run(count, one, fold);
    }
}

/// One core, in order: the chip's way.
#[derive(Debug, Clone, Copy, Default)]
pub struct InOrder;

impl Schedule for InOrder {
    fn run<R: Default + Send>(
        &self,
        count: usize,
        work: impl Fn(usize, &mut R) + Send + Sync,
        mut fold: impl FnMut(usize, &R),
    ) {
        for index in 0..count {
            let mut result = R::default();
            work(index, &mut result);
            fold(index, &result);
        }
    }
}

/// Errors of all windows, in SI units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TotalError {
    position: f64,
    current: f64,
    /// Largest position residual.
    pub largest: f32,
    /// Windows replayed.
    pub windows: usize,
    samples: usize,
}

impl TotalError {
    /// Root mean square of the position residuals; 0 without windows.
    pub fn position_rms(&self) -> f64 {
        libm::sqrt(self.position / self.samples.max(1) as f64)
    }

    /// Root mean square of the current residuals; 0 without windows or without current.
    pub fn current_rms(&self) -> f64 {
        libm::sqrt(self.current / self.samples.max(1) as f64)
    }
}

/// Replays all windows and sums their errors in the order of the log.
pub fn total_error(data: &Data, schedule: &impl Schedule, simulator: &Simulator) -> TotalError {
    let mut total = TotalError::default();
    schedule.run_job(
        data.windows(),
        &Replays::whole(data, simulator, &|number| data.window(number)),
        |_, Replayed { error, .. }| {
            total.position += f64::from(error.position);
            total.current += f64::from(error.current);
            total.largest = total.largest.max(error.largest);
            total.windows += 1;
            total.samples += data.settings.window;
        },
    );
    total
}

/// Sum of the squared weighted residuals over the windows of a fold, to the bit the first of
/// [`Sums`]' products, and how many windows these are.
pub fn cost(
    data: &Data,
    schedule: &impl Schedule,
    fold: (Fold, usize),
    simulator: &Simulator,
) -> (f64, usize) {
    let windows = data.windows_in_fold(fold);
    let window = |number| data.window(Data::number_in_fold(fold, number));
    let replays = Replays::whole(data, simulator, &window);
    (replays.cost(schedule, windows), windows)
}

/// The same cost, if it is below `limit`. Windows are left out that come after it is known not to be: none takes anything off it.
pub fn cost_below(
    limit: f64,
    data: &Data,
    schedule: &impl Schedule,
    fold: (Fold, usize),
    simulator: &Simulator,
) -> Option<f64> {
    let windows = data.windows_in_fold(fold);
    let mut cost = 0.0;
    let mut first = 0;
    while first < windows {
        let window = |number| data.window(Data::number_in_fold(fold, first + number));
        let replays = Replays {
            limit: limit * ROUNDED - cost,
            ..Replays::whole(data, simulator, &window)
        };
        let next = schedule.at_once().min(windows - first);
        replays.add_cost(schedule, next, &mut cost);
        first += next;
        if cost > limit {
            break;
        }
    }
    (cost < limit).then_some(cost)
}

/// By how much the sum over windows in the order of the log may be rounded below that of a few of them: 2⁻⁵³ for each of the
/// hundred thousand windows of the longest logs is a hundredth of it.
const ROUNDED: f64 = 1.0 + 1e-9;
