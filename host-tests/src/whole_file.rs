//! Files that are there whole or not at all.

use std::fs;
use std::io;
use std::path::Path;

use serde::Serialize;

/// Lets `write` fill a file beside `path` and renames it: a reader never sees half of it, and a
/// failure leaves nothing behind.
///
/// # Errors
/// What `write` or the file system reports.
pub fn write(path: &Path, write: impl FnOnce(&Path) -> io::Result<()>) -> io::Result<()> {
    // Beside the target: a rename does not cross file systems.
    let mut partial = path.as_os_str().to_owned();
    partial.push(format!(".{}.part", std::process::id()));
    let partial = Path::new(&partial);
    let written = write(partial).and_then(|()| fs::rename(partial, path));
    if written.is_err() {
        // It may not even be there; the first error is the one to report.
        let _ = fs::remove_file(partial);
    }
    written
}

/// Writes a value as indented JSON with a newline at its end.
///
/// # Errors
/// What the file system reports.
pub fn write_json(path: &Path, value: &impl Serialize) -> io::Result<()> {
    let mut text = serde_json::to_string_pretty(value).map_err(io::Error::other)?;
    text.push('\n');
    write(path, |partial| fs::write(partial, text))
}
