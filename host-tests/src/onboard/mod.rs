//! `cargo hil onboard`: what the emulated board does by itself, beside this host and the truth.

pub mod command;
pub mod outcome;
mod reading;
mod table;
