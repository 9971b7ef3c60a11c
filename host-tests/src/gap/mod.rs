//! `cargo hil gap`: measured log in, missing effects out, errors before and after.

pub mod command;
pub mod outcome;
