//! What a run consists of: an actuator, what is different about it, what it is asked to do, and what
//! is made of its log.

use model_core::numeric::invalid_parameter::InvalidParameter;
use model_core::plant::State;
use model_core::plant::actuator::Actuator;
use model_core::plant::parameters::{ParameterError, Parameters};

use super::control;
use super::emulate;
use super::machine::Machine;
use super::profile::{Command, Profile};
use super::timing::{CONTROL_PERIOD, PLANT_PERIOD};
use super::tracks::Tracks;

/// One experiment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Experiment {
    /// What it is called in the log.
    pub name: &'static str,
    /// The actuator as its drive believes it to be.
    pub machine: Machine,
    /// The actuator that is emulated. What differs from the machine's, nobody declares.
    pub actuator: Parameters,
    /// What it has that no number of its parameters says.
    pub peculiarity: Option<Peculiarity>,
    /// What becomes of its friction on the way.
    pub wear: Option<Wear>,
    /// What fails on the way.
    pub failure: Option<Failure>,
    /// The positions asked for, again and again.
    pub commands: &'static [Command],
    /// Control steps that are recorded.
    pub steps: u32,
    /// What is made of the log.
    pub evaluation: Evaluation,
}

/// What an actuator has that [`Parameters`] have not, and that the drive is not told about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Peculiarity {
    /// Lost motion of this full width between the drive and its position sensor, rad.
    Play(f32),
    /// Other friction along a part of the stroke.
    RoughSpot {
        /// Where it begins, rad.
        from: f32,
        /// Where it ends, rad.
        to: f32,
        /// By how much friction is more there, sliding and held alike, N·m.
        more: f32,
    },
}

/// A change of friction that the drive is not told about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wear {
    /// The first control step with the new friction.
    pub step: u32,
    /// Friction while sliding, N·m.
    pub coulomb: f32,
    /// Friction that holds at rest, N·m.
    pub breakaway: f32,
}

/// What fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Failure {
    /// From this control step on the position sensor reads what is not a number.
    PositionSensor(u32),
    /// For so many milliseconds from the first sample on nothing is taken out of the queue.
    Recording(u32),
}

/// What is made of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Evaluation {
    /// Nothing.
    None,
    /// The friction is estimated anew.
    Refit,
    /// What the actuator has and the machine lacks is looked for.
    Check,
}

/// Why an experiment cannot begin: a parameter, and what it has to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refused {
    /// The plant's.
    Plant(ParameterError),
    /// The controller's, or a command's.
    Control(InvalidParameter),
}

#[cfg(feature = "tasks")]
impl defmt::Format for Refused {
    fn format(&self, formatter: defmt::Formatter) {
        match self {
            Self::Plant(ParameterError {
                parameter,
                requirement,
            }) => defmt::write!(formatter, "{=str} must be {=str}", parameter, requirement),
            Self::Control(InvalidParameter { name, requirement }) => {
                defmt::write!(formatter, "{=str} {=str}", name, requirement);
            }
        }
    }
}

impl From<ParameterError> for Refused {
    fn from(error: ParameterError) -> Self {
        Self::Plant(error)
    }
}

impl From<InvalidParameter> for Refused {
    fn from(error: InvalidParameter) -> Self {
        Self::Control(error)
    }
}

impl Experiment {
    /// An actuator that is what its machine declares, that stays so, and of which nothing fails and nothing
    /// is asked: what an experiment begins with. `steps`: control steps that are recorded.
    pub const fn new(
        name: &'static str,
        machine: Machine,
        commands: &'static [Command],
        steps: u32,
    ) -> Self {
        Self {
            name,
            machine,
            actuator: machine.plant,
            peculiarity: None,
            wear: None,
            failure: None,
            commands,
            steps,
            evaluation: Evaluation::None,
        }
    }

    /// Works out what the two interrupts need.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn build(&self) -> Result<(emulate::Setup, control::Setup), Refused> {
        let plant = emulate::Setup {
            actuator: Actuator::build(&self.actuator, PLANT_PERIOD)?,
            start: State::new(self.machine.rest, 0.0),
            converters: self.machine.converters,
            tracks: Tracks::new(self.actuator.lower_stop, self.actuator.upper_stop),
            peculiarity: self.peculiarity,
            wear: self.wear,
            sensor_fails: match self.failure {
                Some(Failure::PositionSensor(step)) => Some(step),
                _ => None,
            },
        };
        let control = control::Setup {
            pid: self.machine.position_loop.build(CONTROL_PERIOD)?,
            profile: Profile::new(self.commands)?,
            converters: self.machine.converters,
            steps: self.steps,
        };
        Ok((plant, control))
    }
}
