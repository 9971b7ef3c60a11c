//! An input that is a share of the supply's voltage: counts of a PWM, per cent, or a part of one. What shows that a column is such
//! a share, or is not the one that it was given as.

use super::raw::Raw;
use super::source::Source;
use super::unit::Kind;
use crate::gap::disagreement::channels::largest;
use crate::gap::disagreement::units::full_scale;
use crate::quantity::{given, significant};

/// Largest share that rounding makes of the whole: 100 % that was written as 100.4.
const WHOLE: f64 = 1.005;

/// What the counters of microcontrollers are set to end at: all ones of 8, 10, 12 and 16 bits, one more than that, and a
/// thousand. A column of whole numbers whose largest is one of these is more likely such a counter than chance.
const ENDS: [f64; 9] = [
    255.0, 256.0, 1000.0, 1023.0, 1024.0, 4095.0, 4096.0, 65_535.0, 65_536.0,
];

/// How a column is written so that it is read otherwise, and why.
pub(super) struct Reading {
    /// What the column looks like, behind "`input`".
    pub why: String,
    /// What stands behind the column's name in place of its unit.
    pub spec: String,
    /// What to put in place of an example, in brackets; empty where nothing has to be.
    pub hint: String,
}

/// The counter of a PWM.
struct Counter {
    /// The count that is the whole supply.
    full: f64,
    /// Whether the column ends at it.
    is_reached: bool,
}

impl Counter {
    /// That of a column whose largest value this is. `None` of more than 16 bits.
    fn of(largest: f64) -> Option<Self> {
        let is_reached = ENDS.contains(&largest);
        let full = if is_reached {
            Some(largest)
        } else {
            full_scale(largest)
        };
        full.map(|full| Self { full, is_reached })
    }

    /// `a PWM count of 8 bits`.
    fn name(&self) -> String {
        let bits = [8, 10, 12, 16].into_iter().find(|bits| {
            let counts = f64::from(1_u32 << bits);
            self.full == counts || self.full == counts - 1.0
        });
        match bits {
            Some(bits) => format!("a PWM count of {bits} bits"),
            None => format!("a PWM count to {}", given(self.full)),
        }
    }

    /// What shows it.
    fn why(&self, largest: f64) -> String {
        let ends = if self.is_reached { "end at" } else { "reach" };
        format!(
            "looks like {}, for its values are whole and {ends} {}",
            self.name(),
            given(largest)
        )
    }

    /// The hint behind its spelling.
    fn hint(&self, supply: &str) -> String {
        match (self.is_reached, supply) {
            (true, supply) => supply.to_owned(),
            (false, "") => format!("{} being the most", self.full),
            (false, supply) => format!("{} being the most; {supply}", self.full),
        }
    }
}

/// Where the supply's voltage comes from: the factor behind a share, and what to say of it.
pub(super) const SUPPLY: (&str, &str) = ("*12", "put the volts of your supply in place of 12");

/// Whether the name is that of a part of the supply.
pub(super) fn is_share(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    ["duty", "pwm", "percent"]
        .iter()
        .any(|word| name.contains(word))
}

/// Whether no value has decimals.
fn are_whole(values: &[f64]) -> bool {
    values.iter().all(|value| value.fract() == 0.0)
}

