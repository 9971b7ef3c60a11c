//! Columns of numbers from delimited text, whatever wrote it.

use std::borrow::Cow;
use std::path::Path;

use super::clock;
use super::labelled;
use super::layout::{Delimiter, Layout, Reading, SAMPLE, number};
use super::raw::{Column, Raw};
use super::stamp::{Stamps, is_stamp};
use super::unit::Unit;
use crate::error::InputError;
use crate::log::counted;
use crate::log::rows::is_good;

/// Reads a text.
///
/// # Errors
/// It is none, or has no columns of numbers.
pub(super) fn read(path: &Path, bytes: &[u8], reading: &Reading) -> Result<Raw, InputError> {
    let (text, encoding) = decoded(bytes).ok_or_else(|| {
        let message = "is neither text nor a MATLAB file of version 5; export it as CSV";
        InputError::new(path, None, message)
    })?;
    if text.trim().is_empty() {
        let message = "is empty; expected a row a sample";
        return Err(InputError::new(path, None, message));
    }
    let (names, joined) = match labelled::as_table(&lines(&text)) {
        Some((names, table)) => (Some(names), Some(table)),
        None => (None, with_arrows_as_delimiters(&text, reading)),
    };
    let lines = lines(joined.as_deref().unwrap_or(&text));
    let Some(layout) = Layout::find(&lines, reading) else {
        let message = "has no two columns of numbers; expected a row a sample, \
                       its fields apart by commas, semicolons, tabs or spaces (--delimiter)";
        return Err(InputError::new(path, None, message));
    };
    let mut raw = Raw {
        layout: format!("{encoding}{}", layout.describe(names.is_some())),
        ..Raw::default()
    };
    // The line above the numbers is a header, whether its names could be told or not.
    let above = (0..layout.start).rev().find(|&at| {
        let line = lines[at];
        !line.trim().is_empty() && !layout.is_comment(line)
    });
    let header = layout.names.or(above);
    if let Some(at) = header.filter(|&at| is_left_open(lines[at])) {
        let message = "a quotation mark of the header is not closed; close it, or leave it out";
        return Err(InputError::new(path, Some(at + 1), message));
    }
    (raw.names, raw.units) = names_and_units(&lines, &layout, names);
    raw.columns = vec![Column::default(); layout.width];
    let stamped = stamped(&lines, &layout);
    let mut stamps = vec![None; layout.width];
    let mut comments = 0;
    for (at, line) in lines.iter().enumerate().skip(layout.start) {
        if line.trim().is_empty() {
            continue;
        }
        if layout.is_comment(line) {
            comments += 1;
            continue;
        }
        let fields = rejoined(layout.delimiter.split(line), &layout);
        let is_open = layout.delimiter != Delimiter::Spaces && has_an_odd_mark(line);
        for (place, cell) in fields.iter().enumerate().take(layout.width) {
            if !stamped[place] || stamps[place].is_some() {
                continue;
            }
            stamps[place] = Stamps::beginning_with(cell);
            if stamps[place].is_some() {
                raw.columns[place].first_stamp = Some(cell.to_string());
                raw.units[place] = Some("s".to_owned());
            }
        }
        let read = |place: usize, cell: &str| match &mut stamps[place] {
            _ if !stamped[place] => number(cell, layout.decimal_comma),
            stamps => Stamps::read(stamps.as_mut()?, cell),
        };
        push(&mut raw, (&fields, is_open), at + 1, read);
    }
    drop_empty_end(&mut raw);
    let joined = clock::join_seconds(&mut raw);
    raw.layout += &joined;
    if comments > 0 {
        raw.layout += &format!(", {} left out", counted(comments, "comment line"));
    }
    Ok(raw)
}

