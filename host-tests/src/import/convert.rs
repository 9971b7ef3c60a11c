//! From the columns of a file to a log.

use std::path::Path;

use super::groups::Read;
use super::raw::Raw;
use super::recipe::{Recipe, Turn};
use super::slow::{Slow, cut_off};
use super::source::Source;
use super::stamp::is_cut_clock;
use crate::gap::metrics::least_balanced_samples;
use crate::log::fault::{Fault, Mend};
use crate::log::rows::{check_value, is_credible, is_good};
use crate::log::table::{PrintedDigits, Table, disordered};
use crate::log::{COLUMNS, COMMAND, Columns, Course, FILLED, Log, POSITION, TIME, quoted, rounded};

/// A log, and what was done for it.
#[derive(Debug)]
pub(super) struct Converted {
    /// The log.
    pub log: Log,
    /// What can be read but hardly be so.
    pub doubts: Vec<Fault>,
    /// Rows that were looked at.
    pub rows: usize,
    /// Rows that were left out for want of a number that a machine can have.
    pub left_out: usize,
    /// Rows that were earlier than one before them, and were moved.
    pub sorted: usize,
    /// Columns that have a number in every n-th row alone, and were interpolated in the rows between.
    pub slow: Vec<Interpolated>,
    /// Turns that were added or taken off, all together.
    pub turns: usize,
    /// The first time stamp, s, where it was made zero.
    pub zero: Option<f64>,
    /// Of each column of the log the rows before they are resampled.
    pub columns: Columns,
}

/// A column of the log that was interpolated between the rows that have a number.
#[derive(Debug)]
pub(super) struct Interpolated {
    /// Its place among the columns of the log.
    pub index: usize,
    /// Where the file has its numbers.
    pub slow: Slow,
    /// What the straight lines between them cut off, rms, in the unit of the log.
    pub error: f64,
}

/// A clock that reads more than this counts from some year, s: a log starts at zero then.
const CALENDAR_S: f64 = 1e6;

/// Digits of a time stamp that `f64` surely holds.
const DIGITS: usize = 15;

/// Follows a recipe, whose sources have been read.
///
/// # Errors
/// The first row that cannot be in a log, or what cannot be mended about how the rows lie in time.
pub(super) fn convert(
    path: &Path,
    raw: &Raw,
    recipe: &Recipe,
    sources: &[(usize, Source)],
) -> Result<Converted, Fault> {
    let length = raw.columns[sources[0].1.column].values.len();
    let (first, last) = recipe.lines.unwrap_or((1, usize::MAX));
    let kept = |row: &usize| (first..=last).contains(&raw.lines[*row]);
    let all: Vec<usize> = (0..length).filter(kept).collect();
    let rows = all.len();
    if rows == 0 {
        let least = least_balanced_samples();
        let message = format!("no row is left; expected at least {least}");
        return Err(Fault::new(1, message));
    }
    let start = all[0];
    let slow = slow_columns(raw, sources, &all);
    let (mut chosen, left_out) = good_rows(raw, sources, &slow, all, recipe.skip_bad)?;
    if chosen.is_empty() {
        let least = least_balanced_samples();
        let message = format!("no row has all the numbers; expected at least {least} that do");
        return Err(Fault::new(raw.lines[start], message));
    }
    let time = |row: usize| match sources.iter().find(|(index, _)| *index == TIME) {
        Some((_, source)) => source.apply(raw.columns[source.column].values[row]),
        None => (row - start) as f64 / recipe.rate.unwrap_or(1.0),
    };
    if let Some(&row) = chosen.iter().find(|&&row| !is_good(time(row))) {
        let message = "`time_s` becomes more than single precision holds";
        return Err(Fault::new(raw.lines[row], message));
    }
    let mut sorted = 0;
    if recipe.sort {
        let stamps: Vec<f64> = chosen.iter().map(|&row| time(row)).collect();
        sorted = disordered(&stamps);
        chosen.sort_by(|&a, &b| time(a).total_cmp(&time(b)));
    }
    let mut columns = Columns::default();
    let stamps: Vec<f64> = chosen.iter().map(|&row| time(row)).collect();
    let zero = stamps
        .first()
        .copied()
        .filter(|first| first.abs() > CALENDAR_S);
    columns[TIME] = Some(stamps.iter().map(|&stamp| stamped(stamp, zero)).collect());
    let mut turns = 0;
    let mut lines_between = Vec::new();
    for (index, source) in sources.iter().filter(|(index, _)| *index != TIME) {
        let read = &raw.columns[source.column].values;
        let own_slow = slow.iter().find(|slow| slow.column == source.column);
        let own_rows = chosen.iter().copied();
        let own_rows = own_rows.filter(|&row| own_slow.is_none() || !read[row].is_nan());
        let own_rows: Vec<usize> = own_rows.collect();
        let mut values: Vec<f64> = own_rows.iter().map(|&row| read[row]).collect();
        if let Some(turn) = recipe
            .unwrap
            .filter(|_| [POSITION, COMMAND].contains(index))
        {
            turns += unwrapped(&mut values, turn_of(source, turn)?);
        }
        for (value, &row) in values.iter_mut().zip(&own_rows) {
            *value = checked(source.apply_at(row, *value, raw), *index, raw.lines[row])?;
        }
        if let Some(slow) = own_slow {
            let own: Vec<f64> = own_rows.iter().map(|&row| time(row)).collect();
            lines_between.push(Interpolated {
                index: *index,
                slow: slow.clone(),
                error: cut_off(&own, &values),
            });
            values = interpolated(&own, &values, &stamps, raw.lines[chosen[0]])?;
        }
        columns[*index] = Some(values);
    }
    if let Some(turn) = recipe.unwrap {
        bring_to_position(&mut columns, sources, turn);
    }
    let mut table = table_of(raw, &chosen, &columns);
    table.check_order()?;
    table.check_length(rows - left_out, table.last_line())?;
    let doubts = table.mend_doubts();
    let timed = recipe.sources[TIME].is_some();
    let log = Log::of_table(path, table, recipe.rate.filter(|_| timed))?;
    Ok(Converted {
        log,
        doubts,
        rows,
        left_out,
        sorted,
        slow: lines_between,
        turns,
        zero,
        columns,
    })
}

