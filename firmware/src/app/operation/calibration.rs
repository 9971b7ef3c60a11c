//! What the outputs' amplifiers make of a code, put right: two position tracks, and the current.

use model_core::plant::potentiometer::REFERENCE;

use crate::app::store::field::{Field, Values};
use crate::app::tracks;

/// A factor, and what is added behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correction {
    /// The factor.
    pub gain: f32,
    /// What is added.
    pub offset: f32,
}

impl Correction {
    /// As it is.
    pub const NONE: Self = Self {
        gain: 1.0,
        offset: 0.0,
    };

    /// The value, put right.
    pub fn of(&self, value: f32) -> f32 {
        value * self.gain + self.offset
    }
}

/// Codes of the current's output: 84 MHz by 2048 is a PWM of 41 kHz.
pub const CURRENT_FULL_SCALE: u16 = 2047;

/// Current at either end of its output, A; none at its middle.
pub const CURRENT_SPAN: f32 = 25.0;

/// Of all outputs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibration {
    /// The tracks: volts.
    pub tracks: [Correction; 2],
    /// The current: ampere.
    pub current: Correction,
}

impl Calibration {
    /// What the store has.
    pub fn of(values: &Values) -> Self {
        let correction = |gain, offset| Correction {
            gain: values.get(gain),
            offset: values.get(offset),
        };
        Self {
            tracks: [
                correction(Field::Track1Gain, Field::Track1Offset),
                correction(Field::Track2Gain, Field::Track2Offset),
            ],
            current: correction(Field::CurrentGain, Field::CurrentOffset),
        }
    }

    /// Codes of the two tracks for shares of the reference of 5 V.
    pub fn track_codes(&self, shares: [f32; 2]) -> [u16; 2] {
        let [first, second] = &self.tracks;
        let code = |correction: &Correction, share: f32| {
            tracks::code(correction.of(share * REFERENCE) / REFERENCE)
        };
        [code(first, shares[0]), code(second, shares[1])]
    }

    /// Code of the output of a current, A.
    ///
    /// ```
    /// use firmware::app::operation::calibration::{Calibration, Correction};
    ///
    /// let none = Correction::NONE;
    /// let calibration = Calibration { tracks: [none; 2], current: none };
    /// assert_eq!([-25.0, 0.0, 25.0, 99.0].map(|a| calibration.current_code(a)), [0, 1024, 2047, 2047]);
    /// ```
    pub fn current_code(&self, current: f32) -> u16 {
        let share = 0.5 + self.current.of(current) / (2.0 * CURRENT_SPAN);
        // The conversion saturates, and takes NaN for 0.
        let code = (share * f32::from(CURRENT_FULL_SCALE) + 0.5) as u16;
        code.min(CURRENT_FULL_SCALE)
    }
}
