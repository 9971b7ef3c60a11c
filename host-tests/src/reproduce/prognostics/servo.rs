//! The six-block servo as a bench: a logger as slow as its drive.
//!
//! The rig's servo follows a sweep of the rod in its own position loop. A row each 16 ms, 400 counts a
//! turn of the motor, 127 counts of duty, a flux that saturates. It is the motor that the other bench
//! has, so that the model calibrated there is the model here; friction acts at the motor's shaft.

use model_core::gap::log::{Channel, Log};
use model_core::identify::position_error::Levels;
use model_core::numeric::invalid_parameter::InvalidParameter;
use model_core::plant::ema::{self, Command, Ema, friction};
use model_core::plant::parameters::Parameters;
use model_core::signal::sweep;
use rig::Servo;

use super::estimate::Objective;
use super::stand::{Friction, SECONDS};

/// The servo's gearbox, screw, drive and encoder.
const SERVO: ema::Parameters = ema::Parameters::ALI_2;

/// One count of its encoder, rad.
pub const RESOLUTION: f32 = std::f32::consts::TAU / 400.0;

/// What the rod is asked for, m. At 1 Hz even the healthy motor is near its top speed.
const SWEEP: sweep::Parameters = sweep::Parameters {
    offset: 0.0,
    amplitude: 0.01,
    initial_frequency: 0.1,
    final_frequency: 1.0,
    duration: SECONDS as f32,
};

/// What the servo logged.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// Position asked for, m.
    command: Vec<f32>,
    /// Voltage, V: the duty that was set, times the supply.
    input: Vec<f32>,
    /// Position of the motor, rad.
    position: Vec<f32>,
}

/// A log of a servo with this friction.
///
/// # Errors
/// A signal that the core does not take.
pub fn record(friction: Friction) -> Result<Recorded, InvalidParameter> {
    let gains = (
        SERVO.controller.proportional.into(),
        SERVO.controller.integral.into(),
    );
    let mut servo = Servo::new(gains, true, (friction.coulomb, friction.breakaway));
    let period = SERVO.drive.period;
    let sweep = SWEEP.build(period)?;
    let rows = (SECONDS / f64::from(period)) as u32;
    let travel = f64::from(SERVO.ball_screw.travel(SERVO.gearbox));
    let mut log = Recorded {
        command: Vec::new(),
        input: Vec::new(),
        position: Vec::new(),
    };
    for row in 0..rows {
        let command = sweep.at(row);
        let sample = servo.follow(command.into());
        log.command.push(command);
        log.input
            .push((sample.duty * f64::from(SERVO.drive.supply)) as f32);
        log.position.push((sample.position / travel) as f32);
    }
    Ok(log)
}

impl Recorded {
    /// For the core.
    pub fn log(&self) -> Log<'_> {
        Log::new(
            SERVO.drive.period,
            Channel::Values(&self.input),
            Channel::Values(&self.position),
        )
    }
}

/// The paper's own objective: the six blocks follow the command in their own loop, from the start of
/// the log to its end, and E is that of eq. 5 on the motor's position.
#[derive(Debug, Clone)]
pub struct SixBlocks<'a> {
    log: &'a Recorded,
    ema: Ema,
}

impl<'a> SixBlocks<'a> {
    /// With the motor's inertia and damping from a calibrated model.
    ///
    /// # Errors
    /// A parameter that the servo does not take.
    pub fn new(model: &Parameters, log: &'a Recorded) -> Result<Self, ema::BuildError> {
        let ema = Ema::build(&ema::Parameters {
            motor: ema::motor::Parameters {
                inertia: model.inertia,
                viscous: model.viscous.forward,
                ..SERVO.motor
            },
            // Steps of 1 ms: the exact scheme needs them for the saturation of the flux alone.
            steps: 16,
            ..SERVO
        })?;
        Ok(Self { log, ema })
    }

    /// The integral of eq. 5 over the squares of what `error` gives for each row.
    fn integral(&self, mut error: impl FnMut(usize) -> f32) -> f32 {
        let last = self.log.position.len() - 1;
        let squares = (0..=last).map(|row| {
            let weight = if row == 0 || row == last { 0.5 } else { 1.0 };
            let error = f64::from(error(row));
            weight * error * error
        });
        (squares.sum::<f64>() * f64::from(SERVO.drive.period)) as f32
    }
}

impl Objective for SixBlocks<'_> {
    fn at(&mut self, levels: Levels) -> f32 {
        let mut ema = self.ema.clone();
        ema.reset();
        ema.set_friction(friction::Parameters {
            coulomb: levels.coulomb,
            breakaway: levels.breakaway,
        });
        let travel = SERVO.ball_screw.travel(SERVO.gearbox);
        self.integral(|row| {
            let command = Command::Position(self.log.command[row]);
            ema.step(command).map_or(f32::NAN, |sample| {
                sample.position / travel - self.log.position[row]
            })
        })
    }

    fn at_rest(&self) -> f32 {
        self.integral(|row| self.log.position[row] - self.log.position[0])
    }
}
