//! Measured data, which is not part of the repository: `../shared/data` beside it.
//!
//! A test that needs a file asks [`path`] for it and returns where there is none. It then says so on
//! standard error, past the test harness's capture, in a line that starts with [`SKIPPED`];
//! `cargo hil test` collects these lines and does not count the tests as passed.

use std::io::Write;
use std::path::PathBuf;

use crate::workspace;

/// What the line of a test that cannot run starts with.
pub const SKIPPED: &str = "SKIPPED ";

/// A file of the measured data, or a line on standard error that names the calling test.
///
/// ```no_run
/// use host_tests::measured;
///
/// let Some(train) = measured::path("emps/train.csv") else { return };
/// assert!(train.is_file());
/// ```
pub fn path(file: &str) -> Option<PathBuf> {
    let data = workspace::root().join("../shared/data").join(file);
    if data.is_file() {
        return Some(data);
    }
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    let line = format!("{SKIPPED}{test}: no {}\n", data.display());
    // In one piece, because tests run side by side. Nothing can be done about a closed stream.
    let _ = std::io::stderr().write_all(line.as_bytes());
    None
}
