//! From rows at uneven times to samples at even ones.
//!
//! A position, a velocity, a command, a current or a measured load is a course that was looked at: it is
//! interpolated linearly, which is right to the second order in the distance between the rows. A
//! current belongs to these because what was logged is a reading at its instant, of a winding whose
//! inductance does not let it jump. At a clearly lower rate than that of its rows it is averaged over a
//! period around each sample, lest the ripple between them is taken for a slow current.
//!
//! What the drive was told holds from its row to the next. A new interval that straddles rows gets the
//! mean over its time, which conserves the impulse: a machine with an inertia then has the speed that it
//! had. So it is with a brake. Whether the drive is enabled is decided by the larger part.

mod speeds;

use std::f64::consts::TAU;

use serde::Serialize;

use self::speeds::{Speeds, share_of_clock};
use super::{median, rounded};

/// What reading has changed in a log.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Resampling {
    /// Rows of the file.
    pub rows: usize,
    /// Largest distance of a row's time stamp from the nearest new sample, in periods, 0 to 0.5.
    pub displacement_max: f64,
    /// Root mean square of these distances, in periods. Stamps without any grid have 0.29.
    pub displacement_rms: f64,
    /// Samples that no row is nearest to: where rows are missing, they are filled in. Of stamps without a grid those
    /// in steps of more than one and a half periods.
    pub filled: usize,
    /// Rows that the one before had the same stamp as, or the same nearest sample; of stamps without a grid those of
    /// them that are less than half a period behind the one before.
    pub merged: usize,
    /// Position error that this adds, root mean square, rad or m, estimated: at each sample the parabola that a
    /// straight line between its rows cuts off, by how the speed changes around them; the displacement times the speed
    /// for that share of it which is the clock's and not the machine's; and of rows with one
    /// stamp how far each is from their mean, which takes their place.
    pub position_error: f64,
    /// The smallest step of the position in the rows, which interpolation takes out, rad or m; none where the rows
    /// are not made of such steps.
    #[serde(skip)]
    pub position_step: Option<f64>,
}

impl Resampling {
    /// Of both changes, this one after another: errors add as squares, the rest as it is.
    pub(super) fn after(&self, before: &Self) -> Self {
        Self {
            rows: before.rows,
            displacement_max: self.displacement_max.max(before.displacement_max),
            displacement_rms: self.displacement_rms.hypot(before.displacement_rms),
            filled: self.filled + before.filled,
            merged: self.merged + before.merged,
            position_error: self.position_error.hypot(before.position_error),
            position_step: before.position_step.or(self.position_step),
        }
    }
}

/// Samples at even times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Instants {
    /// Time of the first sample after the first row, s.
    pub start: f64,
    /// Distance of the samples, s.
    pub period: f64,
    /// How many there are.
    pub count: usize,
    /// Whether the rows lie near some grid, so that those which are missing can be told from a clock that wanders.
    has_grid: bool,
}

/// How much worse than the best period's a displacement may be for a rounder number, in periods.
const ROUNDER: f64 = 0.005;

/// Displacement, rms, from which on the stamps have no grid, in periods. Without any it is 1/√12 = 0.29.
const NO_GRID: f64 = 0.2;

/// The same from which on no period is any nearer to the stamps than another.
const NO_PERIOD: f64 = 0.25;

/// Distance of a sample from a row below which they are the same, in periods. Sums of stamps in `f64`
/// err by less in any log that fits into memory.
const SAME: f64 = 1e-6;

/// How far beyond the first and the last row a sample may lie, in periods: the tolerance of an even log.
const BEYOND: f64 = 0.01;

impl Instants {
    /// For rows at these times after the first one, s, which increase.
    ///
    /// The period is the median step, which neither gaps nor repeated rows move, or the slope of the
    /// stamps over the periods counted between them, whichever is nearer to the stamps; of numbers
    /// that do as well the roundest in Hz or s, which is most likely what the logger was set to. Stamps
    /// without a grid are those of a loop that takes now a little longer, now a little less: it has as many
    /// samples as rows, so the period is the mean step ([`mean_step`]).
    pub fn of(time: &[f64]) -> Self {
        match Self::grid(time) {
            Ok((period, phase)) => Self::covering(time, period, phase, true),
            // That of the first row is as good as any phase.
            Err(period) => Self::covering(time, period, 0.0, false),
        }
    }

