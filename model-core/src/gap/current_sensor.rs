//! How a measured current differs from that of the winding: gain, offset and lag of its channel.
//!
//! ```text
//! reading(t) = (1 + g) i(t − τ) + i₀
//! ```
//!
//! Shunts and amplifiers are a few percent off and a logger's filter is late; what that makes of the current
//! looks like a wrong resistance, brushes or a late drive. So every model has these three numbers, which are
//! freed where they explain a log as well as an effect does. They are the channel's, not the machine's: a simulation
//! of the machine alone has none of them.

/// The channel of a measured current. The default is an ideal one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CurrentSensor {
    /// Share by which it reads too much, 1.
    pub gain_error: f32,
    /// What it reads without a current, A.
    pub offset: f32,
    /// Time by which it is late, s.
    pub lag: f32,
}

/// Most rows by which a reading may be late.
pub const MOST_ROWS: usize = 2;

impl CurrentSensor {
    /// What it reads of a current, with those of the rows before it, the last one first. Between rows a current goes
    /// straight; one from farther back than [`MOST_ROWS`] is that of the last of them.
    ///
    /// ```
    /// use model_core::gap::current_sensor::CurrentSensor;
    /// let sensor = CurrentSensor { gain_error: 0.1, offset: 0.5, lag: 1.5e-3 };
    /// // One and a half rows ago there were 0.5 A, read a tenth too large, and 0.5 A besides.
    /// assert!((sensor.reading(3.0, &[1.0, 0.0], 1e-3) - 1.05).abs() < 1e-6);
    /// // An ideal one changes no bit.
    /// assert_eq!(CurrentSensor::default().reading(0.1, &[0.3, 0.4], 1e-3), 0.1);
    /// ```
    #[inline(always)]
    pub fn reading(&self, current: f32, before: &[f32; MOST_ROWS], period: f32) -> f32 {
        let mut late = current;
        let mut rows = self.lag / period;
        for earlier in before {
            if rows > 0.0 {
                late += rows.min(1.0) * (earlier - late);
            }
            rows -= 1.0;
        }
        late + self.gain_error * late + self.offset
    }

    /// The current behind a reading, but for the lag.
    #[inline]
    pub fn behind(&self, reading: f32) -> f32 {
        (reading - self.offset) / (1.0 + self.gain_error)
    }
}
