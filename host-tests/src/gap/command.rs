//! The command line of `cargo hil gap`.

use std::path::PathBuf;

use crate::failure::Failure;

/// What `cargo hil gap` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// What the user declares about the actuator
    #[arg(long, value_name = "M.toml")]
    pub machine: PathBuf,
    /// A log to find the effects in; may be given several times
    #[arg(long, value_name = "A.csv", required = true)]
    pub train: Vec<PathBuf>,
    /// A log to judge them on, opened once at the end; may be given several times
    #[arg(long, value_name = "B.csv")]
    pub validate: Vec<PathBuf>,
    /// Write the result to this file as JSON
    #[arg(long, value_name = "F")]
    pub json: Option<PathBuf>,
    /// Write a report with plots to this directory
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// Finds the effects that the declared machine lacks.
///
/// # Errors
/// A wrong file, or a result that cannot be written.
pub fn run(_args: &Args) -> Result<(), Failure> {
    Err(Failure::other("the gap engine is missing"))
}
