//! What is wrong with a line, where, and what was expected there.

use core::fmt;

use model_core::numeric::invalid_parameter::InvalidParameter;

use super::command::{Argument, Command, Usage};
use super::editor::LINE;

/// A line that is no command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParseError<'a> {
    /// Where, from 1.
    pub column: usize,
    /// What.
    pub flaw: Flaw<'a>,
    /// The command that the line began as.
    pub command: Option<&'static Command>,
}

/// What is wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Flaw<'a> {
    /// No command has this name.
    UnknownCommand(&'a str),
    /// The line ends where an argument should be.
    Missing(&'static Argument),
    /// The line goes on where it should end.
    Superfluous(&'a str),
    /// It is not a finite number.
    NotANumber(&'a str, &'static Argument),
    /// It is not a whole number that fits 32 bits.
    NotACount(&'a str, &'static Argument),
    /// It is out of its bounds.
    OutOfBounds {
        /// As it was written.
        word: &'a str,
        /// Its unit.
        unit: &'static str,
        /// Least that is taken.
        lower: f32,
        /// Most that is taken.
        upper: f32,
    },
    /// It is none of the words that may stand there.
    Unknown(&'a str, &'static Argument),
    /// The arguments do not go together, or one is out of a range that others give.
    Refused(InvalidParameter),
    /// The line was longer than a line may be.
    TooLong,
    /// There was a byte that is neither text nor a key.
    NotText,
}

impl fmt::Display for ParseError<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "error: column {}: ", self.column)?;
        match self.flaw {
            Flaw::UnknownCommand(word) => {
                write!(formatter, "`{word}` is no command; `help` lists them")?;
            }
            Flaw::Missing(argument) => {
                write!(formatter, "the line ends; expected {argument}")?;
            }
            Flaw::Superfluous(word) => {
                write!(
                    formatter,
                    "`{word}` is too much; expected the end of the line"
                )?;
            }
            Flaw::NotANumber(word, argument) => {
                write!(
                    formatter,
                    "`{word}` is no finite number; expected {argument}"
                )?;
            }
            Flaw::NotACount(word, argument) => {
                write!(
                    formatter,
                    "`{word}` is no whole number from 0 to {}; expected {argument}",
                    u32::MAX
                )?;
            }
            Flaw::OutOfBounds {
                word,
                unit,
                lower,
                upper,
            } => {
                write!(
                    formatter,
                    "{word} is out of bounds; expected {lower:?} to {upper:?} {unit}"
                )?;
            }
            Flaw::Unknown(word, argument) => {
                write!(formatter, "`{word}` is unknown; expected {argument}")?;
            }
            Flaw::Refused(refused) => refused.fmt(formatter)?,
            Flaw::TooLong => {
                write!(
                    formatter,
                    "the line is too long; expected at most {LINE} characters"
                )?;
            }
            Flaw::NotText => {
                formatter.write_str("a byte that is no text; expected printable ASCII")?;
            }
        }
        if let Some(command) = self.command {
            write!(formatter, "\nusage: {}", Usage(command))?;
        }
        Ok(())
    }
}

impl core::error::Error for ParseError<'_> {}