    /// Period and phase of the grid that rows at these times lie near. Where there is none the period alone: the one that
    /// the stamps are nearest to, or the mean of their steps.
    fn grid(time: &[f64]) -> Result<(f64, f64), f64> {
        let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let median = median(&steps);
        let starts = [median, slope(time, median)];
        let round = (3..=6).flat_map(|digits| {
            let rounds =
                move |start: f64| [1.0 / rounded(1.0 / start, digits), rounded(start, digits)];
            starts.into_iter().flat_map(rounds)
        });
        let candidates: Vec<(f64, Displacement)> = round
            .chain(starts)
            .map(|period| (period, Displacement::of(time, period)))
            .collect();
        let least = candidates
            .iter()
            .fold(f64::INFINITY, |least, (_, there)| least.min(there.rms));
        let chosen = candidates
            .iter()
            .find(|(_, there)| there.rms <= least + ROUNDER);
        match chosen {
            Some((period, there)) if there.rms < NO_GRID => Ok((*period, there.phase)),
            Some((period, there)) if there.rms < NO_PERIOD => Err(*period),
            Some(_) => Err(mean_step(&steps, median)),
            // Stamps beyond all bounds have no displacement that is a number.
            None => Err(median),
        }
    }

    /// At this period, the first sample at the first row.
    pub fn with_period(time: &[f64], period: f64) -> Self {
        Self::covering(time, period, 0.0, Self::grid(time).is_ok())
    }

    /// All samples between the first and the last row that are `phase` periods after a multiple of the
    /// period.
    fn covering(time: &[f64], period: f64, phase: f64, has_grid: bool) -> Self {
        let last = time[time.len() - 1] / period;
        let first = (-phase - BEYOND).ceil();
        let count = (last - phase + BEYOND).floor() - first + 1.0;
        let start = phase + first;
        Self {
            start: if start.abs() < SAME {
                0.0
            } else {
                rounded(start * period, 12)
            },
            period,
            count: count.max(0.0) as usize,
            has_grid,
        }
    }

    fn time(&self, sample: usize) -> f64 {
        self.start + sample as f64 * self.period
    }

