//! Files that are there whole or not at all.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::error::InputError;
use crate::failure::Failure;

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

/// Refuses a path at which no file can be: better said before minutes of work than after.
///
/// # Errors
/// A directory that is not there, or a path that is one.
pub fn check_place(path: Option<&Path>) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
    let fail = |reason: String| Err(Failure::other(format!("{}: {reason}", path.display())));
    if path.is_dir() {
        return fail("is a directory; expected the name of a file".to_owned());
    }
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() && !parent.is_dir() => fail(format!(
            "there is no directory {}; create it, or name another file",
            parent.display()
        )),
        _ => Ok(()),
    }
}

/// Refuses a directory for outputs that is a file.
///
/// # Errors
/// It is one.
pub fn check_directory(path: Option<&Path>) -> Result<(), Failure> {
    match path {
        Some(path) if path.exists() && !path.is_dir() => Err(Failure::other(format!(
            "{}: is a file; expected the name of a directory, new or not",
            path.display()
        ))),
        _ => Ok(()),
    }
}

/// Refuses outputs that would replace a file which is read, or each other.
///
/// # Errors
/// The first of them, by whatever names the two are called.
pub fn check_apart<'a>(
    outputs: impl IntoIterator<Item = &'a PathBuf>,
    inputs: impl IntoIterator<Item = &'a PathBuf>,
) -> Result<(), Failure> {
    // What is not there yet is known by its directory.
    let place = |path: &Path| {
        fs::canonicalize(path).ok().or_else(|| {
            let parent = path
                .parent()
                .filter(|parent| !parent.as_os_str().is_empty());
            let directory = fs::canonicalize(parent.unwrap_or(Path::new("."))).ok()?;
            Some(directory.join(path.file_name()?))
        })
    };
    let mut taken: Vec<PathBuf> = inputs.into_iter().filter_map(|path| place(path)).collect();
    for output in outputs {
        let Some(place) = place(output) else { continue };
        if taken.contains(&place) {
            let message = "is another file of this command, and would be replaced; name a new one";
            return Err(InputError::new(output, None, message).into());
        }
        taken.push(place);
    }
    Ok(())
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
