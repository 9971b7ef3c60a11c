//! The electromechanical servo of the prognostics paper, in its six blocks (Fig. 7), one a file:
//! [position controller](crate::control::pid), [`drive`], [`motor`], [`gearbox`], [`ball_screw`],
//! [`encoder`]; the dry [`friction`] of all of them acts on the motor's shaft.
//!
//! Transmission and rod are rigid, so that the whole is one inertia (paper, section V). In each
//! period of the drive the encoder is read, the controller and the drive set the duty, and motor
//! and friction advance under it.

use super::parameters::{ParameterError, Parameters as Plant};
use super::{Directional, InputRefused, State};
use crate::control::pid::{self, AntiWindup};
use crate::numeric::invalid_parameter::{InvalidParameter, require};
use drive::CurrentLimit;
use friction::{Mechanism, Scheme};

pub mod ball_screw;
pub mod drive;
pub mod encoder;
pub mod friction;
pub mod gearbox;
pub mod motor;

/// What the servo is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// Position controller: from m to a duty, its limits within ±1.
    pub controller: pid::Parameters,
    /// Drive.
    pub drive: drive::Parameters,
    /// Motor.
    pub motor: motor::Parameters,
    /// Gearbox.
    pub gearbox: gearbox::Parameters,
    /// Ball screw.
    pub ball_screw: ball_screw::Parameters,
    /// Encoder.
    pub encoder: encoder::Parameters,
    /// Dry friction.
    pub friction: friction::Parameters,
    /// How motor and friction are stepped.
    pub scheme: Scheme,
    /// Steps of them in a period of the drive, at least 1.
    pub steps: u16,
}

impl Parameters {
    /// An actuator of the class of the paper's MecVel ALI-2 behind an AX1500.
    ///
    /// Of the paper: the supply of 24 V (section IV), the nominal dry friction of 0.12 N·m and the
    /// motor's peak torque of 1.48 N·m (section VI). The drive's 127 counts are its serial
    /// protocol's. All else is ours, of the orders of magnitude of such a part: the drive's period of
    /// 16 ms, for which the paper gives no number; the motor of the project's examples, a breakaway level a quarter above the Coulomb
    /// level, a gearbox of 6.25 and a lead of 5 mm for 44 mm/s, 200 mm of travel, 400 counts a turn,
    /// and the gains.
    pub const ALI_2: Self = Self {
        controller: pid::Parameters {
            proportional: 300.0,
            integral: 300.0,
            derivative: 0.0,
            derivative_filter_time: 0.0,
            set_point_weight: 1.0,
            derivative_set_point_weight: 0.0,
            output_minimum: -1.0,
            output_maximum: 1.0,
            anti_windup: AntiWindup::ConditionalIntegration,
        },
        drive: drive::Parameters {
            period: 0.016,
            full_command: 127,
            supply: 24.0,
            current_limit: 30.0,
        },
        motor: motor::Parameters {
            resistance: 1.0,
            inductance: 1e-3,
            torque_constant: 0.06,
            peak_torque: 1.48,
            inertia: 1.2e-4,
            viscous: 2e-4,
        },
        gearbox: gearbox::Parameters { ratio: 6.25 },
        ball_screw: ball_screw::Parameters {
            lead: 5e-3,
            mass: 0.0,
            lower_end: -0.1,
            upper_end: 0.1,
        },
        encoder: encoder::Parameters {
            counts_per_turn: 400,
        },
        friction: friction::Parameters {
            coulomb: 0.12,
            breakaway: 0.15,
        },
        scheme: Scheme::Exact,
        steps: 160,
    };

    /// The one inertia that motor, gearbox, screw and rod are, with its stops, on the motor's shaft.
    pub fn plant(&self) -> Plant {
        let travel = self.ball_screw.travel(self.gearbox);
        Plant {
            drive: self.motor.drive(),
            gain: 1.0,
            inertia: self.motor.inertia + self.ball_screw.mass * travel * travel,
            viscous: Directional::both(self.motor.viscous),
            coulomb: Directional::both(self.friction.coulomb),
            breakaway: Directional::both(self.friction.breakaway),
            spring: 0.0,
            spring_rest: 0.0,
            spring_preload: 0.0,
            offset: 0.0,
            lower_stop: self.ball_screw.lower_end / travel,
            upper_stop: self.ball_screw.upper_end / travel,
        }
    }

    fn check(&self) -> Result<(), InvalidParameter> {
        self.drive.check()?;
        self.gearbox.check()?;
        self.ball_screw.check()?;
        let farthest = self.ball_screw.upper_end.max(-self.ball_screw.lower_end);
        let turns = farthest / self.ball_screw.lead * self.gearbox.ratio;
        self.encoder.check(turns)?;
        require(
            self.controller.output_minimum >= -1.0 && self.controller.output_maximum <= 1.0,
            "controller output",
            "must be within -1 to 1, the full duty",
        )?;
        require(self.steps > 0, "steps", "must be at least 1")
    }
}

