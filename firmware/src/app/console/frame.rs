//! A line for a program among the lines for a person.
//!
//! ```text
//! RS text *01234567 CR LF
//! ```
//!
//! RS is the record separator, 0x1E, which a terminal does not show; what follows the star is the CRC-32 of
//! the text, in hexadecimal digits. A frame is written whole or not at all, so one with another checksum was
//! damaged on the line.

use core::fmt::{self, Write};

use crc::{CRC_32_ISO_HDLC, Crc};
use heapless::String;

/// What a frame begins with: ASCII's record separator.
pub const BEGIN: char = '\x1e';

/// Most characters of a text: sixteen rows of a log and their number.
pub const TEXT: usize = 208;

/// Bytes of a frame at most: a text with its beginning, its checksum and its end.
pub const FRAME: usize = TEXT + 13;

static CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Writes a text as a frame.
///
/// # Errors
/// A text of more than [`TEXT`] characters, of which nothing is written; an output that takes nothing.
///
/// ```
/// use firmware::app::console::frame;
///
/// let mut line = String::new();
/// frame::write(&mut line, format_args!("end 7")).unwrap();
/// let text = line.trim_start_matches(frame::BEGIN).trim_end();
/// assert_eq!(frame::read(text), Some("end 7"));
/// assert_eq!(frame::read(&text.replace('7', "8")), None);
/// ```
pub fn write(out: &mut dyn Write, text: fmt::Arguments<'_>) -> fmt::Result {
    let mut line = String::<TEXT>::new();
    line.write_fmt(text)?;
    let checksum = CHECKSUM.checksum(line.as_bytes());
    let mut frame = String::<FRAME>::new();
    write!(frame, "{BEGIN}{line} *{checksum:08x}\r\n")?;
    out.write_str(&frame)
}

/// The text of a frame, given what is between its beginning and its end; none of a damaged one.
pub fn read(frame: &str) -> Option<&str> {
    let (text, checksum) = frame.rsplit_once(" *")?;
    let sent = u32::from_str_radix(checksum, 16).ok()?;
    (checksum.len() == 8 && CHECKSUM.checksum(text.as_bytes()) == sent).then_some(text)
}
