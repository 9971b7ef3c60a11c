//! What makes an image: its actuator, its limits, and what may be done with it.

use crate::app::console::request::Mode;
use crate::app::fault::monitor::Limits;
use crate::app::machine::{EMA, Machine, THROTTLE};

/// An image's constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kit {
    /// What it is called in the log.
    pub name: &'static str,
    /// The actuator before anything is stored.
    pub machine: Machine,
    /// What a real actuator bears. An emulated one bears anything.
    pub limits: Option<Limits>,
    /// The modes, the first one that of the start.
    pub modes: &'static [Mode],
}

impl Kit {
    /// Whether its actuator is emulated: then nothing moves in truth, and faults can be injected.
    pub const fn is_emulated(&self) -> bool {
        self.limits.is_none()
    }
}

/// An emulated throttle body for an engine controller.
pub const THROTTLE_BODY: Kit = Kit {
    name: "throttle",
    machine: THROTTLE,
    limits: None,
    modes: &[Mode::Wires, Mode::Position, Mode::Voltage],
};

/// A controller for a real actuator of 24 V.
///
/// The peak lies above the 24 A that the supply drives through the winding and below the 25 A of the
/// amplifier. The winding bears 6 A for ever and the peak for a second. The supply is that of an
/// industrial 24 V, −25 and +25 %; the capacitors bear 35 V, the gate drivers switch from 8 V up.
pub const ACTUATOR: Kit = Kit {
    name: "controller",
    machine: EMA,
    limits: Some(Limits {
        peak_current: 24.5,
        continuous_current: 6.0,
        peak_time: 1.0,
        supply: [18.0, 30.0],
        supply_time: 5e-3,
    }),
    modes: &[Mode::Position, Mode::Voltage],
};
