//! A measured log: a CSV file with a header row, then one row a sample, SI units.
//!
//! | column | meaning |
//! |---|---|
//! | `time_s` | required: s |
//! | `input` | required: what the drive was told, held from its row to the next |
//! | `position` | required: rad or m, as the sensor gave it |
//! | `command` | optional: the position asked for, rad or m |
//! | `current_a` | optional: measured motor current, A |
//! | `velocity` | optional: measured velocity, rad/s or m/s |
//! | `brake` | optional: friction that a brake adds at the coordinate, N·m or N, not negative, held from its row to the next |
//! | `load_torque` | optional: a measured external torque or force, N·m or N, against positive motion |
//! | `enabled` | optional: 0 while the drive lets go of the motor, else 1; held from its row to the next |
//!
//! Rows at uneven times (jitter, small gaps, repeated rows, two rates) are put on a grid on reading, and
//! [`Log::resampling`] says what that changed.
//!
//! Columns stand in any order; others are ignored. Blank lines, spaces around a field, CRLF and a
//! byte order mark do no harm. Everything else that is not such a log is an [`InputError`].

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use model_core::plant::LONGEST_PERIOD;

use self::fault::{Fault, Mend};
use self::resample::{Instants, Resampling};
use self::table::{PrintedDigits, Spacing, Table};
use crate::error::{InputError, LARGEST_DATA, read_bytes, text_of};
use crate::gap::metrics::SETTLING;
use crate::import::call;

pub(crate) mod fault;
pub mod resample;
pub(crate) mod rows;
mod spikes;
pub(crate) mod table;

/// A uniformly sampled log. Every series has the same length, [`Log::MIN_SAMPLES`] at least when
/// it was read from a file, and finite values that single precision holds.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Log {
    /// The file, as the user named it.
    pub path: PathBuf,
    /// Time of the first sample, s.
    pub start_s: f64,
    /// Sample period, s: the least-squares slope of the time stamps.
    pub period_s: f64,
    /// What the drive was told, held from its sample to the next; V or what the machine's gain takes.
    pub input: Vec<f64>,
    /// Measured position, rad or m.
    pub position: Vec<f64>,
    /// Commanded position, rad or m.
    pub command: Option<Vec<f64>>,
    /// Measured motor current, A.
    pub current: Option<Vec<f64>>,
    /// Measured velocity, rad/s or m/s.
    pub velocity: Option<Vec<f64>>,
    /// Friction that a brake adds at the coordinate, held from its sample to the next, N·m or N.
    pub brake: Option<Vec<f64>>,
    /// Measured external torque or force, positive against positive motion, N·m or N.
    pub load_torque: Option<Vec<f64>>,
    /// 0 while the drive lets go of the motor, so that no current flows whatever `input` says, else 1;
    /// held from its sample to the next.
    pub enabled: Option<Vec<f64>>,
    /// Whether each sample is filled in, where a row was missing; empty where none is.
    pub filled: Vec<bool>,
    /// What reading has changed, where the rows of the file were not at even times, or what an import did before.
    pub resampling: Option<Resampling>,
}

/// How the values of a column stand for the time between its rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Course {
    /// Looked at in its rows: between them it goes its way.
    Seen,
    /// Held from its row to the next.
    Held,
    /// Held, and 0 or 1.
    Switched,
}

/// The known columns, in the order in which they are written. Those before `REQUIRED` must be there.
pub(crate) const COLUMNS: [(&str, Course); 9] = [
    ("time_s", Course::Seen),
    ("input", Course::Held),
    ("position", Course::Seen),
    ("command", Course::Seen),
    ("current_a", Course::Seen),
    ("velocity", Course::Seen),
    ("brake", Course::Held),
    ("load_torque", Course::Seen),
    ("enabled", Course::Switched),
];
/// The column behind them in which an import says of which samples there was no row: 1 there, else 0.
pub(crate) const FILLED: &str = "filled";
pub(crate) const REQUIRED: usize = 3;
pub(crate) const TIME: usize = 0;
pub(crate) const INPUT: usize = 1;
pub(crate) const POSITION: usize = 2;
pub(crate) const COMMAND: usize = 3;
pub(crate) const CURRENT: usize = 4;
pub(crate) const VELOCITY: usize = 5;
pub(crate) const BRAKE: usize = 6;
pub(crate) const LOAD_TORQUE: usize = 7;
pub(crate) const ENABLED: usize = 8;