/// What an input without a unit, or one that was given as volts, looks like, if that is a share. `is_given`: it was given as volts.
pub(super) fn of_volts(name: &str, values: &[f64], is_given: bool) -> Option<Reading> {
    let most = largest(values);
    let (factor, put) = SUPPLY;
    let counter = Counter::of(most).filter(|counter| {
        // No usual supply has as many volts, and no duty as many per cent.
        let is_beyond = most > 100.0 * WHOLE;
        let is_likely = counter.is_reached || is_share(name) || most <= MILLIVOLTS;
        are_whole(values) && is_beyond && is_likely
    });
    if let Some(counter) = counter {
        return Some(Reading {
            why: counter.why(most),
            spec: format!("/{}:duty{factor}", counter.full),
            hint: counter.hint(put),
        });
    }
    // What stays below a hundred in whole numbers may be either; only the drive's full scale tells.
    let is_either = are_whole(values) && most > 1.5;
    let in_percent = || {
        let mut reading = looks_in("%", most);
        if is_either {
            let other = format!("{name}/255:duty{factor}");
            reading.hint += &format!(
                "; whole numbers may be counts as well, and the drive's full scale decides: if that is 255, --input \"{other}\""
            );
        }
        Some(reading)
    };
    let in_counts = || {
        Some(Reading {
            why: format!(
                "may be a PWM count of 8 bits, for its values are whole and reach {}",
                given(most)
            ),
            spec: format!("/255:duty{factor}"),
            hint: format!(
                "255 being the most; {put}; whole numbers may be per cent as well, and the drive's full scale decides: if that \
                 is 100, --input \"{name}:%{factor}\""
            ),
        })
    };
    let is_percent_at_most = most <= 100.0 * WHOLE;
    match most {
        _ if is_given => None,
        // What is called a PWM is a counter's number before it is anything else.
        _ if is_either && is_percent_at_most && is_counter(name) => in_counts(),
        _ if is_share(name) && most > 1.5 && is_percent_at_most => in_percent(),
        _ if most > MILLIVOLTS => Some(Reading {
            why: format!("may be in mV, for it reaches {}", significant(most, 3)),
            spec: ":mV".to_owned(),
            hint: String::new(),
        }),
        _ if most > 60.0 && is_percent_at_most => in_percent(),
        _ if most <= 1.001 && most > 0.05 => Some(looks_in("duty", most)),
        _ => None,
    }
}

/// An input that may be in this unit of a share of the supply, by its largest value.
fn looks_in(unit: &str, most: f64) -> Reading {
    let (factor, put) = SUPPLY;
    Reading {
        why: format!("may be in {unit}, for it reaches {}", significant(most, 3)),
        spec: format!(":{unit}{factor}"),
        hint: put.to_owned(),
    }
}

/// Whether the name is that of a PWM and says nothing of per cent.
fn is_counter(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let is_percent = ["percent", "pct", "%"]
        .iter()
        .any(|word| name.contains(word));
    name.contains("pwm") && !is_percent
}

/// An input beyond this is no voltage but one in millivolts.
const MILLIVOLTS: f64 = 1e3;

/// What an input that was given as a share looks like, if it goes beyond the whole.
pub(super) fn beyond_whole(source: &Source, raw: &Raw) -> Option<Reading> {
    let (unit, known) = source.unit.as_ref()?;
    let behind = source
        .size_behind_unit()
        .filter(|_| known.kind == Kind::Share)?;
    let values = raw.columns[source.column].values.iter();
    let values: Vec<f64> = values.copied().filter(|value| !value.is_nan()).collect();
    let shares: Vec<f64> = values.iter().map(|value| source.at_unit(*value)).collect();
    let (most, share) = (largest(&values), largest(&shares));
    if share <= WHOLE {
        return None;
    }
    let why = format!(
        "was given in {unit} and reaches {} %, and no duty is more than 100 %: it",
        significant(100.0 * share, 3)
    );
    let counter = Counter::of(most).filter(|_| most > 100.0 * WHOLE);
    Some(match counter {
        Some(counter) => Reading {
            why: if are_whole(&values) {
                format!("{why} {}", counter.why(most))
            } else {
                format!("{why} may be {}", counter.name())
            },
            spec: format!("/{}:duty{behind}", counter.full),
            hint: counter.hint(""),
        },
        None => Reading {
            why: format!("{why} may be in %"),
            spec: format!(":%{behind}"),
            hint: String::new(),
        },
    })
}

/// Whether what looks like per cent may as well be counts of a PWM that stayed small: whole numbers of no stated unit.
pub(super) fn may_be_counted(raw: &Raw, column: usize) -> bool {
    let values = raw.columns[column].values.iter();
    let numbers: Vec<f64> = values.copied().filter(|value| !value.is_nan()).collect();
    is_share(&raw.name(column)) && raw.units[column].is_none() && are_whole(&numbers)
}

