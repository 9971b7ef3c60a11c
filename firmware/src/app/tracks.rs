//! The position as a throttle's sensor tells it: on two tracks, one of them inverted.
//!
//! The two add up to full scale wherever the actuator is, so a reader sees a track that is broken.

/// Largest code of a 12-bit converter.
pub const FULL_SCALE: u16 = 4095;

/// A stroke that is spread over the converter's range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tracks {
    lower: f32,
    codes_per_unit: f32,
}

impl Tracks {
    /// For a stroke from `lower` to `upper`, rad or m; `upper` lies above `lower`.
    pub const fn new(lower: f32, upper: f32) -> Self {
        Self {
            lower,
            codes_per_unit: FULL_SCALE as f32 / (upper - lower),
        }
    }

    /// The codes of both tracks: the first rises with the position, the second falls. Beyond the
    /// stroke they stay at its ends; NaN is at its lower one.
    pub fn codes(&self, position: f32) -> [u16; 2] {
        // The conversion saturates, and takes NaN for 0.
        let code = ((position - self.lower) * self.codes_per_unit + 0.5) as u16;
        let rising = code.min(FULL_SCALE);
        [rising, FULL_SCALE - rising]
    }
}
