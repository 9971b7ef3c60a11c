//! Where a column of the log comes from: a column of the file, its unit, and what is done to it.
//!
//! `NAME`, then in any order and worked from left to right `:UNIT`, `*NUMBER`, `/NUMBER`, `+NUMBER`,
//! `-NUMBER`; a `-` in front reverses the sign at the end. So `duty:%*12` takes per cent to volts of a
//! supply of 12 V, `angle-90:deg` takes 90 off before degrees become radians, and `cnt:counts*0.005:mm` is a stroke of
//! 0.005 mm a count. `@NAME` behind all that gives
//! a size its sign, from another column: so `pwm:%*12@dir` is negative where `dir` is 0 or negative.

use std::collections::HashMap;
use std::f64::consts::TAU;

use super::raw::Raw;
use super::text::without_unit;
use super::unit::{Kind, Unit, kinds};
use crate::log::{COLUMNS, CURRENT, INPUT, POSITION, TIME, VELOCITY, quoted};

/// A column of the file with what is done to its values.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Source {
    /// Its place in the file, from 0.
    pub column: usize,
    /// As the user gave it.
    pub text: String,
    /// The unit that was given.
    pub unit: Option<(String, Unit)>,
    /// Multiplications and additions in their order, the unit among them.
    steps: Vec<Step>,
    /// Which of them is the unit.
    unit_at: Option<usize>,
    /// What the user wrote behind the unit, without a direction.
    behind_unit: String,
    /// Whether a `-` in front reverses the sign.
    reversed: bool,
    /// The column that gives the values their sign.
    direction: Option<usize>,
}

/// Columns of the log that a drive or a sensor may give as a size and a direction.
const DIRECTED: [usize; 3] = [INPUT, CURRENT, VELOCITY];

#[derive(Debug, Clone, Copy, PartialEq)]
enum Step {
    Times(f64),
    Plus(f64),
}

impl Step {
    fn applied(self, value: f64) -> f64 {
        match self {
            Self::Times(factor) => value * factor,
            Self::Plus(offset) => value + offset,
        }
    }
}

impl Source {
    /// Reads `text` for a column of the log.
    ///
    /// # Errors
    /// The end of a sentence that says what is wrong and what was expected.
    pub fn parse(text: &str, raw: &Raw, log_column: &str) -> Result<Self, String> {
        let (column, mut rest, reversed) = match find(text, raw) {
            Some((column, rest)) => (column, rest, false),
            None => match text.strip_prefix('-').and_then(|text| find(text, raw)) {
                Some((column, rest)) => (column, rest, true),
                None => return Err(describe_absent(text, raw)),
            },
        };
        let mut source = Self {
            column,
            text: text.to_owned(),
            unit: None,
            steps: Vec::new(),
            unit_at: None,
            behind_unit: String::new(),
            reversed,
            direction: None,
        };
        while let Some(sign) = rest.chars().next() {
            let after = &rest[sign.len_utf8()..];
            if sign == '@' {
                source.direction = Some(direction(after, raw, log_column)?);
                break;
            }
            if sign == ':' {
                rest = source.take_unit(after, log_column)?;
                let behind = rest.split('@').next().unwrap_or_default();
                source.behind_unit = behind.to_owned();
                continue;
            }
            let end = number_end(after);
            let number = after[..end].parse::<f64>().ok().filter(|n| n.is_finite());
            let Some(number) = number else {
                return Err(format!(
                    "{} has no number after `{sign}`; expected as in duty:%*12",
                    quoted(text)
                ));
            };
            source.steps.push(match sign {
                '*' => Step::Times(number),
                '/' if number != 0.0 => Step::Times(1.0 / number),
                '+' => Step::Plus(number),
                '-' => Step::Plus(-number),
                _ => return Err(format!("{} divides by zero", quoted(text))),
            });
            rest = &after[end..];
        }
        source.require_size(log_column)?;
        source.check_stamps(raw, log_column)?;
        if reversed {
            source.steps.push(Step::Times(-1.0));
        }
        Ok(source)
    }

