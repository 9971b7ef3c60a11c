//! `cargo hil bench`: speed on this host.

use std::path::PathBuf;

use crate::failure::Failure;

/// What `cargo hil bench` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Write the result to this file as JSON
    #[arg(long, value_name = "F")]
    pub json: Option<PathBuf>,
}

/// Measures and prints.
///
/// # Errors
/// A result that cannot be written.
pub fn run(_args: &Args) -> Result<(), Failure> {
    Err(Failure::other(
        "nothing to measure: the gap engine is missing",
    ))
}