/// How a share of the supply is written without the supply, where a column's name and values look like one.
pub(super) fn unsized_share(name: &str, values: &[f64]) -> Option<String> {
    let reading = of_volts(name, values, false).filter(|_| is_share(name))?;
    let spec = reading.spec.strip_suffix(SUPPLY.0)?;
    Some(format!("{name}{spec}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::raw::Column;

    /// Whole numbers from nothing to `most` and back, in steps of `step`.
    fn counted(most: f64, step: f64) -> Vec<f64> {
        (0..400)
            .map(|row| (most * (0.05 * f64::from(row)).sin() / step).round() * step)
            .chain([most, -most])
            .collect()
    }

    #[test]
    fn a_pwm_count_is_told_from_volts_and_millivolts() {
        for (name, most, step, spec) in [
            ("pwm", 255.0, 1.0, "/255:duty*12"),
            ("u", 255.0, 1.0, "/255:duty*12"),
            ("u", 187.0, 1.0, "/255:duty*12"),
            ("ctrl", 1023.0, 1.0, "/1023:duty*12"),
            ("ctrl", 1000.0, 1.0, "/1000:duty*12"),
            ("m1", 4095.0, 1.0, "/4095:duty*12"),
            ("duty", 3000.0, 1.0, "/4095:duty*12"),
            ("u", 11_873.0, 1.0, ":mV"),
            ("u", 11_873.5, 0.5, ":mV"),
            ("pwm", 80.0, 1.0, "/255:duty*12"),
            ("pwm", 80.0, 0.1, ":%*12"),
            ("pwm_percent", 80.0, 1.0, ":%*12"),
            ("duty", 80.0, 1.0, ":%*12"),
            ("u", 90.0, 0.1, ":%*12"),
            ("u", 0.9, 0.1, ":duty*12"),
        ] {
            let reading = of_volts(name, &counted(most, step), false);
            assert_eq!(reading.unwrap().spec, spec, "{name} {most}");
        }
        // Where the numbers tell neither, both calls are there, and what decides.
        for (name, other) in [
            ("pwm", "pwm:%*12"),
            ("duty", "duty/255:duty*12"),
            ("u", "u/255:duty*12"),
        ] {
            let reading = of_volts(name, &counted(80.0, 1.0), false).unwrap();
            assert!(reading.hint.contains(other), "{}", reading.hint);
            assert!(reading.hint.contains("full scale"), "{}", reading.hint);
        }
        for (name, most, step) in [("u", 12.0, 0.1), ("u", 24.0, 1.0), ("u", 48.0, 1.0)] {
            assert!(of_volts(name, &counted(most, step), false).is_none());
        }
        // Who says volts is believed but for a counter's numbers.
        assert!(of_volts("pwm", &counted(255.0, 1.0), true).is_some());
        assert!(of_volts("u", &counted(90.0, 0.1), true).is_none());
    }

    #[test]
    fn a_share_beyond_the_whole_is_none() {
        let beyond = |text: &str, values: Vec<f64>| {
            let mut raw = Raw::named(["u"]);
            raw.columns[0] = Column::of(values);
            let source = Source::parse(text, &raw, "input").unwrap();
            beyond_whole(&source, &raw).map(|reading| reading.spec)
        };
        for (text, most, step, spec) in [
            ("u:%*12", 255.0, 1.0, Some("/255:duty*12")),
            ("-u:%*24", 1023.0, 1.0, Some("/1023:duty*24")),
            ("u:duty*12", 255.0, 1.0, Some("/255:duty*12")),
            ("u:duty*12", 90.0, 0.1, Some(":%*12")),
            ("u:%*12", 140.0, 0.1, Some("/255:duty*12")),
            ("u:%*12", 100.0, 1.0, None),
            ("u:%*12", 100.4, 0.1, None),
            ("u/255:duty*12", 255.0, 1.0, None),
            // Which of the two factors is the supply nobody knows.
            ("u*12/255:duty", 255.0, 1.0, None),
        ] {
            let found = beyond(text, counted(most, step));
            assert_eq!(found.as_deref(), spec, "{text} {most}");
        }
    }
}
