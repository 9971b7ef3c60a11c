//! The servo of the prognostics paper's bench: a drive of few levels and slow pace, a rod behind a
//! gearbox and a ball screw, and a controller whose integral may wind up.

use crate::machine::{Machine, Motor, Stops};
use crate::plant::Plant;
use std::f64::consts::TAU;

/// Period of the drive, s.
const PERIOD: f64 = 0.016;
/// Counts of full duty.
const LEVELS: f64 = 127.0;
/// V.
const SUPPLY: f64 = 24.0;
/// N·m.
const PEAK_TORQUE: f64 = 1.48;
/// m of the rod for 1 rad of the motor: a gearbox of 6.25, a lead of 5 mm.
const TRAVEL: f64 = 5.0e-3 / (6.25 * TAU);
/// m of the rod for one of the encoder's 400 counts a turn.
const COUNT: f64 = 5.0e-3 / (6.25 * 400.0);
/// Ends of travel, m either way.
const END: f64 = 0.1;

/// What the bench logs at the start of a period, and the duty that it sets for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoSample {
    /// By the encoder, m.
    pub position: f64,
    /// Of the motor, rad/s.
    pub speed: f64,
    /// A.
    pub current: f64,
    /// −1 to 1.
    pub duty: f64,
}

/// The servo, at rest at 0 at first. Its current never comes near the drive's limit while it speeds
/// up, so that there is none.
#[derive(Debug, Clone)]
pub struct Servo {
    plant: Plant,
    integral: f64,
    proportional_gain: f64,
    integral_gain: f64,
    anti_windup: bool,
}

impl Servo {
    /// With these gains, in duty per m and per m·s, and with or without an integral that stands
    /// while the duty is limited and the error drives it further. Friction in N·m at the motor.
    pub fn new(
        (proportional_gain, integral_gain): (f64, f64),
        anti_windup: bool,
        (coulomb, static_friction): (f64, f64),
    ) -> Self {
        let machine = Machine {
            motor: Motor::Winding {
                resistance: 1.0,
                inductance: 1.0e-3,
                torque_constant: 0.06,
            },
            inertia: 1.2e-4,
            viscous: 2.0e-4,
            coulomb,
            static_friction,
            stops: Some(Stops {
                lower: -END / TRAVEL,
                upper: END / TRAVEL,
            }),
            ..Machine::rotary_ema()
        };
        Self {
            plant: Plant::new(&machine, &[]).with_peak_load(PEAK_TORQUE),
            integral: 0.0,
            proportional_gain,
            integral_gain,
            anti_windup,
        }
    }

    /// One period in closed loop.
    pub fn follow(&mut self, command: f64) -> ServoSample {
        let error = (command / COUNT).round() * COUNT - self.measured();
        let wanted = self.proportional_gain * error + self.integral;
        let stuck_at_limit = wanted.abs() > 1.0 && wanted * error > 0.0;
        if !(self.anti_windup && stuck_at_limit) {
            self.integral += self.integral_gain * error * PERIOD;
        }
        self.drive(wanted)
    }

    /// One period in open loop.
    pub fn drive(&mut self, duty: f64) -> ServoSample {
        let duty = (duty.clamp(-1.0, 1.0) * LEVELS).round() / LEVELS;
        let sample = ServoSample {
            position: self.measured(),
            speed: self.plant.state().velocity,
            current: self.plant.state().current,
            duty,
        };
        self.plant.advance(duty * SUPPLY, PERIOD);
        sample
    }

    /// Where the rod is, m.
    pub fn position(&self) -> f64 {
        self.plant.state().position * TRAVEL
    }

    fn measured(&self) -> f64 {
        (self.position() / COUNT).floor() * COUNT
    }
}
