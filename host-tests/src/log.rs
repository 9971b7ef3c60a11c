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

use std::collections::HashSet;
use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use self::resample::{Instants, Resampling};
use crate::error::{InputError, LARGEST_DATA, line_ends, read_text, text_of};

pub mod resample;

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
    /// What reading has changed, where the rows of the file were not at even times.
    pub resampling: Option<Resampling>,
}

/// How the values of a column stand for the time between its rows.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Course {
    /// Looked at in its rows: between them it goes its way.
    Seen,
    /// Held from its row to the next.
    Held,
    /// Held, and 0 or 1.
    Switched,
}

/// The known columns, in the order in which they are written. Those before `REQUIRED` must be there.
const COLUMNS: [(&str, Course); 9] = [
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
const REQUIRED: usize = 3;
const TIME: usize = 0;
const POSITION: usize = 2;
const BRAKE: usize = 6;
const ENABLED: usize = 8;

/// What a file should have been, for messages.
const EXPECTED: &str = "a log (CSV with the columns time_s, input, position)";

/// Longest gap that is filled in while the machine moves, s: a window in which a replay is judged. In a
/// longer one whole windows would be judged on what nobody measured.
pub const LONGEST_GAP_S: f64 = 0.2;

/// Largest jitter of a log that counts as even, as a share of the period.
const JITTER: f64 = 0.01;

/// How many times as long as the others' period a log's may be, if it has to be brought to theirs: of a
/// slower one more than every third sample would be made up.
const SLOWER: f64 = 1.5;

/// Share of rows that may repeat a stamp with other values, or be off the grid where stamps are printed no
/// finer than the period: more of them is how the stamps were printed, not how the rows were lost.
const MOST_UNTIMED: f64 = 0.1;

/// The period and phase of the grid are themselves estimated from jittering stamps: a log whose
/// jitter just reaches [`JITTER`] must not fail for that.
const GRID_MARGIN: f64 = 1.05;

/// Greatest credible value of a column other than the time, SI: beyond it the sample is damaged, or in
/// another unit. Counts of 30 bits are below.
const GREATEST_VALUE: f64 = 1e9;

/// How many times as large as the steps of the position around it a jump there and back has to be, to be
/// a damaged sample: a position that oscillates makes equal steps.
const SPIKE: f64 = 10.0;

/// How much of such a jump may be left after it, as a share of it.
const SPIKE_LEFT: f64 = 0.1;

/// Most damaged samples that a log is looked through for; where more jump, that is how it moves.
const MOST_SPIKES: usize = 10;

/// Shortest credible period, s; below it the column is not in seconds.
const MIN_PERIOD_S: f64 = 1e-9;

impl Log {
    /// Fewest samples that a file must have: a few replay windows.
    pub const MIN_SAMPLES: usize = 100;

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
    /// The first fault found, with its line.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        Self::read_with_doubts(path, &mut Vec::new())
    }

    /// As [`Log::read`], and adds to `doubts` what can be read but hardly be so: a position that jumps for
    /// one sample in a log that is smooth otherwise, with its line.
    ///
    /// # Errors
    /// As [`Log::read`].
    pub fn read_with_doubts(path: &Path, doubts: &mut Vec<InputError>) -> Result<Self, InputError> {
        Self::of_text(path, &read_text(path, EXPECTED, LARGEST_DATA)?, doubts)
    }

    /// As [`Log::read`], of what a file holds.
    ///
    /// # Errors
    /// As [`Log::read`].
    pub fn of_bytes(path: &Path, bytes: Vec<u8>) -> Result<Self, InputError> {
        Self::of_text(path, &text_of(path, bytes, EXPECTED)?, &mut Vec::new())
    }

    fn of_text(path: &Path, text: &str, doubts: &mut Vec<InputError>) -> Result<Self, InputError> {
        let table = Table::parse(path, text)?;
        doubts.extend(table.spikes(path));
        let rows = table.lines.len();
        let table = table.merge_repeats(path)?;
        let repeated = rows - table.lines.len();
        match table.spacing(path)? {
            Spacing::Even(period_s) => {
                let time = table.columns[TIME].as_ref();
                let start_s = time.expect("the header was checked")[0];
                // Rows that repeat each other leave no other trace.
                let resampling = (repeated > 0).then(|| Resampling::merged(rows, repeated));
                Ok(Self {
                    resampling,
                    ..Self::of_columns(path, start_s, period_s, table.columns)
                })
            }
            Spacing::Uneven => {
                let instants = table.instants(path)?;
                let mut log = table.resampled(path, instants)?;
                if let Some(resampling) = &mut log.resampling {
                    resampling.rows += repeated;
                    resampling.merged += repeated;
                }
                Ok(log)
            }
        }
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
            resampling: None,
        }
    }

    /// All but the time, in the order in which they are written.
    fn series(&self) -> [Option<&Vec<f64>>; COLUMNS.len() - 1] {
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
                 period, at most {SLOWER} times theirs; bring the others to its rate: {}",
                self.period_s,
                import_call(
                    Path::new("OTHER.csv"),
                    &format!(" --rate {}", rounded(1.0 / self.period_s, 6))
                )
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
        };
        let mut log = table.resampled(&self.path, instants)?;
        if let (Some(now), Some(before)) = (&mut log.resampling, self.resampling) {
            *now = now.after(&before);
        }
        Ok(log)
    }

    /// Writes the log to `path`, every value with the digits that give it back unchanged.
    /// So does a period of up to twelve significant digits, unless the log starts so late that
    /// its time stamps cannot carry them.
    ///
    /// # Errors
    /// What the file system reports.
    ///
    /// # Panics
    /// If the series differ in length.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        fs::write(path, self.to_csv())
    }

    /// The log as CSV, as [`Log::write`] writes it.
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
type Columns = [Option<Vec<f64>>; COLUMNS.len()];

