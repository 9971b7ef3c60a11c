//! The command line of `cargo hil emulate`.

use std::path::PathBuf;

use super::longest;
use super::recording::{self, Recording};
use super::requirements::Shortcomings;
use super::run::{self, Built, CYCLES_PER_INSTRUCTION, Extent, Outcome};
use super::summary::{Summary, line};
use super::tracing::{self, Traced};
use crate::failure::Failure;
use crate::outputs::{Kind, Outputs, print};
use crate::progress::announce;
use crate::toolchain::Toolchain;

/// What `cargo hil emulate` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Cycles that an instruction takes on average, 1 to 10
    #[arg(long, value_name = "N", default_value_t = CYCLES_PER_INSTRUCTION, value_parser = cycles)]
    cycles_per_instruction: f64,
    /// Cut the power at every operation of a save, not at some, drive the loop for ten minutes, and run the images that
    /// nobody operates at several cycles an instruction: half an hour more
    #[arg(long)]
    at_length: bool,
    /// Write the result to this file as JSON
    #[arg(long, value_name = "F")]
    json: Option<PathBuf>,
}

fn cycles(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(cycles) if (1.0..=10.0).contains(&cycles) => Ok(cycles),
        _ => Err("expected a number from 1 to 10".to_owned()),
    }
}

/// The images run on emulated chips, and the controller's log traced. `announce` is told each step before
/// it begins.
///
/// # Errors
/// An image that does not run, a log that cannot be traced.
pub fn demonstrate(
    built: &Built,
    cycles_per_instruction: f64,
    extent: Extent,
    mut announce: impl FnMut(&str),
) -> Result<(Outcome, Traced), Failure> {
    announce("both images on emulated chips, each alone, then wired to a loop");
    let outcome = run::run(built, cycles_per_instruction, extent)?;
    announce("tracing the controller's log");
    let traced = tracing::trace(&built.images, &outcome)?;
    Ok((outcome, traced))
}

/// Refuses runs that lack something that a user relies on.
///
/// # Errors
/// All of it.
pub fn require(
    outcome: &Outcome,
    traced: &Traced,
    recording: Option<&Recording>,
) -> Result<(), Failure> {
    let mut lacking = Shortcomings::of(outcome).0;
    lacking.extend(Shortcomings::of_tracing(traced).0);
    lacking.extend(
        recording
            .into_iter()
            .flat_map(|recording| Shortcomings::of_recording(recording).0),
    );
    refuse(&lacking)
}

fn refuse(lacking: &[String]) -> Result<(), Failure> {
    if lacking.is_empty() {
        Ok(())
    } else {
        Err(Failure::Other(format!(
            "the images on emulated chips are not in order\n  {}",
            lacking.join("\n  ")
        )))
    }
}

/// Runs the images, prints what came of it, writes what was asked for.
///
/// # Errors
/// What is missing on this machine; an image that is not in order, once that is printed.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut outputs = Outputs::reading([]);
    let json = outputs.file(args.json.as_deref(), Kind::Marked)?;
    let mut announce = announce();
    let toolchain = Toolchain::set_up()?;
    let built = Built::new(&toolchain, &mut announce)?;
    let cycles = args.cycles_per_instruction;
    let extent = if args.at_length {
        Extent::AtLength
    } else {
        Extent::Everything
    };
    let (outcome, traced) = demonstrate(&built, cycles, extent, &mut announce)?;
    announce("recording the controller over its console");
    let recording = recording::run(&built, cycles)?;
    let mut summary = Summary::new(&outcome, &traced, cycles);
    print(&summary.text(&outcome, &traced, Some(&recording)))?;
    let mut lacking = Vec::new();
    if args.at_length {
        announce("the images that nobody operates, at several cycles an instruction");
        let unattended = longest::longest(&toolchain)?;
        lacking = Shortcomings::of_unattended(&unattended).0;
        for image in &unattended {
            let [name, value] = image.row();
            print(&format!("{}\n", line(&name, &value)))?;
        }
        summary.chip.at_other_cycles.extend(unattended);
    }
    outputs.stage_json(json, &summary)?;
    outputs.commit()?;
    require(&outcome, &traced, Some(&recording))?;
    refuse(&lacking)
}
