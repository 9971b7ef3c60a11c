//! The bench paper's test bench: a synchronous motor, its inverter and control, a gearbox, an
//! encoder behind gears with backlash, and a brake.
//!
//! One block a file, in the order in which a command passes them:
//!
//! * [`control`]: position and speed control, with the three anti-windups;
//! * [`resolver`], [`park`]: angles and frames;
//! * [`hysteresis`], [`three_phase_bridge`]: the inverter;
//! * [`back_emf`], [`windings`], [`torque`]: the motor;
//! * [`mechanics`]: the one inertia, its friction and its stops; [`brake`]: what the brake adds;
//! * [`encoder`], with [`backlash`] or [`tooth_contact`]: the measured position;
//! * [`acquisition`]: the measured current;
//! * [`datasheet`], [`commissioning`]: what the paper prints, and what it does not.
//!
//! Inverter and windings come in two fidelities behind the same mechanics and control
//! ([`electrics`]): [`switching`], the paper's, in steps of 1 µs for the host, and [`averaged`], in
//! steps of 25 µs for the chip. Positions of the bench are those of the slow shaft, velocities and
//! torques those of the motor, currents rms (see [`torque`]).

use super::ema::{encoder as counter, friction, gearbox};
use super::parameters::ParameterError;
use super::{InputRefused, State};
use crate::control::pid;
use crate::numeric::invalid_parameter::{InvalidParameter, require};
use acquisition::LowPass;
use averaged::Averaged;
use control::{Control, Hold, Memory};
use core::f32::consts::TAU;
use electrics::{Drive, Electrics, Rotor};
use encoder::{Encoder, Meshing};
use mechanics::{Mechanics, Scheme};
use resolver::Resolver;
use switching::Switching;

pub mod acquisition;
pub mod averaged;
pub mod back_emf;
pub mod backlash;
pub mod brake;
pub mod commissioning;
pub mod control;
pub mod datasheet;
pub mod electrics;
pub mod encoder;
pub mod hysteresis;
pub mod mechanics;
pub mod park;
pub mod resolver;
pub mod switching;
pub mod three_phase_bridge;
pub mod tooth_contact;
pub mod torque;
pub mod windings;

/// What the bench is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// Control electronics.
    pub control: control::Parameters,
    /// Inverter and motor.
    pub electrics: electrics::Parameters,
    /// What moves.
    pub mechanics: mechanics::Parameters,
    /// Between the motor's shaft and the slow one.
    pub gearbox: gearbox::Parameters,
    /// The measured position.
    pub encoder: encoder::Parameters,
    /// Cut-off of the measured current's filter, Hz, > 0.
    pub current_cut_off: f32,
    /// Steps of everything but the control in a period of it, at least 1.
    pub steps: u16,
}

