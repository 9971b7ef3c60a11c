//! How a text lays out its numbers: found from its lines, or as the user says.

use std::borrow::Cow;

use super::stamp::{DAY, SECOND, is_stamp, nanoseconds};

/// What the user says about the layout; what is left open is found.
#[derive(Debug, Clone, Default)]
pub(super) struct Reading {
    /// What separates the fields.
    pub delimiter: Option<Delimiter>,
    /// Numbers are written with commas.
    pub decimal_comma: bool,
    /// The line of the names, from 1; 0 where there are none.
    pub header: Option<usize>,
    /// What a line of comment begins with.
    pub comment: Option<String>,
}

/// What separates the fields of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Delimiter {
    /// One character.
    Character(char),
    /// Any number of spaces and tabs.
    Spaces,
}

impl Delimiter {
    const FOUND: [Self; 5] = [
        Self::Character(','),
        Self::Character(';'),
        Self::Character('\t'),
        Self::Character('|'),
        Self::Spaces,
    ];

    /// As a user gives it.
    ///
    /// # Errors
    /// What was expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        match text {
            "comma" => Ok(Self::Character(',')),
            "semicolon" => Ok(Self::Character(';')),
            "tab" | "\\t" => Ok(Self::Character('\t')),
            "space" | " " => Ok(Self::Spaces),
            _ => {
                let mut characters = text.chars();
                match (characters.next(), characters.next()) {
                    (Some(one), None) if one.is_ascii() && !one.is_ascii_alphanumeric() => {
                        Ok(Self::Character(one))
                    }
                    _ => Err("expected one character, or comma, semicolon, tab, space".into()),
                }
            }
        }
    }

    fn name(self) -> String {
        match self {
            Self::Character(',') => "commas".into(),
            Self::Character(';') => "semicolons".into(),
            Self::Character('\t') => "tabs".into(),
            Self::Character(other) => format!("`{other}`"),
            Self::Spaces => "spaces".into(),
        }
    }

    /// The fields of a line, without the spaces and quotation marks around them.
    pub fn split(self, line: &str) -> Vec<Cow<'_, str>> {
        let character = match self {
            Self::Spaces => return line.split_whitespace().map(Cow::Borrowed).collect(),
            Self::Character(character) => character,
        };
        if !line.contains('"') {
            return line
                .split(character)
                .map(|field| Cow::Borrowed(field.trim()))
                .collect();
        }
        let mut record = csv::StringRecord::new();
        let read = csv::ReaderBuilder::new()
            .has_headers(false)
            .trim(csv::Trim::All)
            .delimiter(character as u8)
            .from_reader(line.as_bytes())
            .read_record(&mut record);
        // Of UTF-8 in memory nothing fails but a line with nothing in it.
        match read {
            Ok(true) => record
                .iter()
                .map(|field| Cow::Owned(field.trim().to_owned()))
                .collect(),
            _ => Vec::new(),
        }
    }
}

/// Where the numbers of a text are and how they are written.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub delimiter: Delimiter,
    pub decimal_comma: bool,
    /// Two fields are one number: what separates the fields separates its decimals too.
    pub pairs: bool,
    /// The place of a field that is one time stamp with the field behind it: what separates the fields separates its
    /// date from its clock, or its seconds from their decimals.
    pub cut_stamp: Option<usize>,
    /// Fields of a row.
    pub width: usize,
    /// What lines of comment begin with.
    pub comment: Option<String>,
    /// The line of the names, from 0.
    pub names: Option<usize>,
    /// The line of the units, from 0.
    pub units: Option<usize>,
    /// The first line of numbers, from 0.
    pub start: usize,
}

/// What a line may begin with that holds no numbers.
const COMMENTS: [&str; 5] = ["#", "%", "//", "!", "*"];

/// Lines that the layout is found from: the second half of a file has no preamble.
pub(super) const SAMPLE: usize = 200;

/// A cell as a number.
pub(super) fn number(field: &str, decimal_comma: bool) -> Option<f64> {
    if decimal_comma && field.contains(',') {
        // What has a point too is a date, or has thousands apart.
        let plain = field.bytes().filter(|byte| *byte == b',').count() == 1
            && !field.contains('.')
            && !field.ends_with(',');
        return plain
            .then(|| field.replace(',', ".").parse().ok())
            .flatten();
    }
    if let Ok(value) = field.parse() {
        return Some(value);
    }
    match field.to_ascii_lowercase().as_str() {
        "true" | "on" => Some(1.0),
        "false" | "off" => Some(0.0),
        _ => None,
    }
}

