//! Actuator firmware: one application over the boards it runs on.
//!
//! [`app`] is what every board runs and knows no hardware; its interrupts' bodies compile on a
//! host, where tests call them. [`board`] holds one file a board, and what boards share. A program
//! in `bin` joins the two. [`on_target`] holds the tests of the model core that one more program
//! runs on the target.
#![no_std]

pub mod app;
pub mod board;
pub mod on_target;