/// Whether time stamps are a grid.
enum Spacing {
    /// They are, of this period, s.
    Even(f64),
    Uneven,
}

/// The file's known columns, checked row by row.
struct Table {
    /// Line of each row in the file.
    lines: Vec<usize>,
    columns: Columns,
    /// How `time_s` is printed.
    digits: PrintedDigits,
}

impl Table {
    fn parse(path: &Path, text: &str) -> Result<Self, InputError> {
        let fail = |line, message: String| InputError::new(path, Some(line), message);
        let mut rows = Rows::new(text);
        let mut record = csv::StringRecord::new();

        let Some(header_line) = rows.read(&mut record) else {
            return Err(fail(1, format!("the file is empty; expected {EXPECTED}")));
        };
        let width = record.len();
        rows.check_quotes(path, "")?;
        let places = find_columns(path, &record).map_err(|message| fail(header_line, message))?;

        let mut table = Self {
            lines: Vec::new(),
            columns: places.map(|place| place.map(|_| Vec::new())),
            digits: PrintedDigits::default(),
        };
        let mut last_line = header_line;
        let mut last_time = f64::NEG_INFINITY;
        while let Some(line) = rows.read(&mut record) {
            rows.check_quotes(path, &describe_fields(record.len(), width))?;
            if record.len() != width {
                return Err(fail(line, describe_width(record.len(), width)));
            }
            let known = COLUMNS.iter().zip(places).zip(&mut table.columns);
            for (((name, _), place), column) in known {
                if let (Some(place), Some(column)) = (place, column) {
                    let value = parse_number(&record[place])
                        .map_err(|reason| fail(line, format!("`{name}` {reason}")))?;
                    check_value(name, value).map_err(|message| fail(line, message))?;
                    column.push(value);
                    if *name == COLUMNS[TIME].0 {
                        if value < last_time {
                            let message = describe_order(path, value, last_line);
                            return Err(fail(line, message));
                        }
                        last_time = value;
                        table.digits.see(&record[place]);
                    }
                }
            }
            table.lines.push(line);
            last_line = line;
        }
        table.check_length(path, table.lines.len(), last_line)?;
        Ok(table)
    }

    fn check_length(&self, path: &Path, samples: usize, line: usize) -> Result<(), InputError> {
        if samples >= Log::MIN_SAMPLES {
            return Ok(());
        }
        let message = format!(
            "the log ends after {}, expected at least {}",
            counted(samples, "sample"),
            Log::MIN_SAMPLES
        );
        Err(InputError::new(path, Some(line), message))
    }