    fn times(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.count).map(|sample| self.time(sample))
    }

    /// A course that was looked at in the rows, interpolated linearly.
    pub fn interpolated(&self, time: &[f64], values: &[f64]) -> Vec<f64> {
        let mut row = 0;
        let value = |instant: f64| {
            while row + 2 < time.len() && time[row + 1] <= instant {
                row += 1;
            }
            let share = (instant - time[row]) / (time[row + 1] - time[row]);
            let near = SAME * self.period;
            if (instant - time[row]).abs() < near {
                values[row]
            } else if (instant - time[row + 1]).abs() < near {
                values[row + 1]
            } else {
                values[row] + share * (values[row + 1] - values[row])
            }
        };
        self.times().map(value).collect()
    }

    /// The mean of a course that was looked at in the rows, over a period around each sample: what a
    /// slower logger with a filter would have seen. Nothing is delayed by it.
    pub fn averaged(&self, time: &[f64], values: &[f64]) -> Vec<f64> {
        let rows = time.len();
        let mut integral = vec![0.0; rows];
        for row in 1..rows {
            let mean = 0.5 * (values[row - 1] + values[row]);
            integral[row] = integral[row - 1] + mean * (time[row] - time[row - 1]);
        }
        let until = |instant: f64| {
            let row = time.partition_point(|t| *t <= instant).clamp(1, rows - 1) - 1;
            let since = instant - time[row];
            let slope = (values[row + 1] - values[row]) / (time[row + 1] - time[row]);
            integral[row] + since * (values[row] + 0.5 * slope * since)
        };
        let mean = |instant: f64| {
            let from = (instant - self.period / 2.0).max(time[0]);
            let to = (instant + self.period / 2.0).min(time[rows - 1]);
            (until(to) - until(from)) / (to - from)
        };
        self.times().map(mean).collect()
    }

    /// The mean over each sample's time of what holds from its row to the next.
    pub fn held(&self, time: &[f64], values: &[f64]) -> Vec<f64> {
        let mut row = 0;
        let near = SAME * self.period;
        let mean = |from: f64| {
            let to = from + self.period;
            while row + 1 < time.len() && time[row + 1] <= from + near {
                row += 1;
            }
            let one_row = time.get(row + 1).is_none_or(|&next| next >= to - near);
            if one_row {
                return values[row];
            }
            let mut sum = 0.0;
            let mut since = from;
            let mut holding = row;
            while holding + 1 < time.len() && time[holding + 1] < to {
                sum += values[holding] * (time[holding + 1] - since);
                since = time[holding + 1];
                holding += 1;
            }
            (sum + values[holding] * (to - since)) / self.period
        };
        self.times().map(mean).collect()
    }

    /// 0 or 1, whichever held for the larger part of each sample's time.
    pub fn switched(&self, time: &[f64], values: &[f64]) -> Vec<f64> {
        let means = self.held(time, values);
        means
            .into_iter()
            .map(|mean| f64::from(u8::from(mean >= 0.5)))
            .collect()
    }

    /// How many samples were filled into a step between two rows.
    pub fn filled_in(&self, step: f64) -> usize {
        ((step / self.period).round() as usize).saturating_sub(1)
    }

    /// Whether each sample is one that no row is nearest to; nothing where there is none such.
    pub fn without_row(&self, time: &[f64]) -> Vec<bool> {
        let nearest = |time: f64| ((time - self.start) / self.period).round() as usize;
        let mut without = vec![false; self.count];
        for pair in time.windows(2) {
            let first = nearest(pair[0]) + 1;
            let behind = nearest(pair[1])
                .min(first + self.filled_in(pair[1] - pair[0]))
                .min(self.count);
            if first < behind {
                without[first..behind].fill(true);
            }
        }
        if !without.contains(&true) {
            without.clear();
        }
        without
    }

    /// What the change from these rows to these samples amounts to.
    pub fn summary(&self, time: &[f64], position: &[f64]) -> Resampling {
        let places: Vec<f64> = time
            .iter()
            .map(|t| (t - self.start) / self.period)
            .collect();
        let displacement = |row: usize| {
            let distance = (places[row] - places[row].round()).abs();
            if distance < SAME { 0.0 } else { distance }
        };
        let rows = 0..time.len();
        let last = time.len() - 1;
        // Samples between those that are nearest to two neighbours.
        let nearest = |row: usize| places[row].round();
        let between = |row: usize| (nearest(row + 1) - nearest(row) - 1.0).max(0.0) as usize;
        let is_shared = |row: &usize| nearest(*row + 1) - nearest(*row) < 0.5;
        let step = |row: usize| time[row + 1] - time[row];
        // Without a grid a sample is nearest to no row, or to two, by chance; the step between the rows has to say so too.
        let filled = |row: usize| {
            if self.has_grid {
                between(row)
            } else {
                between(row).min(self.filled_in(step(row)))
            }
        };
        let is_merged =
            |row: &usize| is_shared(row) && (self.has_grid || step(*row) < 0.5 * self.period);
        let clock = share_of_clock(time, position, self.period);
        let speeds = Speeds {
            time,
            position,
            period: self.period,
        };
        let shifted = rows.clone().map(|row| {
            let around = speeds.around(row).unwrap_or(0.0);
            (clock * displacement(row) * self.period * around).powi(2)
        });
        let squares = shifted.sum::<f64>() + self.cut_off(&speeds);
        Resampling {
            rows: time.len(),
            displacement_max: rows.clone().map(displacement).fold(0.0, f64::max),
            displacement_rms: (rows.map(|row| displacement(row).powi(2)).sum::<f64>()
                / time.len() as f64)
                .sqrt(),
            filled: (0..last).map(filled).sum(),
            merged: (0..last).filter(is_merged).count(),
            position_error: (squares / self.count.max(1) as f64).sqrt(),
            position_step: smallest_step(position),
        }
    }

    /// Sum over all samples of the square of what a straight line between two rows cuts off there of the parabola that
    /// the speeds before and behind them make.
    fn cut_off(&self, speeds: &Speeds) -> f64 {
        let time = speeds.time;
        let mut squares = 0.0;
        let mut row = 0;
        let mut curvature = speeds.curvature(0);
        for instant in self.times() {
            while row + 2 < time.len() && time[row + 1] <= instant {
                row += 1;
                curvature = speeds.curvature(row);
            }
            let (since, until) = (instant - time[row], time[row + 1] - instant);
            // Beyond the first and the last row lies nothing that could be cut off.
            if since > 0.0 && until > 0.0 {
                squares += (0.5 * since * until * curvature.unwrap_or(0.0)).powi(2);
            }
        }
        squares
    }
}