/// The names and the units of the columns. `names`: those that stand in front of each value, where they do.
fn names_and_units(
    lines: &[&str],
    layout: &Layout,
    names: Option<Vec<String>>,
) -> (Vec<String>, Vec<Option<String>>) {
    let head = |at: usize| {
        let fields = layout.delimiter.split(layout.uncommented(lines[at]));
        fields
            .into_iter()
            .map(Cow::into_owned)
            .collect::<Vec<String>>()
    };
    let mut names = names.or_else(|| layout.names.map(head)).unwrap_or_default();
    names.resize(layout.width, String::new());
    let units = layout.units.map(head).unwrap_or_default();
    let unit_of = |(column, name): (usize, &String)| {
        let own = units.get(column).map(|unit| bare(unit).to_owned());
        own.or_else(|| unit_in(name))
    };
    let units = names.iter().enumerate().map(unit_of).collect();
    (names, units)
}

/// What a serial monitor puts behind the clock that it adds to a line: `12:00:00.002 -> 0.02,1.31`.
const ARROW: &str = "->";

/// The name of the clock's column where the other columns have names.
const CLOCK: &str = "clock";

/// The text with a delimiter in place of the arrow behind each line's clock, where most lines have one. The delimiter is what
/// separates the fields behind it.
fn with_arrows_as_delimiters(text: &str, reading: &Reading) -> Option<String> {
    if !text.contains(ARROW) {
        return None;
    }
    let parts = |line: &'_ str| {
        let (clock, rest) = line.split_once(ARROW)?;
        let (clock, rest) = (clock.trim(), rest.trim());
        is_stamp(clock).then(|| (clock.to_owned(), rest.to_owned()))
    };
    let all: Vec<(&str, Option<(String, String)>)> = lines(text)
        .into_iter()
        .map(|line| (line, parts(line)))
        .collect();
    let rests: Vec<&str> = (all.iter())
        .filter_map(|(_, parts)| parts.as_ref().map(|(_, rest)| rest.as_str()))
        .collect();
    if 2 * rests.len() <= all.len() {
        return None;
    }
    let found = Layout::find(
        &rests,
        &Reading {
            header: None,
            ..reading.clone()
        },
    );
    let found = found.as_ref();
    let delimiter = found.map_or(Delimiter::Character(','), |layout| layout.delimiter);
    let comma = found.is_some_and(|layout| layout.decimal_comma);
    let between = match delimiter {
        Delimiter::Character(character) => character,
        Delimiter::Spaces => ' ',
    };
    let joined = all.iter().map(|(line, parts)| match parts {
        Some((clock, rest)) => {
            let fields = delimiter.split(rest);
            let is_row = fields.iter().any(|field| number(field, comma).is_some());
            format!("{}{between}{rest}\n", if is_row { clock } else { CLOCK })
        }
        None => format!("{line}\n"),
    });
    Some(joined.collect())
}

/// Columns of time stamps: those with more stamps than numbers in the first rows, so that no row that is damaged decides.
fn stamped(lines: &[&str], layout: &Layout) -> Vec<bool> {
    let mut more = vec![0_i64; layout.width];
    let rows = lines.iter().skip(layout.start);
    for line in rows.filter(|line| !layout.is_comment(line)).take(SAMPLE) {
        let fields = rejoined(layout.delimiter.split(line), layout);
        for (cell, more) in fields.iter().zip(&mut more) {
            // A number costs less to tell than a stamp, and none is both.
            if number(cell, layout.decimal_comma).is_some() {
                *more -= 1;
            } else if is_stamp(cell) {
                *more += 1;
            }
        }
    }
    more.into_iter().map(|more| more > 0).collect()
}

/// Whether a line has a field in quotation marks that does not end. The sign of an inch in a field is none.
fn is_left_open(line: &str) -> bool {
    let mut fields = line.split([',', ';', '\t', '|']);
    has_an_odd_mark(line) && fields.any(|field| field.trim_start().starts_with('"'))
}

/// Whether a quotation mark of a line has no other one.
fn has_an_odd_mark(line: &str) -> bool {
    line.bytes().filter(|byte| *byte == b'"').count() % 2 == 1
}

