//! An incremental encoder on the motor's shaft, and the counter that the drive keeps of it.

use crate::numeric::invalid_parameter::{InvalidParameter, require};
use core::f32::consts::TAU;

/// What the encoder is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters {
    /// Counts for one turn of the motor, 1 to 65535.
    pub counts_per_turn: u16,
}

impl Parameters {
    /// `turns`: the largest number of turns on one side of zero.
    pub(in crate::plant) fn check(&self, turns: f32) -> Result<(), InvalidParameter> {
        require(
            self.counts_per_turn > 0,
            "counts per turn",
            "must be at least 1",
        )?;
        // Every count is a number of its own in f32.
        require(
            turns * f32::from(self.counts_per_turn) < 8_388_608.0,
            "counts per turn",
            "must give fewer than 8388608 counts to either end of travel",
        )
    }

    /// rad of the motor for one count.
    pub fn angle(&self) -> f32 {
        TAU / f32::from(self.counts_per_turn)
    }

    /// The counter at an angle of the motor, rad: the last edge passed, as seen from below.
    pub fn count(&self, angle: f32) -> f32 {
        libm::floorf(angle / self.angle())
    }
}
