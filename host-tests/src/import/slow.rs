//! A column of a slow sensor in a table of fast rows: it has a number in every n-th row, and blank cells between.

use super::raw::Raw;
use super::source::Source;
use crate::log::{COLUMNS, Course};

/// Share of the steps from one number to the next that are as long as the usual one, within a row.
const REGULAR: f64 = 0.9;

/// Fewest numbers of such a column.
const LEAST: usize = 8;

/// Most usual steps that may lie between two numbers with what is between them filled in: a sensor misses a reading now and then.
const LONGEST: usize = 3;

/// Such a column of a file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Slow {
    /// Its place in the file.
    pub column: usize,
    /// Rows from one number to the next, usually.
    pub every: usize,
    /// Rows that have a number.
    pub rows: usize,
    /// Of each row of the file, from 0, what becomes of its blank cell.
    blanks: Vec<Blank>,
}

/// What becomes of a blank cell of a slow column.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Blank {
    /// It is a fault, as any blank cell: no number is near.
    Fault,
    /// It lies between two numbers, and is interpolated.
    Filled,
    /// It lies before the first number or behind the last one, where nothing was measured: its row is left out.
    LeftOut,
}

impl Slow {
    /// The column that this source of a column of the log reads, if it is one of those in these rows.
    pub fn find(raw: &Raw, index: usize, source: &Source, rows: &[usize]) -> Option<Self> {
        if COLUMNS[index].1 != Course::Seen {
            return None;
        }
        let values = &raw.columns[source.column].values;
        let has: Vec<usize> = (0..rows.len())
            .filter(|&place| !values[rows[place]].is_nan())
            .collect();
        let mut steps: Vec<usize> = has.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_unstable();
        let every = steps.get(steps.len() / 2).copied()?;
        let regular = steps
            .iter()
            .filter(|step| step.abs_diff(every) <= 1)
            .count();
        if has.len() < LEAST || every < 2 || (regular as f64) < REGULAR * steps.len() as f64 {
            return None;
        }
        let mut blanks = vec![Blank::Fault; values.len()];
        for pair in has
            .windows(2)
            .filter(|pair| pair[1] - pair[0] <= LONGEST * every)
        {
            rows[pair[0] + 1..pair[1]]
                .iter()
                .for_each(|&row| blanks[row] = Blank::Filled);
        }
        let (first, last) = (has[0], has[has.len() - 1]);
        let ends =
            (first.saturating_sub(every)..first).chain(last + 1..rows.len().min(last + 1 + every));
        ends.for_each(|place| blanks[rows[place]] = Blank::LeftOut);
        Some(Self {
            column: source.column,
            every,
            rows: has.len(),
            blanks,
        })
    }

    /// Whether the blank cell of this row gets a number.
    pub fn fills(&self, row: usize) -> bool {
        self.blanks[row] == Blank::Filled
    }

    /// Whether this row lies before the first number or behind the last one, within a usual step.
    pub fn is_beyond(&self, row: usize) -> bool {
        self.blanks[row] == Blank::LeftOut
    }
}