    fn take_unit<'t>(&mut self, after: &'t str, log_column: &str) -> Result<&'t str, String> {
        // The longest known unit: `deg/s*2`, `counts/4096*-1`, `N·m`.
        let ends = after.char_indices().map(|(at, c)| at + c.len_utf8());
        let fits = |end: &usize| {
            let next = after[*end..].chars().next();
            next.is_none_or(|c| ":*+-/@".contains(c)) && Unit::find(&after[..*end]).is_some()
        };
        let end = ends.filter(fits).max().unwrap_or(0);
        let allowed = kinds(log_column);
        let expected = || match allowed {
            [] => format!("`{log_column}` has no unit"),
            kinds => format!("expected one of {}", Unit::known(kinds)),
        };
        let Some(unit) = Unit::find(&after[..end]) else {
            let word: String = after.chars().take_while(|c| !"*+@".contains(*c)).collect();
            return Err(format!(
                "does not know the unit {}; {}",
                quoted(&word),
                expected()
            ));
        };
        let name = &after[..end];
        let mut unit = unit;
        // Counts of so many a turn are an angle, and a second of them a velocity.
        if name.starts_with("counts/") && log_column == "velocity" {
            unit.kind = Kind::AngularVelocity;
        }
        if !allowed.contains(&unit.kind) {
            return Err(format!("cannot be in {}; {}", quoted(name), expected()));
        }
        match &self.unit {
            // What a count is in is said behind how much it is.
            Some((_, before)) if before.kind == Kind::Counts && unit.kind != Kind::Counts => {
                self.require_size(log_column)?;
            }
            None => {}
            Some(_) => {
                return Err(format!(
                    "{} has two units; expected one",
                    quoted(&self.text)
                ));
            }
        }
        self.unit = Some((name.to_owned(), unit));
        self.unit_at = Some(self.steps.len());
        self.steps.push(Step::Times(unit.factor));
        Ok(&after[end..])
    }

    /// Refuses a share of nothing and counts of no size: such a log passes as one in volts or radians.
    fn require_size(&self, log_column: &str) -> Result<(), String> {
        let Some((name, unit)) = &self.unit else {
            return Ok(());
        };
        let mut steps = self.steps.iter().enumerate();
        let is_sized = steps
            .any(|(place, step)| Some(place) != self.unit_at && matches!(step, Step::Times(_)));
        let text = quoted(&self.text);
        let column = self.text.split(':').next().unwrap_or_default();
        match unit.kind {
            _ if is_sized => Ok(()),
            Kind::Share => Err(format!(
                "{text} says what share of the supply it is, and the supply's voltage is missing: write \
                 \"{column}:{name}*12\" if that is 12 V. A machine file that was made with --input duty knows the voltage \
                 itself, and takes \"{column}:{name}*1\""
            )),
            Kind::Counts if log_column == COLUMNS[POSITION].0 => Err(format!(
                "{text} does not say how much a count is; expected as in {column}:counts/4096 for an angle of so many \
                 counts a turn, \"{column}:counts*0.005:mm\" for a stroke of so many millimetres a count, or \
                 \"{column}:counts*0.001\" for so many rad or m a count"
            )),
            Kind::Counts => Err(format!(
                "{text} does not say how much a count is; expected as in \"{column}:counts*0.001\" for so much a count"
            )),
            _ => Ok(()),
        }
    }

    /// Refuses time stamps in another unit than seconds, and where no time is asked for.
    fn check_stamps(&self, raw: &Raw, log_column: &str) -> Result<(), String> {
        let Some(stamp) = &raw.columns[self.column].first_stamp else {
            return Ok(());
        };
        let name = raw.name(self.column);
        if log_column != COLUMNS[TIME].0 {
            return Err(format!(
                "asks for the column {}, which holds time stamps ({stamp}); expected a column of numbers",
                quoted(&name)
            ));
        }
        match &self.unit {
            Some((unit, known)) if known.factor != 1.0 => Err(format!(
                "cannot be in {}, for {} holds time stamps ({stamp}), which are read as seconds since the first row: \
                 leave the unit out",
                quoted(unit),
                quoted(&name)
            )),
            _ => Ok(()),
        }
    }

    /// A value of the file as the log has it.
    pub fn apply(&self, value: f64) -> f64 {
        self.steps
            .iter()
            .fold(value, |value, step| step.applied(value))
    }

    /// The same of a value of this row, with the sign that its direction has there.
    pub fn apply_at(&self, row: usize, value: f64, raw: &Raw) -> f64 {
        let size = self.apply(value);
        match self.direction {
            Some(column) if raw.columns[column].values[row] <= 0.0 => -size,
            _ => size,
        }
    }

    /// A value of the file in its unit's SI unit, before what is done behind the unit.
    pub fn at_unit(&self, value: f64) -> f64 {
        let end = self.unit_at.map_or(0, |at| at + 1);
        let steps = self.steps[..end].iter();
        steps.fold(value, |value, step| step.applied(value))
    }

    /// What is done behind the unit, as the user wrote it, if that makes a size of a share or of a count.
    pub fn size_behind_unit(&self) -> Option<&str> {
        let unit_at = self.unit_at?;
        let behind = &self.steps[unit_at + 1..self.steps.len() - usize::from(self.reversed)];
        let is_sized = behind.iter().any(|step| matches!(step, Step::Times(_)));
        is_sized.then_some(&self.behind_unit)
    }

    /// The same column of the file, its sign and its direction, with this in place of everything else that is done to it.
    pub fn written_with(&self, raw: &Raw, spec: &str) -> String {
        let sign = if self.reversed { "-" } else { "" };
        let direction = self
            .direction
            .map(|column| format!("@{}", raw.name(column)));
        let direction = direction.unwrap_or_default();
        format!("{sign}{}{spec}{direction}", raw.name(self.column))
    }

    /// The columns of the file that it is made of.
    pub fn columns(&self) -> impl Iterator<Item = usize> {
        [self.column].into_iter().chain(self.direction)
    }

    /// Whether nothing is done to the values.
    pub fn is_plain(&self) -> bool {
        self.steps.is_empty() && self.direction.is_none()
    }

    /// Whether the values are multiplied by anything but their unit.
    pub fn is_scaled(&self) -> bool {
        let mut steps = self.steps.iter().enumerate();
        // A reversed sign is no size.
        let scales = |step: &Step| matches!(step, Step::Times(factor) if factor.abs() != 1.0);
        steps.any(|(place, step)| Some(place) != self.unit_at && scales(step))
    }

    /// Length of a turn in the file's numbers, where these are an angle; without a unit they are taken
    /// for what becomes rad.
    pub fn turn(&self) -> Option<f64> {
        let gain = |steps: &[Step]| -> f64 {
            let factors = steps.iter().map(|step| match step {
                Step::Times(factor) => *factor,
                Step::Plus(_) => 1.0,
            });
            factors.product::<f64>().abs()
        };
        let turn = match self.unit_at {
            // What is done behind the unit, a gear perhaps, is not in the reading.
            Some(at) => TAU / gain(&self.steps[..=at]),
            None => TAU / gain(&self.steps),
        };
        let angle = self
            .unit
            .as_ref()
            .is_none_or(|(_, unit)| unit.kind == Kind::Angle);
        (angle && turn.is_finite()).then_some(turn)
    }
}

