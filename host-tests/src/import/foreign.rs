//! MCAP, MDF and Parquet: read by programs of `host-tests/formats`, each built when the first such file comes.

use std::io::{self, BufRead, Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;

use serde::Deserialize;

use super::raw::{Column, Raw};
use crate::error::{InputError, LARGEST_DATA};
use crate::failure::Failure;
use crate::progress::announce;
use crate::readers;

/// A format that a program reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Format {
    /// What a file of it begins with.
    begins: &'static [u8],
    /// What it is called.
    pub name: &'static str,
    /// The feature.
    feature: &'static str,
}

const FORMATS: [Format; 4] = [
    Format {
        begins: b"\x89MCAP0",
        name: "MCAP",
        feature: "mcap",
    },
    Format {
        begins: b"MDF     4",
        name: "MDF",
        feature: "mdf",
    },
    // A logger that was switched off did not finish it.
    Format {
        begins: b"UnFinMF ",
        name: "MDF",
        feature: "mdf",
    },
    Format {
        begins: b"PAR1",
        name: "Parquet",
        feature: "parquet",
    },
];

impl Format {
    /// The format of a file, by its first bytes.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        let known = |format: &Self| bytes.starts_with(format.begins);
        FORMATS.into_iter().find(known)
    }
}

/// What the reader says first.
#[derive(Deserialize)]
struct Head {
    layout: String,
    columns: Vec<Named>,
}

#[derive(Deserialize)]
struct Named {
    name: String,
    unit: String,
    group: usize,
    length: usize,
}

/// Has a file read.
///
/// # Errors
/// What the reader says is wrong with the file; a reader that cannot be built, with the command that does it.
pub(super) fn read(path: &Path, bytes: &[u8], format: Format) -> Result<Raw, Failure> {
    let Format { name, feature, .. } = format;
    announce()(&format!(
        "reading {name} (its reader is built once, which takes minutes)"
    ));
    let program = readers::build(feature, name, ", or write the columns as CSV")?;
    let (said, complaint) = run(Command::new(&program), bytes)
        .map_err(|error| Failure::system(program.display(), &error))?;
    match complaint {
        None => {
            raw(&said).ok_or_else(|| Failure::other(format!("the reader of {name} ended early")))
        }
        Some(reason) => Err(InputError::new(path, None, reason).into()),
    }
}

/// Standard output of the reader; or what is wrong with the file.
fn run(mut program: Command, bytes: &[u8]) -> io::Result<(Vec<u8>, Option<String>)> {
    let mut child = program
        .arg(LARGEST_DATA.to_string())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()?;
    let input = child.stdin.take();
    let output = thread::scope(|scope| {
        scope.spawn(move || {
            // A reader that has refused the file does not take the rest of it.
            let _ = input.map(|mut input| input.write_all(bytes));
        });
        child.wait_with_output()
    })?;
    let complaint = readers::complaint(output.status, &output.stderr);
    Ok((output.stdout, complaint))
}

/// The columns, as the reader wrote them.
fn raw(mut said: &[u8]) -> Option<Raw> {
    let mut head = String::new();
    said.read_line(&mut head).ok()?;
    let head: Head = serde_json::from_str(&head).ok()?;
    let mut raw = Raw {
        layout: head.layout,
        ..Raw::default()
    };
    for column in head.columns {
        let mut bytes = vec![0; column.length * size_of::<f64>()];
        said.read_exact(&mut bytes).ok()?;
        let (numbers, _) = bytes.as_chunks();
        let values: Vec<f64> = numbers
            .iter()
            .map(|&number| f64::from_le_bytes(number))
            .collect();
        raw.lines.extend(raw.lines.len() + 1..=values.len());
        raw.names.push(column.name);
        raw.groups.push(column.group);
        raw.units
            .push(Some(column.unit).filter(|unit| !unit.is_empty()));
        raw.columns.push(Column::of(values));
    }
    Some(raw)
}
