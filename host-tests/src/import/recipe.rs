//! What becomes of the columns of a file.

use std::path::Path;

use super::call::{Call, quoted};
use super::guess::SOME_RATE;
use super::raw::Raw;
use super::share::may_be_counted;
use super::source::Source;
use super::suspect::{Remedy, Suspicion};
use super::unit::Kind;
use crate::log::fault::Mend;
use crate::log::{COLUMNS, POSITION, TIME};

/// The options that say where a column of the log comes from, in the order of the log's columns.
pub(super) const FLAGS: [&str; COLUMNS.len()] = [
    "--time",
    "--input",
    "--position",
    "--command",
    "--current",
    "--velocity",
    "--brake",
    "--load-torque",
    "--enabled",
];

/// At what a reading of an angle starts again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Turn {
    /// At a turn of its unit.
    OfUnit,
    /// At so many of the file's numbers.
    Of(f64),
}

/// How a file becomes a log.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Recipe {
    /// Where each column of the log comes from, as a user writes it.
    pub sources: [Option<String>; COLUMNS.len()],
    /// Whether the jumps of a position that starts again are taken out.
    pub unwrap: Option<Turn>,
    /// The rate of the log, Hz; where no column is the time, that of the rows.
    pub rate: Option<f64>,
    /// The first and the last line that are kept.
    pub lines: Option<(usize, usize)>,
    /// The rows are put into the order of their time.
    pub sort: bool,
    /// Rows without a number where one has to be are left out.
    pub skip_bad: bool,
    /// What the user said about the layout of the file, and the machine file, as options.
    pub layout: Vec<String>,
}

impl Recipe {
    /// The sources, with the columns of the log that they are for.
    ///
    /// # Errors
    /// The first that cannot be read, with its option.
    pub fn each(&self, raw: &Raw) -> Result<Vec<(usize, Source)>, String> {
        let given = self.sources.iter().enumerate();
        let given = given.filter_map(|(index, text)| Some((index, text.as_ref()?)));
        given
            .map(|(index, text)| {
                let source = Source::parse(text, raw, COLUMNS[index].0);
                let source = source.map_err(|reason| format!("{} {reason}", FLAGS[index]))?;
                Ok((index, source))
            })
            .collect()
    }

    /// The same, of one length.
    ///
    /// # Errors
    /// The first that cannot be read, with its option, or that has another length.
    pub fn parsed(&self, raw: &Raw) -> Result<Vec<(usize, Source)>, String> {
        let sources = self.each(raw)?;
        let length = |column: usize| raw.columns[column].values.len();
        let (_, first) = sources.first().ok_or("no column is asked for")?;
        let first = first.column;
        let odd = sources
            .iter()
            .flat_map(|(_, source)| source.columns())
            .find(|column| length(*column) != length(first));
        let Some(odd) = odd else {
            return Ok(sources);
        };
        let names = [raw.name(first), raw.name(odd)];
        // Of each set of arrays the same name, with a number behind it.
        let bare = |column: usize| {
            raw.names[column].trim_end_matches(|c: char| c.is_ascii_digit() || c == '.')
        };
        let beside = |column: usize, of: usize| {
            let mut others = (0..raw.names.len())
                .filter(move |&other| bare(other) == bare(column) && length(other) == length(of));
            others.next().map(|other| raw.name(other))
        };
        let pairs = [
            beside(odd, first).map(|other| format!("{} and {other}", names[0])),
            beside(first, odd).map(|other| format!("{other} and {}", names[1])),
        ];
        let pairs: Vec<String> = pairs.into_iter().flatten().collect();
        let remedy = if pairs.is_empty() {
            String::new()
        } else {
            format!(", as {} are", pairs.join(" are, or "))
        };
        Err(format!(
            "{} has {} values, {} has {}; expected columns of one length{remedy}",
            names[0],
            length(first),
            names[1],
            length(odd)
        ))
    }

