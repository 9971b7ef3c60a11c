//! A line into what it asks for: a command's name, then its arguments, with blanks between.

use super::command::{Argument, Command, Presence};
use super::error::{Flaw, ParseError};
use super::request::Request;
use crate::app::store::field::Description;

/// What a line is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Line {
    /// Nothing.
    Blank,
    /// Something that is asked for.
    Request(Request),
}

/// Reads a line. Parameters are named as in `parameters` and become places in there.
///
/// ```
/// use firmware::app::console::parse::{Line, parse};
/// use firmware::app::console::request::Request;
///
/// assert_eq!(parse("arm", &[]), Ok(Line::Request(Request::Arm)));
/// let error = parse("sine 0 1 2 none", &[]).unwrap_err();
/// assert_eq!(
///     error.to_string(),
///     "error: column 12: `none` is no finite number; expected phase: rad\n\
///      usage: sine offset amplitude frequency [phase]"
/// );
/// ```
///
/// # Errors
/// What is wrong with it, where, and what was expected there.
pub fn parse<'a>(line: &'a str, parameters: &[Description]) -> Result<Line, ParseError<'a>> {
    let mut words = Words { line, at: 0 };
    let Some(name) = words.next() else {
        return Ok(Line::Blank);
    };
    let Some(command) = Command::named(name.text) else {
        return Err(ParseError {
            column: name.column,
            flaw: Flaw::UnknownCommand(name.text),
            command: None,
        });
    };
    let mut arguments = Arguments {
        words,
        command,
        parameters,
    };
    let line = (command.read)(&mut arguments)?;
    arguments.end()?;
    Ok(line)
}

/// A word, and where it begins, from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Word<'a> {
    pub text: &'a str,
    pub column: usize,
}

/// What is left of a line.
#[derive(Debug, Clone, Copy)]
struct Words<'a> {
    line: &'a str,
    at: usize,
}

impl<'a> Words<'a> {
    fn rest(&self) -> &'a str {
        self.line.get(self.at..).unwrap_or_default()
    }

    /// Where the next word begins, or the line ends, from 1.
    fn column(&self) -> usize {
        let rest = self.rest();
        self.at + (rest.len() - rest.trim_ascii_start().len()) + 1
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = Word<'a>;

    fn next(&mut self) -> Option<Word<'a>> {
        let column = self.column();
        let text = self.rest().split_ascii_whitespace().next()?;
        self.at = column - 1 + text.len();
        Some(Word { text, column })
    }
}

/// What follows a command's name. Arguments are told by their place in the command's list, for the
/// error.
pub(super) struct Arguments<'a, 't> {
    words: Words<'a>,
    command: &'static Command,
    parameters: &'t [Description],
}

impl<'a> Arguments<'a, '_> {
    pub fn command(&self) -> &'static Command {
        self.command
    }

    pub fn error(&self, column: usize, flaw: Flaw<'a>) -> ParseError<'a> {
        ParseError {
            column,
            flaw,
            command: Some(self.command),
        }
    }

    fn argument(&self, index: usize) -> &'static Argument {
        // A command that reads more than it lists is told its last one.
        let arguments = self.command.arguments;
        arguments
            .get(index)
            .or(arguments.last())
            .unwrap_or(&NO_ARGUMENT)
    }

    pub fn word(&mut self) -> Option<Word<'a>> {
        self.words.next()
    }

    /// Where the next word begins, from 1.
    pub fn next_column(&self) -> usize {
        self.words.column()
    }

    pub fn is_at_end(&self) -> bool {
        self.words.rest().trim_ascii_start().is_empty()
    }

    pub fn end(&mut self) -> Result<(), ParseError<'a>> {
        match self.word() {
            Some(word) => Err(self.error(word.column, Flaw::Superfluous(word.text))),
            None => Ok(()),
        }
    }

    /// That an argument is not there.
    pub fn missing(&self, index: usize) -> ParseError<'a> {
        self.error(self.next_column(), Flaw::Missing(self.argument(index)))
    }

    fn required(&mut self, index: usize) -> Result<Word<'a>, ParseError<'a>> {
        self.word().ok_or_else(|| self.missing(index))
    }

    /// A word for which `find` has something.
    pub fn choice<T>(
        &mut self,
        index: usize,
        find: impl FnOnce(&'a str) -> Option<T>,
    ) -> Result<T, ParseError<'a>> {
        let word = self.required(index)?;
        find(word.text).ok_or_else(|| {
            let flaw = Flaw::Unknown(word.text, self.argument(index));
            self.error(word.column, flaw)
        })
    }

    pub fn count(&mut self, index: usize) -> Result<u32, ParseError<'a>> {
        let word = self.required(index)?;
        word.text.parse().map_err(|_| {
            let flaw = Flaw::NotACount(word.text, self.argument(index));
            self.error(word.column, flaw)
        })
    }

    fn finite(&self, index: usize, word: Word<'a>) -> Result<f32, ParseError<'a>> {
        let number = word
            .text
            .parse()
            .ok()
            .filter(|number: &f32| number.is_finite());
        number.ok_or_else(|| {
            let flaw = Flaw::NotANumber(word.text, self.argument(index));
            self.error(word.column, flaw)
        })
    }

    /// A finite number.
    pub fn required_number(&mut self, index: usize) -> Result<f32, ParseError<'a>> {
        let word = self.required(index)?;
        self.finite(index, word)
    }

    /// A number within bounds that have this unit.
    pub fn number_in(
        &mut self,
        index: usize,
        unit: &'static str,
        lower: f32,
        upper: f32,
    ) -> Result<f32, ParseError<'a>> {
        let word = self.required(index)?;
        let number = self.finite(index, word)?;
        if (lower..=upper).contains(&number) {
            return Ok(number);
        }
        let flaw = Flaw::OutOfBounds {
            word: word.text,
            unit,
            lower,
            upper,
        };
        Err(self.error(word.column, flaw))
    }

    /// A number within bounds; 0 for an optional one that is not there.
    pub fn number_within(
        &mut self,
        index: usize,
        lower: f32,
        upper: f32,
    ) -> Result<f32, ParseError<'a>> {
        let argument = self.argument(index);
        if argument.presence == Presence::Optional && self.is_at_end() {
            return Ok(0.0);
        }
        self.number_in(index, argument.values, lower, upper)
    }

    /// A parameter's place.
    pub fn parameter(&mut self, index: usize) -> Result<usize, ParseError<'a>> {
        let parameters = self.parameters;
        self.choice(index, |word| {
            parameters
                .iter()
                .position(|parameter| parameter.name == word)
        })
    }

    /// A value for a parameter.
    pub fn value_of(&mut self, index: usize, parameter: usize) -> Result<f32, ParseError<'a>> {
        match self.parameters.get(parameter) {
            Some(&Description {
                unit, lower, upper, ..
            }) => self.number_in(index, unit, lower, upper),
            None => Err(self.missing(index)),
        }
    }
}

/// What stands for the argument of a command that has none.
static NO_ARGUMENT: Argument = Argument {
    name: "nothing",
    values: "the end of the line",
    presence: Presence::Optional,
};