/// Root mean square of what straight lines between readings at these times cut off the course that was read, estimated from
/// the readings alone.
///
/// Over a step of L a parabola of the curvature κ is up to κ L²/8 away from its chord, in the mean square κ² L⁴/120. κ² is the
/// mean of the second divided differences at both ends of the step. That is exact for a course that is smooth over
/// two steps. Of a course with corners, as a motion against dry friction or against a stop has them, the square of such
/// differences over single steps is twice that over double steps, and the mean square that is cut off is twice as large
/// as the formula has it: a corner of 2v at a random place of its step leaves 2 v² L³/45, and κ² L⁵/120 sums up to v² L³/45. So
/// the ratio of both, between 1 (smooth) and 2 (corners), is the factor that is missing.
/// The steps of the sensor's counts have a larger ratio, and are none of this error: it is not taken for more than 2.
pub(super) fn cut_off(times: &[f64], values: &[f64]) -> f64 {
    let curvatures = |apart: usize| -> Vec<f64> {
        let slope =
            |from: usize, to: usize| (values[to] - values[from]) / (times[to] - times[from]);
        let middles = apart..times.len().saturating_sub(apart);
        let second = |at: usize| {
            let change = slope(at, at + apart) - slope(at - apart, at);
            let square = (2.0 * change / (times[at + apart] - times[at - apart])).powi(2);
            // Of two readings at one time there is none.
            if square.is_finite() { square } else { 0.0 }
        };
        middles.map(second).collect()
    };
    let mean = |squares: &[f64]| squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    let (single, double) = (curvatures(1), curvatures(2));
    let (Some(&first), Some(&last)) = (single.first(), single.last()) else {
        return 0.0;
    };
    // The two ends have no difference of their own.
    let at = |place: usize| match place {
        0 => first,
        place => single.get(place - 1).copied().unwrap_or(last),
    };
    let cut = |place: usize| {
        let step = times[place + 1] - times[place];
        0.5 * (at(place) + at(place + 1)) * step.powi(5) / 120.0
    };
    let squares: f64 = (0..times.len() - 1).map(cut).sum();
    let ratio = mean(&single) / mean(&double);
    let missing = if ratio.is_finite() {
        ratio.clamp(1.0, 2.0)
    } else {
        1.0
    };
    (missing * squares / (times[times.len() - 1] - times[0])).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the straight lines between readings every `step` really cut off, rms, over all times between.
    fn truth(course: impl Fn(f64) -> f64, times: &[f64]) -> f64 {
        const BETWEEN: usize = 50;
        let between = times.windows(2).flat_map(|pair| {
            let (from, to) = (course(pair[0]), course(pair[1]));
            let (start, step) = (pair[0], pair[1] - pair[0]);
            (0..BETWEEN).map(move |k| {
                let share = k as f64 / BETWEEN as f64;
                (start + share * step, from + share * (to - from), step)
            })
        });
        let (mut squares, mut sum) = (0.0, 0.0);
        for (time, line, weight) in between {
            squares += weight * (line - course(time)).powi(2);
            sum += weight;
        }
        (squares / sum).sqrt()
    }

    /// A sine, a sweep of sines from 0.2 to 4 Hz, and a triangle whose corners lie anywhere in a step.
    #[test]
    fn what_straight_lines_cut_off_is_known_from_the_readings() {
        use std::f64::consts::TAU;
        let sine = |t: f64| (TAU * 0.7 * t).sin();
        let sweep = |t: f64| (TAU * (0.2 * t + 0.19 * t * t)).sin();
        let triangle = |t: f64| ((0.731 * t).rem_euclid(1.0) - 0.5).abs();
        let courses: [(&str, &dyn Fn(f64) -> f64); 3] =
            [("sine", &sine), ("sweep", &sweep), ("triangle", &triangle)];
        for (name, course) in courses {
            for step in [0.005, 0.01, 0.02] {
                let even: Vec<f64> = (0..)
                    .map(|k| f64::from(k) * step)
                    .take_while(|t| *t < 10.0)
                    .collect();
                // The same with one reading in twenty lost.
                let kept = even.iter().enumerate().filter(|(place, _)| place % 20 != 7);
                let ragged: Vec<f64> = kept.map(|(_, time)| *time).collect();
                for times in [even, ragged] {
                    let values: Vec<f64> = times.iter().map(|t| course(*t)).collect();
                    let (said, real) = (cut_off(&times, &values), truth(course, &times));
                    assert!(
                        (said / real - 1.0).abs() < 0.3,
                        "{name}, {step} s: {said} for {real}"
                    );
                }
            }
        }
    }

    /// The steps of a sensor are its own error.
    #[test]
    fn counts_add_less_than_half_of_one() {
        let times: Vec<f64> = (0..1_000).map(|k| f64::from(k) * 0.01).collect();
        let values: Vec<f64> = times
            .iter()
            .map(|t| (3.7 * t).sin())
            .map(|x| (x / 0.02).round() * 0.02)
            .collect();
        assert!(cut_off(&times, &values) < 0.01);
        assert_eq!(cut_off(&times[..2], &values[..2]), 0.0);
    }
}