/// The table of these rows, with what an import before this one says that it has filled in.
fn table_of(raw: &Raw, chosen: &[usize], columns: &Columns) -> Table {
    let filled = raw.names.iter().position(|name| name == FILLED);
    let filled = filled.map(|column| &raw.columns[column].values);
    let is_filled = |row: &usize| filled?.get(*row).map(|filled| *filled == 1.0);
    Table {
        lines: chosen.iter().map(|&row| raw.lines[row]).collect(),
        digits: digits(columns[TIME].as_deref().unwrap_or_default()),
        columns: columns.clone(),
        filled: chosen.iter().map_while(is_filled).collect(),
    }
}

/// The columns of slow sensors. What is no row, for its time has no number, does not count.
fn slow_columns(raw: &Raw, sources: &[(usize, Source)], rows: &[usize]) -> Vec<Slow> {
    let time = sources.iter().find(|(index, _)| *index == TIME);
    let has_time = |row: &&usize| {
        time.is_none_or(|(_, time)| !raw.columns[time.column].values[**row].is_nan())
    };
    let rows: Vec<usize> = rows.iter().filter(has_time).copied().collect();
    let slow = sources.iter();
    slow.filter_map(|(index, source)| Slow::find(raw, *index, source, &rows))
        .collect()
}

/// The values at their own times brought to others, on the straight line from one to the next. `line`: the first row's.
fn interpolated(
    own: &[f64],
    values: &[f64],
    times: &[f64],
    line: usize,
) -> Result<Vec<f64>, Fault> {
    let message = "`time_s` does not rise; expected a clock that runs";
    let read = Read::of(own, values).ok_or_else(|| Fault::new(line, message))?;
    let (first, last) = (read.first(), read.last());
    let at = |time: &f64| read.at(time.clamp(first, last), Course::Seen);
    Ok(times.iter().map(at).collect())
}

