//! What long work says of itself: each step before it begins, on a terminal alone.

use std::io::{self, IsTerminal};

use crate::error::tell;

/// Tells a person at standard error what is done next; a pipe is told nothing.
pub fn announce() -> impl Fn(&str) + Copy + Send {
    let on_terminal = io::stderr().is_terminal();
    move |step| {
        if on_terminal {
            tell(format_args!("{step} ..."));
        }
    }
}
