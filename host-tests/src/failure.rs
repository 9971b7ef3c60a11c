//! How a command fails, and the exit status that follows.

use std::fmt;
use std::process::ExitCode;

use crate::error::{InputError, one_line};

/// Why a command did not do what it was asked. Displayed as one line, but for what a tool that was
/// run has to say, which follows it.
#[derive(Debug)]
pub enum Failure {
    /// A file of the user's is wrong: exit status 2.
    Input(InputError),
    /// The command was called wrongly: exit status 2.
    Usage(String),
    /// Anything else, with what can be done about it: exit status 1.
    Other(String),
}

impl Failure {
    /// Anything but a wrong file.
    pub fn other(message: impl Into<String>) -> Self {
        Self::Other(message.into())
    }

    /// An operation of the system that failed, on what, and why.
    pub fn system(what: impl fmt::Display, error: impl fmt::Display) -> Self {
        Self::Other(one_line(&format!("{what}: {error}")))
    }

    /// The exit status of the program.
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Self::Input(_) | Self::Usage(_) => ExitCode::from(2),
            Self::Other(_) => ExitCode::FAILURE,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input(error) => error.fmt(f),
            Self::Usage(message) => f.write_str(&one_line(message)),
            Self::Other(message) => f.write_str(message),
        }
    }
}

impl std::error::Error for Failure {}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        Self::Input(error)
    }
}
