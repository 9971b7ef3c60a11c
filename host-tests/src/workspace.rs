//! Where things are in the user's clone.

use std::path::{Path, PathBuf};

/// The workspace's root.
pub fn root() -> PathBuf {
    // Cargo says where the crate is now; a clone that was moved was built elsewhere.
    let crate_directory = std::env::var_os("CARGO_MANIFEST_DIR")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")), PathBuf::from);
    crate_directory
        .parent()
        .unwrap_or(&crate_directory)
        .to_owned()
}

/// Where `cargo hil` leaves its results.
pub fn results() -> PathBuf {
    root().join("target/hil")
}

/// A path as it is the same on every machine.
pub fn shown(path: &Path) -> String {
    let inside = path.strip_prefix(root()).unwrap_or(path);
    inside.display().to_string()
}