impl Parameters {
    /// The paper's bench, by the averaged electrics: five exact steps of 25 µs a period.
    ///
    /// From the datasheets of Tables 2.1 to 2.8 and our [`commissioning`] values, without backlash
    /// and with the brake off.
    pub const AVERAGED: Self = Self {
        control: control::Parameters {
            period: commissioning::CONTROL_PERIOD,
            position_gain: commissioning::POSITION_GAIN,
            speed_limit: commissioning::SPEED_LIMIT,
            speed_gain: commissioning::SPEED_GAIN,
            integral_time: commissioning::INTEGRAL_TIME,
            derivative_time: commissioning::DERIVATIVE_TIME,
            derivative_filter: commissioning::DERIVATIVE_FILTER,
            tracking_time: commissioning::TRACKING_TIME,
            hold: Hold::Never,
            torque_constant: datasheet::motor::TORQUE_CONSTANT,
            current_limit: datasheet::motor::MAXIMUM_CURRENT,
        },
        electrics: electrics::Parameters {
            windings: windings::Parameters {
                pole_pairs: datasheet::motor::POLE_PAIRS,
                resistance: datasheet::motor::RESISTANCE,
                inductance: datasheet::motor::INDUCTANCE,
            },
            back_emf: back_emf::Parameters::SOUND,
            torque: torque::Parameters {
                torque_constant: datasheet::motor::TORQUE_CONSTANT,
                saturation: 0.0,
            },
            inverter: three_phase_bridge::Parameters {
                bus_voltage: commissioning::BUS_VOLTAGE,
                band: 0.1,
            },
        },
        mechanics: mechanics::Parameters {
            motor_inertia: datasheet::motor::INERTIA + datasheet::gearbox::INERTIA,
            load_inertia: datasheet::encoder::INERTIA
                * datasheet::encoder::GEAR_RATIO
                * datasheet::encoder::GEAR_RATIO,
            motor_viscous: commissioning::VISCOUS,
            load_viscous: 0.0,
            tare: friction::Parameters {
                coulomb: commissioning::TARE_COULOMB,
                breakaway: commissioning::TARE_BREAKAWAY,
            },
            transmission_loss: 0.0,
            load_share: 0.0,
            lower_stop: -commissioning::END_STOP,
            upper_stop: commissioning::END_STOP,
            scheme: Scheme::Exact,
        },
        gearbox: gearbox::Parameters {
            ratio: datasheet::gearbox::RATIO,
        },
        encoder: encoder::Parameters {
            counter: counter::Parameters {
                counts_per_turn: datasheet::encoder::COUNTS_PER_TURN,
            },
            gears: gearbox::Parameters {
                ratio: datasheet::encoder::GEAR_RATIO,
            },
            backlash: 0.0,
            meshing: Meshing::Rigid,
        },
        current_cut_off: commissioning::CURRENT_CUT_OFF,
        steps: 5,
    };

    /// The paper's bench, by the switching electrics: Borello's friction in Euler steps of 1 µs.
    pub const SWITCHING: Self = Self {
        mechanics: mechanics::Parameters {
            scheme: Scheme::Borello,
            ..Self::AVERAGED.mechanics
        },
        steps: 125,
        ..Self::AVERAGED
    };

    /// The same with elastic teeth in place of the rigid play, whose inertia is the encoder's and
    /// no longer part of the motor's, and whose drag is what starts the encoder (Table 2.6).
    pub fn with_elastic_teeth(self, stiffness: f32, damping: f32) -> Self {
        let referred = self.encoder.gears.ratio * self.encoder.gears.ratio;
        Self {
            mechanics: mechanics::Parameters {
                load_inertia: 0.0,
                ..self.mechanics
            },
            encoder: encoder::Parameters {
                meshing: Meshing::Elastic(tooth_contact::Parameters {
                    stiffness,
                    damping,
                    inertia: datasheet::encoder::INERTIA * referred,
                    drag: datasheet::encoder::STARTING_TORQUE * self.encoder.gears.ratio,
                }),
                ..self.encoder
            },
            ..self
        }
    }
}

/// What the bench records of a period: everything but the reference as it was at its start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Of the slow shaft by the encoder's counter, rad.
    pub position: f32,
    /// Of the slow shaft by the motor, rad.
    pub motor_position: f32,
    /// Of the motor, rad/s.
    pub velocity: f32,
    /// Quadrature current, filtered, A rms.
    pub quadrature_current: f32,
    /// Reference of the quadrature current over the period, A rms.
    pub reference_current: f32,
}

/// The bench in motion.
///
/// ```
/// use model_core::plant::bench::{AveragedBench, Parameters};
/// let mut bench = AveragedBench::build(&Parameters::AVERAGED)?;
/// for _ in 0..8000 {
///     bench.step(0.1)?;
/// }
/// // 1 s later the encoder is there, within two of its counts.
/// assert!((bench.encoder().position() - 0.1).abs() < 1e-4);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Bench<E> {
    control: Control,
    memory: Memory,
    electrics: E,
    mechanics: Mechanics,
    encoder: Encoder,
    filter: LowPass,
    resolver: Resolver,
    /// Turns of the slow shaft for one of the motor.
    reduction: f32,
    steps: u16,
    drive: Drive,
    /// Torque that the encoder takes, at the motor's shaft, N·m.
    load: f32,
    steps_done: u64,
}

