//! What the bench is asked to do.

use crate::trajectory::{Move, Sine, Trajectory};

/// A commanded motion of the slow shaft and its log.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    /// Position of the slow shaft, rad; 0 at first.
    pub trajectory: Trajectory,
    /// What passes before the log begins, s.
    pub settling: f64,
    /// Length of the log, s.
    pub seconds: f64,
    /// Rows a second, Hz: 8000 or an integer part of it.
    pub sample_rate: f64,
    /// Seed of the noise.
    pub seed: u64,
}

impl Program {
    fn new(trajectory: Trajectory, settling: f64, seconds: f64) -> Self {
        Self {
            trajectory,
            settling,
            seconds,
            sample_rate: 500.0,
            seed: 1,
        }
    }

    /// A sine from 0 of this amplitude, degrees, and frequency, Hz: three periods after one of
    /// settling.
    pub fn sine(degrees: f64, frequency: f64) -> Self {
        let trajectory = Trajectory::Sines {
            centre: 0.0,
            components: vec![Sine {
                amplitude: degrees.to_radians(),
                frequency,
                phase: 0.0,
            }],
        };
        Self::new(trajectory, 1.0 / frequency, 3.0 / frequency)
    }

    /// The sine of the paper's campaign: 10° at 0.1 Hz (section 5.2).
    pub fn paper_sine() -> Self {
        Self::sine(10.0, 0.1)
    }

    /// A sine that the campaign does not have: 6° at 0.23 Hz.
    pub fn validation_sine() -> Self {
        Self::sine(6.0, 0.23)
    }

    /// The ramp of the load-cell mapping: 0.085°/s for 120 s (section 5.1).
    pub fn slow_ramp() -> Self {
        let speed = 0.085_f64.to_radians();
        let trajectory = Trajectory::Moves {
            start: 0.0,
            moves: vec![Move {
                target: 150.0 * speed,
                speed,
                acceleration: speed,
                dwell: 0.0,
            }],
        };
        Self::new(trajectory, 5.0, 120.0)
    }

    /// Steps of many lengths both ways, 2 s each; the longer ones meet the speed limit.
    pub fn multi_step() -> Self {
        const DEGREES: [f64; 10] = [0.0, 2.0, -1.0, 5.0, 4.0, -6.0, -5.5, 10.0, -10.0, 0.0];
        let trajectory = Trajectory::Sampled {
            rate: 0.5,
            values: DEGREES.map(f64::to_radians).to_vec(),
        };
        Self::new(trajectory, 0.0, 20.0)
    }

    /// With a log of `seconds`.
    pub fn lasting(mut self, seconds: f64) -> Self {
        self.seconds = seconds;
        self
    }

    /// With a log that begins after `seconds`.
    pub fn settling(mut self, seconds: f64) -> Self {
        self.settling = seconds;
        self
    }

    /// With another seed.
    pub fn seeded(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// With other rows a second, Hz.
    pub fn sampled_at(mut self, rate: f64) -> Self {
        self.sample_rate = rate;
        self
    }
}
