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
    let decimal = if decimal_comma { ',' } else { '.' };
    if let Some(plain) = ungrouped(field, decimal) {
        return plain.parse().ok();
    }
    if decimal_comma && field.contains(',') {
        // What has a point too is a date.
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

/// What separates thousands: in Switzerland an apostrophe, by the SI a space, which may be one that does not break a line.
const GROUPING: [char; 7] = [',', '.', '\'', '’', ' ', '\u{a0}', '\u{202f}'];

/// A number whose thousands are apart, as in `1,234,567.8`, without what separates them and with a decimal point; `None` of any
/// other. `decimal`: what separates its decimals, and so not its thousands.
fn ungrouped(field: &str, decimal: char) -> Option<String> {
    let digits = field.strip_prefix(['-', '+']).unwrap_or(field);
    let separator = digits.chars().find(|c| !c.is_ascii_digit())?;
    if separator == decimal || !GROUPING.contains(&separator) {
        return None;
    }
    let (whole, decimals) = match digits.split_once(decimal) {
        Some((whole, decimals)) => (whole, Some(decimals)),
        None => (digits, None),
    };
    let mut groups = whole.split(separator);
    let is_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    // `0,001` has decimals: no number of thousands begins with a zero.
    let is_first =
        |text: &str| is_digits(text) && (1..=3).contains(&text.len()) && !text.starts_with('0');
    let is_grouped = groups.next().is_some_and(is_first)
        && groups.all(|group| is_digits(group) && group.len() == 3)
        && decimals.is_none_or(is_digits);
    let sign = &field[..field.len() - digits.len()];
    let plain = whole.replace(separator, "");
    is_grouped.then(|| format!("{sign}{plain}.{}", decimals.unwrap_or("0")))
}

/// Whether a cell is a number whose decimals are behind this, and cannot be one whose thousands are: one with three
/// digits behind a single comma or point may be either.
fn has_decimals(cell: &str, decimal: char) -> bool {
    let other = if decimal == ',' { '.' } else { ',' };
    cell.contains(decimal)
        && number(cell, decimal == ',').is_some()
        && ungrouped(cell, other).is_none()
}

/// Whether a cell is a number with two or more separators of thousands like this.
fn has_thousands(cell: &str, separator: char) -> bool {
    let decimal = if separator == ',' { '.' } else { ',' };
    cell.matches(separator).count() >= 2 && ungrouped(cell, decimal).is_some()
}

/// Whether these cells are written with decimal commas. A cell that can only be read one way decides; a comma or a point with three
/// digits behind it is one of decimals where no cell says that it separates thousands.
fn are_with_commas<'t>(cells: impl Iterator<Item = &'t str> + Clone) -> bool {
    let any = |is_it: fn(&str, char) -> bool, mark: char| {
        cells
            .clone()
            .any(|cell| cell.contains(mark) && is_it(cell, mark))
    };
    if any(has_decimals, '.') || any(has_thousands, ',') {
        return false;
    }
    let may_be = |cell: &str, mark: char| number(cell, mark == ',').is_some();
    any(has_decimals, ',') || any(has_thousands, '.') || any(may_be, ',') && !any(may_be, '.')
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
        // How many numbers a row usually has.
        let rows = sample.iter().map(|line| delimiter.split(line));
        let rows = rows.filter(|fields| fields.len() == width);
        let mut counts: Vec<usize> = rows.map(|fields| numbers(&fields, decimal_comma)).collect();
        counts.sort_unstable();
        let usual = counts.get(counts.len() / 2).copied().unwrap_or(0);
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
        layout.find_names(lines, reading, usual);
        layout.find_cut_stamp(lines, sample);
        Some(layout)
    }

    /// `usual`: how many numbers a row usually has.
    fn find_names(&mut self, lines: &[&str], reading: &Reading, usual: usize) {
        let has = |at: usize, least: usize| {
            let fields = self.delimiter.split(lines[at]);
            !self.is_comment(lines[at])
                && fields.len() == self.width
                && numbers(&fields, self.decimal_comma) >= least
        };
        // A line of settings above the table may hold two numbers, too: the table begins with its first whole row, or with rows
        // right above that which lack a number.
        let begin = || {
            let whole = (0..lines.len()).find(|at| has(*at, usual.max(2)))?;
            let lacking = (0..whole).rev().take_while(|at| has(*at, 2)).last();
            Some(lacking.unwrap_or(whole))
        };
        let start = match reading.header {
            Some(line) => line.min(lines.len()),
            None => begin().unwrap_or(lines.len()),
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

    /// In words. `has_labels`: each value had its name in front.
    pub fn describe(&self, has_labels: bool) -> String {
        let mut words = vec![format!("fields apart by {}", self.delimiter.name())];
        if self.decimal_comma {
            words.push("decimal commas".into());
        }
        words.push(match self.names {
            _ if has_labels => "a name in front of each value".into(),
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
    let cells = || rows.iter().flatten().map(|cell| &**cell);
    let decimal_comma = comma || are_with_commas(cells());
    let mut widths: Vec<usize> = rows.iter().map(Vec::len).collect();
    widths.sort_unstable();
    let usual = *widths.get(widths.len() / 2)?;
    let good = rows.iter().filter(|row| row.len() == usual);
    let counts: Vec<usize> = good.map(|row| numbers(row, decimal_comma)).collect();
    let rows_of_numbers = counts.iter().filter(|count| **count >= 2).count();
    let all = counts.iter().sum();
    (rows_of_numbers > 0).then_some(((rows_of_numbers, all), delimiter, decimal_comma, usual))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_may_be_apart() {
        for (cell, comma, value) in [
            ("1,234,567.8", false, 1_234_567.8),
            ("-12,748", false, -12_748.0),
            ("1'234.5", false, 1_234.5),
            ("1\u{a0}234\u{202f}567", false, f64::NAN),
            ("1\u{202f}234\u{202f}567", false, 1_234_567.0),
            ("1.234.567,8", true, 1_234_567.8),
            ("12 000", true, 12_000.0),
            ("1.234", false, 1.234),
            ("1,234", true, 1.234),
            ("0.001", true, 0.001),
            ("1,23,456", false, f64::NAN),
            ("27.11.2026", true, f64::NAN),
        ] {
            let read = number(cell, comma).unwrap_or(f64::NAN);
            let is_same = read == value || read.is_nan() && value.is_nan();
            assert!(is_same, "{cell}: {read}");
        }
    }

    #[test]
    fn cells_tell_decimal_commas_from_thousands() {
        for (cells, comma) in [
            (["0,5", "1,25", "3"], true),
            (["0.5", "1,250", "3"], false),
            (["1,250", "999", "3"], true),
            (["1,250", "1,000,250", "3"], false),
            (["1.250", "0,5", "3"], true),
            (["1.250", "1.000.250", "0,125"], true),
            (["1.250", "2.125", "3"], false),
            (["0.001", "0.002", "1,000"], false),
        ] {
            assert_eq!(are_with_commas(cells.into_iter()), comma, "{cells:?}");
        }
    }
}