/// Takes a row: its fields, and whether a quotation mark among them is not closed. `read` gives the number that
/// a cell at a place is, if it is one.
fn push(
    raw: &mut Raw,
    (fields, is_open): (&[Cow<'_, str>], bool),
    line: usize,
    mut read: impl FnMut(usize, &str) -> Option<f64>,
) {
    let row = raw.lines.len();
    let width = raw.columns.len();
    // A delimiter at the end of the line adds an empty field.
    let too_long = fields.len() > width && fields[width..].iter().any(|field| !field.is_empty());
    for (place, column) in raw.columns.iter_mut().enumerate() {
        let cell = fields.get(place);
        let value = cell.and_then(|cell| read(place, cell));
        let good = value.filter(|value| is_good(*value) && !too_long && !is_open);
        column.values.push(good.unwrap_or(f64::NAN));
        if good.is_none() && column.bad.is_none() {
            let said = match cell {
                _ if is_open => "in a row with a quotation mark that is not closed".to_owned(),
                _ if too_long => format!("in a row of {} fields instead of {width}", fields.len()),
                Some(cell) if cell.is_empty() => "empty".to_owned(),
                Some(cell) => crate::log::quoted(cell),
                None => format!(
                    "missing, for the row has {}",
                    counted(fields.len(), "field")
                ),
            };
            column.bad = Some((row, said));
        }
    }
    raw.lines.push(line);
}

/// Two fields made one where a stamp or the decimals are apart by what separates the fields.
fn rejoined<'t>(mut fields: Vec<Cow<'t, str>>, layout: &Layout) -> Vec<Cow<'t, str>> {
    if let Some(place) = layout.cut_stamp
        && place + 1 < fields.len()
    {
        let rest = fields.remove(place + 1);
        fields[place] = Cow::Owned(layout.whole_stamp(&fields[place], &rest));
    }
    if !layout.pairs || fields.len() != 2 * layout.width {
        return fields;
    }
    let pair = |pair: &[Cow<'t, str>]| Cow::Owned(format!("{}.{}", pair[0], pair[1]));
    fields.chunks(2).map(pair).collect()
}

/// Last columns without a name and without a value come from delimiters at the ends of the lines.
fn drop_empty_end(raw: &mut Raw) {
    let is_empty = |raw: &Raw| {
        let column = raw.columns.last();
        column.is_some_and(|column| column.values.iter().all(|value| value.is_nan()))
    };
    while raw.names.last().is_some_and(String::is_empty) && is_empty(raw) {
        raw.columns.pop();
        raw.names.pop();
        raw.units.pop();
    }
}

/// The lines of a text; a lone carriage return ends one too.
fn lines(text: &str) -> Vec<&str> {
    let mut lines = Vec::new();
    let mut rest = text;
    while let Some(end) = rest.find(['\n', '\r']) {
        lines.push(&rest[..end]);
        let ending = if rest[end..].starts_with("\r\n") {
            2
        } else {
            1
        };
        rest = &rest[end + ending..];
    }
    if !rest.is_empty() {
        lines.push(rest);
    }
    lines
}

/// Bytes as text, and how they are encoded if that is worth saying.
fn decoded(bytes: &[u8]) -> Option<(Cow<'_, str>, &'static str)> {
    let wide = |of: fn([u8; 2]) -> u16| {
        let units = bytes[2..]
            .chunks_exact(2)
            .map(|pair| of([pair[0], pair[1]]));
        let text: Result<String, _> = char::decode_utf16(units).collect();
        Some((Cow::Owned(text.ok()?), "UTF-16, "))
    };
    if bytes.starts_with(b"\xff\xfe") {
        return wide(u16::from_le_bytes);
    }
    if bytes.starts_with(b"\xfe\xff") {
        return wide(u16::from_be_bytes);
    }
    if bytes.contains(&0) {
        return without_mark(bytes).map(|text| (Cow::Owned(text), "UTF-16, "));
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    Some(match std::str::from_utf8(bytes) {
        Ok(text) => (Cow::Borrowed(text), ""),
        // What western systems wrote before UTF-8, where ° and µ have the numbers that Unicode gives them.
        Err(_) => (
            Cow::Owned(bytes.iter().map(|&byte| char::from(byte)).collect()),
            "Latin-1, ",
        ),
    })
}

/// UTF-16 without the mark in front that says so: of a table nearly every other byte is 0, the first or the second of each two.
fn without_mark(bytes: &[u8]) -> Option<String> {
    let zeros = |first: usize| {
        let places = bytes.iter().skip(first).step_by(2);
        let count = places.clone().filter(|byte| **byte == 0).count();
        10 * count >= 9 * places.len()
    };
    let of: fn([u8; 2]) -> u16 = match (zeros(0), zeros(1)) {
        (true, false) => u16::from_be_bytes,
        (false, true) => u16::from_le_bytes,
        _ => return None,
    };
    let units = bytes.chunks_exact(2).map(|pair| of([pair[0], pair[1]]));
    char::decode_utf16(units).collect::<Result<_, _>>().ok()
}

/// A unit without the brackets around it.
fn bare(unit: &str) -> &str {
    unit.trim_matches(|c: char| "[](){} ".contains(c))
}

/// Whether these are the units of columns.
pub(super) fn are_units(fields: &[Cow<'_, str>]) -> bool {
    let known = |field: &str| Unit::find(bare(field)).is_some();
    let is_clock = |field: &str| {
        ["mm", "ss"]
            .iter()
            .all(|part| field.to_lowercase().contains(part))
    };
    let may_be =
        |field: &str| matches!(bare(field), "" | "-" | "1") || known(field) || is_clock(field);
    fields.iter().all(|field| may_be(field)) && fields.iter().any(|field| known(field))
}

/// The unit that a name ends with: `time [ms]`, `angle (deg)`, `t_ms`, `current/mA`.
fn unit_in(name: &str) -> Option<String> {
    let bracketed = bracketed(name).map(|(_, unit)| unit);
    let unit = bracketed.or_else(|| suffixed(name).map(|(_, unit)| unit))?;
    Unit::find(unit).map(|_| unit.to_owned())
}

/// A name and the word behind it, which may be its unit.
pub(super) fn suffixed(name: &str) -> Option<(&str, &str)> {
    let name = name.trim_end();
    if bracketed(name).is_some() {
        return None;
    }
    name.rsplit_once(['_', '/', ' '])
}

/// What is left of a name without the unit that stands behind it, in brackets or as a word of its own.
pub(super) fn without_unit(name: &str) -> Option<&str> {
    let spaced = || {
        let (rest, unit) = name.trim_end().rsplit_once(' ')?;
        Unit::find(unit).map(|_| rest.trim_end())
    };
    bracketed(name).map(|(name, _)| name).or_else(spaced)
}

/// A name and what stands in brackets behind it.
fn bracketed(name: &str) -> Option<(&str, &str)> {
    let brackets = [('[', ']'), ('(', ')'), ('{', '}')];
    brackets.into_iter().find_map(|(open, close)| {
        let (name, inside) = name.trim_end().strip_suffix(close)?.rsplit_once(open)?;
        Some((name.trim_end(), inside.trim()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> Raw {
        read(Path::new("a.txt"), text.as_bytes(), &Reading::default()).unwrap()
    }

    fn values(raw: &Raw) -> Vec<Vec<f64>> {
        raw.columns
            .iter()
            .map(|column| column.values.clone())
            .collect()
    }

    /// The same two rows, however they are written.
    #[test]
    fn the_layout_is_found() {
        let expected = [[0.0, 0.25], [1.5, -2.5], [3e-3, 1000.0]].map(|column| column.to_vec());
        for text in [
            "t,u,x\n0,1.5,3e-3\n0.25,-2.5,1000\n",
            "t;u;x\r\n0;1,5;0,003\r\n0,25;-2,5;1000\r\n",
            "t\tu\tx\n0\t1,5\t3e-3\n0,25\t-2,5\t1000",
            "  t   u   x\n  0 1.5 0.003\n 0.25  -2.5   1000\n",
            "# made by a logger, 2026\n# t u x\n0 1.5 0.003\n0.25 -2.5 1000\n",
            "Logger 7\nChannels: 3\n\nt,u,x\n[s],[V],[rad]\n0,1.5,0.003\n# pause\n0.25,-2.5,1000\n",
            "t,u,x\n\"0\",\"1,5\",\"0,003\"\n\"0,25\",\"-2,5\",\"1000\"\n",
            "t,u,x\n0,0,1,5,0,003\n0,25,-2,5,1000,0\n",
            "\u{feff}t|u|x\n0|1.5|0.003\n0.25|-2.5|1000\n",
            "t,u,x,\n0,1.5,0.003,\n0.25,-2.5,1000,\n",
        ] {
            let raw = read_text(text);
            assert_eq!(raw.names, ["t", "u", "x"], "{text}");
            assert_eq!(values(&raw), expected, "{text}");
        }
        let raw = read_text("0;1,5;0,003\n0,25;-2,5;1000\n");
        assert_eq!((raw.names, raw.lines), (vec![String::new(); 3], vec![1, 2]));
    }

    /// As the serial monitor of the Arduino IDE shows lines where it is told to show their times.
    #[test]
    fn an_arrow_behind_a_clock_separates_it() {
        for (text, names) in [
            (
                "12:00:00.002 -> 0.02,1.31,0.5\n12:00:00.252 -> 0.03,1.32,0.6\n",
                ["", "", "", ""],
            ),
            (
                "12:00:00.002 -> 0.02\t1.31\t0.5\r\n12:00:00.252 -> 0.03\t1.32\t0.6\r\n",
                ["", "", "", ""],
            ),
            (
                "12:00:00.002 -> 0.02 1.31 0.5\n12:00:00.252 -> 0.03 1.32 0.6\n",
                ["", "", "", ""],
            ),
            (
                "11:59:59.900 -> u,x,i\n12:00:00.002 -> 0.02,1.31,0.5\n12:00:00.252 -> 0.03,1.32,0.6\n",
                ["clock", "u", "x", "i"],
            ),
        ] {
            let raw = read_text(text);
            assert_eq!(raw.names, names, "{text}");
            let expected = [[0.0, 0.25], [0.02, 0.03], [1.31, 1.32], [0.5, 0.6]];
            assert_eq!(
                values(&raw),
                expected.map(|column| column.to_vec()),
                "{text}"
            );
        }
    }

    #[test]
    fn other_encodings_are_read() {
        let text = "t [ms];Winkel [°]\n1;2\n3;4\n";
        let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
        let mut wide = vec![0xff, 0xfe];
        wide.extend(text.encode_utf16().flat_map(u16::to_le_bytes));
        for bytes in [text.as_bytes(), &latin, &wide] {
            let raw = read(Path::new("a.txt"), bytes, &Reading::default()).unwrap();
            assert_eq!(raw.names[1], "Winkel [°]");
            assert_eq!(raw.units, [Some("ms".to_owned()), Some("°".to_owned())]);
        }
        assert!(read(Path::new("a.txt"), b"\x7fELF\0\0", &Reading::default()).is_err());
    }

    #[test]
    fn a_cell_without_a_number_is_kept_apart() {
        let raw = read_text("t,u\n0,1\n1,\n2,off\n3\n4,nan\n5,1,2\n");
        let column = &raw.columns[1];
        assert_eq!(column.bad, Some((1, "empty".to_owned())));
        let good: Vec<bool> = column
            .values
            .iter()
            .map(|value| value.is_finite())
            .collect();
        assert_eq!(good, [true, false, true, false, false, false]);
    }
}
