//! `cargo hil track`: the numbers of one machine over many logs in time.

pub mod command;
mod figure;
pub mod jump;
pub mod outcome;
mod text;
pub mod trend;
