//! The command line of `cargo hil emulate`.

use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;

use super::recording::{self, Recording};
use super::requirements::Shortcomings;
use super::run::{self, CYCLES_PER_INSTRUCTION, Images, Outcome};
use super::summary::Summary;
use super::tracing::{self, Traced};
use crate::failure::Failure;
use crate::outputs::{Kind, Outputs};
use crate::toolchain::Toolchain;

/// What `cargo hil emulate` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Cycles that an instruction takes on average, 1 to 10
    #[arg(long, value_name = "N", default_value_t = CYCLES_PER_INSTRUCTION, value_parser = cycles)]
    cycles_per_instruction: f64,
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

/// The emulation, built, and the images run on it. `announce` is told each step before it begins.
///
/// # Errors
/// What does not build, an image that does not run, a log that cannot be traced.
pub fn demonstrate(
    toolchain: &Toolchain,
    cycles_per_instruction: f64,
    mut announce: impl FnMut(&str),
) -> Result<(Outcome, Traced, Recording), Failure> {
    announce("the emulated chips (built once, which takes minutes)");
    let emulation = run::build()?;
    announce("the images as they are flashed");
    let images = Images::build(toolchain)?;
    announce("both images on emulated chips, wired to a loop");
    let outcome = run::run(&emulation, &images, cycles_per_instruction)?;
    announce("tracing the controller's log");
    let traced = tracing::trace(&images, &outcome)?;
    announce("recording the controller over its console");
    let recording = recording::run(&emulation, &images, cycles_per_instruction)?;
    Ok((outcome, traced, recording))
}

/// Refuses runs that lack something that a user relies on.
///
/// # Errors
/// All of it.
pub fn require(outcome: &Outcome, traced: &Traced, recording: &Recording) -> Result<(), Failure> {
    let mut lacking = Shortcomings::of(outcome).0;
    lacking.extend(Shortcomings::of_tracing(traced).0);
    lacking.extend(Shortcomings::of_recording(recording).0);
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
    let json = outputs.file(args.json.as_deref(), Kind::Json)?;
    let on_terminal = io::stderr().is_terminal();
    let toolchain = Toolchain::set_up()?;
    let (outcome, traced, recording) =
        demonstrate(&toolchain, args.cycles_per_instruction, |step| {
            if on_terminal {
                eprintln!("{step} ...");
            }
        })?;
    let summary = Summary::new(&outcome, &traced, args.cycles_per_instruction);
    outputs.stage_json(json, &summary)?;
    outputs.commit()?;
    io::stdout()
        .write_all(summary.text(&outcome, &traced, &recording).as_bytes())
        .map_err(|error| Failure::system("standard output", &error))?;
    require(&outcome, &traced, &recording)
}
