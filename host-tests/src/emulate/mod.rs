//! `cargo hil emulate`: the images as they are flashed, on emulated chips.
//!
//! The chips are a package of their own, `host-tests/emulation`, for its emulator asks for a newer compiler
//! than the rest. It is built once, into `target/emulation`, and runs the `throttle` by itself, a `save` of
//! the `controller` over an end of power, and both of them wired to a loop. What the images said
//! and what was counted comes back as JSON ([`run`]); what a user relies on is held against it
//! ([`requirements`]); and the log that the controller recorded is traced ([`tracing`]). Then the controller is
//! recorded once more, over its console as `cargo hil record` does ([`recording`]). The images that nobody operates
//! run there too ([`unattended`]), at length at several cycles an instruction ([`longest`]).

pub mod command;
pub mod longest;
pub mod recording;
pub mod requirements;
pub mod run;
pub mod summary;
pub mod tracing;
pub mod unattended;
