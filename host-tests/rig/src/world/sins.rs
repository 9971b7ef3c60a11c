//! What loggers do to a log.

use super::dice::{between, chance, log_between, pick, sign};
use crate::random::Random;

/// How the input is logged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InputRow {
    /// What acts from the row on.
    Exact,
    /// What acted in the row before.
    RowLate,
    /// The mean of what acts from the row to the next.
    Averaged,
}

/// The sins of one logger; [`Sins::NONE`] is a good one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sins {
    /// Logged over true current.
    pub current_gain: f64,
    /// Offset of the current, as a share of its largest value.
    pub current_offset: f64,
    /// Rows by which the current is late, 0 to 2.
    pub current_lag: f64,
    /// How the input is logged.
    pub input: InputRow,
    /// Corrections of the loop in one row.
    pub corrections: usize,
    /// Largest lateness of a row behind its place on the grid, in rows.
    pub jitter: f64,
    /// Share of rows that are lost.
    pub dropped: f64,
    /// Whether one position is wrong.
    pub glitch: bool,
    /// Time constant of a filter of the position, in rows.
    pub filter: f64,
}

impl Sins {
    /// None.
    pub const NONE: Self = Self {
        current_gain: 1.0,
        current_offset: 0.0,
        current_lag: 0.0,
        input: InputRow::Exact,
        corrections: 1,
        jitter: 0.0,
        dropped: 0.0,
        glitch: false,
        filter: 0.0,
    };

    /// One to four of them.
    pub(super) fn draw(random: &mut Random) -> Self {
        let mut sins = Self::NONE;
        let count = pick(random, &[1, 2, 2, 3, 4]);
        for _ in 0..count {
            match pick(random, &[0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9]) {
                0 => sins.current_gain = 1.0 + 0.05 * between(random, -1.0, 1.0),
                1 => sins.current_offset = 0.03 * between(random, -1.0, 1.0),
                2 => sins.current_lag = between(random, 0.1, 2.0),
                3 => sins.input = InputRow::RowLate,
                4 | 5 => {
                    sins.corrections = super::control::corrections_a_row(random).max(2);
                    if chance(random, 0.5) {
                        sins.input = InputRow::Averaged;
                    }
                }
                6 => sins.jitter = log_between(random, 0.003, 0.3),
                7 => sins.dropped = log_between(random, 3e-4, 1e-2),
                8 => sins.glitch = true,
                _ => sins.filter = between(random, 0.2, 1.0),
            }
        }
        sins
    }

    /// Whether it is the current that is logged badly.
    pub(super) fn on_current(&self) -> bool {
        (self.current_gain, self.current_offset, self.current_lag) != (1.0, 0.0, 0.0)
    }

    /// For a log without a current; a logger that has no other sin is late with its input.
    pub(super) fn without_current(&mut self) {
        let sinned = self.any();
        (self.current_gain, self.current_offset, self.current_lag) = (1.0, 0.0, 0.0);
        if sinned && !self.any() {
            self.input = InputRow::RowLate;
        }
    }

    /// The same logger with every row in its place and none of them wrong.
    #[must_use]
    pub fn mended(self) -> Self {
        Self {
            jitter: 0.0,
            dropped: 0.0,
            glitch: false,
            ..self
        }
    }

    /// Whether there is any.
    pub fn any(&self) -> bool {
        *self != Self::NONE
    }

    /// Names of those that there are.
    pub fn names(&self) -> Vec<&'static str> {
        let named = [
            (self.current_gain != 1.0, "current gain"),
            (self.current_offset != 0.0, "current offset"),
            (self.current_lag != 0.0, "current late"),
            (self.input == InputRow::RowLate, "input a row late"),
            (self.input == InputRow::Averaged, "input averaged"),
            (self.corrections > 1, "loop faster than log"),
            (self.jitter > 0.0, "jitter"),
            (self.dropped > 0.0, "rows dropped"),
            (self.glitch, "glitch"),
            (self.filter > 0.0, "position filtered"),
        ];
        let there = named.into_iter().filter(|(is, _)| *is);
        there.map(|(_, name)| name).collect()
    }

    /// The current column as this logger writes it, of samples at the rows.
    pub(super) fn current(&self, column: &[f64]) -> Vec<f64> {
        let largest = column
            .iter()
            .fold(0.0, |most, value| f64::max(most, value.abs()));
        let whole = self.current_lag.floor();
        let share = self.current_lag - whole;
        let at = |row: usize| column[row.saturating_sub(whole as usize)];
        (0..column.len())
            .map(|row| {
                let late = at(row) + share * (at(row.saturating_sub(1)) - at(row));
                self.current_gain * late + self.current_offset * largest
            })
            .collect()
    }

    /// A place and a size of a wrong position, in strokes.
    pub(super) fn glitch_at(&self, random: &mut Random, rows: usize) -> Option<(usize, f64)> {
        let place = (rows as f64 * between(random, 0.1, 0.9)) as usize;
        let size = sign(random) * between(random, 0.05, 0.4);
        self.glitch.then_some((place, size))
    }
}

#[cfg(test)]
mod tests {
    use super::Sins;

    #[test]
    fn a_late_current_is_the_one_of_then() {
        let sins = Sins {
            current_lag: 1.5,
            ..Sins::NONE
        };
        let column: Vec<f64> = (0..10).map(f64::from).collect();
        let late = sins.current(&column);
        assert!((late[7] - 5.5).abs() < 1e-12);
        assert_eq!(late.len(), 10);
        assert_eq!(Sins::NONE.current(&column), column);
    }
}
