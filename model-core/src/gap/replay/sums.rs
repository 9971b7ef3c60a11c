//! The least-squares sums of a model and its copies over the windows of a fold.

use super::data::{Data, Fold, Window};
use super::places::{Places, Replay};
use super::restart::{Restart, RunIn, lead};
use super::runner::{Row, Runner};
use super::{Job, Schedule};
use crate::gap::ensemble::{COLUMNS, Ensemble, MOST_SIMULATORS, Source};
use crate::gap::held::Varied;
use crate::gap::simulator::Simulator;
use crate::numeric::triangle::{Triangle, entries};
use crate::plant::modes::Modes;
use heapless::Vec;

/// Products of the columns, summed over one window.
pub type WindowSums = Triangle<f32, { entries(COLUMNS) }>;

/// Replays one window with the model and its perturbed copies and adds the products of
/// (residual, sensitivities) to the sums.
pub(super) fn accumulate(sums: &mut WindowSums, data: &Data, window: Window, ensemble: &Ensemble) {
    let log = &data.logs[window.log];
    let settings = &data.settings;
    let simulators = ensemble.simulators();
    let is_stateful = simulators.iter().any(Simulator::is_stateful);
    let mut restart = Restart::new(log, window.start, settings, is_stateful);
    let mut shared = RunIn::default();
    let mut runners: Vec<Runner<&Modes, Varied>, MOST_SIMULATORS> = simulators
        .iter()
        .map(|simulator| {
            let model = ensemble.shared_run_in();
            let mut own = RunIn::default();
            let run_in = if model.is_some_and(|model| simulator.runs_in_like(model)) {
                &mut shared
            } else {
                &mut own
            };
            Runner::from_restart(simulator, log, &mut restart, settings, run_in)
        })
        .collect();
    let mut positions = [0.0f32; COLUMNS];
    let mut currents = [0.0f32; COLUMNS];
    let columns = ensemble.lanes().len() + 1;
    let sensor = ensemble.current_sensor();
    let late = ensemble.reads_within_steps();
    let mut last = 0.0;
    for index in window.start..window.start + settings.window {
        let row = Row::new(log, index);
        let mut residuals = runners
            .iter_mut()
            .map(|runner| runner.advance_and_see(&row));
        let mut next = || residuals.next().unwrap_or_default();
        let (centre, (seen, rise)) = next();
        let before = core::mem::replace(&mut last, rise);
        let seen = (seen, if late { rise } else { before });
        positions[0] = centre.0 * settings.position_weight;
        currents[0] = centre.1 * settings.current_weight;
        for (column, lane) in ensemble.lanes().iter().enumerate() {
            let (position, current) = (&mut positions[column + 1], &mut currents[column + 1]);
            match lane.source {
                Source::Copies {
                    two_sided,
                    inverse_step,
                } => {
                    let moved = next().0;
                    let from = if two_sided { next().0 } else { centre };
                    *position = (moved.0 - from.0) * settings.position_weight * inverse_step;
                    *current = (moved.1 - from.1) * settings.current_weight * inverse_step;
                }
                Source::Sensor { reading, scale } => {
                    *position = 0.0;
                    *current = if log.current.is_some() {
                        sensor.slope(reading, seen) * settings.current_weight * scale
                    } else {
                        0.0
                    };
                }
            }
        }
        let with_current = settings.current_weight > 0.0;
        for (column, sums) in sums.rows_mut().take(columns).enumerate() {
            let (position, current) = (positions[column], currents[column]);
            let add = |sums: &mut [f32], first: usize| {
                let others = (&positions[first..], &currents[first..]);
                if with_current {
                    add_products(sums, (position, current), others);
                } else {
                    add_position_products(sums, position, others.0);
                }
            };
            let (before, own) = ensemble.partners(column);
            add(&mut sums[own..], own);
            if before > 0 {
                add(&mut sums[..before], 0);
            }
        }
    }
}

/// Adds the products of both channels: position first.
#[inline]
pub(super) fn add_products(
    sums: &mut [f32],
    (position, current): (f32, f32),
    (positions, currents): (&[f32], &[f32]),
) {
    for (sum, (other, flow)) in sums.iter_mut().zip(positions.iter().zip(currents)) {
        *sum = *sum + position * other + current * flow;
    }
}

#[inline]
pub(super) fn add_position_products(sums: &mut [f32], position: f32, positions: &[f32]) {
    for (sum, other) in sums.iter_mut().zip(positions) {
        *sum += position * other;
    }
}

/// The sums of windows.
pub(super) struct Accumulate<'a> {
    data: &'a Data<'a>,
    fold: (Fold, usize),
    ensemble: &'a Ensemble<'a>,
}

impl Accumulate<'_> {
    fn window(&self, number: usize) -> Option<Window> {
        self.data.window(Data::number_in_fold(self.fold, number))
    }
}

impl Job for Accumulate<'_> {
    type Result = WindowSums;

    fn lead(&self, number: usize) -> usize {
        let simulators = self.ensemble.simulators();
        let is_stateful = simulators.iter().any(Simulator::is_stateful);
        let window = self.window(number);
        window.map_or(0, |window| lead(self.data, window, is_stateful))
    }

    #[inline(always)]
    fn work<const N: usize>(&self, numbers: &[usize], results: &mut [WindowSums]) {
        let at = |place: usize| self.window(numbers[place]);
        if N > 1 {
            accumulate_all::<N>(results, self.data, at, self.ensemble);
        } else if let (Some(sums), Some(window)) = (results.first_mut(), at(0)) {
            accumulate(sums, self.data, window, self.ensemble);
        }
    }
}

