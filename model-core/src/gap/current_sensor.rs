//! How the sensor of the current errs.

use heapless::Vec;

/// What a sensor of the current says: `gain` times the current of `lag` seconds before, and `offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CurrentSensor {
    /// What it says over the current, above 0.
    pub gain: f32,
    /// What it says of no current, A.
    pub offset: f32,
    /// How late it says it, s; below 0 where it is early.
    pub lag: f32,
}

/// One of its numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reading {
    /// [`CurrentSensor::gain`].
    Gain,
    /// [`CurrentSensor::offset`].
    Offset,
    /// [`CurrentSensor::lag`].
    Lag,
}

impl Reading {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Gain, Self::Offset, Self::Lag];
}

/// Some of its numbers.
pub type Readings = Vec<Reading, { Reading::ALL.len() }>;

impl Default for CurrentSensor {
    fn default() -> Self {
        Self {
            gain: 1.0,
            offset: 0.0,
            lag: 0.0,
        }
    }
}

impl CurrentSensor {
    /// What it says of a current.
    #[inline]
    pub fn reading(&self, current: f32) -> f32 {
        self.gain * current + self.offset
    }

    /// The current of which it says this.
    #[inline]
    pub fn current(&self, reading: f32) -> f32 {
        (reading - self.offset) / self.gain
    }

    /// By how much more it says per unit of one of its numbers, of a current that rises so fast, A and A/s.
    #[inline]
    pub fn slope(&self, reading: Reading, (current, rise): (f32, f32)) -> f32 {
        match reading {
            Reading::Gain => current,
            Reading::Offset => 1.0,
            Reading::Lag => -self.gain * rise,
        }
    }

    /// One of its numbers.
    pub fn get(&self, reading: Reading) -> f32 {
        match reading {
            Reading::Gain => self.gain,
            Reading::Offset => self.offset,
            Reading::Lag => self.lag,
        }
    }

    /// Sets one of its numbers.
    pub fn set(&mut self, reading: Reading, value: f32) {
        match reading {
            Reading::Gain => self.gain = value,
            Reading::Offset => self.offset = value,
            Reading::Lag => self.lag = value,
        }
    }
}
