//! The known columns of a log, row by row, and how their rows lie in time.

use std::ops::Range;
use std::path::Path;

use super::fault::{Fault, Mend};
use super::resample::{Instants, Resampling, smallest_step};
use super::rows::{
    Rows, check_value, describe_fields, describe_step, describe_width, find_columns, parse_number,
};
use super::spikes::{MOST_SPIKES, RANGE, SPIKE, said_of, spikes, straighten};
use super::{
    COLUMNS, COMMAND, CURRENT, Columns, Course, EXPECTED, FILLED, GRID_MARGIN, INPUT, JITTER,
    LOAD_TORQUE, LONGEST_GAP_S, Log, MAX_PERIOD_S, MIN_PERIOD_S, MOST_UNTIMED, POSITION, SLOWER,
    TIME, VELOCITY, counted, median, rounded,
};
use crate::gap::metrics::{SETTLING, least_balanced_samples};
use crate::import::stamp::is_stamp;
use crate::import::unit::{Unit, unit_of_step, unit_of_time};
use crate::quantity::given;

/// Most parts of a log with gaps for which an import is printed.
const MOST_PARTS: usize = 4;

/// Whether time stamps are a grid.
pub(crate) enum Spacing {
    /// They are, of this period, s.
    Even(f64),
    Uneven,
}

/// The known columns of a log, row by row. The time never runs backwards.
pub(crate) struct Table {
    /// Line of each row in the file.
    pub lines: Vec<usize>,
    pub columns: Columns,
    /// How `time_s` is printed.
    pub digits: PrintedDigits,
    /// Which rows an import has filled in; empty where none.
    pub filled: Vec<bool>,
}

impl Table {
    /// The rows of a text with a header.
    ///
    /// # Errors
    /// The first fault found, and how an import would mend it.
    pub fn parse(text: &str) -> Result<Self, Fault> {
        let mut rows = Rows::new(text);
        let mut record = csv::StringRecord::new();
        let Some(header_line) = rows.read(&mut record) else {
            let message = format!("the file is empty; expected {EXPECTED}");
            return Err(Fault::new(1, message));
        };
        let width = record.len();
        rows.check_quotes("")?;
        let places = find_columns(&record)
            .map_err(|message| Fault::mended_by(header_line, message, Mend::Read))?;

        let mut table = Self {
            lines: Vec::new(),
            columns: places.map(|place| place.map(|_| Vec::new())),
            digits: PrintedDigits::default(),
            filled: Vec::new(),
        };
        let filled = record.iter().position(|name| name == FILLED);
        let mut last_line = header_line;
        while let Some(line) = rows.read(&mut record) {
            rows.check_quotes(&describe_fields(record.len(), width))?;
            if record.len() != width {
                return Err(describe_width(line, record.len(), width));
            }
            let known = COLUMNS.iter().zip(places).zip(&mut table.columns);
            for (((name, _), place), column) in known {
                if let (Some(place), Some(column)) = (place, column) {
                    let field = &record[place];
                    let value = parse_number(field).map_err(|reason| {
                        let is_stamp = *name == COLUMNS[TIME].0 && is_stamp(field);
                        let mend = if is_stamp { Mend::Read } else { Mend::SkipBad };
                        Fault::mended_by(line, format!("`{name}` {reason}"), mend)
                    })?;
                    check_value(line, name, value)?;
                    column.push(value);
                    if *name == COLUMNS[TIME].0 {
                        table.digits.see(field);
                    }
                }
            }
            // Whatever else a column of that name holds is none of ours.
            table
                .filled
                .extend(filled.map(|place| record[place].trim() == "1"));
            table.lines.push(line);
            last_line = line;
        }
        table.check_order()?;
        table.check_length(table.lines.len(), last_line)?;
        table.check_pace()?;
        Ok(table)
    }