    /// Positions that jump for one sample in a log that is smooth otherwise: no machine moves there and
    /// back between two samples, many times as fast as ever else.
    fn spikes(&self, path: &Path) -> Vec<InputError> {
        let position = self.columns[POSITION].as_deref().unwrap_or_default();
        let steps: Vec<f64> = position.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let mut sizes: Vec<f64> = steps.iter().map(|step| step.abs()).collect();
        // Each damaged sample makes two steps.
        let (_, usual, _) = sizes.select_nth_unstable_by(2 * MOST_SPIKES, |a, b| b.total_cmp(a));
        // At rest nothing but the last digit changes, seldom: no jump of that is one.
        let digit = (steps.iter().map(|step| step.abs()))
            .filter(|size| *size > 0.0)
            .fold(f64::INFINITY, f64::min);
        let limit = SPIKE * usual.max(digit);
        let large: Vec<usize> = (0..steps.len())
            .filter(|&at| steps[at].abs() > limit)
            .collect();
        let back = |pair: &[usize]| {
            let [there, back] = [steps[pair[0]], steps[pair[1]]];
            pair[1] == pair[0] + 1 && (there + back).abs() <= SPIKE_LEFT * there.abs()
        };
        // A jump that stays is an angle that wraps, or a gap: others know better what to say of it.
        let (pairs, rest) = large.as_chunks::<2>();
        if pairs.is_empty() || !rest.is_empty() || !pairs.iter().all(|pair| back(pair)) {
            return Vec::new();
        }
        let doubt = |pair: &[usize; 2]| {
            let row = pair[1];
            let message = format!(
                "`position` is {:?} in this sample alone, {:?} before and {:?} after it, and no other steps \
             are nearly as large: replace the sample by the mean of its neighbours, or remove the row",
                position[row],
                position[row - 1],
                position[row + 1]
            );
            InputError::new(path, Some(self.lines[row]), message)
        };
        pairs.iter().map(doubt).collect()
    }

    fn time(&self) -> &[f64] {
        self.columns[TIME]
            .as_deref()
            .expect("the header was checked")
    }

    fn last_line(&self) -> usize {
        self.lines.last().copied().unwrap_or(1)
    }

    /// Rows of one time stamp made one: of what was looked at the mean; of what holds to the next row the
    /// last, since the others held for no time.
    fn merge_repeats(mut self, path: &Path) -> Result<Self, InputError> {
        let time = self.time();
        let rows = time.len();
        let starts: Vec<usize> = (0..rows)
            .filter(|&row| row == 0 || time[row] > time[row - 1])
            .collect();
        if starts.len() == rows {
            return Ok(self);
        }
        let ends = || starts[1..].iter().copied().chain([rows]);
        let same = |row: usize| {
            let mut columns = self.columns.iter().flatten();
            columns.all(|column| column[row] == column[row - 1])
        };
        let mut told_apart = (1..rows).filter(|&row| time[row] == time[row - 1] && !same(row));
        if told_apart.clone().count() as f64 > MOST_UNTIMED * rows as f64
            && let Some(row) = told_apart.next()
        {
            let message = format!(
                "`time_s` {:?} repeats that of line {}, as many others do; print `time_s` with more digits",
                time[row],
                self.lines[row - 1]
            );
            return Err(InputError::new(path, Some(self.lines[row]), message));
        }
        let merged = self.columns.each_ref().map(|column| column.is_some());
        for (index, _) in merged.iter().enumerate().filter(|(_, there)| **there) {
            let values = self.columns[index].as_deref().unwrap_or_default();
            let one = |(&start, end): (&usize, usize)| match COLUMNS[index].1 {
                Course::Seen if end - start > 1 && index != TIME => {
                    values[start..end].iter().sum::<f64>() / (end - start) as f64
                }
                Course::Seen | Course::Held | Course::Switched => values[end - 1],
            };
            self.columns[index] = Some(starts.iter().zip(ends()).map(one).collect());
        }
        self.lines = starts.iter().map(|&row| self.lines[row]).collect();
        self.check_length(path, starts.len(), self.last_line())?;
        Ok(self)
    }

