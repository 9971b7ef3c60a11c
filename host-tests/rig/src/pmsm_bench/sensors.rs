//! What the drive and the load cell add to what they measure.

use super::control::Control;
use std::f64::consts::TAU;

/// Imperfections of the measured values; standard deviations unless said otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensors {
    /// Of the speed that the drive reports and controls, rad/s at the motor shaft.
    pub speed_noise: f64,
    /// Of the d and q current that the drive measures and controls, A rms.
    pub current_noise: f64,
    /// Of the phase-current sensors: a vector of this length at rest in the stator, which turns
    /// backward in d-q, A rms.
    pub current_offset: f64,
    /// Greatest ripple of the switching inverter on the logged i_q, A. It is drawn evenly from both
    /// sides of zero each period, as a free-running hysteresis looks when sampled.
    pub current_ripple: f64,
    /// Corner of the first-order filter of the logged i_q, Hz.
    pub current_filter: f64,
    /// Of the load cell, N.
    pub force_noise: f64,
}

impl Sensors {
    /// The bench's: the paper's ±0.1 A of hysteresis, logged behind 100 Hz.
    pub const BENCH: Self = Self {
        speed_noise: 0.02,
        current_noise: 0.01,
        current_offset: 5.0e-3,
        current_ripple: 0.1,
        current_filter: 100.0,
        force_noise: 0.05,
    };

    /// Nothing but the log's filter.
    pub const IDEAL: Self = Self {
        speed_noise: 0.0,
        current_noise: 0.0,
        current_offset: 0.0,
        current_ripple: 0.0,
        current_filter: 100.0,
        force_noise: 0.0,
    };

    /// Share of the way to its input that the log's filter goes in a period of the drive.
    pub(super) fn filter_share(&self) -> f64 {
        1.0 - (-TAU * self.current_filter * Control::PERIOD).exp()
    }

    /// What the offset adds to i_d and i_q at this electrical angle, A rms.
    pub(super) fn offset(&self, electrical_angle: f64) -> (f64, f64) {
        (
            self.current_offset * electrical_angle.cos(),
            -self.current_offset * electrical_angle.sin(),
        )
    }
}