/// The bench by the switching electrics.
pub type SwitchingBench = Bench<Switching>;

/// The bench by the averaged electrics.
pub type AveragedBench = Bench<Averaged>;

impl<E: Electrics> Bench<E> {
    /// A bench at rest at 0, in the middle of its backlash, with the brake off.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn build(parameters: &Parameters) -> Result<Self, BuildError> {
        require(parameters.steps > 0, "steps", "must be at least 1")?;
        parameters.gearbox.check()?;
        let ratio = parameters.gearbox.ratio;
        let control = parameters.control.build(ratio)?;
        let period = parameters.control.period / f32::from(parameters.steps);
        Ok(Self {
            control,
            memory: Memory::default(),
            electrics: E::build(&parameters.electrics, period)?,
            mechanics: Mechanics::build(&parameters.mechanics, ratio, period)?,
            encoder: Encoder::build(&parameters.encoder, period)?,
            filter: LowPass::build(parameters.current_cut_off, period)?,
            resolver: Resolver::new(parameters.electrics.windings.pole_pairs),
            reduction: 1.0 / ratio,
            steps: parameters.steps,
            drive: Drive::default(),
            load: 0.0,
            steps_done: 0,
        })
    }

    /// Sets the brake's friction at the motor's shaft, N·m: what [`brake::friction`] gives.
    pub fn set_brake(&mut self, friction: f32) {
        self.mechanics.set_brake(friction);
    }

    /// One period of the control, for a position of the slow shaft, rad.
    ///
    /// # Errors
    /// [`InputRefused`] for a command that is not finite; the bench is unchanged.
    pub fn step(&mut self, command: f32) -> Result<Sample, InputRefused> {
        let position = self.encoder.position();
        let state = self.mechanics.state();
        let velocity = state.velocity.value();
        let motor_position = state.position.value() * self.reduction;
        let reference_current = self
            .control
            .step(&mut self.memory, command, position, velocity)?;
        let sample = Sample {
            position,
            motor_position,
            velocity,
            quadrature_current: self.filter.output(),
            reference_current,
        };
        for _ in 0..self.steps {
            self.advance(reference_current)?;
        }
        Ok(sample)
    }

    /// One step of everything but the control, towards a quadrature current, A rms.
    ///
    /// # Errors
    /// [`InputRefused`] for a current beyond what a step takes.
    #[inline]
    pub fn advance(&mut self, reference: f32) -> Result<(), InputRefused> {
        let state = self.mechanics.state();
        let angle = state.position.value();
        self.drive = self.electrics.step(
            reference,
            &Rotor {
                electrical: self.resolver.electrical(angle),
                mechanical: angle * (1.0 / TAU),
                velocity: state.velocity.value(),
            },
        );
        self.mechanics.step(self.drive.torque, self.load)?;
        let state = self.mechanics.state();
        let taken = self.encoder.step(
            state.position.value() * self.reduction,
            state.velocity.value() * self.reduction,
        );
        self.load = taken * self.reduction;
        self.filter.step(self.drive.quadrature);
        self.steps_done += 1;
        Ok(())
    }

    /// The motor: position, rad, and velocity, rad/s.
    pub fn motor(&self) -> &State {
        self.mechanics.state()
    }

    /// The encoder.
    pub fn encoder(&self) -> &Encoder {
        &self.encoder
    }

    /// Inverter and windings.
    pub fn electrics(&self) -> &E {
        &self.electrics
    }

    /// Torque and currents of the last step.
    pub fn drive(&self) -> Drive {
        self.drive
    }

    /// The speed controller's terms of the last period, N·m.
    pub fn terms(&self) -> pid::Terms {
        self.memory.terms()
    }

    /// Steps so far: what the computing costs.
    pub fn steps_done(&self) -> u64 {
        self.steps_done
    }
}

/// Why a bench cannot be built.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BuildError {
    /// A parameter of its mechanics.
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
