//! The command line of `cargo hil onboard`.

use std::path::PathBuf;

use super::outcome::Onboard;
use crate::board_run;
use crate::emulate::command::{demonstrate, require};
use crate::emulate::run::{Built, CYCLES_PER_INSTRUCTION, Extent};
use crate::emulate::summary::Summary;
use crate::failure::Failure;
use crate::on_target_run;
use crate::outputs::{Kind, Outputs, print};
use crate::progress::announce;

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
    let json = outputs.file(args.json.as_deref(), Kind::Marked)?;
    let mut announce = announce();
    let prepared = board_run::prepare(&mut announce)?;
    announce(
        "an actuator of each kind, and beside it a log of each kind of verdict, on emulated chips",
    );
    let (run, verdicts) = rayon::join(|| prepared.actuators(), || prepared.verdicts());
    let (run, verdicts) = (run?, verdicts?);
    announce("instruction counts");
    let counts = on_target_run::run(&prepared.toolchain)?.counts;
    let built = Built::new(&prepared.toolchain, &mut announce)?;
    let (outcome, traced) =
        demonstrate(&built, CYCLES_PER_INSTRUCTION, Extent::Loop, &mut announce)?;
    let summary = Summary::new(&outcome, &traced, CYCLES_PER_INSTRUCTION);
    let mut text = summary.text(&outcome, &traced, None);
    let onboard = Onboard::read(summary, &run, &verdicts, &counts)?;
    text += &format!(
        "\nAn actuator of each kind on the chip itself\n{}",
        onboard.table()
    );
    outputs.stage_json(json, &onboard)?;
    outputs.commit()?;
    print(&text)?;
    require(&outcome, &traced, None)?;
    run.require_parity()?;
    board_run::require_parity(&verdicts.comparisons)
}
