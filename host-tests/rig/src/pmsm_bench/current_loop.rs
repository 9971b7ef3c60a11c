//! The drive's current loop.

use super::control::Control;
use super::motor::Motor;

/// Bandwidth of the closed loop, rad/s: about 240 Hz, usual for a drive of 8 kHz.
const BANDWIDTH: f64 = 1500.0;

/// Proportional-integral control of i_d (to 0) and i_q, with the winding's pole cancelled and the
/// voltages of rotation fed forward.
#[derive(Debug, Clone, Default)]
pub(super) struct CurrentLoop {
    integral: (f64, f64),
}

impl CurrentLoop {
    /// Voltages (v_d, v_q) for measured currents (i_d, i_q), a wanted i_q and a speed, V rms. The
    /// integrals stand still while the inverter is at its limit.
    pub(super) fn step(
        &mut self,
        motor: &Motor,
        (i_d, i_q): (f64, f64),
        wanted_i_q: f64,
        speed: f64,
    ) -> (f64, f64) {
        let electrical_speed = motor.pole_pairs * speed;
        let (error_d, error_q) = (-i_d, wanted_i_q - i_q);
        let gain = BANDWIDTH * motor.inductance;
        let v_d = gain * error_d + self.integral.0 - electrical_speed * motor.inductance * i_q;
        let v_q = gain * error_q
            + self.integral.1
            + electrical_speed * (motor.inductance * i_d + motor.flux_linkage());
        let length = v_d.hypot(v_q);
        if length > motor.peak_voltage {
            let share = motor.peak_voltage / length;
            return (share * v_d, share * v_q);
        }
        let rate = BANDWIDTH * motor.resistance * Control::PERIOD;
        self.integral.0 += rate * error_d;
        self.integral.1 += rate * error_q;
        (v_d, v_q)
    }
}

#[cfg(test)]
mod tests {
    use super::{BANDWIDTH, Control, CurrentLoop, Motor};
    use crate::pmsm_bench::{Brake, EncoderGear, Loss, Plant};

    /// With the pole of the winding cancelled the loop is an integrator's: i = I (1 − (1 − ω T)^n)
    /// after n periods, to the first order of the period over the winding's time constant.
    #[test]
    fn current_follows_a_step_at_the_bandwidth() {
        let held = Motor {
            inertia: 1e9,
            ..Motor::SIMOTICS_1FK7060
        };
        let mut plant = Plant::new(held, Brake::even(0.0), Loss::None, EncoderGear::play(0.0));
        let mut control = CurrentLoop::default();
        for period in 0..40 {
            let state = *plant.state();
            let exact = 3.0 * (1.0 - (1.0 - BANDWIDTH * Control::PERIOD).powi(period));
            assert!(
                (state.current_q - exact).abs() < 0.02,
                "{period}: {state:?}"
            );
            let measured = (state.current_d, state.current_q);
            plant.advance(control.step(&held, measured, 3.0, 0.0), Control::PERIOD);
        }
    }

    #[test]
    fn voltage_stays_within_the_inverter() {
        let motor = Motor::SIMOTICS_1FK7060;
        let (d, q) = CurrentLoop::default().step(&motor, (-3.0, 0.0), 10.7, 300.0);
        assert!((d.hypot(q) - motor.peak_voltage).abs() < 1e-9);
    }
}
