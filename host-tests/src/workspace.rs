//! Where things are in the user's clone.

use std::path::{Path, PathBuf};

/// The workspace's root.
pub fn root() -> PathBuf {
    let crate_directory = Path::new(env!("CARGO_MANIFEST_DIR"));
    crate_directory
        .parent()
        .unwrap_or(crate_directory)
        .to_owned()
}

/// Where `cargo hil` leaves its results.
pub fn results() -> PathBuf {
    root().join("target/hil")
}
