//! The command line of `cargo hil onboard`.

use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;

use super::outcome::Onboard;
use crate::board_run;
use crate::failure::Failure;
use crate::on_target_run;
use crate::outputs::{Kind, Outputs};

/// What `cargo hil onboard` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Write the result to this file as JSON
    #[arg(long, value_name = "F")]
    json: Option<PathBuf>,
}

/// Runs the board, prints a table, writes what was asked for.
///
/// # Errors
/// What is missing on this machine; a board that differs from this host, once that is reported; a
/// result that cannot be written.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut outputs = Outputs::reading([]);
    let json = outputs.file(args.json.as_deref(), Kind::Json)?;
    let on_terminal = io::stderr().is_terminal();
    let mut announce = |step: &str| {
        if on_terminal {
            eprintln!("{step} ...");
        }
    };
    let run = board_run::run(&mut announce)?;
    announce("a log of each kind of verdict on the emulated board");
    let verdicts = board_run::run_verdicts(&run.toolchain)?;
    announce("instruction counts");
    let counts = on_target_run::run(&run.toolchain)?.counts;
    let onboard = Onboard::read(&run, Some(&verdicts), &counts)?;
    outputs.stage_json(json, &onboard)?;
    outputs.commit()?;
    io::stdout()
        .write_all(onboard.table().as_bytes())
        .map_err(|error| Failure::system("standard output", &error))?;
    run.require_parity()?;
    board_run::require_parity(&verdicts.comparisons)
}
