//! What makes an image: its actuator, and what may be done with it.

use crate::app::console::request::Mode;
use crate::app::machine::{EMA, Machine, THROTTLE};

/// An image's constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kit {
    /// What it is called in the log.
    pub name: &'static str,
    /// The actuator before anything is stored.
    pub machine: Machine,
    /// Whether it is emulated: then nothing moves in truth, it bears anything, and faults can be injected.
    pub is_emulated: bool,
    /// The modes, the first one that of the start.
    pub modes: &'static [Mode],
}

/// An emulated throttle body for an engine controller.
pub const THROTTLE_BODY: Kit = Kit {
    name: "throttle",
    machine: THROTTLE,
    is_emulated: true,
    modes: &[Mode::Wires, Mode::Position, Mode::Voltage],
};

/// A controller for a real actuator, before it is told which: one of 24 V.
pub const ACTUATOR: Kit = Kit {
    name: "controller",
    machine: EMA,
    is_emulated: false,
    modes: &[Mode::Position, Mode::Voltage],
};
