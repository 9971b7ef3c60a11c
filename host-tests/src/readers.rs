//! Programs of `host-tests/formats`, each built when somebody needs it.
//!
//! They read by other people's code, which takes longer to build than all the rest of this program.

use std::path::PathBuf;
use std::process::ExitStatus;

use crate::failure::Failure;
use crate::package::Package;

/// Their package.
pub const READERS: Package = Package { name: "formats" };

/// The feature of the reader of boards' logs.
pub const BOARD_LOG: &str = "defmt";

/// Builds the reader of a feature, or finds it built. `name` is what it reads, `instead` what can be done without it.
///
/// # Errors
/// A reader that cannot be built, with the command that does it.
pub fn build(feature: &str, name: &str, instead: &str) -> Result<PathBuf, Failure> {
    READERS.build(&program(feature), feature).map_err(|failure| {
        Failure::other(format!(
            "the reader of {name} cannot be built: see that the registry can be reached and try again by \
             `cargo build --release --manifest-path host-tests/formats/Cargo.toml --target-dir target/formats \
             --features {feature} --bin {}`{instead}\n{failure}",
            program(feature)
        ))
    })
}

/// Whether the reader of a feature has been built.
pub(crate) fn is_built(feature: &str) -> bool {
    READERS.executable(&program(feature)).exists()
}

fn program(feature: &str) -> String {
    format!("read-{feature}")
}

/// What is wrong with a file, by its reader's exit status and standard error.
pub(crate) fn complaint(status: ExitStatus, said: &[u8]) -> Option<String> {
    if status.success() {
        return None;
    }
    let said = String::from_utf8_lossy(said);
    let first = said.lines().find(|line| !line.trim().is_empty());
    Some(match (status.code(), first) {
        (Some(2), Some(reason)) => reason.to_owned(),
        (_, reason) => format!(
            "is damaged beyond what its reader bears ({})",
            reason.unwrap_or("it says nothing")
        ),
    })
}
