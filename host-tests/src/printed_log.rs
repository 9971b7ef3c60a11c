//! A board's log as `probe-rs run` prints it: decoded already, as text.
//!
//! probe-rs prints frames by `defmt_decoder`'s formatter, in one of two formats (`--log-format`):
//!
//! ```text
//! 0.001040 [INFO ] supply at 23.5 V (board src/main.rs:12)      oneline, the default
//! 0.001040 INFO  supply at 23.5 V                               full
//! └─ board::main @ src/main.rs:12
//! ```
//!
//! The time is left out of both with `--no-timestamps`, the place where an image has none, and there may be
//! colours. Numbers are printed with the digits that give them back, so that nothing is lost: the samples have
//! the bits that the board sent.

use std::path::Path;

use anstream::adapter::strip_str;

use crate::board_log::{BoardLog, Line, parse_sample};
use crate::error::InputError;

/// Levels of defmt, as they are printed.
const LEVELS: [&str; 5] = ["ERROR", "WARN", "INFO", "DEBUG", "TRACE"];

/// What begins a line that says where the one before it comes from.
const PLACE: &str = "└─";

/// What every sample begins with, wherever in a line it stands.
const SAMPLE: &str = "sample sequence=";

/// How the samples come whole.
const REMEDY: &str = "send what probe-rs prints straight into a file (`cargo run … > board.txt`), in its format \
                      oneline or full, or remove the line";

/// What was printed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Printed {
    /// The board's lines. The last one counts as damaged where it has no end.
    pub log: BoardLog,
    /// Lines that are none of the board's: what cargo and probe-rs say themselves.
    pub others: usize,
}

/// These bytes as text, if they are some. A board's own bytes end each frame with a zero, which no text has.
fn text(bytes: &[u8]) -> Option<&str> {
    let text = str::from_utf8(bytes).ok()?;
    (!text.is_empty() && !text.contains('\0')).then_some(text)
}

/// Reads what was printed; `None` of bytes that are no text.
///
/// # Errors
/// Text of another encoding than UTF-8, or a sample that is not whole, with its line.
pub fn read(path: &Path, bytes: &[u8]) -> Result<Option<Printed>, InputError> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        let message =
            "is text in UTF-16; expected UTF-8 (PowerShell: `… | Out-File -Encoding utf8 FILE`)";
        return Err(InputError::new(path, None, message));
    }
    let Some(text) = text(bytes) else {
        return Ok(None);
    };
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut printed = Printed::default();
    for (index, row) in text.split_inclusive('\n').enumerate() {
        let bare = strip_str(row).to_string();
        let bare = bare.trim();
        if bare.is_empty() || bare.starts_with(PLACE) {
            continue;
        }
        let fault = |what: &str| {
            let message = format!("{what}: `{bare}`; {REMEDY}");
            InputError::new(path, Some(index + 1), message)
        };
        let line = line(bare);
        let is_cut = !row.ends_with('\n');
        match line {
            Some(line) if line.sample.is_none() && line.message.contains(SAMPLE) => {
                if !is_cut {
                    return Err(fault("holds a sample that is not whole"));
                }
                printed.log.damaged += 1;
            }
            // The last digits of a sample may be missing, and the rest would be a number all the same.
            Some(line) if is_cut && line.sample.is_some() && !bare.ends_with(')') => {
                printed.log.damaged += 1;
            }
            Some(line) => printed.log.lines.push(line),
            None if bare.contains(SAMPLE) => {
                return Err(fault("holds a sample, but not as probe-rs prints it"));
            }
            None => printed.others += 1,
        }
    }
    Ok(Some(printed))
}

/// One of the board's lines, without colours; `None` of another one.
fn line(text: &str) -> Option<Line> {
    let (time, rest) = match text.split_once(char::is_whitespace) {
        Some((first, rest)) if is_time(first) => (first, rest.trim_start()),
        _ => ("", text),
    };
    let (level, message) = match rest.strip_prefix('[') {
        Some(rest) => {
            let (level, message) = rest.split_once(']')?;
            (level.trim(), without_place(message.trim()))
        }
        None => {
            let (level, message) = rest.split_once(char::is_whitespace)?;
            (level, message.trim())
        }
    };
    LEVELS.contains(&level).then(|| Line {
        time: time.to_owned(),
        level: level.to_owned(),
        sample: parse_sample(message),
        message: message.to_owned(),
    })
}

/// Whether it is a time stamp as defmt's formats print one: digits, points and colons.
fn is_time(word: &str) -> bool {
    word.starts_with(|first: char| first.is_ascii_digit())
        && word
            .chars()
            .all(|c| c.is_ascii_digit() || matches!(c, '.' | ':'))
}

/// A message without the crate, file and line that oneline puts behind it.
fn without_place(message: &str) -> &str {
    let Some((words, place)) = message.rsplit_once(" (") else {
        return message;
    };
    let numbered = place
        .strip_suffix(')')
        .and_then(|place| place.rsplit_once(':'));
    match numbered {
        Some((file, line)) if file.contains(' ') && line.parse::<u32>().is_ok() => words,
        _ => message,
    }
}
