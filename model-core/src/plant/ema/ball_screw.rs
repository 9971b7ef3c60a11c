//! A rigid ball screw between its ends of travel.

use super::gearbox;
use crate::numeric::invalid_parameter::{InvalidParameter, require};
use core::f32::consts::TAU;

/// What the screw is.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters {
    /// Travel of the rod for one turn, m, 1e-5 to 1.
    pub lead: f32,
    /// Mass of rod and load, kg, 0 to 1e6.
    pub mass: f32,
    /// Lower end of travel, m, not above 0, where the rod starts.
    pub lower_end: f32,
    /// Upper end of travel, m, not below 0, and above the lower end by at most 100 m.
    pub upper_end: f32,
}

impl Parameters {
    pub(super) fn check(&self) -> Result<(), InvalidParameter> {
        require(
            (1e-5..=1.0).contains(&self.lead),
            "lead",
            "must be 1e-5 to 1 m",
        )?;
        require(
            (0.0..=1e6).contains(&self.mass),
            "mass",
            "must be 0 to 1e6 kg",
        )?;
        require(
            (-100.0..=0.0).contains(&self.lower_end),
            "lower end",
            "must be -100 to 0 m",
        )?;
        require(
            (0.0..=100.0).contains(&self.upper_end),
            "upper end",
            "must be 0 to 100 m",
        )?;
        require(
            self.lower_end < self.upper_end,
            "lower end",
            "must be below the upper end",
        )
    }

    /// Travel of the rod for 1 rad of the motor, m.
    pub fn travel(&self, gearbox: gearbox::Parameters) -> f32 {
        self.lead / (TAU * gearbox.ratio)
    }
}