    /// A grid for rows at uneven times, if these can be mended.
    fn instants(&self, path: &Path) -> Result<Instants, InputError> {
        let time = self.time();
        let since_start: Vec<f64> = time.iter().map(|t| t - time[0]).collect();
        let instants = Instants::of(&since_start);
        let period = instants.period;
        let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let resolution = self.digits.resolution(time);
        let refuse = |interval: usize, fault: String| {
            Err(InputError::new(path, Some(self.lines[interval + 1]), fault))
        };
        let off = |step: &&f64| (**step / period - 1.0).abs() > 0.5;
        if resolution > period / 2.0
            && steps.iter().filter(off).count() as f64 > MOST_UNTIMED * steps.len() as f64
            && let Some(first) = steps.iter().position(|step| off(&step))
        {
            let fault = format!(
                "{}: print `time_s` with more digits",
                describe_step(steps[first], period)
            );
            return refuse(first, fault);
        }
        for (interval, &step) in steps.iter().enumerate() {
            let is_gap = instants.filled_in(step) > 0 && step > LONGEST_GAP_S;
            if is_gap && self.moves_around(interval) {
                let fault = format!(
                    "{} in the middle of motion, at most {LONGEST_GAP_S} s are filled in; cut the log \
                     here and give both parts, or record it again at one rate and convert it: {}",
                    describe_step(step, period),
                    import_call(path, "")
                );
                return refuse(interval, fault);
            }
        }
        let filled = |step: &f64| instants.filled_in(*step) as f64;
        let made_up: f64 = steps.iter().map(filled).sum();
        if made_up > time.len() as f64
            && let Some((widest, _)) =
                (steps.iter().enumerate()).max_by(|(_, a), (_, b)| a.total_cmp(b))
        {
            let fault = format!(
                "{}, and more samples would have to be filled in than the log has; cut it here, or bring \
                 it to its lower rate: {}",
                describe_step(steps[widest], period),
                import_call(path, " --rate HZ")
            );
            return refuse(widest, fault);
        }
        Ok(instants)
    }

    /// Whether the position changes, by more than two of its smallest steps, in the windows before and
    /// after an interval or in between.
    fn moves_around(&self, interval: usize) -> bool {
        let time = self.time();
        let position = self.columns[POSITION]
            .as_deref()
            .expect("the header was checked");
        let near = time.iter().zip(position).filter(|(t, _)| {
            **t >= time[interval] - LONGEST_GAP_S && **t <= time[interval + 1] + LONGEST_GAP_S
        });
        let (low, high) = near.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, p)| {
            (low.min(*p), high.max(*p))
        });
        let changes = position.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let count = changes
            .filter(|change| *change > 0.0)
            .fold(f64::INFINITY, f64::min);
        high > low && high - low > 2.0 * count
    }

    /// The log on a grid, its times after the first row.
    fn resampled(self, path: &Path, instants: Instants) -> Result<Log, InputError> {
        self.check_length(path, instants.count, self.last_line())?;
        let first = self.time()[0];
        let time: Vec<f64> = self.time().iter().map(|t| t - first).collect();
        let mut columns = Columns::default();
        for (index, column) in self.columns.iter().enumerate().skip(TIME + 1) {
            columns[index] = column.as_deref().map(|values| match COLUMNS[index].1 {
                Course::Seen => instants.interpolated(&time, values),
                Course::Held => instants.held(&time, values),
                Course::Switched => instants.switched(&time, values),
            });
        }
        let position = self.columns[POSITION].as_deref().unwrap_or_default();
        Ok(Log {
            resampling: Some(instants.summary(&time, position)),
            ..Log::of_columns(path, first + instants.start, instants.period, columns)
        })
    }

    /// Whether the time stamps are uniform (see [`Log::read`]).
    fn spacing(&self, path: &Path) -> Result<Spacing, InputError> {
        let time = self.time();
        let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let median = median(&steps);
        let resolution = self.digits.resolution(time);
        // What rounding does to a step. Beyond half a period it could pass for a missing sample.
        let rounding = if resolution <= median / 2.0 {
            resolution
        } else {
            0.0
        };
        // First a period that neither a gap nor rounding moves, to find what a line could not be
        // fitted to: two stamps, each off the grid by the tolerance, are the most that may pass.
        let near = |step: &&f64| (**step - median).abs() <= 0.1 * median + rounding;
        let (sum, count) = steps
            .iter()
            .filter(near)
            .fold((0.0, 0.0), |(sum, count), step| (sum + step, count + 1.0));
        let period = sum / count;
        if period < MIN_PERIOD_S {
            let message = format!(
                "`time_s` steps by {period:e} s; expected seconds: {}",
                import_call(path, "").replacen("time_s", "time_s:us", 1)
            );
            return Err(InputError::new(path, Some(self.lines[1]), message));
        }
        let tolerance = 2.0 * JITTER * GRID_MARGIN * period + rounding;
        let too_far = |step: &f64| (step - period).abs() > tolerance;
        if steps.iter().any(too_far) {
            return Ok(Spacing::Uneven);
        }

        let grid = Grid::fit(time);
        // Multiples of the resolution are printed exactly: what is left is jitter.
        let multiple = (grid.period / resolution).round().max(1.0) * resolution;
        let strays = (grid.period - multiple).abs() * time.len() as f64;
        let (period, rounding) = if strays < resolution / 2.0 {
            (multiple, 0.0)
        } else {
            (grid.period, rounding)
        };
        let tolerance = JITTER * GRID_MARGIN * period;
        let on_grid = |row: usize| (time[row] - grid.time(row)).abs() <= tolerance + rounding / 2.0;
        let uniform = |interval: usize| {
            (steps[interval] - period).abs() <= tolerance + rounding
                || (on_grid(interval) && on_grid(interval + 1))
        };
        if (0..steps.len()).all(uniform) {
            // What follows the twelfth digit is the rounding of the sums: a sample in 10¹².
            Ok(Spacing::Even(rounded(period, 12)))
        } else {
            Ok(Spacing::Uneven)
        }
    }
}

