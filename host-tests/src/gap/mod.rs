//! `cargo hil gap`: measured log in, missing effects out, errors before and after.

pub mod outcome;
pub mod report;
pub mod table;
