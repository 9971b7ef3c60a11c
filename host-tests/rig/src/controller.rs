//! The position loop of the bench.

/// Gains of a parallel PID on a position, its output the drive's input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PidGains {
    /// Input per rad or m.
    pub proportional: f64,
    /// Input per rad·s or m·s.
    pub integral: f64,
    /// Input per rad/s or m/s.
    pub derivative: f64,
    /// Time constant of the derivative's first-order filter, s.
    pub derivative_time: f64,
}

/// The loop's state. The derivative acts on the measurement, through a first-order filter
/// (backward Euler); the integral (forward Euler) stands still while the output is limited and
/// the error would drive it further.
#[derive(Debug, Clone)]
pub struct Pid {
    gains: PidGains,
    limit: f64,
    period: f64,
    integral: f64,
    rate: f64,
    last: Option<f64>,
}

impl Pid {
    /// A loop at rest, run every `period` seconds, its output within ±`limit`.
    pub fn new(gains: PidGains, limit: f64, period: f64) -> Self {
        Self {
            gains,
            limit,
            period,
            integral: 0.0,
            rate: 0.0,
            last: None,
        }
    }

    /// The input for this sample.
    pub fn step(&mut self, command: f64, measured: f64) -> f64 {
        let last = self.last.replace(measured).unwrap_or(measured);
        self.rate = (self.gains.derivative_time * self.rate + measured - last)
            / (self.gains.derivative_time + self.period);
        let error = command - measured;
        let wanted =
            self.gains.proportional * error + self.integral - self.gains.derivative * self.rate;
        let output = wanted.clamp(-self.limit, self.limit);
        if output == wanted || error * wanted < 0.0 {
            self.integral += self.gains.integral * error * self.period;
        }
        output
    }
}

#[cfg(test)]
mod tests {
    use super::{Pid, PidGains};

    const GAINS: PidGains = PidGains {
        proportional: 2.0,
        integral: 10.0,
        derivative: 0.5,
        derivative_time: 4.0e-3,
    };

    #[test]
    fn constant_error_ramps_the_output_by_the_integral_gain() {
        let mut pid = Pid::new(GAINS, 100.0, 1.0e-3);
        let last = (0..=1000).map(|_| pid.step(3.0, 0.0)).last().unwrap();
        // kp e + ki e t after 1 s.
        assert!((last - (2.0 * 3.0 + 10.0 * 3.0)).abs() < 1e-9);
    }

    #[test]
    fn derivative_settles_on_the_speed_of_a_ramp() {
        let mut pid = Pid::new(
            PidGains {
                proportional: 0.0,
                integral: 0.0,
                ..GAINS
            },
            100.0,
            1.0e-3,
        );
        let last = (0..200)
            .map(|k| pid.step(0.0, 7.0e-3 * f64::from(k)))
            .last()
            .unwrap();
        assert!((last + 0.5 * 7.0).abs() < 1e-9);
    }

    #[test]
    fn integral_does_not_wind_up_at_the_limit() {
        let mut pid = Pid::new(GAINS, 5.0, 1.0e-3);
        for _ in 0..5000 {
            assert_eq!(pid.step(10.0, 0.0), 5.0);
        }
        assert!(pid.step(0.0, 0.0).abs() < 5.0 * 1e-9);
    }
}
