//! Ramp between two levels.

use super::time;
use crate::numeric::invalid_parameter::{InvalidParameter, require, require_finite};

/// What the ramp leads from and to, when it starts and how long it takes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters {
    /// Value up to the start.
    pub initial_value: f32,
    /// Value from the end on.
    pub final_value: f32,
    /// Time of the start in s, rounded to a whole period: zero or more.
    pub start: f32,
    /// Time from start to end in s, rounded to a whole period: at least one.
    pub duration: f32,
}

impl Parameters {
    /// The signal for a `period` in s.
    pub fn build(self, period: f32) -> Result<Ramp, InvalidParameter> {
        require_finite(self.initial_value, "initial_value")?;
        require_finite(self.final_value, "final_value")?;
        let ticks = time::ticks(self.duration, period, "duration")?;
        require(ticks > 0, "duration", "must be at least one period")?;
        let rise = f64::from(self.final_value) - f64::from(self.initial_value);
        let rise_per_tick = (rise / f64::from(ticks)) as f32;
        require_finite(rise_per_tick, "final_value")?;
        Ok(Ramp {
            initial_value: self.initial_value,
            final_value: self.final_value,
            start: time::ticks(self.start, period, "start")?,
            ticks,
            rise_per_tick,
        })
    }
}

/// A ramp: the initial value + rise·(ticks since the start)/(ticks of the duration), and constant
/// before and after.
///
/// Both levels are exact; in between the error is below 4.2e-7 of the larger level.
///
/// ```
/// use model_core::signal::ramp::Parameters;
///
/// let ramp = Parameters { initial_value: 1.0, final_value: 3.0, start: 1.0, duration: 2.0 };
/// let ramp = ramp.build(0.25)?;
/// assert_eq!([ramp.at(4), ramp.at(8), ramp.at(12), ramp.at(1000)], [1.0, 2.0, 3.0, 3.0]);
/// # Ok::<(), model_core::numeric::invalid_parameter::InvalidParameter>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ramp {
    initial_value: f32,
    final_value: f32,
    start: u32,
    ticks: u32,
    rise_per_tick: f32,
}

impl Ramp {
    /// The value `tick` periods after the start of the signal.
    #[inline]
    pub fn at(&self, tick: u32) -> f32 {
        let elapsed = tick.saturating_sub(self.start);
        if elapsed < self.ticks {
            self.initial_value + self.rise_per_tick * elapsed as f32
        } else {
            self.final_value
        }
    }
}
