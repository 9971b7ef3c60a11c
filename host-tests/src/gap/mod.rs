//! `cargo hil gap`: measured log in, missing effects out, errors before and after.

pub mod command;
pub mod engine;
pub mod metrics;
pub mod outcome;
pub mod report;
pub mod table;
pub mod zero_phase;