    /// What to put into a guessed call: the rate of rows without a time, and a size for the 1 of each source whose unit says
    /// nothing without it.
    pub fn sizes_to_fill_in(&self, raw: &Raw) -> Vec<String> {
        let given = self.sources.iter().zip(COLUMNS);
        let given = given.filter_map(|(text, (column, _))| {
            let text = text.as_deref()?;
            let source = Source::parse(text, raw, column).ok()?;
            let size = match source.unit?.1.kind {
                Kind::Share => "the volts of the supply",
                Kind::Counts if column == COLUMNS[POSITION].0 => {
                    "the size of a count, in rad or m,"
                }
                Kind::Counts => "the size of a count",
                _ => return None,
            };
            let put = format!("put {size} in place of the 1 of {}", quoted(text));
            if !may_be_counted(raw, source.column) {
                return Some(put);
            }
            let name = raw.name(source.column);
            if text.contains("/255:") {
                let percent = format!("{name}:%*1");
                return Some(format!(
                    "{put}, 255 being the drive's full scale; if that is 100, it is {}",
                    quoted(&percent)
                ));
            }
            let counts = format!("{name}/255:duty*1");
            Some(format!(
                "{put}, which of a PWM that counts to 255 is {}",
                quoted(&counts)
            ))
        });
        let rate = self.sources[TIME]
            .is_none()
            .then(|| format!("put the rate of the rows, Hz, in place of {SOME_RATE}"));
        rate.into_iter().chain(given).collect()
    }

    /// The recipe with what would mend these suspicions, if any is known to.
    pub fn with_remedies(&self, suspicions: &[Suspicion]) -> Option<Self> {
        let mut mended = self.clone();
        for suspicion in suspicions {
            match &suspicion.remedy {
                Some(Remedy::Source(index, text)) => mended.sources[*index] = Some(text.clone()),
                Some(Remedy::Unwrap) => mended.unwrap = Some(Turn::OfUnit),
                None => {}
            }
        }
        (mended != *self).then_some(mended)
    }

    /// Adds what mends a fault. Whether there was anything to add.
    pub fn mend(&mut self, mend: &Mend, raw: &Raw) -> bool {
        let before = self.clone();
        match mend {
            // Nothing of the recipe: each part gets one of its own.
            Mend::Read | Mend::Parts(_) => return true,
            Mend::SkipBad => self.skip_bad = true,
            Mend::Sort => self.sort = true,
            Mend::Lines(first, last) => self.lines = Some((*first, *last)),
            Mend::Even(rate) => {
                self.sources[TIME] = None;
                self.rate = Some(*rate);
            }
            Mend::Rate(rate) => self.rate = Some(*rate),
            Mend::TimeUnit(unit) => {
                let time = self.sources[TIME].as_deref().unwrap_or_default();
                if let Ok(source) = Source::parse(time, raw, COLUMNS[TIME].0) {
                    self.sources[TIME] = Some(format!("{}:{unit}", raw.name(source.column)));
                }
            }
            Mend::Reverse(name) => {
                let index = COLUMNS.iter().position(|(known, _)| known == name);
                if let Some(text) = index.and_then(|index| self.sources[index].as_mut()) {
                    // Reversed twice is as before: nothing would be mended.
                    if text.ends_with("*-1") {
                        return false;
                    }
                    text.push_str("*-1");
                }
            }
        }
        *self != before
    }

    /// The command that follows this recipe.
    pub fn call(&self, path: &Path, out: &str) -> Call {
        let mut call = Call::new(path);
        for (index, source) in self.sources.iter().enumerate() {
            if let Some(source) = source {
                call.source(index, source);
            }
        }
        match self.unwrap {
            None => {}
            Some(Turn::OfUnit) => call.flag("--unwrap"),
            Some(Turn::Of(turn)) => call.option("--unwrap", &turn.to_string()),
        }
        if let Some(rate) = self.rate {
            call.option("--rate", &rate.to_string());
        }
        if let Some((first, last)) = self.lines {
            call.option("--lines", &format!("{first}-{last}"));
        }
        if self.sort {
            call.flag("--sort");
        }
        if self.skip_bad {
            call.flag("--skip-bad");
        }
        for word in &self.layout {
            call.flag(word);
        }
        call.option("--out", out);
        call
    }
}

#[cfg(test)]
mod tests {
    use super::super::raw::Column;
    use super::*;

    /// As a MATLAB file has them that holds measurements of two rates.
    #[test]
    fn columns_of_two_lengths_are_refused_with_those_that_go_together() {
        let mut raw = Raw::named(["time", "duty", "enc", "time.2", "enc.2"]);
        for (column, length) in raw.columns.iter_mut().zip([400, 400, 200, 200, 400]) {
            *column = Column::of(vec![0.0; length]);
        }
        let sources = ["time", "duty", "enc"].map(|name| Some(name.to_owned()));
        let mut recipe = Recipe::default();
        recipe.sources[..3].clone_from_slice(&sources);
        let refused = recipe.parsed(&raw).unwrap_err();
        let together = "as time and enc.2 are, or time.2 and enc are";
        assert!(refused.contains(together), "{refused}");
    }
}