/// The rows in which every column has a number, or gets one as that of a slow sensor, and how many have not; with `skip_bad`
/// those in which no machine has such a number are left out too.
fn good_rows(
    raw: &Raw,
    sources: &[(usize, Source)],
    slow: &[Slow],
    rows: Vec<usize>,
    skip_bad: bool,
) -> Result<(Vec<usize>, usize), Fault> {
    let fills = |row: usize, column: usize| {
        let mut slow = slow.iter();
        slow.any(|slow| slow.column == column && slow.fills(row))
    };
    let is_blank = |row: usize, column: usize| raw.columns[column].values[row].is_nan();
    let bad = |row: usize| {
        let mut columns = sources
            .iter()
            .flat_map(|(index, source)| source.columns().map(move |column| (*index, column)));
        columns.find(|(_, column)| is_blank(row, *column) && !fills(row, *column))
    };
    let is_possible = |row: usize| {
        sources.iter().all(|(index, source)| {
            let value = source.apply_at(row, raw.columns[source.column].values[row], raw);
            is_blank(row, source.column) || is_credible(COLUMNS[*index].0, value)
        })
    };
    let mostly_blank = |column: usize| {
        let blank = rows.iter().filter(|row| is_blank(**row, column));
        2 * blank.count() > rows.len()
    };
    let before = rows.len();
    let mut good = Vec::with_capacity(before);
    for &row in &rows {
        // Nothing was measured there, and the log is no longer than what was.
        if slow.iter().any(|slow| slow.is_beyond(row)) {
            continue;
        }
        let Some((index, column)) = bad(row) else {
            if !skip_bad || is_possible(row) {
                good.push(row);
            }
            continue;
        };
        if !skip_bad {
            let what = match &raw.columns[column].bad {
                Some((first, what)) if *first == row => what.clone(),
                _ => "none".to_owned(),
            };
            let is_cut = index == TIME && is_cut_clock(what.trim_matches('"'));
            // A column that has no numbers is read the wrong way: without its rows nothing would be left.
            let is_misread = slow.iter().all(|slow| slow.column != column) && mostly_blank(column);
            let remedy = if is_cut {
                "a clock without its hours or its seconds: have the logger or the spreadsheet write 06:29:54.123"
            } else if is_misread {
                "most rows have no number there: see that it is the right column, and what separates the fields (--delimiter)"
            } else {
                "leave such rows out"
            };
            let message = format!(
                "the number for `{}` is {what}, in column {}; {remedy}",
                COLUMNS[index].0,
                quoted(&raw.name(column))
            );
            if is_cut || is_misread {
                return Err(Fault::new(raw.lines[row], message));
            }
            return Err(Fault::mended_by(raw.lines[row], message, Mend::SkipBad));
        }
    }
    let left_out = before - good.len();
    Ok((good, left_out))
}

/// A time stamp without what calculating has added to its digits.
fn stamped(stamp: f64, zero: Option<f64>) -> f64 {
    match zero {
        // A tenth of a microsecond is what f64 holds of the seconds of a calendar.
        Some(zero) => ((stamp - zero) * 1e7).round() / 1e7,
        None => rounded(stamp, DIGITS),
    }
}

fn digits(time: &[f64]) -> PrintedDigits {
    let mut digits = PrintedDigits::default();
    for stamp in time {
        digits.see(&format!("{stamp:?}"));
    }
    digits
}

fn checked(value: f64, index: usize, line: usize) -> Result<f64, Fault> {
    let name = COLUMNS[index].0;
    // A state word is on wherever it is not zero.
    let value = match COLUMNS[index].1 {
        Course::Switched => f64::from(u8::from(value != 0.0)),
        Course::Seen | Course::Held => value,
    };
    if !is_good(value) {
        let message = format!("`{name}` becomes {value:e}, more than single precision holds");
        return Err(Fault::mended_by(line, message, Mend::SkipBad));
    }
    check_value(line, name, value)?;
    Ok(value)
}

/// Length of a turn in the file's numbers.
fn turn_of(source: &Source, turn: Turn) -> Result<f64, Fault> {
    match turn {
        Turn::Of(turn) => Ok(turn),
        Turn::OfUnit => source.turn().ok_or_else(|| {
            let message = format!(
                "{} is no angle: --unwrap has to say at how many of the file's numbers it starts again, \
                 as in --unwrap 65536",
                quoted(&source.text)
            );
            Fault::new(1, message)
        }),
    }
}

/// Takes out the jumps by a turn, and counts them.
fn unwrapped(values: &mut [f64], turn: f64) -> usize {
    let mut offset = 0.0;
    let mut jumps = 0;
    let mut before = values[0];
    for value in values {
        let turns = ((*value - before) / turn).round();
        before = *value;
        if turns != 0.0 {
            offset -= turns * turn;
            jumps += 1;
        }
        *value += offset;
    }
    jumps
}

/// A command that starts on another turn than the position is brought to it.
fn bring_to_position(columns: &mut Columns, sources: &[(usize, Source)], turn: Turn) {
    let command = sources.iter().find(|(index, _)| *index == COMMAND);
    let first = |column: &Option<Vec<f64>>| column.as_ref().map(|values| values[0]);
    let Some((_, source)) = command else {
        return;
    };
    let (Some(position), Some(asked)) = (first(&columns[POSITION]), first(&columns[COMMAND]))
    else {
        return;
    };
    let Ok(turn) = turn_of(source, turn) else {
        return;
    };
    let turn = (source.apply(turn) - source.apply(0.0)).abs();
    let offset = ((position - asked) / turn).round() * turn;
    if offset.is_finite() && offset != 0.0 {
        columns[COMMAND]
            .iter_mut()
            .flatten()
            .for_each(|value| *value += offset);
    }
}
