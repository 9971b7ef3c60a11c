//! A line of text from the bytes of a terminal, with an echo.
//!
//! | key | does |
//! |---|---|
//! | Backspace, Delete | takes the last character back |
//! | Ctrl-U | takes the whole line back |
//! | Ctrl-C | leaves the line |
//! | Up, Ctrl-P | fetches the last line, in place of this one |
//! | other keys that send an escape sequence | nothing |
//!
//! A line that is too long, or has a byte in it that is neither text nor a key, is refused as a whole
//! when it ends: what is left of a damaged line may be another command.

use core::fmt::Write;

/// Most characters of a line.
pub const LINE: usize = 128;

/// What comes before each line.
pub const PROMPT: &str = "> ";

/// Ctrl-U, which takes the whole line back.
pub const TAKEN_BACK: u8 = 0x15;

/// Ctrl-C, which leaves the line.
pub const LEFT: u8 = 0x03;

const BELL: &str = "\x07";

/// What ended a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event<'a> {
    /// Its end; printable ASCII.
    Line(&'a str),
    /// Its end, but it had more than [`LINE`] characters.
    TooLong,
    /// Its end, but it had a byte that is neither text nor a key.
    NotText {
        /// Where, from 1.
        column: usize,
    },
    /// Ctrl-C.
    Left,
}

/// Where in an escape sequence the next byte is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Escape {
    #[default]
    Outside,
    /// Behind ESC.
    Begun,
    /// Behind ESC [, up to a final byte.
    Control,
    /// Behind ESC O: one more.
    Single,
}

/// Why the line will be refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Flaw {
    TooLong,
    NotText { column: usize },
}

/// Characters of a line.
#[derive(Debug, Clone, Copy)]
struct Text {
    bytes: [u8; LINE],
    length: usize,
}

impl Text {
    const EMPTY: Self = Self {
        bytes: [0; LINE],
        length: 0,
    };

    /// False if there is no room.
    fn push(&mut self, byte: u8) -> bool {
        let place = self.bytes.get_mut(self.length);
        let room = place.is_some();
        if let Some(place) = place {
            *place = byte;
            self.length += 1;
        }
        room
    }

    fn as_str(&self) -> &str {
        let bytes = self.bytes.get(..self.length).unwrap_or_default();
        // Only ASCII is pushed.
        core::str::from_utf8(bytes).unwrap_or_default()
    }
}

/// The editor.
#[derive(Debug, Clone)]
pub struct Editor {
    line: Text,
    last: Text,
    flaw: Option<Flaw>,
    escape: Escape,
    /// Whether the line before ended with a carriage return, whose line feed may follow.
    returned: bool,
    /// Whether the line has ended, and goes with the next byte.
    ended: bool,
}

impl Editor {
    /// An empty line, and none before it.
    pub const fn new() -> Self {
        Self {
            line: Text::EMPTY,
            last: Text::EMPTY,
            flaw: None,
            escape: Escape::Outside,
            returned: false,
            ended: false,
        }
    }

    /// The line so far.
    pub fn line(&self) -> &str {
        if self.ended { "" } else { self.line.as_str() }
    }

    /// Takes a byte. An echo that is not taken is lost, the line is not.
    pub fn take(&mut self, byte: u8, echo: &mut dyn Write) -> Option<Event<'_>> {
        if self.ended {
            self.begin();
        }
        let follows_return = core::mem::take(&mut self.returned);
        if self.is_in_escape(byte, echo) {
            return None;
        }
        match byte {
            b'\n' if follows_return => None,
            b'\r' | b'\n' => {
                self.returned = byte == b'\r';
                let _ = echo.write_str("\n");
                Some(self.end())
            }
            LEFT => {
                let _ = echo.write_str("^C\n");
                self.ended = true;
                Some(Event::Left)
            }
            0x08 | 0x7f => {
                if self.line.length > 0 {
                    self.line.length -= 1;
                    let _ = echo.write_str("\x08 \x08");
                }
                None
            }
            0x10 => {
                self.recall(echo);
                None
            }
            TAKEN_BACK => {
                self.begin();
                redraw("", echo);
                None
            }
            b'\t' => {
                self.push(b' ', echo);
                None
            }
            b' '..=b'~' => {
                self.push(byte, echo);
                None
            }
            _ => {
                let column = self.line.length + 1;
                self.spoil(Flaw::NotText { column }, echo);
                None
            }
        }
    }

    fn begin(&mut self) {
        self.line = Text::EMPTY;
        self.flaw = None;
        self.ended = false;
    }

    fn end(&mut self) -> Event<'_> {
        self.ended = true;
        match self.flaw {
            Some(Flaw::TooLong) => Event::TooLong,
            Some(Flaw::NotText { column }) => Event::NotText { column },
            None => {
                if !self.line.as_str().trim_ascii().is_empty() {
                    self.last = self.line;
                }
                Event::Line(self.line.as_str())
            }
        }
    }

    fn push(&mut self, byte: u8, echo: &mut dyn Write) {
        if self.flaw.is_some() {
            let _ = echo.write_str(BELL);
        } else if self.line.push(byte) {
            let _ = echo.write_char(char::from(byte));
        } else {
            self.spoil(Flaw::TooLong, echo);
        }
    }

    fn spoil(&mut self, flaw: Flaw, echo: &mut dyn Write) {
        self.flaw.get_or_insert(flaw);
        let _ = echo.write_str(BELL);
    }

    fn recall(&mut self, echo: &mut dyn Write) {
        self.begin();
        self.line = self.last;
        redraw(self.line.as_str(), echo);
    }

    /// Whether the byte belongs to an escape sequence; if it is its last and means something, does it.
    fn is_in_escape(&mut self, byte: u8, echo: &mut dyn Write) -> bool {
        self.escape = match (self.escape, byte) {
            (_, 0x1b) => Escape::Begun,
            // A key that is none of a sequence's ends it and counts.
            (Escape::Outside, _) | (_, 0x00..=0x1f | 0x7f..) => {
                self.escape = Escape::Outside;
                return false;
            }
            (Escape::Begun, b'[') => Escape::Control,
            (Escape::Begun, b'O') => Escape::Single,
            (Escape::Begun, _) => Escape::Outside,
            (Escape::Control, b' '..=b'?') => Escape::Control,
            (Escape::Control | Escape::Single, _) => {
                if byte == b'A' {
                    self.recall(echo);
                }
                Escape::Outside
            }
        };
        true
    }
}

impl Default for Editor {
    fn default() -> Self {
        Self::new()
    }
}

/// The prompt's line anew, with this text.
fn redraw(text: &str, echo: &mut dyn Write) {
    let _ = write!(echo, "\r\x1b[K{PROMPT}{text}");
}