/// What a file should have been, for messages.
const EXPECTED: &str = "a log (CSV with the columns time_s, input, position)";

/// Longest gap that is filled in while the machine moves, s: a window in which a replay is judged. In a
/// longer one whole windows would be judged on what nobody measured.
pub const LONGEST_GAP_S: f64 = 0.2;

/// Largest jitter of a log that counts as even, as a share of the period.
const JITTER: f64 = 0.01;

/// How many times as long as the others' period a log's may be, if it has to be brought to theirs: of a
/// slower one more than every third sample would be made up.
pub(crate) const SLOWER: f64 = 1.5;

/// Share of rows that may repeat a stamp with other values, or be off the grid where stamps are printed no
/// finer than the period: more of them is how the stamps were printed, not how the rows were lost.
const MOST_UNTIMED: f64 = 0.1;

/// The period and phase of the grid are themselves estimated from jittering stamps: a log whose
/// jitter just reaches [`JITTER`] must not fail for that.
const GRID_MARGIN: f64 = 1.05;

/// Greatest credible value of a column other than the time, SI: beyond it the sample is damaged, or in
/// another unit. Counts of 30 bits are below.
const GREATEST_VALUE: f64 = 1e9;

/// Shortest credible period, s; below it the column is not in seconds.
const MIN_PERIOD_S: f64 = 1e-9;

/// Longest credible period, s: no model can be stepped by more. Above it the column is not in seconds.
const MAX_PERIOD_S: f64 = LONGEST_PERIOD as f64;

impl Log {
    /// Fewest samples that a file must have: at either end the filters of the torque balance settle over so many, and
    /// where nothing lies between, a log says nothing, and adds nothing to the other logs of a machine.
    pub const MIN_SAMPLES: usize = 2 * SETTLING;

    /// The smallest step of the position's sensor, rad or m, where the positions are made of such steps.
    pub fn position_step(&self) -> Option<f64> {
        let before = self.resampling.and_then(|change| change.position_step);
        before.or_else(|| resample::smallest_step(&self.position))
    }

