//! A file of any kind as columns of numbers.

use std::io;
use std::path::Path;

use flate2::read::MultiGzDecoder;

use super::layout::Reading;
use super::unit::{Unit, kinds};
use super::{foreign, mat, text};
use crate::error::{InputError, LARGEST_DATA, read_at_most};
use crate::failure::Failure;
use crate::log::rows::is_good;

/// What a file holds, before anybody said what it means.
#[derive(Debug, Clone, Default)]
pub(super) struct Raw {
    /// How it is laid out, in words.
    pub layout: String,
    /// Names of the columns, empty where there is none.
    pub names: Vec<String>,
    /// The unit that the file itself gives a column, as it is spelled there.
    pub units: Vec<Option<String>>,
    /// The columns, in the order of their names.
    pub columns: Vec<Column>,
    /// Which group of rows each column is of, where the file has several, each with a time of its own; empty else.
    pub groups: Vec<usize>,
    /// The line of each row in the file; of arrays its number.
    pub lines: Vec<usize>,
}

/// One column of a file.
#[derive(Debug, Clone, Default)]
pub(super) struct Column {
    /// Row by row; NaN where there is no finite number.
    pub values: Vec<f64>,
    /// The first cell that is none: its row from 0, and what stands there.
    pub bad: Option<(usize, String)>,
    /// The first of its time stamps, where it holds such; its values are seconds since that one.
    pub first_stamp: Option<String>,
}

/// First bytes of what gzip packed.
const GZIP: &[u8] = b"\x1f\x8b";

/// First bytes of formats that are known and not read, and what to do with such a file.
const UNREAD: [(&[u8], &str); 4] = [
    (
        b"MDF ",
        "is MDF of version 3 or older; convert it to version 4, or export its channels as CSV",
    ),
    (
        b"\x89HDF",
        "is HDF5 (a MATLAB file of version 7.3, perhaps); save it by save('F.mat', '-v7') or as CSV",
    ),
    (
        b"MATLAB 7.3",
        "is a MATLAB file of version 7.3; save it by save('F.mat', '-v7')",
    ),
    (
        b"PK\x03\x04",
        "is a spreadsheet or an archive; save the sheet as CSV, or unpack it",
    ),
];

impl Column {
    /// The column of these values.
    pub fn of(mut values: Vec<f64>) -> Self {
        let mut bad = None;
        for (row, value) in values.iter_mut().enumerate() {
            if !is_good(*value) {
                bad.get_or_insert_with(|| (row, format!("{value:?}")));
                *value = f64::NAN;
            }
        }
        Self {
            values,
            bad,
            first_stamp: None,
        }
    }
}

/// Why something packed cannot be read.
pub(super) fn not_unpacked(what: &str, error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::FileTooLarge => {
            let most = LARGEST_DATA >> 20;
            format!("unpacks to more than {most} MB; cut it into shorter files")
        }
        _ => format!("is cut short or damaged {what} ({error})"),
    }
}

impl Raw {
    /// Reads what a file holds, unpacked if it is compressed by gzip.
    ///
    /// # Errors
    /// A format that is not known, with what to do about it; a reader that cannot be built.
    pub fn read(path: &Path, bytes: &[u8], reading: &Reading) -> Result<Self, Failure> {
        let fail = |message: String| InputError::new(path, None, message);
        let compressed = bytes.starts_with(GZIP);
        let unpacked;
        let bytes = if compressed {
            unpacked = read_at_most(MultiGzDecoder::new(bytes), LARGEST_DATA)
                .map_err(|error| fail(not_unpacked("gzip", &error)))?;
            &unpacked[..]
        } else {
            bytes
        };
        let format = foreign::Format::of(bytes);
        let unread = UNREAD.iter().find(|(start, _)| bytes.starts_with(start));
        if let (Some((_, remedy)), None) = (unread, format) {
            return Err(fail((*remedy).to_owned()).into());
        }
        let mut raw = if let Some(format) = format {
            foreign::read(path, bytes, format)?
        } else if mat::is_it(bytes) {
            mat::read(bytes).map_err(fail)?
        } else {
            text::read(path, bytes, reading)?
        };
        if compressed {
            raw.layout = format!("gzip, {}", raw.layout);
        }
        Ok(raw)
    }

    /// What the file is, if that is told by its first bytes and is no text.
    pub fn format_of(bytes: &[u8]) -> Option<&'static str> {
        let unread = UNREAD.iter().any(|(start, _)| bytes.starts_with(start));
        match foreign::Format::of(bytes) {
            Some(format) => Some(format.name),
            None if bytes.starts_with(GZIP) => Some("packed by gzip"),
            None if mat::is_it(bytes) => Some("a MATLAB file"),
            None => unread.then_some("of a format that is not read"),
        }
    }

    /// The columns for a message: names, or how many there are.
    pub fn listed(&self) -> String {
        const SHOWN: usize = 20;
        let names: Vec<String> = (0..self.names.len().min(SHOWN))
            .map(|at| self.name(at))
            .collect();
        let rest = if self.names.len() > SHOWN {
            ", …"
        } else {
            ""
        };
        if self.names.iter().all(String::is_empty) {
            format!("1 to {}, for the columns have no names", self.names.len())
        } else {
            format!("{}{rest}, or a column's number", names.join(", "))
        }
    }

    /// What a column is called where it is asked for: its name, or its number if it has none of its own.
    pub fn name(&self, column: usize) -> String {
        let name = &self.names[column];
        let first = self.names.iter().position(|other| other == name);
        if name.is_empty() || first != Some(column) {
            (column + 1).to_string()
        } else {
            name.clone()
        }
    }

    /// The unit that the file itself gives a column, as it is spelled there, if a column of the log may be
    /// in it and it changes the values: an SI unit does not. A share and a count do by a size that it does not say.
    pub fn own_unit(&self, column: usize, log_column: &str) -> Option<&str> {
        let own = self.stated_unit(column, log_column)?;
        let unit = Unit::find(own)?;
        (unit.factor != 1.0 || unit.needs_size()).then_some(own)
    }

    /// The same of any unit that a column of the log may be in, an SI unit too.
    pub fn stated_unit(&self, column: usize, log_column: &str) -> Option<&str> {
        let own = self.units[column].as_deref()?;
        let unit = Unit::find(own)?;
        kinds(log_column).contains(&unit.kind).then_some(own)
    }

    #[cfg(test)]
    pub fn named<const N: usize>(names: [&str; N]) -> Self {
        Self {
            names: names.map(str::to_owned).to_vec(),
            units: vec![None; N],
            columns: vec![Column::default(); N],
            ..Self::default()
        }
    }
}
