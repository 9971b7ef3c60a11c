//! `cargo hil decode`: a board's defmt log as lines, and its samples as CSV.

use std::io::{self, BufWriter, Write};
use std::path::PathBuf;

use crate::board_log::{self, BoardLog, Dictionary};
use crate::error::InputError;
use crate::failure::Failure;

/// What `cargo hil decode` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The image that wrote the log
    #[arg(value_name = "ELF")]
    elf: PathBuf,
    /// What it sent, byte for byte
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// Write the samples to this file instead of to the terminal
    #[arg(long, value_name = "F")]
    csv: Option<PathBuf>,
}

/// Prints the log's lines; with `--csv`, writes its samples.
///
/// # Errors
/// A file that is not what it should be, or a result that cannot be written.
pub fn run(args: &Args) -> Result<(), Failure> {
    let dictionary = Dictionary::read(&args.elf)?;
    let bytes = board_log::read(&args.log, "a defmt log as the board sent it")?;
    let log = dictionary.decode(&bytes);
    let fault = |message: String| Failure::from(InputError::new(&args.log, None, message));
    if log.lines.is_empty() {
        return Err(fault(format!(
            "no frame can be decoded; expected the log of {}",
            args.elf.display()
        )));
    }
    if let Some(csv) = &args.csv {
        if log.samples().next().is_none() {
            return Err(fault(
                "holds no sample, so there is no CSV to write".to_owned(),
            ));
        }
        log.write_csv(csv)
            .map_err(|error| Failure::system(csv.display(), &error))?;
    }
    print(&log, args.csv.is_some()).map_err(|error| Failure::system("standard output", &error))?;
    if log.damaged > 0 {
        eprintln!("warning: {} damaged frames left out", log.damaged);
    }
    if let Some((before, after)) = log.first_gap() {
        eprintln!("warning: samples are missing, first between number {before} and {after}");
    }
    Ok(())
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