fn numbers(fields: &[Cow<'_, str>], decimal_comma: bool) -> usize {
    let is_number = |field: &&Cow<'_, str>| number(field, decimal_comma).is_some();
    fields.iter().filter(is_number).count()
}

impl Layout {
    /// Finds what the user has not said. `None` where no two columns of numbers are.
    pub fn find(lines: &[&str], reading: &Reading) -> Option<Self> {
        let comment = reading.comment.clone().or_else(|| found_comment(lines));
        let rows: Vec<&str> = lines
            .iter()
            .copied()
            .filter(|line| !line.trim().is_empty() && !is_comment(line, comment.as_deref()))
            .collect();
        let from = (rows.len() / 2).min(rows.len().saturating_sub(SAMPLE / 2));
        let sample = &rows[from..rows.len().min(from + SAMPLE)];
        let candidates = match reading.delimiter {
            Some(delimiter) => vec![delimiter],
            None => Delimiter::FOUND.to_vec(),
        };
        let (_, delimiter, decimal_comma, width) = candidates
            .into_iter()
            .filter_map(|delimiter| judged(sample, delimiter, reading.decimal_comma))
            // Of equals the first.
            .reduce(|best, next| if next.0 > best.0 { next } else { best })?;
        let mut layout = Self {
            delimiter,
            decimal_comma,
            pairs: false,
            cut_stamp: None,
            width,
            comment,
            names: None,
            units: None,
            start: 0,
        };
        layout.find_names(lines, reading);
        layout.find_cut_stamp(lines, sample);
        Some(layout)
    }

    fn find_names(&mut self, lines: &[&str], reading: &Reading) {
        let fields = |at: usize| self.delimiter.split(lines[at]);
        let is_row = |at: &usize| {
            let fields = fields(*at);
            !self.is_comment(lines[*at])
                && fields.len() == self.width
                && numbers(&fields, self.decimal_comma) >= 2
        };
        let start = match reading.header {
            Some(line) => line.min(lines.len()),
            None => (0..lines.len()).find(is_row).unwrap_or(lines.len()),
        };
        // The names stand in the nearest line above that may have them, comment or not.
        let text = |at: usize| self.uncommented(lines[at]);
        let width = |at: usize| self.delimiter.split(text(at)).len();
        let may_name = |at: usize| {
            let fields = self.delimiter.split(text(at));
            let widths = [self.width, self.width.saturating_sub(1).max(1)];
            let paired =
                self.delimiter == Delimiter::Character(',') && 2 * fields.len() == self.width;
            (widths.contains(&fields.len()) || paired)
                && (self.width < 2 || fields.len() >= 2)
                && 2 * numbers(&fields, self.decimal_comma) <= fields.len()
        };
        let mut names = match reading.header {
            Some(0) => None,
            Some(line) => Some((line - 1).min(lines.len().saturating_sub(1))),
            None => (0..start)
                .rev()
                .find(|&at| !text(at).trim().is_empty() && may_name(at)),
        };
        let mut units = None;
        if let Some(at) = names
            && reading.header.is_none()
            && super::text::are_units(&self.delimiter.split(text(at)))
            && let Some(above) = at.checked_sub(1).filter(|&above| may_name(above))
        {
            (names, units) = (Some(above), Some(at));
        }
        let paired = |at: usize| 2 * width(at) == self.width;
        if self.delimiter == Delimiter::Character(',') && names.is_some_and(paired) {
            self.pairs = true;
            self.width /= 2;
            self.decimal_comma = true;
        }
        // Units stand below the names.
        let start = units.or(names).map_or(start, |at| at + 1);
        (self.names, self.units, self.start) = (names, units, start);
    }

    /// Finds a stamp that is cut in two in every row of the sample, and that the names count as one column.
    fn find_cut_stamp(&mut self, lines: &[&str], sample: &[&str]) {
        let named = |at: usize| self.delimiter.split(self.uncommented(lines[at])).len();
        if self.names.is_some_and(|at| named(at) == self.width) {
            return;
        }
        let rows: Vec<Vec<Cow<'_, str>>> = (sample.iter())
            .map(|line| self.delimiter.split(line))
            .filter(|row| row.len() == self.width)
            .collect();
        let is_cut = |row: &Vec<Cow<'_, str>>, place: usize| {
            let (cell, next) = (&row[place], &row[place + 1]);
            let cut = match self.delimiter {
                // The decimals of a clock are milliseconds, or their thousandths, with all their zeros.
                Delimiter::Character(',') => {
                    let decimals = next.bytes().all(|byte| byte.is_ascii_digit());
                    is_stamp(cell) && decimals && matches!(next.len(), 3 | 6)
                }
                Delimiter::Spaces => !is_stamp(cell) && is_stamp(next),
                Delimiter::Character(_) => false,
            };
            cut && is_stamp(&self.whole_stamp(cell, next))
        };
        let everywhere =
            |place: &usize| !rows.is_empty() && rows.iter().all(|row| is_cut(row, *place));
        // Of names that are one fewer than the fields nobody needs proof.
        let is_named = self.names.is_some();
        let mut places = 0..self.width.saturating_sub(1);
        self.cut_stamp =
            places.find(|place| everywhere(place) && (is_named || self.goes_on(lines, *place)));
        self.width -= usize::from(self.cut_stamp.is_some());
    }

    /// Whether a field goes on from row to row as the decimals of the clock before it do: within a second it does not fall, and into
    /// the next one it is less than a second on. Digits that mean something else fall within a second, or stay or rise into the next
    /// one. A row in ten may be out of order, or come behind a gap.
    fn goes_on(&self, lines: &[&str], place: usize) -> bool {
        let rows = lines.iter().filter_map(|line| {
            let row = self.delimiter.split(line);
            let (begin, end) = (row.get(place)?, row.get(place + 1)?);
            let stamps = [begin.to_string(), self.whole_stamp(begin, end)];
            Some(stamps.map(|stamp| nanoseconds(&stamp)))
        });
        let rows: Vec<[i64; 2]> = rows
            .filter_map(|[clock, whole]| Some([clock?, whole?]))
            .collect();
        let step = |from: i64, to: i64| (to - from).rem_euclid(DAY);
        let (within, across): (Vec<_>, Vec<_>) = (rows.iter().zip(rows.iter().skip(1)))
            .map(|([clock, time], [next_clock, next_time])| {
                (step(*clock, *next_clock), step(*time, *next_time))
            })
            .partition(|(seconds, _)| *seconds == 0);
        let mostly = |steps: &[(i64, i64)], least: i64| {
            let on = steps
                .iter()
                .filter(|(_, step)| (least..SECOND).contains(step));
            10 * on.count() >= 9 * steps.len()
        };
        !within.is_empty() && mostly(&within, 0) && mostly(&across, 1)
    }

    /// The two parts of a stamp put together.
    pub fn whole_stamp(&self, begin: &str, end: &str) -> String {
        match self.delimiter {
            Delimiter::Spaces => format!("{begin} {end}"),
            Delimiter::Character(_) => format!("{begin}.{end}"),
        }
    }

    /// Whether a line holds no numbers by what it begins with.
    pub fn is_comment(&self, line: &str) -> bool {
        is_comment(line, self.comment.as_deref())
    }

    /// A line without what makes it a comment.
    pub fn uncommented<'t>(&self, line: &'t str) -> &'t str {
        let line = line.trim_start_matches([' ', '\u{feff}']);
        match self
            .comment
            .as_deref()
            .and_then(|start| line.strip_prefix(start))
        {
            Some(rest) => rest.trim_start(),
            None => line,
        }
    }

    /// In words.
    pub fn describe(&self) -> String {
        let mut words = vec![format!("fields apart by {}", self.delimiter.name())];
        if self.decimal_comma {
            words.push("decimal commas".into());
        }
        words.push(match self.names {
            Some(line) => format!("names in line {}", line + 1),
            None => "no names".into(),
        });
        if let Some(line) = self.units {
            words.push(format!("units in line {}", line + 1));
        }
        words.join(", ")
    }
}

