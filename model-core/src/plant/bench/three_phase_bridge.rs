//! The three-phase bridge: each terminal at one rail or the other (bench paper, section 3.3).
//!
//! Its MOSFETs are without resistance, dead time and drop: each relay's output switches one of a
//! leg, its inverse the other.

use crate::numeric::invalid_parameter::{InvalidParameter, require_positive};

/// What the inverter is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// Between the rails, V, > 0.
    pub bus_voltage: f32,
    /// Half the width of the relays' hysteresis, A, > 0.
    pub band: f32,
}

impl Parameters {
    pub(super) fn check(&self) -> Result<(), InvalidParameter> {
        require_positive(self.bus_voltage, "bus voltage")?;
        require_positive(self.band, "hysteresis band")
    }

    /// Voltages of the terminals against the negative rail, V.
    #[inline]
    pub fn terminals(&self, on: [bool; 3]) -> [f32; 3] {
        on.map(|on| if on { self.bus_voltage } else { 0.0 })
    }
}
