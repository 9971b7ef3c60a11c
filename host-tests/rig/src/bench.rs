//! What a bench of ordinary parts adds to the machine on it.

use std::f64::consts::TAU;

/// Imperfections of supply, motor, mounting and sensors. [`Bench::IDEAL`] has none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bench {
    /// Reading of the current sensor without current, A.
    pub current_offset: f64,
    /// Growth of that reading, A/s.
    pub current_drift: f64,
    /// Ripple of the supply, as a share of the voltage that the drive was told to give.
    pub supply_ripple: f64,
    /// Its frequency, Hz.
    pub supply_frequency: f64,
    /// Its phase at the start of the log, rad.
    pub supply_phase: f64,
    /// Ripple of the torque constant over the angle, as a share of it. The back-EMF has it too.
    pub torque_ripple: f64,
    /// Periods of that ripple in a turn, or in 2π m.
    pub ripples_per_turn: f64,
    /// Steps of the current sensor's converter, A; 0 for none.
    pub current_resolution: f64,
    /// Reading of the position sensor at 0, rad or m.
    pub position_offset: f64,
    /// Growth of that reading, rad/s or m/s.
    pub position_drift: f64,
    /// Lost motion between motor and position sensor, rad or m.
    pub backlash: f64,
}

impl Bench {
    /// A bench that adds nothing.
    pub const IDEAL: Self = Self {
        current_offset: 0.0,
        current_drift: 0.0,
        supply_ripple: 0.0,
        supply_frequency: 100.0,
        supply_phase: 0.0,
        torque_ripple: 0.0,
        ripples_per_turn: 12.0,
        current_resolution: 0.0,
        position_offset: 0.0,
        position_drift: 0.0,
        backlash: 0.0,
    };

    /// What the supply makes of one volt at `time`.
    pub(crate) fn supply(&self, time: f64) -> f64 {
        1.0 + self.supply_ripple * (TAU * self.supply_frequency * time + self.supply_phase).sin()
    }

    /// What the current sensor adds at `time`, A.
    pub(crate) fn current_error(&self, time: f64) -> f64 {
        self.current_offset + self.current_drift * time
    }

    /// What the position sensor adds at `time`, rad or m.
    pub(crate) fn position_error(&self, time: f64) -> f64 {
        self.position_offset + self.position_drift * time
    }

    /// Where the sensor's side of the backlash is, once the motor's is at `motor`: it stays until the
    /// motor has taken up the play, and is dragged along from then on.
    pub(crate) fn take_up(&self, sensor: f64, motor: f64) -> f64 {
        let half = 0.5 * self.backlash;
        sensor.clamp(motor - half, motor + half)
    }
}

#[cfg(test)]
mod tests {
    use super::Bench;

    #[test]
    fn the_play_is_lost_at_every_reversal() {
        let bench = Bench {
            backlash: 0.2,
            ..Bench::IDEAL
        };
        let mut sensor = 0.0;
        for (motor, expected) in [(0.05, 0.0), (0.3, 0.2), (1.0, 0.9), (0.85, 0.9), (0.5, 0.6)] {
            sensor = bench.take_up(sensor, motor);
            assert!((sensor - expected).abs() < 1e-12, "{motor}");
        }
    }
}