    /// Refuses time that runs backwards.
    ///
    /// # Errors
    /// The first row that is earlier than the one before it.
    pub fn check_order(&self) -> Result<(), Fault> {
        let time = self.time();
        let Some(row) = (1..time.len()).find(|&row| time[row] < time[row - 1]) else {
            return Ok(());
        };
        let mut message = format!(
            "`time_s` {:?} is earlier than that of line {}; expected no sample before the last one",
            time[row],
            self.lines[row - 1]
        );
        let late = disordered(time);
        let has_gaps = fills_gaps(time, late);
        let mend = if late as f64 <= MOST_UNTIMED * time.len() as f64 && has_gaps {
            Mend::Sort
        } else if !has_gaps && keeps_pace(time) {
            message += ", but the rows keep the pace of a rate: if they are even and only their stamps scatter, give it";
            Mend::Even(self.even_rate())
        } else {
            // A clock that restarted or ran over: what lies before it is as good as what lies behind.
            self.longest_parts(self.runs(|row| time[row] < time[row - 1]))
        };
        Err(Fault::mended_by(self.lines[row], message, mend))
    }

    /// Refuses rows that are farther apart than in any log: their time is in another unit than seconds.
    ///
    /// # Errors
    /// The second row, with the unit that the time may be in.
    pub fn check_pace(&self) -> Result<(), Fault> {
        let Some((step, unit)) = unit_of_time(self.time()).filter(|(step, _)| *step > MAX_PERIOD_S)
        else {
            return Ok(());
        };
        let message = format!(
            "`time_s` steps by {} s, as one in {unit} does; expected seconds, {MAX_PERIOD_S} s a row at most",
            given(step)
        );
        Err(Fault::mended_by(
            self.lines[1],
            message,
            Mend::TimeUnit(unit),
        ))
    }

    /// The lines of the longest stretch of rows that does not break anywhere; `breaks` says whether one
    /// does before a row.
    fn longest_run(&self, breaks: impl Fn(usize) -> bool) -> Mend {
        let longest = self.runs(breaks).into_iter();
        let (start, end) = longest
            .max_by_key(|(start, end)| (end - start, usize::MAX - start))
            .unwrap_or((0, self.lines.len()));
        Mend::Lines(self.lines[start], self.lines[end - 1])
    }

    /// The stretches of rows that do not break anywhere, each by its first row and the one behind its last.
    fn runs(&self, breaks: impl Fn(usize) -> bool) -> Vec<(usize, usize)> {
        let rows = self.lines.len();
        let starts: Vec<usize> = (0..rows).filter(|&row| row == 0 || breaks(row)).collect();
        let ends = starts[1..].iter().copied().chain([rows]);
        starts.iter().copied().zip(ends).collect()
    }

    /// The longest of these stretches, in their order.
    fn longest_parts(&self, mut runs: Vec<(usize, usize)>) -> Mend {
        runs.sort_by_key(|(start, end)| std::cmp::Reverse(end - start));
        runs.truncate(MOST_PARTS);
        runs.sort_unstable();
        let lines = runs.into_iter();
        Mend::Parts(
            lines
                .map(|(start, end)| (self.lines[start], self.lines[end - 1]))
                .collect(),
        )
    }

    /// The rate that these rows have if they are even and only their stamps are not, Hz.
    fn even_rate(&self) -> f64 {
        let step = Grid::fit(self.time()).period;
        // A time in another unit makes rates that no log has.
        let unit = unit_of_step(step).filter(|_| step > MAX_PERIOD_S);
        let unit = unit.and_then(Unit::find);
        let mean = unit.map_or(1.0, |unit| unit.factor) * step;
        let rate = rounded(1.0 / mean, 6);
        // Stamps that are off by their last digit say no more than three digits of the rate.
        let plain = rounded(1.0 / mean, 3);
        if (plain / rate - 1.0).abs() < 1e-3 {
            plain
        } else {
            rate
        }
    }

