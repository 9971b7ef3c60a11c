//! From when to when an effect acts that comes and goes: the windows in a row that gain most by it.
//!
//! Every window restarts from what was measured, so that such an effect changes those windows alone in
//! which it acts. One replay with it throughout and one without it give every window's gain, and the run
//! of windows with the largest sum of gains is found while they come in, in order (J. Bentley,
//! *Programming pearls: algorithm design techniques*, 1984, after J. B. Kadane).

use super::replay::{Data, Job, MARGIN, Replayed, Replays, Schedule};
use super::simulator::Simulator;
use core::array;
use core::ops::Range;

/// The run of neighbouring gains with the largest sum.
#[derive(Debug, Clone, Default)]
struct LargestRun {
    /// Gains seen.
    count: usize,
    /// The run that ends at the last of them: its first, and its sum.
    open: (usize, f64),
    /// The best so far, and its sum.
    best: (Range<usize>, f64),
}

impl LargestRun {
    fn push(&mut self, gain: f64) {
        if self.open.1 <= 0.0 {
            self.open = (self.count, 0.0);
        }
        self.open.1 += gain;
        self.count += 1;
        if self.open.1 > self.best.1 {
            self.best = (self.open.0..self.count, self.open.1);
        }
    }
}

/// What the windows at a place in their logs gain together.
struct Gains<'a> {
    data: &'a Data<'a>,
    without: &'a Simulator,
    throughout: &'a Simulator,
}

impl Job for Gains<'_> {
    type Result = f64;

    #[inline(always)]
    fn work<const N: usize>(&self, numbers: &[usize], results: &mut [f64]) {
        for log in 0..self.data.logs.len() {
            let window = |place: usize| self.data.window_at(log, numbers[place]);
            let count = (0..results.len()).map_while(window).count();
            let gains = &mut results[..count];
            let mut before = [0.0; N];
            // A loop instead of two calls: a replay is compiled into it.
            for (simulator, last) in [(self.without, false), (self.throughout, true)] {
                let mut replayed = [Replayed::default(); N];
                let replays = Replays::whole(self.data, simulator, &window);
                let places: [usize; N] = array::from_fn(|place| place);
                replays.work::<N>(&places[..count], &mut replayed[..count]);
                for (lane, gain) in gains.iter_mut().enumerate() {
                    let cost = f64::from(replayed[lane].cost);
                    if last {
                        *gain += before[lane] - cost;
                    } else {
                        before[lane] = cost;
                    }
                }
            }
        }
    }
}

/// When the logs are followed best by acting, s since they began, at the borders of windows, and how
/// many windows were simulated for that. From the first window on it is from the beginning.
///
/// `None` inside if no window gains.
pub fn best_span(
    data: &Data,
    schedule: &impl Schedule,
    (without, throughout): (&Simulator, &Simulator),
) -> (Option<(f32, f32)>, u64) {
    let mut run = LargestRun::default();
    let gains = Gains {
        data,
        without,
        throughout,
    };
    schedule.run_job(data.longest(), &gains, |_, gain| run.push(*gain));
    let border = |window: usize| {
        let sample = MARGIN + window * data.settings.window;
        sample as f32 * data.logs[0].period
    };
    let Range { start, end } = run.best.0;
    let begin = if start == 0 { 0.0 } else { border(start) };
    let span = (end > 0).then(|| (begin, border(end)));
    (span, 2 * data.windows() as u64)
}

#[cfg(test)]
mod tests {
    use super::LargestRun;

    #[test]
    fn the_largest_run_is_that_of_a_search_through_all() {
        // Every sequence of six gains of these sizes.
        let sizes = [-2.0, -0.5, 0.0, 1.0];
        for code in 0..4_u32.pow(6) {
            let gains: [f64; 6] =
                core::array::from_fn(|place| sizes[(code >> (2 * place)) as usize % 4]);
            let mut run = LargestRun::default();
            gains.iter().for_each(|gain| run.push(*gain));
            let mut largest = 0.0;
            for start in 0..6 {
                for end in start + 1..=6 {
                    let sum: f64 = gains[start..end].iter().sum();
                    largest = sum.max(largest);
                }
            }
            let sum: f64 = gains[run.best.0].iter().sum();
            assert_eq!((sum, run.best.1), (largest, largest), "{gains:?}");
        }
    }
}