/// The column that a text behind `@` names.
fn direction(text: &str, raw: &Raw, log_column: &str) -> Result<usize, String> {
    if !DIRECTED.iter().any(|index| COLUMNS[*index].0 == log_column) {
        return Err(format!(
            "takes no direction from {}: only --input, --current and --velocity do",
            quoted(text)
        ));
    }
    match find(text, raw) {
        Some((column, "")) if raw.columns[column].first_stamp.is_none() => Ok(column),
        Some((column, "")) => Err(format!(
            "takes its direction from {}, which holds time stamps; expected a column of numbers",
            quoted(&raw.name(column))
        )),
        _ => Err(format!(
            "takes its direction from {}, which is not there; expected one of {}",
            quoted(text),
            raw.listed()
        )),
    }
}

/// The column that the text begins with, and what follows its name: the longest name that fits, then a
/// number that counts columns from 1.
fn find<'t>(text: &'t str, raw: &Raw) -> Option<(usize, &'t str)> {
    let ends = |rest: &str| rest.chars().next().is_none_or(|c| ":*+-/@".contains(c));
    let whole: Vec<&str> = raw.names.iter().map(String::as_str).collect();
    let named = |names: &[&str], alike: fn(&str, &str) -> bool| {
        let names = names.iter().enumerate();
        let fits = names.filter(|(_, name)| {
            !name.is_empty()
                && text.is_char_boundary(name.len().min(text.len()))
                && text.len() >= name.len()
                && alike(&text[..name.len()], name)
                && ends(&text[name.len()..])
        });
        let longest = fits.map(|(column, name)| (name.len(), usize::MAX - column));
        let longest = longest.max();
        longest.map(|(length, column)| (usize::MAX - column, &text[length..]))
    };
    let numbered = || {
        let digits = text.bytes().take_while(u8::is_ascii_digit).count();
        let number: usize = text[..digits].parse().ok()?;
        let rest = &text[digits..];
        (number >= 1 && number <= raw.names.len() && ends(rest)).then(|| (number - 1, rest))
    };
    // `angle` is `angle [deg]` and `angle deg` too, where there is one such column.
    let bare = || {
        let bare = whole.iter().map(|name| without_unit(name).unwrap_or(""));
        let bare: Vec<&str> = bare.collect();
        let mut counts: HashMap<&str, usize> = HashMap::new();
        for name in &bare {
            *counts.entry(name).or_default() += 1;
        }
        let alone: Vec<&str> = bare
            .iter()
            .map(|name| if counts[name] == 1 { *name } else { "" })
            .collect();
        named(&alone, |text, name| text == name)
    };
    named(&whole, |text, name| text == name)
        .or_else(numbered)
        .or_else(|| named(&whole, |text, name| text.eq_ignore_ascii_case(name)))
        .or_else(bare)
}

