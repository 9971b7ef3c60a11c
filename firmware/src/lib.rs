//! Actuator firmware: one application over the boards it runs on.
#![no_std]
