//! The throttle paper.

use std::path::Path;

use crate::failure::Failure;

pub mod implementations;
mod report;
pub mod stand;
pub mod tables;

/// Runs it.
///
/// # Errors
/// x
pub fn run(_json: Option<&Path>) -> Result<(), Failure> {
    Ok(())
}
