//! `cargo hil decode`: a board's defmt log as lines, and its samples as CSV.

use std::collections::HashMap;
use std::io::{self, BufWriter, Write};
use std::path::PathBuf;

use crate::board_link::log_transfer::LogTransfer;
use crate::board_log::{BoardLog, Recording};
use crate::dictionary::Dictionary;
use crate::error::{InputError, LARGEST_DATA, one_line, read_bytes, tell};
use crate::failure::Failure;
use crate::outputs::{Kind, Outputs};
use crate::printed_log;

/// What `cargo hil decode` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The image that wrote the log
    #[arg(value_name = "ELF")]
    elf: PathBuf,
    /// What it sent, byte for byte, what `probe-rs run` printed of it, or what a terminal program kept of `dump log console`
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// Write the samples of one experiment to this file instead of to the terminal
    #[arg(long, value_name = "F")]
    csv: Option<PathBuf>,
    /// Which experiment: the first one unless it is named; NAME:2 is the second of that name
    #[arg(long, value_name = "NAME", requires = "csv")]
    experiment: Option<String>,
}

/// Prints the log's lines; with `--csv`, writes its samples.
///
/// # Errors
/// A file that is not what it should be, or a result that cannot be written.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut outputs = Outputs::reading([&args.elf, &args.log]);
    let csv = outputs.file(args.csv.as_deref(), Kind::Log)?;
    let dictionary = Dictionary::read(&args.elf)?;
    let bytes = read_bytes(
        &args.log,
        "a defmt log as the board sent it or as probe-rs printed it, or a console's `dump log console`",
        LARGEST_DATA,
    )?;
    let fault = |message: String| Failure::from(InputError::new(&args.log, None, message));
    let captured = LogTransfer::captured(&bytes).map_err(fault)?;
    // What the console sends has numbers alone: its rows make a CSV, and no lines to read.
    let without_samples = args.csv.is_some() || captured.is_some();
    let mut others = 0;
    let log = match captured {
        Some(log) => log,
        None => match printed_log::read(&args.log, &bytes)? {
            Some(printed) => {
                others = printed.others;
                printed.log
            }
            None => dictionary.decode(&bytes)?,
        },
    };
    if log.lines.is_empty() {
        return Err(fault(format!(
            "no frame can be decoded, and no line is one that probe-rs prints of a board's log, or the console's \
             `dump log console` with the control characters that begin its lines; expected the log of {}",
            args.elf.display()
        )));
    }
    let recordings = log.recordings();
    if let (Some(csv), Some(output)) = (&args.csv, csv) {
        let recorded = named(&recordings);
        let chosen = match &args.experiment {
            Some(asked) => recorded.iter().find(|(name, _)| name == asked),
            None => recorded.first(),
        };
        let Some((name, chosen)) = chosen else {
            return Err(fault(match &args.experiment {
                Some(name) => format!(
                    "holds no sample of an experiment {name:?}; expected one of {}",
                    names(&recorded)
                ),
                None => "holds no sample, so there is no CSV to write".to_owned(),
            }));
        };
        outputs.stage(output, chosen.to_csv())?;
        if recorded.len() > 1 && args.experiment.is_none() {
            tell(format_args!(
                "note: {} holds the experiment {name:?}; the log has {}, see --experiment",
                one_line(&csv.to_string_lossy()),
                one_line(&names(&recorded))
            ));
        }
    }
    outputs.commit()?;
    print(&log, without_samples).map_err(|error| Failure::system("standard output", &error))?;
    if others > 0 {
        tell(format_args!(
            "note: {others} lines that are none of the board's left out"
        ));
    }
    if log.damaged > 0 {
        tell(format_args!(
            "warning: {} damaged frames left out",
            log.damaged
        ));
    }
    for recording in &recordings {
        if let Some((before, after)) = recording.first_gap() {
            let of = if recording.name.is_empty() {
                String::new()
            } else {
                format!(" of {:?}", recording.name)
            };
            tell(format_args!(
                "warning: samples{of} are missing, first between number {before} and {after}"
            ));
        }
    }
    Ok(())
}

/// Those with samples, each by its name, and from the second of a name on by its number too.
fn named<'a>(recordings: &'a [Recording<'a>]) -> Vec<(String, &'a Recording<'a>)> {
    let mut numbers: HashMap<&str, usize> = HashMap::new();
    let recorded = recordings
        .iter()
        .filter(|recording| recording.samples().next().is_some());
    recorded
        .map(|recording| {
            let number = numbers.entry(recording.name).or_default();
            *number += 1;
            let name = match *number {
                1 => recording.name.to_owned(),
                number => format!("{}:{number}", recording.name),
            };
            (name, recording)
        })
        .collect()
}

fn names(recorded: &[(String, &Recording)]) -> String {
    let names: Vec<&str> = recorded.iter().map(|(name, _)| name.as_str()).collect();
    names.join(", ")
}

fn print(log: &BoardLog, without_samples: bool) -> io::Result<()> {
    let mut out = BufWriter::new(io::stdout().lock());
    for line in &log.lines {
        if line.sample.is_none() || !without_samples {
            writeln!(out, "{line}")?;
        }
    }
    out.flush()
}
