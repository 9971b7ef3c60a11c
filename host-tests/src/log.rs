//! A measured log: a CSV file with a header row, then one row a sample, SI units, uniformly sampled.
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
//!
//! Columns stand in any order; others are ignored. Blank lines, spaces around a field, CRLF and a
//! byte order mark do no harm. Everything else that is not such a log is an [`InputError`].

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::error::{InputError, line_ends, read_text, text_of};

/// A uniformly sampled log. Every series has the same length, [`Log::MIN_SAMPLES`] at least when
/// it was read from a file, and finite values that single precision holds.
#[derive(Debug, Clone, PartialEq)]
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
}

/// The known columns, in the order in which they are written. Those before `REQUIRED` must be there.
const COLUMNS: [&str; 7] = [
    "time_s",
    "input",
    "position",
    "command",
    "current_a",
    "velocity",
    "brake",
];
const REQUIRED: usize = 3;
const TIME: usize = 0;
const BRAKE: usize = 6;

/// What a file should have been, for messages.
const EXPECTED: &str = "a log (CSV with the columns time_s, input, position)";

/// Largest accepted jitter as a share of the period.
const JITTER: f64 = 0.01;

/// The period and phase of the grid are themselves estimated from jittering stamps: a log whose
/// jitter just reaches [`JITTER`] must not fail for that.
const GRID_MARGIN: f64 = 1.05;

/// Shortest credible period, s; below it the column is not in seconds.
const MIN_PERIOD_S: f64 = 1e-9;

impl Log {
    /// Fewest samples that a file must have: a few replay windows.
    pub const MIN_SAMPLES: usize = 100;