/// The rows of a CSV text that are not blank, each with its line.
struct Rows<'t> {
    text: &'t [u8],
    reader: csv::Reader<&'t [u8]>,
    offset: usize,
    line: usize,
    /// Where a quotation mark opens that nothing closes.
    unclosed: Option<usize>,
}

impl<'t> Rows<'t> {
    fn new(text: &'t str) -> Self {
        Self {
            text: text.as_bytes(),
            reader: csv::ReaderBuilder::new()
                .has_headers(false)
                .flexible(true)
                .trim(csv::Trim::All)
                .from_reader(text.as_bytes()),
            offset: 0,
            line: 1,
            unclosed: unclosed_quote(text),
        }
    }

    /// Refuses the row that was just read if a quotation mark in it is not closed. `finding` begins the
    /// message: what else is wrong with the row.
    fn check_quotes(&self, path: &Path, finding: &str) -> Result<(), InputError> {
        let end = self.reader.position().byte() as usize;
        let Some(at) = self.unclosed.filter(|at| *at < end) else {
            return Ok(());
        };
        let line = 1 + line_ends(self.text, 0, at);
        let rest = String::from_utf8_lossy(&self.text[at..]);
        let rest = rest.lines().next().unwrap_or_default();
        let message = format!(
            "{finding}the quotation mark of {} is not closed; close it, or remove it",
            quoted(rest)
        );
        Err(InputError::new(path, Some(line), message))
    }

    /// Reads the next row and returns its line, or `None` at the end.
    fn read(&mut self, record: &mut csv::StringRecord) -> Option<usize> {
        loop {
            // Reading fails for lack of UTF-8, which the text has, or of equal widths, which are
            // checked by the caller.
            if !self.reader.read_record(record).unwrap_or(false) {
                return None;
            }
            let start = record.position().map_or(0, csv::Position::byte) as usize;
            // The reader counts the blank lines before a row as part of it.
            let blank = self.text[start..]
                .iter()
                .take_while(|byte| matches!(byte, b'\r' | b'\n'))
                .count();
            self.line += line_ends(self.text, self.offset, start + blank);
            self.offset = start + blank;
            // A line of spaces is a blank line too.
            if record.len() > 1 || !record[0].is_empty() {
                return Some(self.line);
            }
        }
    }
}