    pub fn check_length(&self, samples: usize, line: usize) -> Result<(), Fault> {
        if samples >= Log::MIN_SAMPLES {
            return Ok(());
        }
        let message = format!(
            "the log ends after {}, expected at least {}: the filters of the torque balance settle over the {SETTLING} at \
             either end; record longer",
            counted(samples, "sample"),
            least_balanced_samples()
        );
        Err(Fault::new(line, message))
    }

    /// What can be read but hardly be so: samples that are alone in their column. Of a position that is, the straight line
    /// between its neighbours is taken.
    pub fn mend_doubts(&mut self) -> Vec<Fault> {
        let mut doubts = self.mend_spikes();
        let columns = [INPUT, CURRENT, VELOCITY, COMMAND, LOAD_TORQUE];
        doubts.extend(columns.into_iter().filter_map(|column| self.alone(column)));
        doubts
    }

    /// A sample many times as large as every other one of its column, or a few that are as no converter has them: a drive holds
    /// what it drives for longer, and a winding its current.
    fn alone(&self, column: usize) -> Option<Fault> {
        let values = self.columns[column].as_deref()?;
        let mut rows: Vec<usize> = (0..values.len()).collect();
        let size = |row: usize| values[row].abs();
        let most = MOST_SPIKES.min(rows.len().checked_sub(1)?);
        rows.select_nth_unstable_by(most, |a, b| size(*b).total_cmp(&size(*a)));
        rows.truncate(most + 1);
        rows.sort_by(|a, b| size(*b).total_cmp(&size(*a)).then(a.cmp(b)));
        let is_alone = |count: &usize| {
            let (last, next) = (size(rows[count - 1]), size(rows[*count]));
            next > 0.0 && last > next * if *count == 1 { SPIKE } else { RANGE }
        };
        let count = (1..=most).rev().find(is_alone)?;
        let (row, next) = (rows[0], size(rows[count]));
        let others = match count {
            1 => " alone".to_owned(),
            2 => ", about as much in one other".to_owned(),
            _ => format!(", about as much in {} others", count - 1),
        };
        let message = format!(
            "`{}` is {:?} in this sample{others}, and {next:?} at most in the rest: correct it, or remove the row",
            COLUMNS[column].0, values[row]
        );
        Some(Fault::new(self.lines[row], message))
    }

    /// Positions that jump for a few samples in a log that is smooth otherwise: no machine moves there and back so fast. What
    /// lies between two others gets the straight line between these, in whole steps of the sensor.
    fn mend_spikes(&mut self) -> Vec<Fault> {
        let Some(position) = self.columns[POSITION].as_deref_mut() else {
            return Vec::new();
        };
        let damaged = spikes(position);
        if damaged.is_empty() {
            return Vec::new();
        }
        let step = smallest_step(position);
        let mend = |rows: Range<usize>| {
            let message = said_of(&rows, position);
            straighten(position, &rows, step);
            Fault::new(self.lines[rows.start], message)
        };
        damaged.into_iter().map(mend).collect()
    }

    pub fn time(&self) -> &[f64] {
        self.columns[TIME]
            .as_deref()
            .expect("the header was checked")
    }

    /// What an import has changed before in rows that are even now.
    pub(super) fn filled_before(&self, period: f64) -> Option<Resampling> {
        let first = *self.time().first()?;
        let position = self.columns[POSITION].as_deref()?;
        let rows = (0..self.lines.len()).filter(|&row| self.filled.get(row) == Some(&false));
        let there: Vec<usize> = rows.collect();
        if there.len() < 2 || there.len() == self.lines.len() {
            return None;
        }
        let time: Vec<f64> = there.iter().map(|&row| self.time()[row] - first).collect();
        let position: Vec<f64> = there.iter().map(|&row| position[row]).collect();
        let all: Vec<f64> = self.time().iter().map(|time| time - first).collect();
        Some(Instants::with_period(&all, period).summary(&time, &position))
    }

