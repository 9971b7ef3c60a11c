//! What two models predict differently, window by window.

use super::data::Data;
use super::places::Places;
use super::restart::lead;
use super::runner::{Row, Runner};
use super::{Job, WindowError};
use crate::gap::simulator::Simulator;
use core::slice;

/// What two simulations make of one window.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Contrast {
    /// Errors of the first and of the second.
    pub errors: [WindowError; 2],
    /// Sum of the squared distances between their positions.
    pub apart: f32,
}

/// Windows to be replayed by two simulators, each with its own way of restarting. Both cut the same
/// logs into the same windows.
pub(in crate::gap) struct Contrasts<'a> {
    /// The logs as the first and as the second one restarts in them.
    pub data: [&'a Data<'a>; 2],
    /// The first and the second simulator.
    pub simulators: [&'a Simulator; 2],
}

impl Job for Contrasts<'_> {
    type Result = Contrast;

    fn lead(&self, number: usize) -> usize {
        let window = self.data[0].window(number);
        let leads = self.data.iter().zip(self.simulators);
        let leads = leads.map(|(data, simulator)| {
            window.map_or(0, |window| lead(data, window, simulator.is_stateful()))
        });
        leads.max().unwrap_or(0)
    }

    #[inline(always)]
    fn work<const N: usize>(&self, numbers: &[usize], results: &mut [Contrast]) {
        if N > 1 {
            self.work_all::<N>(numbers, results);
        } else if let (Some(result), Some(&number)) = (results.first_mut(), numbers.first()) {
            self.work_one(number, result);
        }
    }
}

impl Contrasts<'_> {
    fn work_one(&self, number: usize, result: &mut Contrast) {
        let [first, second] = self.data;
        let Some(window) = first.window(number) else {
            return;
        };
        let log = &first.logs[window.log];
        let runner =
            |simulator, data: &Data| Runner::new(simulator, log, window.start, &data.settings);
        let mut runners = [
            runner(self.simulators[0], first),
            runner(self.simulators[1], second),
        ];
        for index in window.start..window.start + first.settings.window {
            let row = Row::new(log, index);
            let [one, other] = &mut runners;
            result.add([one.advance(&row), other.advance(&row)]);
        }
    }

    #[inline(always)]
    fn work_all<const N: usize>(&self, numbers: &[usize], results: &mut [Contrast]) {
        let count = results.len();
        let start = |place: usize| {
            let (data, simulator) = (self.data[place], self.simulators[place]);
            let at = |lane: usize| data.window(numbers[lane]);
            let mut places = Places::<N>::new(data, count, at, slice::from_ref(simulator))?;
            let replay = places.start(simulator);
            Some((places, [replay]))
        };
        let (Some(mut first), Some(mut second)) = (start(0), start(1)) else {
            return;
        };
        for _ in 0..self.data[0].settings.window {
            let mut residuals = [[([0.0; N], [0.0; N])]; 2];
            // Run-ins lead to the windows; of these each has as many steps.
            for ((places, replay), residual) in
                [&mut first, &mut second].into_iter().zip(&mut residuals)
            {
                while places.step(replay, residual).is_none() {}
            }
            for (lane, result) in results.iter_mut().enumerate() {
                result.add(residuals.map(|[(position, second)]| (position[lane], second[lane])));
            }
        }
    }
}

impl Contrast {
    /// Takes the residuals of a step.
    #[inline(always)]
    fn add(&mut self, residuals: [(f32, f32); 2]) {
        for (error, (position, second)) in self.errors.iter_mut().zip(residuals) {
            error.position += position * position;
            error.current += second * second;
            error.largest = error.largest.max(position.abs());
        }
        let apart = residuals[0].0 - residuals[1].0;
        self.apart += apart * apart;
    }
}