/// The places of the known columns in the header, or what is wrong with it.
fn find_columns(
    path: &Path,
    header: &csv::StringRecord,
) -> Result<[Option<usize>; COLUMNS.len()], String> {
    if header.iter().all(|field| field.parse::<f64>().is_ok()) {
        return Err(format!(
            "the first row holds numbers, not column names; expected {EXPECTED}"
        ));
    }
    let mut names = HashSet::new();
    for name in header {
        if !name.is_empty() && !names.insert(name) {
            return Err(format!(
                "the column {} is there twice; keep one",
                quoted(name)
            ));
        }
    }
    let places = COLUMNS.map(|(known, _)| header.iter().position(|name| name == known));
    for ((known, _), place) in COLUMNS.into_iter().zip(places) {
        // An optional column under another name must not be dropped in silence.
        let stem = known.trim_end_matches("_s").trim_end_matches("_a");
        let alike =
            |name: &&str| name.eq_ignore_ascii_case(known) || name.eq_ignore_ascii_case(stem);
        if let (None, Some(name)) = (place, header.iter().find(alike)) {
            return Err(format!(
                "unknown column {}; name it `{known}`",
                quoted(name)
            ));
        }
    }
    let missing: Vec<String> = COLUMNS[..REQUIRED]
        .iter()
        .zip(places)
        .filter(|(_, place)| place.is_none())
        .map(|((name, _), _)| format!("`{name}`"))
        .collect();
    if missing.is_empty() {
        return Ok(places);
    }
    let hint = if header.len() == 1 && header[0].contains([';', '\t']) {
        "; separate the fields by commas"
    } else {
        ""
    };
    Err(format!(
        "the header has no column {}{hint}; expected {EXPECTED}: {}",
        missing.join(", "),
        import_call(path, "")
            .replacen("time_s", "TIME:s", 1)
            .replacen("--position position", "--position POSITION:UNIT", 1)
            .replacen("--input input", "--input INPUT", 1)
    ))
}

/// A finite number that single precision holds, or the rest of a sentence that says why not.
fn parse_number(field: &str) -> Result<f64, String> {
    if field.is_empty() {
        return Err("is empty, expected a number".into());
    }
    let Ok(value) = field.parse::<f64>() else {
        return Err(format!("is {}, expected a number", quoted(field)));
    };
    // A NaN fails the comparison.
    if value.abs() <= f64::from(f32::MAX) {
        Ok(value)
    } else {
        Err(format!(
            "is {}, expected a finite number that single precision holds; \
             cut the log here or mend the sample",
            quoted(field)
        ))
    }
}

/// What is wrong with a row of that many fields.
fn describe_width(fields: usize, width: usize) -> String {
    let remedy = if fields < width {
        "the row is cut short; complete or remove it"
    } else {
        "write decimal points, not decimal commas, and one sample a row"
    };
    describe_fields(fields, width) + remedy
}

/// That a row has other than the right number of fields, and nothing where it has that.
fn describe_fields(fields: usize, width: usize) -> String {
    if fields == width {
        return String::new();
    }
    format!("{}, the header has {width}: ", counted(fields, "field"))
}

/// Where a quotation mark opens that nothing closes: the rest of the file is one field then.
fn unclosed_quote(text: &str) -> Option<usize> {
    // As the reader takes them: a mark opens at the start of a field, and a double one inside is text.
    let (mut open, mut starts) = (None, true);
    let mut bytes = text.bytes().enumerate().peekable();
    while let Some((at, byte)) = bytes.next() {
        match (open, byte) {
            (None, b'"') if starts => open = Some(at),
            (Some(_), b'"') if bytes.next_if(|(_, next)| *next == b'"').is_none() => open = None,
            _ => (),
        }
        starts = open.is_none() && matches!(byte, b',' | b'\n' | b'\r');
    }
    open
}

/// Refuses what no measurement, no brake and no switch can be, whichever column it is.
fn check_value(name: &str, value: f64) -> Result<(), String> {
    if name != COLUMNS[TIME].0 && value.abs() > GREATEST_VALUE {
        return Err(format!(
            "`{name}` is {value:?}, which no machine does; expected SI units, at most {GREATEST_VALUE:e}: \
             cut the log here, mend the sample, or convert the unit"
        ));
    }
    if name == COLUMNS[BRAKE].0 && value < 0.0 {
        return Err(format!(
            "`brake` is {value:?}, expected 0 or more: the level of the friction that the brake adds, \
             whichever way the machine moves"
        ));
    }
    if name == COLUMNS[ENABLED].0 && value != 0.0 && value != 1.0 {
        return Err(format!(
            "`enabled` is {value:?}, expected 0 while the drive lets go of the motor, else 1"
        ));
    }
    Ok(())
}