/// As [`accumulate`], in several windows.
#[inline(always)]
pub(super) fn accumulate_all<const N: usize>(
    results: &mut [WindowSums],
    data: &Data,
    at: impl Fn(usize) -> Option<Window>,
    ensemble: &Ensemble,
) {
    let simulators = ensemble.simulators();
    let Some(mut places) = Places::<N>::new(data, results.len(), at, simulators) else {
        return;
    };
    let settings = &data.settings;
    let mut replays: Vec<Replay<&Modes, Varied, N>, MOST_SIMULATORS> = simulators
        .iter()
        .map(|simulator| places.start(simulator))
        .collect();
    if let Some(model) = ensemble.shared_run_in() {
        for replay in replays.iter_mut().skip(1) {
            replay.follow(model);
        }
    }
    let mut positions = [[0.0f32; N]; COLUMNS];
    let mut currents = [[0.0f32; N]; COLUMNS];
    let mut sums = [[0.0f32; N]; entries(COLUMNS)];
    let mut residuals = [([0.0f32; N], [0.0f32; N]); MOST_SIMULATORS];
    let columns = ensemble.lanes().len() + 1;
    let (position_weight, current_weight) = (settings.position_weight, settings.current_weight);
    let with_current = current_weight > 0.0;
    let sensor = ensemble.current_sensor();
    let measured = places.measured_current();
    let late = ensemble.reads_within_steps();
    let mut last = [0.0; N];
    for _ in 0..places.steps() {
        let Some((seen, rises)) = places.step(&mut replays, &mut residuals) else {
            continue;
        };
        let before = core::mem::replace(&mut last, rises);
        let rises = if late { rises } else { before };
        let mut next = 1;
        let centre = &residuals[0];
        for lane in 0..N {
            positions[0][lane] = centre.0[lane] * position_weight;
            currents[0][lane] = centre.1[lane] * current_weight;
        }
        for (column, perturbed) in ensemble.lanes().iter().enumerate() {
            let (position, current) = (&mut positions[column + 1], &mut currents[column + 1]);
            match perturbed.source {
                Source::Copies {
                    two_sided,
                    inverse_step,
                } => {
                    let moved = &residuals[next];
                    let from = if two_sided {
                        &residuals[next + 1]
                    } else {
                        centre
                    };
                    next += 1 + usize::from(two_sided);
                    for lane in 0..N {
                        position[lane] =
                            (moved.0[lane] - from.0[lane]) * position_weight * inverse_step;
                        current[lane] =
                            (moved.1[lane] - from.1[lane]) * current_weight * inverse_step;
                    }
                }
                Source::Sensor { reading, scale } => {
                    for lane in 0..N {
                        position[lane] = 0.0;
                        current[lane] = if measured[lane] {
                            sensor.slope(reading, (seen[lane], rises[lane]))
                                * current_weight
                                * scale
                        } else {
                            0.0
                        };
                    }
                }
            }
        }
        for column in 0..columns {
            let (before, own) = ensemble.partners(column);
            let (position, current) = (positions[column], currents[column]);
            let sums = &mut sums[entries(column)..];
            for other in 0..=column {
                if other >= before && other < own {
                    continue;
                }
                let (positions, currents) = (&positions[other], &currents[other]);
                let sum = &mut sums[other];
                for lane in 0..N {
                    sum[lane] += position[lane] * positions[lane];
                }
                if with_current {
                    for lane in 0..N {
                        sum[lane] += current[lane] * currents[lane];
                    }
                }
            }
        }
    }
    for (lane, result) in results.iter_mut().enumerate() {
        for (column, row) in result.rows_mut().take(columns).enumerate() {
            for (sum, lanes) in row.iter_mut().zip(&sums[entries(column)..]) {
                *sum = lanes[lane];
            }
        }
    }
}

/// Least-squares sums over the windows of a fold.
#[derive(Debug, Clone, Default)]
pub struct Sums {
    /// Products of the columns; 0 is the residual.
    pub products: Triangle<f64, { entries(COLUMNS) }>,
    /// Windows that took part.
    pub windows: usize,
}

/// Replays the windows of a fold with a model and its copies. `observe` is told the sums of each
/// window, in the order of the log.
pub fn replay_windows(
    data: &Data,
    schedule: &impl Schedule,
    fold: (Fold, usize),
    ensemble: &Ensemble,
    mut observe: impl FnMut(&WindowSums),
) {
    let job = Accumulate {
        data,
        fold,
        ensemble,
    };
    schedule.run_job(data.windows_in_fold(fold), &job, |_, sums| observe(sums));
}

impl Sums {
    /// Replays the windows of a fold and sums them up in the order of the log.
    pub fn replay(
        &mut self,
        data: &Data,
        schedule: &impl Schedule,
        fold: (Fold, usize),
        ensemble: &Ensemble,
    ) {
        *self = Self::default();
        replay_windows(data, schedule, fold, ensemble, |window| {
            self.add(window, ensemble);
        });
    }

    fn add(&mut self, window: &WindowSums, ensemble: &Ensemble) {
        self.windows += 1;
        for row in 0..=ensemble.lanes().len() {
            let (before, own) = ensemble.partners(row);
            let products = self.products.row_mut(row);
            for partners in [0..before, own..row + 1] {
                for column in partners {
                    products[column] += f64::from(window.row(row)[column]);
                }
            }
        }
    }

    /// Windows simulated, each copy counted.
    pub fn simulated(&self, ensemble: &Ensemble) -> u64 {
        self.windows as u64 * ensemble.simulators().len() as u64
    }
}
