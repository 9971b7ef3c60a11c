//! What is wrong with a file that the user gave, and where.

use std::fmt;
use std::fs::File;
use std::io::{self, Read, Write};
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
    /// An error in `file`. `message` (quoted from the file, perhaps) and the name of the file are shown
    /// as [`one_line`] has them.
    pub fn new(file: &Path, line: Option<usize>, message: impl AsRef<str>) -> Self {
        Self {
            file: file.to_owned(),
            line,
            message: one_line(message.as_ref()),
        }
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let file = one_line(&self.file.to_string_lossy());
        match self.line {
            Some(line) => write!(f, "{file}:{line}: {}", self.message),
            None => write!(f, "{file}: {}", self.message),
        }
    }
}

impl std::error::Error for InputError {}

/// Says a line on standard error. Where nobody can hear it, nothing is lost: what counts is the exit status.
pub fn tell(line: impl fmt::Display) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// Says on standard error what is doubtful in the user's files, a line each.
pub(crate) fn warn(doubts: &[InputError]) {
    for doubt in doubts {
        tell(format_args!("warning: {doubt}"));
    }
}

/// Most characters of a name or a message that are shown. What is wrong stands at the beginning, the
/// remedy at the end: a longer one is cut in the middle.
const SHOWN: usize = 1000;

/// Text as it can stand in one line of a terminal: control characters are escaped, and what is longer
/// than 1000 characters is cut in the middle.
///
/// ```
/// assert_eq!(host_tests::error::one_line("a\nb"), "a\\nb");
/// assert!(host_tests::error::one_line(&"a".repeat(100_000)).chars().count() <= 1000);
/// ```
pub fn one_line(text: &str) -> String {
    let mut line = String::with_capacity(text.len().min(SHOWN));
    // What is cut is not escaped first: a message may quote a whole file.
    let count = text.chars().count();
    let shown: Box<dyn Iterator<Item = char>> = if count > SHOWN {
        let tail = text.chars().skip(count - SHOWN / 2 + 2);
        let head = text.chars().take(SHOWN / 2 - 1);
        Box::new(head.chain(" … ".chars()).chain(tail))
    } else {
        Box::new(text.chars())
    };
    shown.for_each(|character| show(character, &mut line));
    line
}

/// Text of several lines as it can stand in a terminal: control characters are escaped, the ends of its lines are not.
///
/// ```
/// assert_eq!(host_tests::error::escaped("a\u{1b}[31m\nb\n"), "a\\u{1b}[31m\nb\n");
/// ```
pub fn escaped(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '\n' => shown.push(character),
            _ => show(character, &mut shown),
        }
    }
    shown
}

fn show(character: char, shown: &mut String) {
    if character.is_control() {
        shown.extend(character.escape_default());
    } else {
        shown.push(character);
    }
}

/// Largest log, logger's file, board's log or image that is read, bytes: some ten million rows. Larger ones
/// are cut before.
pub const LARGEST_DATA: u64 = 512 << 20;

/// Largest file of declarations (TOML) that is read, bytes.
pub const LARGEST_DECLARATION: u64 = 1 << 20;

/// What the help of every command with inputs says about their size.
pub const LIMITS: &str = "Inputs: a log, a logger's file, a board's log or an image may have 512 MB, a machine file 1 MB.";

/// The bytes of a user's file of at most `largest` bytes. `expected` ends the messages for a file that
/// cannot be one: "a log (CSV)".
///
/// # Errors
/// A file that is not there, cannot be read, or is larger.
pub(crate) fn read_bytes(path: &Path, expected: &str, largest: u64) -> Result<Vec<u8>, InputError> {
    load(path, largest).map_err(|error| unreadable(path, &error, expected, largest))
}

/// What is said of a user's file that could not be read. `expected` and `largest` as for [`read_bytes`].
pub(crate) fn unreadable(
    path: &Path,
    error: &io::Error,
    expected: &str,
    largest: u64,
) -> InputError {
    let reason = match error.kind() {
        io::ErrorKind::NotFound => format!("no such file; expected {expected}"),
        io::ErrorKind::IsADirectory => format!("is a directory; expected {expected}"),
        io::ErrorKind::FileTooLarge => {
            let most = largest >> 20;
            format!("is larger than {most} MB; expected {expected} of that size at most")
        }
        _ => format!("cannot be read ({error}); expected {expected}"),
    };
    InputError::new(path, None, reason)
}

/// The text of a user's file of at most `largest` bytes, without its byte order mark. `expected` as for
/// [`read_bytes`].
pub(crate) fn read_text(path: &Path, expected: &str, largest: u64) -> Result<String, InputError> {
    text_of(path, read_bytes(path, expected, largest)?, expected)
}

fn load(path: &Path, largest: u64) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    // A pipe or a device has no length beforehand, and may have no end.
    if file.metadata()?.len() > largest {
        return Err(io::ErrorKind::FileTooLarge.into());
    }
    read_at_most(file, largest)
}

/// All that there is to read, if it is at most `largest` bytes.
///
/// # Errors
/// What reading reports; [`io::ErrorKind::FileTooLarge`] where there is more.
pub(crate) fn read_at_most(from: impl Read, largest: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    from.take(largest + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 <= largest {
        Ok(bytes)
    } else {
        Err(io::ErrorKind::FileTooLarge.into())
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_more_is_read_than_may_be() {
        assert_eq!(read_at_most(&b"abc"[..], 3).unwrap(), b"abc");
        for endless in [
            read_at_most(&b"abcd"[..], 3),
            read_at_most(io::repeat(0), 3),
        ] {
            assert_eq!(endless.unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        }
    }
}
