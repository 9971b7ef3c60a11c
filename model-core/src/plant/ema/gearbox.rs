//! A rigid gearbox.

use crate::numeric::invalid_parameter::{InvalidParameter, require};

/// What the gearbox is.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters {
    /// Turns of the motor for one of the screw, 1e-3 to 1e6.
    pub ratio: f32,
}

impl Parameters {
    pub(in crate::plant) fn check(&self) -> Result<(), InvalidParameter> {
        require(
            (1e-3..=1e6).contains(&self.ratio),
            "gear ratio",
            "must be 1e-3 to 1e6",
        )
    }
}
