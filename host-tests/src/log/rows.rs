//! The rows of a log's text and what a cell of them may be.

use std::collections::HashSet;

use super::fault::{Fault, Mend};
use super::{
    BRAKE, COLUMNS, CURRENT, ENABLED, EXPECTED, GREATEST_VALUE, REQUIRED, TIME, counted, quoted,
    rounded,
};
use crate::error::line_ends;
use crate::import::guess::is_current;

/// The rows of a CSV text that are not blank, each with its line.
pub(super) struct Rows<'t> {
    text: &'t [u8],
    reader: csv::Reader<&'t [u8]>,
    offset: usize,
    line: usize,
    /// Where a quotation mark opens that nothing closes.
    unclosed: Option<usize>,
}

impl<'t> Rows<'t> {
    pub fn new(text: &'t str) -> Self {
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
    pub fn check_quotes(&self, finding: &str) -> Result<(), Fault> {
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
        Err(Fault::mended_by(line, message, Mend::SkipBad))
    }

    /// Reads the next row and returns its line, or `None` at the end.
    pub fn read(&mut self, record: &mut csv::StringRecord) -> Option<usize> {
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
pub(super) fn find_columns(
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
        // Nor may a measured current, whatever its name.
        if let (None, Some(name)) = (places[CURRENT], header.iter().find(|name| is_current(name))) {
            return Err(format!(
                "the column {} looks like the motor's current, and a log has that as `{}`, in A; import it, or remove the column",
                quoted(name),
                COLUMNS[CURRENT].0
            ));
        }
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

/// Whether a log may have this number: it is finite, and single precision holds it.
pub(crate) fn is_good(value: f64) -> bool {
    // A NaN fails the comparison.
    value.abs() <= f64::from(f32::MAX)
}

/// A finite number that single precision holds, or the rest of a sentence that says why not.
pub(super) fn parse_number(field: &str) -> Result<f64, String> {
    if field.is_empty() {
        return Err("is empty, expected a number".into());
    }
    let Ok(value) = field.parse::<f64>() else {
        return Err(format!("is {}, expected a number", quoted(field)));
    };
    if is_good(value) {
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
pub(super) fn describe_width(line: usize, fields: usize, width: usize) -> Fault {
    let (remedy, mend) = if fields < width {
        ("the row is cut short; complete or remove it", Mend::SkipBad)
    } else {
        let remedy = "write decimal points, not decimal commas, and one sample a row";
        (remedy, Mend::Read)
    };
    Fault::mended_by(line, describe_fields(fields, width) + remedy, mend)
}

/// That a row has other than the right number of fields, and nothing where it has that.
pub(super) fn describe_fields(fields: usize, width: usize) -> String {
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

/// Whether a log may have this number in a column: any time, and of a machine no more than [`GREATEST_VALUE`].
pub(crate) fn is_credible(name: &str, value: f64) -> bool {
    name == COLUMNS[TIME].0 || value.abs() <= GREATEST_VALUE
}

/// Refuses what no measurement, no brake and no switch can be, whichever column it is.
pub(crate) fn check_value(line: usize, name: &'static str, value: f64) -> Result<(), Fault> {
    if !is_credible(name, value) {
        let message = format!(
            "`{name}` is {value:?}, which no machine does; expected SI units, at most {GREATEST_VALUE:e}: \
             leave the row out, or convert the unit"
        );
        return Err(Fault::mended_by(line, message, Mend::SkipBad));
    }
    if name == COLUMNS[BRAKE].0 && value < 0.0 {
        let message = format!(
            "`brake` is {value:?}, expected 0 or more: the level of the friction that the brake adds, \
             whichever way the machine moves"
        );
        return Err(Fault::mended_by(line, message, Mend::Reverse(name)));
    }
    if name == COLUMNS[ENABLED].0 && value != 0.0 && value != 1.0 {
        let message = format!(
            "`enabled` is {value:?}, expected 0 while the drive lets go of the motor, else 1"
        );
        return Err(Fault::mended_by(line, message, Mend::Read));
    }
    Ok(())
}

/// What a step of `time_s` is beside the period.
pub(super) fn describe_step(step: f64, period: f64) -> String {
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
