//! A drive like the RoboteQ AX1500: a few levels of duty, a current limit, a slow loop.
//!
//! It differs in what is limited. The AX1500 limits the current from the *supply*, 26.25 A unless it is
//! set otherwise and at most 30 A, while that through the motor may be higher (user's manual, version
//! 1.9b, page 136); here it is the motor's current. With 24 V on 1 Ω neither limit is reached while
//! driving.

use crate::numeric::invalid_parameter::{InvalidParameter, require, require_positive};

/// What the drive is.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters {
    /// Period of its loop, s, at most 1. It takes a command, reads the encoder and the
    /// current, and sets the duty once a period.
    pub period: f32,
    /// Counts of the command at full duty, 1 to 32767: ±127.
    pub full_command: u16,
    /// Supply of the bridge, V, above 0 and at most 1000: 24 V.
    pub supply: f32,
    /// Current of the motor above which the duty is scaled down, A, > 0.
    pub current_limit: f32,
}

impl Parameters {
    pub(super) fn check(&self) -> Result<(), InvalidParameter> {
        require(
            self.period > 0.0 && self.period <= 1.0,
            "drive period",
            "must be above 0 and at most 1 s",
        )?;
        require(
            (1..=32_767).contains(&self.full_command),
            "full command",
            "must be 1 to 32767 counts",
        )?;
        require(
            self.supply > 0.0 && self.supply <= 1000.0,
            "supply",
            "must be above 0 and at most 1000 V",
        )?;
        require_positive(self.current_limit, "current limit")
    }

    /// A duty as the counts that it is sent as, within full duty either way.
    pub fn counts(&self, duty: f32) -> i32 {
        let full = f32::from(self.full_command);
        libm::roundf((duty * full).clamp(-full, full)) as i32
    }
}

/// What the current limit leaves of the duty, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CurrentLimit {
    scale: f32,
}

impl CurrentLimit {
    pub(super) const OPEN: Self = Self { scale: 1.0 };

    /// The share for this period. It falls at once by what the current is too large by, and comes
    /// back by half of what the current has room for, so that it does not hunt. A current against
    /// the command brakes: less duty would only raise it.
    pub(super) fn follow(&mut self, command: f32, current: f32, limit: f32) -> f32 {
        let motoring = if command < 0.0 { -current } else { current };
        let allowed = if motoring > 0.0 {
            (self.scale * (limit / motoring)).min(1.0)
        } else {
            1.0
        };
        self.scale = if allowed < self.scale {
            allowed
        } else {
            self.scale + 0.5 * (allowed - self.scale)
        };
        self.scale
    }
}
