//! The word `stop` among the bytes of a line, whatever else the line is.
//!
//! A line that was begun by noise, whose beginning was lost, that is too long or has an escape sequence in
//! it is refused as a whole. That must not cost the one order that cannot wait: so where a line asks for
//! nothing, and `stop` was among its bytes as they came, before any editing, it is the order to stop. Only
//! who takes the line back or leaves it takes that back too.

/// The word.
const WORD: [u8; 4] = *b"stop";

/// Looks for it.
///
/// ```
/// use firmware::app::console::stop::Watch;
///
/// let mut watch = Watch::new();
/// for byte in *b"\x00st\x1b[stop" {
///     watch.take(byte);
/// }
/// assert!(watch.end());
/// assert!(!watch.end(), "the next line has none");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Watch {
    last: [u8; WORD.len()],
    seen: bool,
}

impl Watch {
    /// At the beginning of a line.
    pub const fn new() -> Self {
        Self {
            last: [0; WORD.len()],
            seen: false,
        }
    }

    /// Takes a byte of the line.
    pub fn take(&mut self, byte: u8) {
        self.last.rotate_left(1);
        if let Some(last) = self.last.last_mut() {
            *last = byte;
        }
        self.seen |= self.last == WORD;
    }

    /// Ends the line: whether the word was in it.
    pub fn end(&mut self) -> bool {
        core::mem::take(self).seen
    }
}