    /// Reads and checks a log.
    ///
    /// The time stamps must be a uniform grid. An interval between two rows is accepted if it is
    /// within 1 % of the period, or if both its stamps are within 1 % of a period of the
    /// least-squares grid. So stamps may scatter by 1 % and the logger's clock may drift
    /// slowly. The digits with which `time_s` is printed are allowed for where rounding to them
    /// moves the stamps (3 kHz with four decimals), and only there.
    ///
    /// # Errors
    /// The first fault found, with its line.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        Self::of_text(path, &read_text(path, EXPECTED)?)
    }

    /// As [`Log::read`], of what a file holds.
    ///
    /// # Errors
    /// As [`Log::read`].
    pub fn of_bytes(path: &Path, bytes: Vec<u8>) -> Result<Self, InputError> {
        Self::of_text(path, &text_of(path, bytes, EXPECTED)?)
    }

    fn of_text(path: &Path, text: &str) -> Result<Self, InputError> {
        let table = Table::parse(path, text)?;
        let period_s = table.period(path)?;
        let [time, input, position, command, current, velocity, brake] = table.columns;
        let required = |column: Option<Vec<f64>>| column.expect("the header was checked");
        Ok(Self {
            path: path.to_owned(),
            start_s: required(time)[0],
            period_s,
            input: required(input),
            position: required(position),
            command,
            current,
            velocity,
            brake,
        })
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
        let series = [
            Some(&self.input),
            Some(&self.position),
            self.command.as_ref(),
            self.current.as_ref(),
            self.velocity.as_ref(),
            self.brake.as_ref(),
        ];
        for column in series.into_iter().flatten() {
            assert_eq!(column.len(), self.samples(), "series of unequal length");
        }
        let mut out = BufWriter::new(File::create(path)?);
        write!(out, "{}", COLUMNS[TIME])?;
        for (name, column) in COLUMNS[TIME + 1..].iter().zip(series) {
            if column.is_some() {
                write!(out, ",{name}")?;
            }
        }
        writeln!(out)?;
        for row in 0..self.samples() {
            // Fifteen digits spare the reader 0.30000000000000004. The start is the user's own.
            let time_s = match row {
                0 => self.start_s,
                _ => rounded(self.time_s(row), 15),
            };
            write!(out, "{time_s:?}")?;
            for column in series.into_iter().flatten() {
                write!(out, ",{:?}", column[row])?;
            }
            writeln!(out)?;
        }
        out.flush()
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

/// The file's known columns, checked row by row.
struct Table {
    /// Line of each row in the file.
    lines: Vec<usize>,
    /// In the order of [`COLUMNS`].
    columns: [Option<Vec<f64>>; COLUMNS.len()],
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
        let places = find_columns(&record).map_err(|message| fail(header_line, message))?;

        let mut table = Self {
            lines: Vec::new(),
            columns: places.map(|place| place.map(|_| Vec::new())),
            digits: PrintedDigits::default(),
        };
        let mut last_line = header_line;
        let mut last_time = f64::NEG_INFINITY;
        while let Some(line) = rows.read(&mut record) {
            if record.len() != width {
                return Err(fail(line, describe_width(record.len(), width)));
            }
            let known = COLUMNS.iter().zip(places).zip(&mut table.columns);
            for ((name, place), column) in known {
                if let (Some(place), Some(column)) = (place, column) {
                    let value = parse_number(&record[place])
                        .map_err(|reason| fail(line, format!("`{name}` {reason}")))?;
                    if *name == COLUMNS[BRAKE] && value < 0.0 {
                        return Err(fail(line, describe_brake(value)));
                    }
                    column.push(value);
                    if *name == COLUMNS[TIME] {
                        if value <= last_time {
                            let message = describe_order(value, last_time, last_line);
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
        let samples = table.lines.len();
        if samples < Log::MIN_SAMPLES {
            let message = format!(
                "the log ends after {}, expected at least {}",
                counted(samples, "sample"),
                Log::MIN_SAMPLES
            );
            return Err(fail(last_line, message));
        }
        Ok(table)
    }

    /// The sample period in s, if the time stamps are uniform (see [`Log::read`]).
    fn period(&self, path: &Path) -> Result<f64, InputError> {
        let time = self.columns[TIME]
            .as_deref()
            .expect("the header was checked");
        let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let median = median(&steps);
        let resolution = self.digits.resolution(time);
        // What rounding does to a step. Beyond half a period it could pass for a missing sample.
        let rounding = if resolution <= median / 2.0 {
            resolution
        } else {
            0.0
        };
        let refuse = |interval: usize, period: f64| {
            let message = describe_step(steps[interval], period, resolution);
            InputError::new(path, Some(self.lines[interval + 1]), message)
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
            let message = format!("`time_s` steps by {period:e} s; expected seconds");
            return Err(InputError::new(path, Some(self.lines[1]), message));
        }
        let tolerance = 2.0 * JITTER * GRID_MARGIN * period + rounding;
        let too_far = |step: &f64| (step - period).abs() > tolerance;
        if let Some(interval) = steps.iter().position(too_far) {
            return Err(refuse(interval, period));
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
        match (0..steps.len()).find(|&interval| !uniform(interval)) {
            Some(interval) => Err(refuse(interval, period)),
            // What follows the twelfth digit is the rounding of the sums: a sample in 10¹².
            None => Ok(rounded(period, 12)),
        }
    }
}

/// The rows of a CSV text that are not blank, each with its line.
struct Rows<'t> {
    text: &'t [u8],
    reader: csv::Reader<&'t [u8]>,
    offset: usize,
    line: usize,
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
        }
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
fn find_columns(header: &csv::StringRecord) -> Result<[Option<usize>; COLUMNS.len()], String> {
    if header.iter().all(|field| field.parse::<f64>().is_ok()) {
        return Err(format!(
            "the first row holds numbers, not column names; expected {EXPECTED}"
        ));
    }
    for (place, name) in header.iter().enumerate() {
        if !name.is_empty() && header.iter().take(place).any(|earlier| earlier == name) {
            return Err(format!(
                "the column {} is there twice; keep one",
                quoted(name)
            ));
        }
    }
    let places = COLUMNS.map(|known| header.iter().position(|name| name == known));
    for (known, place) in COLUMNS.into_iter().zip(places) {
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
        .map(|(name, _)| format!("`{name}`"))
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
        "the header has no column {}{hint}; expected {EXPECTED}",
        missing.join(", ")
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
    let fields = counted(fields, "field");
    format!("{fields}, the header has {width}: {remedy}")
}

/// What is wrong with a brake that would push.
fn describe_brake(level: f64) -> String {
    format!(
        "`brake` is {level:?}, expected 0 or more: the level of the friction that the brake adds, \
         whichever way the machine moves"
    )
}

/// What is wrong with a time that is not later than the last one.
fn describe_order(time: f64, last_time: f64, last_line: usize) -> String {
    let fault = if time < last_time {
        "is earlier than"
    } else {
        "repeats"
    };
    format!(
        "`time_s` {time:?} {fault} that of line {last_line}; \
         expected each sample later than the one before"
    )
}

/// What is wrong with a step of `time_s`.
fn describe_step(step: f64, period: f64, resolution: f64) -> String {
    let missing = (step / period).round() - 1.0;
    let (fault, blurred) = if missing >= 1.0 {
        let samples = counted(missing as usize, "sample");
        let fault = format!("a gap of {samples}; cut the log here or fill it in");
        (fault, resolution > period / 2.0)
    } else {
        let percent = 100.0 * (step / period - 1.0).abs();
        let accepted = 100.0 * JITTER;
        let fault = format!(
            "a jitter of {percent:.1} %, at most {accepted} % is accepted; resample the log uniformly"
        );
        (fault, resolution > JITTER * period)
    };
    let digits = if blurred {
        ", or print `time_s` with more digits"
    } else {
        ""
    };
    format!(
        "`time_s` steps by {:?} s where the period is {:?} s: {fault}{digits}",
        rounded(step, 6),
        rounded(period, 6)
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