fn describe_absent(text: &str, raw: &Raw) -> String {
    let end = text.find([':', '*', '@']).unwrap_or(text.len());
    let wanted = quoted(&text[..end]);
    // A line of settings above the table may look like names.
    let header = if raw.layout.contains("names in line") {
        "; if these are not the names, say in which line these are (--header)"
    } else {
        ""
    };
    format!(
        "asks for the column {wanted}, and the file has none of that name; expected one of {}{header}",
        raw.listed()
    )
}

/// Where the number ends that the text begins with.
fn number_end(text: &str) -> usize {
    let bytes = text.as_bytes();
    (0..bytes.len())
        .find(|&at| match bytes[at] {
            b'0'..=b'9' | b'.' | b'e' | b'E' => false,
            b'+' | b'-' => at > 0 && !matches!(bytes[at - 1], b'e' | b'E'),
            _ => true,
        })
        .unwrap_or(bytes.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn raw() -> Raw {
        Raw::named(["t", "pos", "pos-act", "Duty [%]", "", "a:b"])
    }

    #[track_caller]
    fn applied(text: &str, column: &str, value: f64) -> f64 {
        Source::parse(text, &raw(), column).unwrap().apply(value)
    }

    #[test]
    fn a_source_does_what_it_says_from_left_to_right() {
        assert_eq!(applied("t:ms", "time_s", 250.0), 0.25);
        assert_eq!(applied("Duty [%]:%*12", "input", 50.0), 6.0);
        assert_eq!(applied("pos:deg*-1", "position", 180.0), -PI);
        assert_eq!(applied("-pos:deg", "position", 180.0), -PI);
        assert_eq!(applied("pos-90:deg", "position", 180.0), PI / 2.0);
        assert_eq!(applied("pos:counts/4096", "position", 1024.0), TAU / 4.0);
        assert_eq!(applied("pos:counts/4096*2+1", "position", 1024.0), 1.0 + PI);
        assert_eq!(applied("pos:deg/s/2", "velocity", 360.0), PI);
        assert_eq!(applied("pos*1e-3+2", "position", 500.0), 2.5);
        assert_eq!(applied("pos/4", "position", 2.0), 0.5);
    }

    #[test]
    fn a_size_has_the_sign_of_its_direction() {
        let mut raw = raw();
        raw.columns[1].values = vec![1.0, 0.0, -1.0];
        let duty = |text| Source::parse(text, &raw, "input").unwrap();
        let values = |text| [0, 1, 2].map(|row| duty(text).apply_at(row, 50.0, &raw));
        assert_eq!(values("Duty [%]:%*12@pos"), [6.0, -6.0, -6.0]);
        assert_eq!(values("-4:%*12@2"), [-6.0, 6.0, 6.0]);
        assert_eq!(duty("4*2@pos").columns().collect::<Vec<_>>(), [3, 1]);
    }

    #[test]
    fn a_turn_is_that_of_the_reading() {
        for (text, turn) in [
            ("pos", TAU),
            ("pos:deg", 360.0),
            ("pos:deg/10", 360.0),
            ("-pos:rev", 1.0),
            ("pos:counts/4096", 4096.0),
        ] {
            let found = Source::parse(text, &raw(), "position").unwrap().turn();
            assert!(
                found.is_some_and(|found| (found / turn - 1.0).abs() < 1e-12),
                "{text}"
            );
        }
        assert_eq!(
            Source::parse("pos:mm", &raw(), "position").unwrap().turn(),
            None
        );
    }

    #[test]
    fn a_column_is_found_by_name_before_number() {
        let column = |text| Source::parse(text, &raw(), "position").map(|source| source.column);
        assert_eq!(column("pos"), Ok(1));
        assert_eq!(column("pos-act"), Ok(2));
        assert_eq!(column("POS"), Ok(1));
        assert_eq!(column("5"), Ok(4));
        assert_eq!(column("a:b:deg"), Ok(5));
        for absent in ["7", "0", "position", "", "--input", "po"] {
            let error = column(absent).unwrap_err();
            assert!(error.contains("t, pos, pos-act"), "{error}");
        }
    }

    #[test]
    fn what_is_no_source_is_refused() {
        let refused = |text, column, words: &str| {
            let error = Source::parse(text, &raw(), column).unwrap_err();
            assert!(error.contains(words), "{error}");
        };
        refused("t:deg", "time_s", "expected one of s, ms");
        refused("pos:furlong", "position", "\"furlong\"");
        refused("pos:deg:rad", "position", "two units");
        refused("pos*", "position", "no number after `*`");
        refused("pos*x", "position", "no number after `*`");
        refused("pos/0", "position", "divides by zero");
        refused("pos*1e999", "position", "no number");
        refused("pos@t", "position", "takes no direction");
        refused("4:%*12@dir", "input", "\"dir\", which is not there");
        refused("4:%*12@pos*2", "input", "\"pos*2\", which is not there");
    }
}
