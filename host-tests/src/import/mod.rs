//! `cargo hil import`: any logger's file to a log.
//!
//! A file becomes columns of numbers (`raw`, from text, MATLAB arrays or, by programs that are
//! built for it, `foreign` formats), a `recipe` says which of
//! them is which column of the log, in which unit and with what done to it, `convert` follows it.
//! How rows lie in time is judged and mended by the code that reads a log. Where a log is refused for
//! its form, `call` finds the recipe that would mend it, and prints it as a command.

pub(crate) mod call;
mod clock;
pub mod command;
mod convert;
pub(crate) mod foreign;
mod groups;
pub(crate) mod guess;
mod labelled;
mod layout;
mod mat;
mod page;
mod raw;
mod recipe;
mod share;
mod slow;
mod source;
pub(crate) mod stamp;
mod summary;
mod suspect;
mod text;
pub(crate) mod unit;