    pub fn last_line(&self) -> usize {
        self.lines.last().copied().unwrap_or(1)
    }

    /// Rows of one time stamp made one: of what was looked at the mean; of what holds to the next row the
    /// last, since the others held for no time. With the sum of the squares of what that changes in the positions.
    ///
    /// # Errors
    /// Most rows share their stamps: these say nothing of when a row was.
    pub fn merge_repeats(mut self) -> Result<(Self, f64), Fault> {
        let time = self.time();
        let rows = time.len();
        let starts: Vec<usize> = (0..rows)
            .filter(|&row| row == 0 || time[row] > time[row - 1])
            .collect();
        if starts.len() == rows {
            return Ok((self, 0.0));
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
                "`time_s` {:?} repeats that of line {}, as many others do; print `time_s` with more digits, or, if the rows are even, give their rate",
                time[row],
                self.lines[row - 1]
            );
            let mend = Mend::Even(self.even_rate());
            return Err(Fault::mended_by(self.lines[row], message, mend));
        }
        let position = self.columns[POSITION].as_deref().unwrap_or_default();
        let moved = |(&start, end): (&usize, usize)| {
            let same = &position[start..end];
            let mean = same.iter().sum::<f64>() / same.len() as f64;
            same.iter().map(|read| (read - mean).powi(2)).sum::<f64>()
        };
        let moved: f64 = starts.iter().zip(ends()).map(moved).sum();
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
        self.filled.clear();
        self.check_length(starts.len(), self.last_line())?;
        Ok((self, moved))
    }

    /// A grid for rows at uneven times, if these can be mended; at a rate of `rate` Hz, or at theirs.
    ///
    /// # Errors
    /// Too much would have to be made up.
    pub(super) fn instants(&self, rate: Option<f64>) -> Result<Instants, Fault> {
        let time = self.time();
        let since_start: Vec<f64> = time.iter().map(|t| t - time[0]).collect();
        let instants = match rate {
            Some(rate) => Instants::with_period(&since_start, 1.0 / rate),
            None => Instants::of(&since_start),
        };
        let period = instants.period;
        let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let resolution = self.digits.resolution(time);
        let refuse = |interval: usize, fault: String, mend: Mend| {
            Err(Fault::mended_by(self.lines[interval + 1], fault, mend))
        };
        let off = |step: &&f64| (**step / period - 1.0).abs() > 0.5;
        if rate.is_none()
            && resolution > period / 2.0
            && steps.iter().filter(off).count() as f64 > MOST_UNTIMED * steps.len() as f64
            && let Some(first) = steps.iter().position(|step| off(&step))
        {
            let fault = format!(
                "{}: print `time_s` with more digits, or, if the rows are even, give their rate",
                describe_step(steps[first], period)
            );
            return refuse(first, fault, Mend::Even(self.even_rate()));
        }
        let is_gap = |step: f64| instants.filled_in(step) > 0 && step > LONGEST_GAP_S;
        let in_motion = |interval: usize| is_gap(steps[interval]) && self.moves_around(interval);
        if let Some(interval) = (0..steps.len()).find(|&interval| in_motion(interval)) {
            let runs = self.runs(|row| in_motion(row - 1));
            let cut = match runs.len() {
                2 => "cut the log here and give both parts",
                _ => "cut the log at each such gap and give the parts",
            };
            let fault = format!(
                "{} in the middle of motion, at most {LONGEST_GAP_S} s are filled in; {cut}",
                describe_step(steps[interval], period)
            );
            return refuse(interval, fault, self.longest_parts(runs));
        }
        let filled = |step: &f64| instants.filled_in(*step) as f64;
        let made_up: f64 = steps.iter().map(filled).sum();
        if made_up > time.len() as f64
            && let Some((widest, _)) =
                (steps.iter().enumerate()).max_by(|(_, a), (_, b)| a.total_cmp(b))
        {
            let wide: Vec<f64> = (steps.iter().copied())
                .filter(|&step| instants.filled_in(step) > 0)
                .collect();
            let (remedy, mend) = if wide.len() as f64 > MOST_UNTIMED * steps.len() as f64 {
                let rate = rounded(1.0 / median(&wide), 3);
                ("bring it to its lower rate", Mend::Rate(rate))
            } else {
                let cut =
                    self.longest_run(|row| instants.filled_in(steps[row - 1]) > time.len() / 10);
                ("cut it here", cut)
            };
            let fault = format!(
                "{}, and more samples would have to be filled in than the log has; {remedy}",
                describe_step(steps[widest], period)
            );
            return refuse(widest, fault, mend);
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
    ///
    /// # Errors
    /// Too few samples are left.
    pub(super) fn resampled(self, path: &Path, instants: Instants) -> Result<Log, Fault> {
        self.check_length(instants.count, self.last_line())?;
        let first = self.time()[0];
        let time: Vec<f64> = self.time().iter().map(|t| t - first).collect();
        let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let slower = instants.period > SLOWER * median(&steps);
        let mut columns = Columns::default();
        for (index, column) in self.columns.iter().enumerate().skip(TIME + 1) {
            columns[index] = column.as_deref().map(|values| match COLUMNS[index].1 {
                Course::Seen if index == CURRENT && slower => instants.averaged(&time, values),
                Course::Seen => instants.interpolated(&time, values),
                Course::Held => instants.held(&time, values),
                Course::Switched => instants.switched(&time, values),
            });
        }
        let position = self.columns[POSITION].as_deref().unwrap_or_default();
        Ok(Log {
            resampling: Some(instants.summary(&time, position)),
            filled: instants.without_row(&time),
            ..Log::of_columns(path, first + instants.start, instants.period, columns)
        })
    }

    /// Whether the time stamps are uniform (see [`Log::read`]).
    ///
    /// # Errors
    /// The column is not in seconds.
    pub fn spacing(&self) -> Result<Spacing, Fault> {
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
            let message = format!("`time_s` steps by {period:e} s; expected seconds");
            // Nothing but days, of the units that times come in, makes such small numbers.
            return Err(Fault::mended_by(
                self.lines[1],
                message,
                Mend::TimeUnit("day"),
            ));
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
#[derive(Debug, Default, Clone)]
pub(crate) struct PrintedDigits {
    decimals: i32,
    significant: i32,
}

impl PrintedDigits {
    pub fn see(&mut self, field: &str) {
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

/// Whether rows that came late, so many of them, belong where their stamps say: they have left gaps there. Behind a
/// clock that was set back they come upon rows that are there already.
fn fills_gaps(time: &[f64], late: usize) -> bool {
    let mut sorted = time.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let steps: Vec<f64> = sorted.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let usual = median(&steps);
    let short = steps.iter().filter(|&&step| step < usual / 2.0).count();
    2 * short <= late
}

/// Whether rows are even though their stamps are not. A stamp that scatters is off by itself, and the mean of [`SETTLING`]
/// of them is near an even clock; where the clock was set, or rows are missing or belong elsewhere, that mean is off too.
fn keeps_pace(time: &[f64]) -> bool {
    let grid = Grid::fit(time);
    let strays: Vec<f64> = (0..time.len())
        .map(|row| time[row] - grid.time(row))
        .collect();
    let is_near = |strays: &[f64]| {
        let mean = strays.iter().sum::<f64>() / SETTLING as f64;
        mean.abs() <= grid.period
    };
    strays.len() >= SETTLING && strays.windows(SETTLING).all(is_near)
}

/// How many rows are earlier than one before them.
pub(crate) fn disordered(time: &[f64]) -> usize {
    let mut latest = f64::NEG_INFINITY;
    let mut count = 0;
    for &stamp in time {
        count += usize::from(stamp < latest);
        latest = latest.max(stamp);
    }
    count
}
