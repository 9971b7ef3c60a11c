//! `cargo hil onboard`: what the emulated chip does by itself, beside this host and the truth.

pub mod command;
pub mod outcome;
mod reading;
mod table;
