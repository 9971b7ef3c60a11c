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
    /// Of each row of the file, from 0, whether its blank cell lies near enough to a number to be filled in.
    fills: Vec<bool>,
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
        let mut fills = vec![false; values.len()];
        for pair in has
            .windows(2)
            .filter(|pair| pair[1] - pair[0] <= LONGEST * every)
        {
            rows[pair[0] + 1..pair[1]]
                .iter()
                .for_each(|&row| fills[row] = true);
        }
        let (first, last) = (has[0], has[has.len() - 1]);
        let ends =
            (first.saturating_sub(every)..first).chain(last + 1..rows.len().min(last + 1 + every));
        ends.for_each(|place| fills[rows[place]] = true);
        Some(Self {
            column: source.column,
            every,
            rows: has.len(),
            fills,
        })
    }

    /// Whether this row has a number, or gets one.
    pub fn fills(&self, row: usize) -> bool {
        self.fills[row]
    }
}