/// What the servo is told for a period of its drive.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Command {
    /// Closed loop: a position of the rod, m.
    Position(f32),
    /// Open loop: a duty, −1 to 1; beyond it counts as ±1.
    Duty(f32),
}

/// What the bench records of a period: everything but the duty as it was at its start.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sample {
    /// Position of the rod by the encoder's count, m.
    pub position: f32,
    /// Speed of the motor, rad/s.
    pub speed: f32,
    /// Current of the motor, A.
    pub current: f32,
    /// Duty over the period, −1 to 1.
    pub duty: f32,
}

/// The servo in motion.
///
/// ```
/// use model_core::plant::ema::{Command, Ema, Parameters};
/// let mut ema = Ema::build(&Parameters::ALI_2)?;
/// for _ in 0..250 {
///     ema.step(Command::Position(0.02))?;
/// }
/// // 4 s later the rod is there, within what friction holds against the controller.
/// assert!((ema.position() - 0.02).abs() < 1e-4);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Ema {
    controller: pid::Coefficients,
    drive: drive::Parameters,
    motor: motor::Parameters,
    encoder: encoder::Parameters,
    mechanism: Mechanism,
    steps: u16,
    /// m of the rod for 1 rad of the motor.
    travel: f32,
    memory: pid::State,
    limit: CurrentLimit,
    state: State,
}

impl Ema {
    /// A servo at rest at position 0.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn build(parameters: &Parameters) -> Result<Self, BuildError> {
        parameters.check()?;
        let Parameters {
            drive,
            motor,
            encoder,
            scheme,
            steps,
            ..
        } = *parameters;
        let step = drive.period / f32::from(steps);
        Ok(Self {
            controller: parameters.controller.build(drive.period)?,
            mechanism: Mechanism::build(scheme, &parameters.plant(), motor.peak_torque, step)?,
            travel: parameters.ball_screw.travel(parameters.gearbox),
            drive,
            motor,
            encoder,
            steps,
            memory: pid::State::default(),
            limit: CurrentLimit::OPEN,
            state: State::new(0.0, 0.0),
        })
    }

    /// Sets the friction levels: what a search changes that compares the servo in its loop with a log.
    /// Negative or non-finite levels count as zero, and the breakaway level is raised to the Coulomb level.
    pub fn set_friction(&mut self, friction: friction::Parameters) {
        self.mechanism.set_friction(friction);
    }

    /// Back to rest at position 0, with friction as it is.
    pub fn reset(&mut self) {
        self.memory = pid::State::default();
        self.limit = CurrentLimit::OPEN;
        self.state = State::new(0.0, 0.0);
    }

    /// One period of the drive.
    ///
    /// A position is a number of counts to the drive, and so is a duty. The controller rests while
    /// the loop is open.
    ///
    /// # Errors
    /// [`InputRefused`] for a command that is not finite, or so far off that the controller
    /// overflows; the state is unchanged.
    pub fn step(&mut self, command: Command) -> Result<Sample, InputRefused> {
        let count = self.travel * self.encoder.angle();
        let position = count * self.encoder.count(self.state.position.value());
        let mut memory = self.memory;
        let wanted = match command {
            Command::Position(set_point) => {
                let set_point = count * libm::roundf(set_point / count);
                self.controller
                    .step(&mut memory, set_point, position)
                    .map_err(|_| InputRefused)?
            }
            Command::Duty(duty) if duty.is_finite() => duty,
            Command::Duty(_) => return Err(InputRefused),
        };
        let sent = self.drive.counts(wanted) as f32 / f32::from(self.drive.full_command);
        let current = self.state.current;
        let mut limit = self.limit;
        let duty = sent * limit.follow(sent, current, self.drive.current_limit);
        let sample = Sample {
            position,
            speed: self.state.velocity.value(),
            current,
            duty,
        };
        let voltage = duty * self.drive.supply;
        let mut state = self.state;
        self.mechanism
            .advance(&mut state, &self.motor, voltage, self.steps)?;
        self.state = state;
        self.limit = limit;
        self.memory = memory;
        Ok(sample)
    }

    /// Where the rod is, m: between the encoder's counts too.
    pub fn position(&self) -> f32 {
        self.state.position.value() * self.travel
    }

    /// Motor and winding, on the motor's shaft.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The controller's terms of the last closed-loop period, in duty.
    pub fn terms(&self) -> pid::Terms {
        self.memory.terms()
    }
}

/// Why a servo cannot be built.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BuildError {
    /// A parameter of its motor, friction or scheme.
    Plant(ParameterError),
    /// Any other.
    Settings(InvalidParameter),
}

impl From<ParameterError> for BuildError {
    fn from(error: ParameterError) -> Self {
        Self::Plant(error)
    }
}

impl From<InvalidParameter> for BuildError {
    fn from(error: InvalidParameter) -> Self {
        Self::Settings(error)
    }
}

impl core::fmt::Display for BuildError {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Plant(error) => error.fmt(formatter),
            Self::Settings(error) => error.fmt(formatter),
        }
    }
}

impl core::error::Error for BuildError {}
