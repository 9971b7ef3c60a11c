//! The control electronics: position and speed control in cascade (bench paper, section 3.1).
//!
//! ```text
//! position error × gain → reference speed, limited
//! speed error → PID → reference torque ÷ torque constant → reference current, limited
//! ```
//!
//! The derivative has the filter G_d(s) = T_d s/(T_d/N s + 1). Of the paper's anti-windups the third
//! is always on: what the limit takes off the output comes off the integral
//! ([`AntiWindup::BackCalculation`]). The first or the second can be chosen beside it: [`Hold`].

use super::super::InputRefused;
use crate::control::pid::{self, AntiWindup};
use crate::numeric::invalid_parameter::{InvalidParameter, require, require_positive};

/// What holds the integral besides the limit of the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hold {
    /// Nothing.
    Never,
    /// Anti-windup 1: the motor has stood for more than one period.
    AtStandstill,
    /// Anti-windup 2: the position error, rad of the slow shaft, is larger than this.
    BeyondPositionError(f32),
}

/// Gains and limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// Of the loops, s, > 0.
    pub period: f32,
    /// Reference speed for a position error, both on the motor's shaft, 1/s.
    pub position_gain: f32,
    /// Largest reference speed of the motor, rad/s, > 0.
    pub speed_limit: f32,
    /// Torque for a speed error, N·m·s/rad.
    pub speed_gain: f32,
    /// T_i, s, > 0.
    pub integral_time: f32,
    /// T_d, s, ≥ 0.
    pub derivative_time: f32,
    /// N, > 0.
    pub derivative_filter: f32,
    /// Time in which the third anti-windup takes the integral back, s, at least a period.
    pub tracking_time: f32,
    /// The first or the second anti-windup.
    pub hold: Hold,
    /// Torque of a current, N·m per A rms, > 0: what the drive believes of the motor.
    pub torque_constant: f32,
    /// Largest reference current, A rms, > 0.
    pub current_limit: f32,
}

/// The cascade, ready to run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Control {
    /// Speed of the motor for a position error of the slow shaft.
    gain: f32,
    speed_limit: f32,
    hold: Hold,
    current_for_torque: f32,
    pid: pid::Coefficients,
}

/// What the cascade remembers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Memory {
    pid: pid::State,
    /// The motor stood a period ago.
    stood: bool,
}

impl Memory {
    /// The speed controller's terms of the last period, N·m.
    pub fn terms(&self) -> pid::Terms {
        self.pid.terms()
    }
}

impl Parameters {
    /// For a motor that turns `ratio` times for once of the slow shaft.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn build(&self, ratio: f32) -> Result<Control, InvalidParameter> {
        require_positive(self.position_gain, "position gain")?;
        require_positive(self.speed_limit, "speed limit")?;
        require_positive(self.speed_gain, "speed gain")?;
        require_positive(self.integral_time, "integral time")?;
        require_positive(self.derivative_filter, "derivative filter")?;
        require_positive(self.torque_constant, "torque constant")?;
        require_positive(self.current_limit, "current limit")?;
        let current_for_torque = 1.0 / self.torque_constant;
        require(
            current_for_torque.is_finite(),
            "torque constant",
            "must have an inverse within f32",
        )?;
        if let Hold::BeyondPositionError(threshold) = self.hold {
            require(
                threshold >= 0.0,
                "position error threshold",
                "must be at least 0",
            )?;
        }
        let torque_limit = self.torque_constant * self.current_limit;
        let pid = pid::Parameters {
            proportional: self.speed_gain,
            integral: self.speed_gain / self.integral_time,
            derivative: self.speed_gain * self.derivative_time,
            derivative_filter_time: self.derivative_time / self.derivative_filter,
            set_point_weight: 1.0,
            derivative_set_point_weight: 1.0,
            output_minimum: -torque_limit,
            output_maximum: torque_limit,
            anti_windup: AntiWindup::BackCalculation {
                tracking_time: self.tracking_time,
            },
        };
        Ok(Control {
            gain: self.position_gain * ratio,
            speed_limit: self.speed_limit,
            hold: self.hold,
            current_for_torque,
            pid: pid.build(self.period)?,
        })
    }
}

impl Control {
    /// One period: the reference current, A rms, for a command and a position, rad of the slow
    /// shaft, and the motor's speed, rad/s.
    ///
    /// # Errors
    /// [`InputRefused`] for a command that is not finite; the memory is unchanged.
    #[inline]
    pub fn step(
        &self,
        memory: &mut Memory,
        command: f32,
        position: f32,
        speed: f32,
    ) -> Result<f32, InputRefused> {
        if !command.is_finite() {
            return Err(InputRefused);
        }
        let error = command - position;
        let reference = (self.gain * error).clamp(-self.speed_limit, self.speed_limit);
        let stands = speed == 0.0;
        let held = match self.hold {
            Hold::Never => false,
            Hold::AtStandstill => stands && memory.stood,
            Hold::BeyondPositionError(threshold) => error.abs() > threshold,
        };
        let torque = if held {
            self.pid
                .step_holding_integral(&mut memory.pid, reference, speed)
        } else {
            self.pid.step(&mut memory.pid, reference, speed)
        }
        .map_err(|_| InputRefused)?;
        memory.stood = stands;
        // The limits of the torque are those of the current.
        Ok(torque * self.current_for_torque)
    }
}
