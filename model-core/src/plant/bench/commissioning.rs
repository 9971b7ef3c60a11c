//! Values that the paper does not print, chosen here for the whole project.
//!
//! Its controller and electrical parameters were tuned on an earlier bench and left out of the text
//! (sections 6.3 and 7.2). These make a well damped loop: the speed follows with
//! 0.1/8.3e-4 = 120 1/s, six times the gain of the position loop around it.

use super::datasheet;
use core::f32::consts::SQRT_2;

/// Period of position and speed control, s: that of the drive's own loops.
pub const CONTROL_PERIOD: f32 = 125e-6;
/// Reference speed for a position error, both on the motor's shaft, 1/s.
pub const POSITION_GAIN: f32 = 20.0;
/// Largest reference speed of the motor, rad/s.
pub const SPEED_LIMIT: f32 = 100.0;
/// Torque for a speed error, N·m·s/rad.
pub const SPEED_GAIN: f32 = 0.1;
/// Integral time of the speed controller, s.
pub const INTEGRAL_TIME: f32 = 0.1;
/// Derivative time T_d of the speed controller, s.
pub const DERIVATIVE_TIME: f32 = 0.5e-3;
/// N: T_d over the time constant of the derivative's filter.
pub const DERIVATIVE_FILTER: f32 = 10.0;
/// Time in which the third anti-windup takes the integral back, s.
pub const TRACKING_TIME: f32 = 10e-3;
/// The bridge's supply, V: the peak of the rectified line.
pub const BUS_VOLTAGE: f32 = datasheet::inverter::LINE_VOLTAGE * SQRT_2;
/// Viscous friction of all that turns, at the motor's shaft, N·m·s/rad.
pub const VISCOUS: f32 = 2e-3;
/// Friction of the bench without its brake while it slides, at the motor's shaft, N·m.
pub const TARE_COULOMB: f32 = 0.05;
/// The same at rest.
pub const TARE_BREAKAWAY: f32 = 0.06;
/// Cut-off of the quadrature current's filter, Hz.
pub const CURRENT_CUT_OFF: f32 = 100.0;
/// Ends of travel, rad of the slow shaft either way: a quarter turn.
pub const END_STOP: f32 = core::f32::consts::FRAC_PI_2;
