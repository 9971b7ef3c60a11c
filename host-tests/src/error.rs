//! What is wrong with a file that the user gave, and where.

use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// One fault of an input file: where it is, what is wrong, and what was expected or how to mend it.
///
/// Displayed as `FILE:LINE: message`, or `FILE: message` where no line is to blame.
///
/// ```
/// use host_tests::error::InputError;
///
/// let error = InputError::new("motor.toml".as_ref(), Some(7), "`inertia` is negative");
/// assert_eq!(error.to_string(), "motor.toml:7: `inertia` is negative");
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InputError {
    /// The file, as the user named it.
    pub file: PathBuf,
    /// The line to blame, counted from 1; `None` where the file as a whole is at fault.
    pub line: Option<usize>,
    /// What is wrong and what was expected, in one line.
    pub message: String,
}

impl InputError {
    /// An error in `file`. Control characters in `message` (quoted from the file, perhaps) are
    /// escaped, so that it stays one line and leaves the terminal alone.
    pub fn new(file: &Path, line: Option<usize>, message: impl AsRef<str>) -> Self {
        let mut one_line = String::with_capacity(message.as_ref().len());
        for character in message.as_ref().chars() {
            if character.is_control() {
                one_line.extend(character.escape_default());
            } else {
                one_line.push(character);
            }
        }
        Self {
            file: file.to_owned(),
            line,
            message: one_line,
        }
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}: {}", self.file.display(), self.message),
            None => write!(f, "{}: {}", self.file.display(), self.message),
        }
    }
}

impl std::error::Error for InputError {}

/// The text of a file without its byte order mark. `expected` ends the messages for a file that
/// cannot be one: "a log (CSV)".
pub(crate) fn read_text(path: &Path, expected: &str) -> Result<String, InputError> {
    let bytes = fs::read(path).map_err(|error| {
        let reason = match error.kind() {
            io::ErrorKind::NotFound => format!("no such file; expected {expected}"),
            io::ErrorKind::IsADirectory => format!("is a directory; expected {expected}"),
            _ => format!("cannot be read ({error}); expected {expected}"),
        };
        InputError::new(path, None, reason)
    })?;
    text_of(path, bytes, expected)
}

/// As [`read_text`], of what a file holds.
pub(crate) fn text_of(path: &Path, bytes: Vec<u8>, expected: &str) -> Result<String, InputError> {
    let mut text = String::from_utf8(bytes).map_err(|error| {
        let fault = error.utf8_error().valid_up_to();
        let line = line_of(error.as_bytes(), fault);
        let message = format!("not UTF-8 text; expected {expected} saved as UTF-8");
        InputError::new(path, Some(line), message)
    })?;
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    Ok(text)
}

/// The line, from 1, that holds the byte at `offset`. A line ends with `\n`, `\r\n` or a lone `\r`.
pub(crate) fn line_of(text: &[u8], offset: usize) -> usize {
    1 + line_ends(text, 0, offset)
}

/// How many lines end in `text[from..to]`.
pub(crate) fn line_ends(text: &[u8], from: usize, to: usize) -> usize {
    (from..to.min(text.len()))
        .filter(|&at| match text[at] {
            b'\n' => true,
            b'\r' => text.get(at + 1) != Some(&b'\n'),
            _ => false,
        })
        .count()
}