/// What is wrong with a time that is earlier than the last one.
fn describe_order(path: &Path, time: f64, last_line: usize) -> String {
    format!(
        "`time_s` {time:?} is earlier than that of line {last_line}; expected no sample before the last \
         one: cut the log here, or take another clock's column: {}",
        import_call(path, "").replacen("time_s", "COLUMN:s", 1)
    )
}

/// What a step of `time_s` is beside the period.
fn describe_step(step: f64, period: f64) -> String {
    let missing = (step / period).round() - 1.0;
    let fault = if missing >= 1.0 {
        format!("a gap of {}", counted(missing as usize, "sample"))
    } else {
        let percent = 100.0 * (step / period - 1.0).abs();
        format!("a jitter of {percent:.1} %")
    };
    format!(
        "`time_s` steps by {:?} s where the period is {:?} s: {fault}",
        rounded(step, 6),
        rounded(period, 6)
    )
}

/// The call that makes a log of another file, or of one with faults that reading does not mend.
fn import_call(path: &Path, option: &str) -> String {
    format!(
        "cargo hil import {} --time time_s --position position --input input{option} --out LOG.csv",
        path.display()
    )
}

/// The least-squares line through time stamps over their row numbers.
struct Grid {
    period: f64,
    middle_row: f64,
    middle_time: f64,
}

impl Grid {
    fn fit(time: &[f64]) -> Self {
        let rows = time.len() as f64;
        let middle_row = (rows - 1.0) / 2.0;
        // Relative to the first stamp, so that a late start costs no precision.
        let mean = time.iter().map(|t| t - time[0]).sum::<f64>() / rows;
        let moment: f64 = time
            .iter()
            .enumerate()
            .map(|(row, t)| (row as f64 - middle_row) * (t - time[0] - mean))
            .sum();
        Self {
            period: moment / (rows * (rows * rows - 1.0) / 12.0),
            middle_row,
            middle_time: time[0] + mean,
        }
    }

    fn time(&self, row: usize) -> f64 {
        self.middle_time + self.period * (row as f64 - self.middle_row)
    }
}

/// The most digits that the file prints a time stamp with. Both counts are needed: a fixed format
/// keeps the decimals, `%g` the significant digits, and either may drop trailing zeros.
#[derive(Default)]
struct PrintedDigits {
    decimals: i32,
    significant: i32,
}

impl PrintedDigits {
    fn see(&mut self, field: &str) {
        let (mantissa, exponent) = field.split_once(['e', 'E']).unwrap_or((field, "0"));
        // Beyond what f64 holds the exponent is of no interest.
        let exponent = exponent.parse().unwrap_or(0).clamp(-400, 400);
        let fraction = mantissa
            .split_once('.')
            .map_or(0, |(_, digits)| digits.len() as i32);
        let significant = mantissa
            .trim_start_matches(['+', '-', '0', '.'])
            .bytes()
            .filter(u8::is_ascii_digit)
            .count() as i32;
        self.decimals = self.decimals.max(fraction.saturating_sub(exponent));
        self.significant = self.significant.max(significant);
    }

    /// The coarsest unit in which these stamps were printed, s, or that of f64 if it is coarser.
    fn resolution(&self, time: &[f64]) -> f64 {
        let largest = time.iter().fold(0.0_f64, |most, t| most.max(t.abs()));
        let leading = largest.log10().floor() as i32;
        10_f64
            .powi(-self.decimals)
            .max(10_f64.powi((leading + 1).saturating_sub(self.significant)))
            .max(largest * f64::EPSILON)
    }
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    let middle = sorted.len() / 2;
    *sorted.select_nth_unstable_by(middle, f64::total_cmp).1
}

fn counted(count: usize, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{plural}")
}

/// A field in quotation marks, cut to what a terminal line can show.
fn quoted(field: &str) -> String {
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
