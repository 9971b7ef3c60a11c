//! The position as a throttle's sensor tells it: on two tracks, of which one falls as the other
//! rises, in codes of a 12-bit converter.
//!
//! They stay between a tenth and nine tenths of full scale and add up to it wherever the actuator is,
//! so a reader sees a track that is broken.

use model_core::plant::potentiometer::Track;

/// Largest code of a 12-bit converter.
pub const FULL_SCALE: u16 = 4095;

/// Codes of both tracks while a fault is latched: ground, where no position takes them and where a
/// reader finds both out of their range.
pub const DIAGNOSTIC: [u16; 2] = [0, 0];

/// Two straight lines of the position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tracks([Track; 2]);

impl Tracks {
    /// For a stroke from `lower` to `upper`, rad or m; `upper` lies above `lower`.
    pub const fn new(lower: f32, upper: f32) -> Self {
        Self([
            Track::rising(lower, upper),
            Track::complementary(lower, upper),
        ])
    }

    /// The codes of both tracks. Beyond the stroke they go on to the converter's ends; NaN is 0 on
    /// both, which no position gives.
    pub fn codes(&self, position: f32) -> [u16; 2] {
        self.0.map(|track| code(track.share(position)))
    }
}

/// The nearest code of a share of full scale.
pub fn code(share: f32) -> u16 {
    // The conversion saturates, and takes NaN for 0.
    let code = (share * f32::from(FULL_SCALE) + 0.5) as u16;
    code.min(FULL_SCALE)
}
