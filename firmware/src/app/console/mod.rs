//! Orders from a terminal: bytes in, a [`Request`] out, and a [`Response`] back as text.
//!
//! The [`editor`] makes lines of bytes, [`parse()`] makes requests of lines by the table of
//! [`command`]s, and [`Console`] joins them. It knows no hardware and performs nothing itself. One word is
//! understood in any line, [`stop`]. Each line has exactly one response, with the next prompt behind it; a line that is wrong has
//! an [`error`] that says where, and what was expected there.

pub mod command;
pub mod editor;
pub mod error;
pub mod frame;
pub mod injection;
pub mod parse;
mod reading;
pub mod request;
pub mod response;
pub mod stop;

use core::fmt::{self, Write};

use super::store::field::Description;
use editor::{Editor, Event, LEFT, LINE, PROMPT, TAKEN_BACK};
use error::{Flaw, ParseError};
use parse::{Line, parse};
use request::Request;
use response::Response;

/// Bytes of the longest answer at most, which is that of `help`.
pub const LONGEST_ANSWER: usize = 3072;

/// A terminal's other end.
///
/// ```
/// use firmware::app::console::{self, Console};
/// use firmware::app::console::request::Request;
/// use firmware::app::console::response::Response;
///
/// let mut console = Console::new(&[]);
/// let mut terminal = String::new();
/// let mut requests = "arm\r".bytes().filter_map(|byte| console.take(byte, &mut terminal));
/// assert_eq!(requests.next(), Some(Request::Arm));
/// console::reply(&Response::Done, &mut terminal);
/// assert_eq!(terminal, "arm\r\nok\r\n> ");
/// ```
#[derive(Debug, Clone)]
pub struct Console<'t> {
    editor: Editor,
    stop: stop::Watch,
    parameters: &'t [Description],
}

impl<'t> Console<'t> {
    /// With these parameters to show and set.
    pub const fn new(parameters: &'t [Description]) -> Self {
        Self {
            editor: Editor::new(),
            stop: stop::Watch::new(),
            parameters,
        }
    }

    /// The line so far.
    pub fn line(&self) -> &str {
        self.editor.line()
    }

    /// Says that it is there. An output that takes nothing loses the text, here and below.
    pub fn greet(&self, out: &mut dyn Write) {
        answer(format_args!("`help` lists the commands"), out);
    }

    /// Says something of itself, and shows the line so far anew behind it.
    pub fn announce(&self, text: fmt::Arguments<'_>, out: &mut dyn Write) {
        let mut lines = Lines(out);
        let _ = lines.write_str("\n");
        answer(text, out);
        let _ = out.write_str(self.line());
    }

    /// Takes a byte. A request is to be answered by [`reply`] before the next byte.
    pub fn take(&mut self, byte: u8, out: &mut dyn Write) -> Option<Request> {
        let mut lines = Lines(out);
        let error = |column, flaw| ParseError {
            column,
            flaw,
            command: None,
        };
        match byte {
            TAKEN_BACK | LEFT => {
                self.stop.end();
            }
            _ => self.stop.take(byte),
        }
        let event = self.editor.take(byte, &mut lines)?;
        let stop = self.stop.end();
        let line = match event {
            Event::Line(line) => parse(line, self.parameters),
            Event::TooLong => Err(error(LINE + 1, Flaw::TooLong)),
            Event::NotText { column } => Err(error(column, Flaw::NotText)),
            Event::Left => Ok(Line::Blank),
        };
        match line {
            Ok(Line::Request(request)) => return Some(request),
            _ if stop => return Some(Request::Disarm),
            Ok(Line::Blank) => {
                let _ = lines.write_str(PROMPT);
            }
            Err(error) => answer(format_args!("{error}"), out),
        }
        None
    }
}

/// Answers a request.
pub fn reply(response: &Response<'_>, out: &mut dyn Write) {
    answer(format_args!("{response}"), out);
}

fn answer(text: fmt::Arguments<'_>, out: &mut dyn Write) {
    let mut lines = Lines(out);
    let _ = lines.write_fmt(text);
    let _ = lines.write_str("\n");
    let _ = lines.write_str(PROMPT);
}

/// A terminal wants a carriage return before each line feed.
struct Lines<'o>(&'o mut dyn Write);

impl Write for Lines<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for (place, part) in text.split('\n').enumerate() {
            if place > 0 {
                self.0.write_str("\r\n")?;
            }
            self.0.write_str(part)?;
        }
        Ok(())
    }
}