/// Mean of the steps that are within half of the usual one: gaps and repeated rows are none of the clock's steps. To three
/// digits in Hz, which is more than such a clock keeps.
fn mean_step(steps: &[f64], median: f64) -> f64 {
    let mut mean = median;
    // A second time around the mean itself: the median of a loop that is mostly on time is its shortest step.
    for _ in 0..2 {
        let near = steps.iter().filter(|step| (*step / mean - 1.0).abs() < 0.5);
        let (sum, count) = near.fold((0.0, 0.0), |(sum, count), step| (sum + step, count + 1.0));
        if count > 0.0 {
            mean = sum / count;
        }
    }
    1.0 / rounded(1.0 / mean, 3)
}

/// The smallest step of a position sensor, where the position is made of such steps.
pub(crate) fn smallest_step(position: &[f64]) -> Option<f64> {
    let steps = || position.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let largest = steps().fold(0.0, f64::max);
    let apart = |step: &f64| *step > 1e-7 * largest;
    let smallest = steps().filter(apart).fold(f64::INFINITY, f64::min);
    let (mut whole, mut count) = (0, 0);
    for step in steps().filter(apart) {
        let counts = step / smallest;
        // Beyond twenty, printed digits and the unit's own rounding blur what is left over.
        if counts < 20.0 {
            count += 1;
            whole += usize::from((counts - counts.round()).abs() < 0.05);
        }
    }
    (count >= 20 && whole as f64 >= 0.95 * f64::from(count)).then_some(smallest)
}

/// Least-squares slope of time stamps over the periods between them, each step rounded to whole ones.
fn slope(time: &[f64], period: f64) -> f64 {
    let mut counted = 0.0;
    let mut before = time[0];
    let counts: Vec<f64> = time
        .iter()
        .map(|&t| {
            counted += ((t - before) / period).round();
            before = t;
            counted
        })
        .collect();
    let rows = time.len() as f64;
    let middle = counts.iter().sum::<f64>() / rows;
    let moment: f64 = counts.iter().zip(time).map(|(c, t)| (c - middle) * t).sum();
    let squares: f64 = counts.iter().map(|c| (c - middle).powi(2)).sum();
    moment / squares
}

/// How far stamps lie from a grid of some period, in periods.
struct Displacement {
    /// Place of the grid that is nearest to the stamps, −0.5 to 0.5.
    phase: f64,
    rms: f64,
}