/// Whether a line begins with `start`, as lines of comment do.
fn is_comment(line: &str, start: Option<&str>) -> bool {
    start.is_some_and(|start| line.trim_start().starts_with(start))
}

/// What lines of comment begin with, if some do.
fn found_comment(lines: &[&str]) -> Option<String> {
    let starts = |start: &&&str| lines.iter().any(|line| is_comment(line, Some(start)));
    COMMENTS
        .iter()
        .find(starts)
        .map(|start| (*start).to_owned())
}

/// How well a delimiter explains the lines: how many of them are rows of one width, then how many
/// numbers they have. With whether these are written with commas, and the width.
fn judged(
    sample: &[&str],
    delimiter: Delimiter,
    comma: bool,
) -> Option<((usize, usize), Delimiter, bool, usize)> {
    let rows: Vec<Vec<Cow<'_, str>>> = sample.iter().map(|line| delimiter.split(line)).collect();
    let cells = || rows.iter().flatten();
    let decimal_comma = comma
        || cells().any(|cell| cell.contains(',') && number(cell, true).is_some())
            && !cells().any(|cell| cell.contains('.') && number(cell, false).is_some());
    let mut widths: Vec<usize> = rows.iter().map(Vec::len).collect();
    widths.sort_unstable();
    let usual = *widths.get(widths.len() / 2)?;
    let good = rows.iter().filter(|row| row.len() == usual);
    let counts: Vec<usize> = good.map(|row| numbers(row, decimal_comma)).collect();
    let rows_of_numbers = counts.iter().filter(|count| **count >= 2).count();
    let all = counts.iter().sum();
    (rows_of_numbers > 0).then_some(((rows_of_numbers, all), delimiter, decimal_comma, usual))
}
