//! Motor and load as one inertia, with friction and end stops (bench paper, section 3.5).
//!
//! Inertia and viscous friction of the slow shaft count at the motor's divided by the square of the
//! ratio. At an end stop the velocity is reset, and a net torque into the stop does nothing.
//!
//! Beyond the paper, friction that grows with the transmitted torque, off by default:
//!
//! ```text
//! F = F_tare + (1 + c) F_brake + μ |T_motor|
//! ```
//!
//! The effect `load_dependent_friction` is the last term: the motor's torque stands for the
//! transmitted one. Of a bench whose brake is measured the torque that gearbox and chain pass on is
//! known, and c is what they lose of it. Where all of the motor's torque is passed on, 1 + c is
//! 1/(1 − μ).

use crate::plant::actuator::Actuator;
use crate::plant::borello::Borello;
use crate::plant::ema::friction::{Parameters as Friction, by_euler};
use crate::plant::parameters::{ParameterError, Parameters as Plant};
use crate::plant::{Directional, InputRefused, State};

/// How motion and friction are stepped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    /// Euler steps with a zero crossing, the paper's: [`crate::plant::borello`].
    Borello,
    /// Exact steps with events: [`crate::plant::actuator`].
    Exact,
}

/// What moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// Of the rotor and the gearbox's input, kg·m², > 0.
    pub motor_inertia: f32,
    /// Of what turns with the slow shaft, referred to it, kg·m², ≥ 0.
    pub load_inertia: f32,
    /// Viscous friction at the motor's shaft, N·m·s/rad, ≥ 0.
    pub motor_viscous: f32,
    /// Viscous friction of the slow shaft, N·m·s/rad, ≥ 0.
    pub load_viscous: f32,
    /// Dry friction of the bench without its brake, at the motor's shaft.
    pub tare: Friction,
    /// c: friction of gearbox and chain for 1 N·m that they pass on to the brake, ≥ 0; 0 for none.
    pub transmission_loss: f32,
    /// μ: share of the motor's torque that friction takes, ≥ 0; 0 for none.
    pub load_share: f32,
    /// Lower end of travel, rad of the slow shaft, below the upper one.
    pub lower_stop: f32,
    /// Upper end of travel, rad of the slow shaft.
    pub upper_stop: f32,
    /// How it is stepped.
    pub scheme: Scheme,
}

impl Parameters {
    /// The one inertia at the motor's shaft, behind so many turns for one of the slow shaft.
    pub fn plant(&self, ratio: f32) -> Plant {
        let square = ratio * ratio;
        Plant {
            viscous: Directional::both(self.motor_viscous + self.load_viscous / square),
            coulomb: Directional::both(self.tare.coulomb),
            breakaway: Directional::both(self.tare.breakaway),
            lower_stop: self.lower_stop * ratio,
            upper_stop: self.upper_stop * ratio,
            ..Plant::free(self.motor_inertia + self.load_inertia / square)
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "there is no allocation")]
enum Mechanism {
    Borello(Borello),
    Exact(Actuator),
}

/// Motor and load in motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Mechanics {
    mechanism: Mechanism,
    tare: Friction,
    /// With what the transmission loses.
    brake: f32,
    transmission_loss: f32,
    load_share: f32,
    state: State,
}

impl Mechanics {
    /// At rest at zero, with the brake off, for steps of `period` seconds.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn build(parameters: &Parameters, ratio: f32, period: f32) -> Result<Self, ParameterError> {
        let shares = [
            ("transmission_loss", parameters.transmission_loss),
            ("load_share", parameters.load_share),
        ];
        for (parameter, share) in shares {
            if !(share >= 0.0 && share.is_finite()) {
                return Err(ParameterError {
                    parameter,
                    requirement: "at least 0 and finite",
                });
            }
        }
        let plant = parameters.plant(ratio);
        let mechanism = match parameters.scheme {
            Scheme::Borello => Mechanism::Borello(Borello::build(&plant, period)?),
            Scheme::Exact => Mechanism::Exact(Actuator::build(&plant, period)?),
        };
        Ok(Self {
            mechanism,
            tare: parameters.tare,
            brake: 0.0,
            transmission_loss: parameters.transmission_loss,
            load_share: parameters.load_share,
            state: State::default(),
        })
    }

    /// Sets the brake's friction at the motor's shaft, N·m, on top of the tare. What is negative or
    /// not finite counts as zero.
    pub fn set_brake(&mut self, friction: f32) {
        let friction = if friction.is_finite() {
            friction.max(0.0)
        } else {
            0.0
        };
        self.brake = friction * (1.0 + self.transmission_loss);
        self.set_levels(0.0);
    }

    #[inline]
    fn set_levels(&mut self, transmitted: f32) {
        let added = self.brake + self.load_share * transmitted.abs();
        let coulomb = self.tare.coulomb + added;
        let breakaway = self.tare.breakaway + added;
        match &mut self.mechanism {
            Mechanism::Borello(scheme) => scheme.set_friction(coulomb, breakaway),
            Mechanism::Exact(actuator) => actuator.set_friction(coulomb, breakaway),
        }
    }

    /// One step under the motor's torque and what the slow shaft gives back, both N·m at the
    /// motor's shaft.
    ///
    /// # Errors
    /// [`InputRefused`] for a torque beyond what a step takes.
    #[inline]
    pub fn step(&mut self, motor: f32, load: f32) -> Result<(), InputRefused> {
        if self.load_share > 0.0 {
            self.set_levels(motor);
        }
        let torque = motor - load;
        match &self.mechanism {
            Mechanism::Borello(scheme) => by_euler(scheme, &mut self.state, torque, 1),
            Mechanism::Exact(actuator) => actuator.step(&mut self.state, torque),
        }
    }

    /// Position, rad, and velocity, rad/s, of the motor.
    #[inline]
    pub fn state(&self) -> &State {
        &self.state
    }
}