    /// Reads and checks a log.
    ///
    /// Time stamps on a uniform grid are taken as they are. An interval between two rows counts as even
    /// if it is within 1 % of the period, or if both its stamps are within 1 % of a period of the
    /// least-squares grid. So stamps may scatter by 1 % and the logger's clock may drift
    /// slowly. The digits with which `time_s` is printed are allowed for where rounding to them
    /// moves the stamps (3 kHz with four decimals), and only there.
    ///
    /// Anything else is resampled ([`resample`]), but for what cannot be mended: time that runs
    /// backwards, a gap longer than [`LONGEST_GAP_S`] in motion, more samples to fill in than there are
    /// rows, and stamps printed so coarsely that they repeat or scatter all the time.
    ///
    /// # Errors
    /// The first fault found, with its line and the `cargo hil import` call that would mend it.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        Self::read_with_doubts(path, &mut Vec::new())
    }

    /// As [`Log::read`], and adds to `doubts` what can be read but hardly be so, with its line: a position that jumps
    /// for one sample in a log that is smooth otherwise, which gets the mean of its neighbours, an input or a current of one sample that is ten times every
    /// other one.
    ///
    /// # Errors
    /// As [`Log::read`].
    pub fn read_with_doubts(path: &Path, doubts: &mut Vec<InputError>) -> Result<Self, InputError> {
        Self::with_doubts(path, read_bytes(path, EXPECTED, LARGEST_DATA)?, doubts)
    }

    /// As [`Log::read`], of what a file holds.
    ///
    /// # Errors
    /// As [`Log::read`].
    pub fn of_bytes(path: &Path, bytes: Vec<u8>) -> Result<Self, InputError> {
        Self::with_doubts(path, bytes, &mut Vec::new())
    }

    fn with_doubts(
        path: &Path,
        bytes: Vec<u8>,
        doubts: &mut Vec<InputError>,
    ) -> Result<Self, InputError> {
        if let Some(error) = call::of_format(path, &bytes, EXPECTED) {
            return Err(error);
        }
        if std::str::from_utf8(&bytes).is_err()
            && let Err(error) = text_of(path, bytes.clone(), EXPECTED)
        {
            return Err(call::mended(error, path, &bytes, Some(Mend::Read)));
        }
        let text = text_of(path, bytes, EXPECTED)?;
        let in_file = |fault: Fault| InputError::new(path, Some(fault.line), fault.message);
        Table::parse(&text)
            .and_then(|mut table| {
                doubts.extend(table.mend_doubts().into_iter().map(in_file));
                Self::of_table(path, table, None)
            })
            .map_err(|fault| {
                let mend = fault.mend.clone();
                call::mended(in_file(fault), path, text.as_bytes(), mend)
            })
    }

    /// The log that these rows are, at a rate of `rate` Hz or at the one that they have.
    ///
    /// # Errors
    /// What cannot be mended about how they lie in time.
    pub(crate) fn of_table(path: &Path, table: Table, rate: Option<f64>) -> Result<Self, Fault> {
        let rows = table.lines.len();
        let position = table.columns[POSITION].as_deref().unwrap_or_default();
        // A mean of two readings is none of the sensor's steps.
        let position_step = resample::smallest_step(position);
        let (table, moved) = table.merge_repeats()?;
        let repeated = rows - table.lines.len();
        let first = table.time()[0];
        let instants = match (table.spacing()?, rate) {
            (Spacing::Even(period_s), None) => {
                // Rows that repeat each other leave no other trace.
                let resampling = (repeated > 0).then(|| Resampling {
                    rows,
                    merged: repeated,
                    position_error: (moved / table.lines.len() as f64).sqrt(),
                    position_step,
                    ..Resampling::default()
                });
                return Ok(Self {
                    resampling: resampling.or_else(|| table.filled_before(period_s)),
                    filled: table.filled,
                    ..Self::of_columns(path, first, period_s, table.columns)
                });
            }
            _ => table.instants(rate)?,
        };
        let mut log = table.resampled(path, instants)?;
        if let Some(resampling) = &mut log.resampling {
            resampling.rows += repeated;
            resampling.merged += repeated;
            let merging = (moved / log.input.len() as f64).sqrt();
            resampling.position_error = resampling.position_error.hypot(merging);
            resampling.position_step = position_step;
        }
        Ok(log)
    }

    fn of_columns(path: &Path, start_s: f64, period_s: f64, columns: Columns) -> Self {
        let [
            _,
            input,
            position,
            command,
            current,
            velocity,
            brake,
            load_torque,
            enabled,
        ] = columns;
        let required = |column: Option<Vec<f64>>| column.expect("the header was checked");
        Self {
            path: path.to_owned(),
            start_s,
            period_s,
            input: required(input),
            position: required(position),
            command,
            current,
            velocity,
            brake,
            load_torque,
            enabled,
            filled: Vec::new(),
            resampling: None,
        }
    }

    /// All but the time, in the order in which they are written.
    pub(crate) fn series(&self) -> [Option<&Vec<f64>>; COLUMNS.len() - 1] {
        [
            Some(&self.input),
            Some(&self.position),
            self.command.as_ref(),
            self.current.as_ref(),
            self.velocity.as_ref(),
            self.brake.as_ref(),
            self.load_torque.as_ref(),
            self.enabled.as_ref(),
        ]
    }

    /// The same log at another sampling period, s: of logs that are traced together all must have one.
    /// A period that differs by less than the tolerance of an even log is left as it is.
    ///
    /// # Errors
    /// A period at which more samples would have to be made up than there are rows, or so few are left
    /// that it is no log.
    pub fn at_period(self, period_s: f64) -> Result<Self, InputError> {
        if (self.period_s - period_s).abs() <= JITTER * period_s {
            return Ok(self);
        }
        if self.period_s > SLOWER * period_s {
            let message = format!(
                "sampled every {} s where the other logs have {period_s} s: expected one sampling \
                 period, at most {SLOWER} times theirs; bring the others to its rate",
                self.period_s
            );
            return Err(InputError::new(&self.path, None, message));
        }
        let time: Vec<f64> = (0..self.samples()).map(|row| self.time_s(row)).collect();
        let mut columns = Columns::default();
        for (column, series) in columns[TIME + 1..].iter_mut().zip(self.series()) {
            *column = series.cloned();
        }
        let since_start: Vec<f64> = time.iter().map(|t| t - self.start_s).collect();
        let instants = Instants::with_period(&since_start, period_s);
        columns[TIME] = Some(time);
        let table = Table {
            lines: (0..self.samples()).collect(),
            columns,
            digits: PrintedDigits::default(),
            filled: Vec::new(),
        };
        let mut log = table
            .resampled(&self.path, instants)
            .map_err(|fault| InputError::new(&self.path, Some(fault.line), fault.message))?;
        if let (Some(now), Some(before)) = (&mut log.resampling, self.resampling) {
            *now = now.after(&before);
        }
        Ok(log)
    }

    /// As [`Log::at_period`], at the period of another log.
    ///
    /// # Errors
    /// As [`Log::at_period`], with the call that brings the other one to the period of this one.
    pub fn at_period_of(self, other: &Self) -> Result<Self, InputError> {
        let rate = rounded(1.0 / self.period_s, 6);
        self.at_period(other.period_s).map_err(|error| {
            let bytes = read_bytes(&other.path, EXPECTED, LARGEST_DATA).unwrap_or_default();
            call::mended(error, &other.path, &bytes, Some(Mend::Rate(rate)))
        })
    }

    /// The log as CSV, every value with the digits that give it back unchanged. So has a period of up to
    /// twelve significant digits, unless the log starts so late that its time stamps cannot carry them.
    ///
    /// # Panics
    /// If the series differ in length.
    pub fn to_csv(&self) -> String {
        let series = self.series();
        for column in series.into_iter().flatten() {
            assert_eq!(column.len(), self.samples(), "series of unequal length");
        }
        let mut text = COLUMNS[TIME].0.to_owned();
        for ((name, _), column) in COLUMNS[TIME + 1..].iter().zip(series) {
            if column.is_some() {
                text.push(',');
                text += name;
            }
        }
        if !self.filled.is_empty() {
            text.push(',');
            text += FILLED;
        }
        text.push('\n');
        // A string takes everything.
        for row in 0..self.samples() {
            // Fifteen digits spare the reader 0.30000000000000004. The start is the user's own.
            let time_s = match row {
                0 => self.start_s,
                _ => rounded(self.time_s(row), 15),
            };
            let _ = write!(text, "{time_s:?}");
            for column in series.into_iter().flatten() {
                let _ = write!(text, ",{:?}", column[row]);
            }
            if let Some(filled) = self.filled.get(row) {
                let _ = write!(text, ",{}", u8::from(*filled));
            }
            text.push('\n');
        }
        text
    }

    /// Whether the other log has the same samples, under whatever name.
    pub fn repeats(&self, other: &Self) -> bool {
        self.input == other.input
            && self.position == other.position
            && self.current == other.current
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.input.len()
    }

    /// Time of a sample on the log's grid, s.
    pub fn time_s(&self, sample: usize) -> f64 {
        self.start_s + sample as f64 * self.period_s
    }
}

/// Values of the known columns, in the order of [`COLUMNS`].
pub(crate) type Columns = [Option<Vec<f64>>; COLUMNS.len()];

pub(crate) fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    let middle = sorted.len() / 2;
    *sorted.select_nth_unstable_by(middle, f64::total_cmp).1
}

pub(crate) fn counted(count: usize, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{plural}")
}

/// A field in quotation marks, cut to what a terminal line can show.
pub(crate) fn quoted(field: &str) -> String {
    const SHOWN: usize = 40;
    let rest = if field.chars().count() > SHOWN {
        "…"
    } else {
        ""
    };
    format!(
        "\"{}{rest}\"",
        field.chars().take(SHOWN).collect::<String>()
    )
}

/// `value` to that many significant digits.
pub(crate) fn rounded(value: f64, digits: usize) -> f64 {
    let decimals = digits - 1;
    format!("{value:.decimals$e}")
        .parse()
        .expect("a printed number")
}
