//! Position and speed loop (section 3.1).

/// Numbers of the cascade.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Control {
    /// Reference speed for a position error, both at the motor shaft, 1/s.
    pub position_gain: f64,
    /// Largest reference speed, rad/s at the motor shaft.
    pub speed_limit: f64,
    /// Torque for a speed error, N·m·s/rad.
    pub speed_gain: f64,
    /// s.
    pub integral_time: f64,
    /// s.
    pub derivative_time: f64,
    /// N of the derivative's filter, whose time constant is `derivative_time` / N.
    pub derivative_filter: f64,
    /// Time in which back-calculation (anti-windup 3) unloads the integral at the limit, s.
    pub tracking_time: f64,
    /// Periods of the drive in one of the position loop.
    pub position_divider: usize,
}

impl Control {
    /// Period of the drive's speed and current loop, s.
    pub const PERIOD: f64 = 125.0e-6;

    /// The bench's: a drive at 8 kHz under a PLC at 1 kHz.
    pub const BENCH: Self = Self {
        position_gain: 20.0,
        speed_limit: 100.0,
        speed_gain: 0.1,
        integral_time: 0.1,
        derivative_time: 0.5e-3,
        derivative_filter: 10.0,
        tracking_time: 0.01,
        position_divider: 8,
    };

    /// Reference speed for this position error at the motor shaft, rad/s.
    pub(super) fn reference_speed(&self, position_error: f64) -> f64 {
        (self.position_gain * position_error).clamp(-self.speed_limit, self.speed_limit)
    }
}

/// State of the speed loop.
#[derive(Debug, Clone, Default)]
pub(super) struct SpeedLoop {
    integral: f64,
    derivative: f64,
    last_error: f64,
}

impl SpeedLoop {
    /// Torque for this speed error, within ±`limit`, N·m. Backward Euler, the integral after the
    /// limit.
    pub(super) fn step(&mut self, control: &Control, error: f64, limit: f64) -> f64 {
        let period = Control::PERIOD;
        let filter = control.derivative_time / control.derivative_filter;
        self.derivative = (filter * self.derivative
            + control.derivative_time * (error - self.last_error))
            / (filter + period);
        self.last_error = error;
        let wanted = control.speed_gain * (error + self.derivative) + self.integral;
        let torque = wanted.clamp(-limit, limit);
        self.integral += period
            * (control.speed_gain / control.integral_time * error
                + (torque - wanted) / control.tracking_time);
        torque
    }
}

#[cfg(test)]
mod tests {
    use super::{Control, SpeedLoop};

    /// K (e + e t / Ti) for a constant error once the derivative's kick has died.
    #[test]
    fn constant_error_ramps_the_torque() {
        let (mut pid, control) = (SpeedLoop::default(), Control::BENCH);
        let torque = (0..=1600)
            .map(|_| pid.step(&control, 2.0, 20.0))
            .last()
            .unwrap();
        assert!((torque - 0.1 * (2.0 + 2.0 * 0.2 / 0.1)).abs() < 1e-9);
    }

    /// At the limit the integral settles where K e / Ti = (K e + I − limit) / Tt.
    #[test]
    fn back_calculation_bounds_the_integral() {
        let (mut pid, control) = (SpeedLoop::default(), Control::BENCH);
        for _ in 0..8_000 {
            pid.step(&control, 50.0, 3.0);
        }
        let settled = 3.0 - 0.1 * 50.0 + 0.1 * 50.0 * control.tracking_time / control.integral_time;
        assert!((pid.integral - settled).abs() < 1e-6);
        assert!(pid.step(&control, -40.0, 3.0) < 0.0);
    }
}