impl Displacement {
    fn of(time: &[f64], period: f64) -> Self {
        let (sine, cosine) = time
            .iter()
            .map(|t| (TAU * (t / period)).sin_cos())
            .fold((0.0, 0.0), |(s, c), (sine, cosine)| (s + sine, c + cosine));
        let mean = f64::atan2(sine, cosine) / TAU;
        let strays: Vec<f64> = time
            .iter()
            .map(|t| t / period - mean)
            .map(|place| place - place.round())
            .collect();
        // The median from there: where most stamps are on a grid these stay where they are.
        let middle = median(&strays);
        let phase = mean + middle;
        let squares: f64 = strays.iter().map(|stray| (stray - middle).powi(2)).sum();
        Self {
            phase,
            rms: (squares / time.len() as f64).sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2,000 rows at 1 kHz whose stamps scatter by up to three tenths of a period.
    fn jittered() -> Vec<f64> {
        let scatter = |row: f64| 0.3 * (2.4 * row).sin();
        let first = scatter(0.0);
        (0..2_000)
            .map(f64::from)
            .map(|row| (row + scatter(row) - first) * 1e-3)
            .collect()
    }

    #[test]
    fn the_period_is_that_of_the_clock() {
        let instants = Instants::of(&jittered());
        assert_eq!(instants.period, 1e-3);
        assert!(instants.start.abs() < 0.31e-3, "{instants:?}");
        // A tenth of the rows missing, a tenth of them twice within a period.
        let ragged: Vec<f64> = (0..1_000)
            .filter(|row| row % 10 != 7)
            .flat_map(|row| {
                let stamp = f64::from(row) * 2e-3;
                let twice = (row % 10 == 3).then_some(stamp + 0.4e-3);
                [Some(stamp), twice].into_iter().flatten()
            })
            .collect();
        let instants = Instants::of(&ragged);
        assert_eq!((instants.period, instants.count), (2e-3, 1_000));
        let summary = instants.summary(&ragged, &vec![0.0; ragged.len()]);
        assert_eq!((summary.filled, summary.merged), (100, 100));
    }

    /// Stamps that wander off any grid keep the rate to three digits.
    #[test]
    fn without_a_grid_the_mean_counts() {
        let mut stamp = 0.0;
        let wandering: Vec<f64> = (0..3_000)
            .map(|row| {
                let here = stamp;
                stamp += 5.3e-3 * (1.0 + 0.04 * (1.7 * f64::from(row)).sin().powi(3));
                here
            })
            .collect();
        let instants = Instants::of(&wandering);
        assert!(
            (instants.period / 5.3e-3 - 1.0).abs() < 0.01,
            "{instants:?}"
        );
    }

    /// 4,000 rows of a loop of 5 ms that is often a millisecond or two late: 5.375 ms in the mean.
    fn late_loop() -> Vec<f64> {
        let mut random = 1_u32;
        let mut stamp = 0;
        let rows = (0..4_000).map(|_| {
            let here = f64::from(stamp) * 1e-3;
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            stamp += [4, 5, 5, 5, 5, 6, 6, 7][(random >> 24) as usize % 8];
            here
        });
        rows.collect()
    }

    /// How far the interpolated course is from the true one, rms.
    fn true_error(
        instants: &Instants,
        time: &[f64],
        seen: &[f64],
        course: impl Fn(f64) -> f64,
    ) -> f64 {
        let samples = instants.times().zip(instants.interpolated(time, seen));
        let squares = samples.map(|(t, value)| (value - course(t)).powi(2));
        (squares.sum::<f64>() / instants.count as f64).sqrt()
    }

    /// No row of a loop that is often late is missing, and none is too many.
    #[test]
    fn a_loop_that_is_often_late_misses_no_row() {
        let time = late_loop();
        let instants = Instants::of(&time);
        let mean = time[time.len() - 1] / (time.len() - 1) as f64;
        assert!((instants.period / mean - 1.0).abs() < 0.004, "{instants:?}");
        assert!(instants.count.abs_diff(time.len()) < 16, "{instants:?}");
        let course = |t: f64| (9.0 * t).sin();
        let seen: Vec<f64> = time.iter().map(|t| course(*t)).collect();
        let summary = instants.summary(&time, &seen);
        assert_eq!((summary.filled, summary.merged), (0, 0));
        let error = true_error(&instants, &time, &seen, course);
        assert!(
            (summary.position_error / error - 1.0).abs() < 0.2,
            "{summary:?} {error}"
        );
        // Three rows are lost at twenty places: steps of 16 to 28 ms, four periods of the mean.
        let lost = |row: &usize| (100..103).contains(&(row % 200));
        let rest: Vec<usize> = (0..time.len()).filter(|row| !lost(row)).collect();
        let time: Vec<f64> = rest.iter().map(|&row| time[row]).collect();
        let seen: Vec<f64> = rest.iter().map(|&row| seen[row]).collect();
        let instants = Instants::of(&time);
        let summary = instants.summary(&time, &seen);
        assert!(summary.filled.abs_diff(60) <= 10, "{summary:?}");
        assert_eq!(summary.merged, 0);
        let error = true_error(&instants, &time, &seen, course);
        assert!(
            (summary.position_error / error - 1.0).abs() < 0.3,
            "{summary:?} {error}"
        );
    }

    /// A sensor's counts are its own error, and none that resampling adds.
    #[test]
    fn counts_of_a_sensor_under_jitter_stay_below_a_count() {
        let count = 1.4e-3;
        let time = late_loop();
        let seen: Vec<f64> = time
            .iter()
            .map(|t| ((9.0 * t).sin() / count).round() * count)
            .collect();
        let summary = Instants::of(&time).summary(&time, &seen);
        // The interpolation alone, as in the test above, adds some 0.2 mrad.
        assert!(summary.position_error < 0.3e-3, "{summary:?}");
    }

    /// Two rows a microsecond apart, with a count of the sensor between them, are no high speed: beside the gap before
    /// them neither.
    #[test]
    fn rows_that_all_but_repeat_a_stamp_cost_no_more() {
        let count = 1e-3;
        let course = |t: f64| (0.5 * t / count).round() * count;
        let even: Vec<f64> = (0..1_000).map(|row| f64::from(row) * 2e-3).collect();
        let mut time: Vec<f64> = (even.iter().copied())
            .filter(|t| !(1.0..1.006).contains(t))
            .collect();
        let behind = time.partition_point(|t| *t < 1.005) + 1;
        time.insert(behind, time[behind - 1] + 1e-6);
        let mut position: Vec<f64> = time.iter().map(|t| course(*t)).collect();
        position[behind] += count;
        let summary = Instants::of(&time).summary(&time, &position);
        assert_eq!((summary.filled, summary.merged), (3, 1));
        // The motion is a straight line: what a gap adds is within the sensor's steps.
        assert!(
            summary.position_error < count / 12_f64.sqrt(),
            "{summary:?}"
        );
    }

    /// Linear interpolation of a sine errs by ω²h²/8 at most, h being the widest step.
    #[test]
    fn a_sine_under_jitter_is_recovered_to_the_second_order() {
        let time = jittered();
        let omega = 40.0;
        let course: Vec<f64> = time.iter().map(|t| (omega * t).sin()).collect();
        let instants = Instants::of(&time);
        let widest = time.windows(2).map(|pair| pair[1] - pair[0]);
        let widest = widest.fold(0.0, f64::max);
        let bound = (omega * widest).powi(2) / 8.0;
        for (t, value) in instants.times().zip(instants.interpolated(&time, &course)) {
            // Beyond the last row a line is extended, by a hundredth of a period.
            assert!((value - (omega * t).sin()).abs() < 1.1 * bound, "{t}");
        }
        let summary = instants.summary(&time, &course);
        let error = true_error(&instants, &time, &course, |t| (omega * t).sin());
        assert!(
            (summary.position_error / error - 1.0).abs() < 0.1,
            "{summary:?} {error}"
        );
        // Where the machine was looked at evenly and only the stamps scatter, the samples err by the first order.
        let seen: Vec<f64> = (0..time.len())
            .map(|row| (omega * row as f64 * 1e-3).sin())
            .collect();
        let by_clock = instants.summary(&time, &seen);
        let expected = (0.3 / 2_f64.sqrt()) * 1e-3 * omega / 2_f64.sqrt();
        assert!(
            (by_clock.position_error / expected - 1.0).abs() < 0.1,
            "{by_clock:?} {expected}"
        );
        assert!((summary.displacement_rms / (0.3 / 2_f64.sqrt()) - 1.0).abs() < 0.02);
        assert_eq!((summary.filled, summary.merged), (0, 0));
    }

    #[test]
    fn the_impulse_of_a_held_input_is_conserved() {
        let time = jittered();
        let input: Vec<f64> = (0..time.len())
            .map(|row| f64::from((row * row % 13) as u32) - 6.0)
            .collect();
        for instants in [
            Instants::of(&time),
            Instants::with_period(&time, 2.7e-3),
            Instants::with_period(&time, 0.8e-3),
        ] {
            let held = instants.held(&time, &input);
            // Against the integral of the steps, at the end of every sample.
            let integral = |to: f64| -> f64 {
                let until = |row: usize| time.get(row + 1).map_or(to, |next| next.min(to));
                let last = time.iter().rposition(|t| *t <= to).unwrap_or(0);
                (0..=last)
                    .map(|row| input[row] * (until(row) - time[row]))
                    .sum()
            };
            let start = integral(instants.start.max(0.0)) + input[0] * instants.start.min(0.0);
            let mut sum = 0.0;
            for (sample, value) in held.iter().enumerate() {
                sum += value * instants.period;
                let expected = integral(instants.time(sample + 1)) - start;
                assert!((sum - expected).abs() < 1e-9, "{sample}: {sum} {expected}");
            }
        }
    }

    /// The mean of a straight line is its middle, and that of a ripple of one period is nothing.
    #[test]
    fn a_current_loses_its_ripple_and_keeps_its_time() {
        let time: Vec<f64> = (0..2_001).map(|row| f64::from(row) * 1e-4).collect();
        let course: Vec<f64> = (0..2_001)
            .map(|row| 3.0 * f64::from(row) * 1e-4 + if row % 10 < 5 { 1.0 } else { -1.0 })
            .collect();
        let instants = Instants::with_period(&time, 1e-3);
        let averaged = instants.averaged(&time, &course);
        // At both ends half a period is missing.
        for (t, value) in instants.times().zip(&averaged).skip(1).take(198) {
            assert!((value - 3.0 * t).abs() < 1e-9, "{t}: {value}");
        }
        let looked_at = instants.interpolated(&time, &course);
        assert!((looked_at[100] - averaged[100]).abs() > 0.9);
    }

    #[test]
    fn a_switch_stays_a_switch() {
        let time = [0.0, 1.0, 2.3, 3.6, 5.0];
        let instants = Instants::with_period(&time, 1.0);
        let switched = instants.switched(&time, &[1.0, 0.0, 0.0, 1.0, 1.0]);
        assert_eq!(switched, [1.0, 0.0, 0.0, 0.0, 1.0, 1.0]);
    }
}
