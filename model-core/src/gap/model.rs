//! The declared actuator with its effects.

use super::current_sensor::{CurrentSensor, Reading};
use super::held::Held;
use super::simulator::Simulator;
use crate::effect::gravity::Gravity;
use crate::effect::learned_map::LearnedMap;
use crate::effect::{Active, Chain, Effect, Id, Law};
use crate::plant::Directional;
use crate::plant::modes::Modes;
use crate::plant::parameters::{Drive, ParameterError, Parameters};
use crate::unit::Dimension;
use heapless::Vec;

/// Most effects that a model holds.
pub const MOST_EFFECTS: usize = 8;

/// A number of the declared actuator or of its log that a fit may move, by the name that it has in a machine file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Base {
    /// Winding resistance.
    Resistance,
    /// Winding inductance.
    Inductance,
    /// Torque and back-EMF constant.
    TorqueConstant,
    /// Inertia of rotor and load.
    Inertia,
    /// Viscous friction, both directions.
    Viscous,
    /// Stiffness of the return spring.
    Spring,
    /// Where the return spring is at rest.
    SpringRest,
    /// Torque step at the spring's rest.
    SpringPreload,
    /// Torque of an unbalanced load at a right angle to hanging.
    GravityTorque,
    /// Where the load hangs.
    GravityRest,
    /// Lower end stop.
    LowerStop,
    /// Upper end stop.
    UpperStop,
    /// Coulomb friction, both directions.
    Coulomb,
    /// Breakaway level, both directions.
    Static,
    /// How much earlier an input acted than the log has it: no machine file names it.
    InputLead,
}

/// Some of them, each once.
pub type Numbers = Vec<Base, { Base::ALL.len() }>;

impl Base {
    /// Those of which no effect says the same: where the residual asks for another value, the machine
    /// file is wrong.
    pub const WITHOUT_EFFECT: [Self; 6] = [
        Self::Resistance,
        Self::TorqueConstant,
        Self::Inertia,
        Self::Viscous,
        Self::Coulomb,
        Self::Static,
    ];

    /// All of them: those that a machine file may name in `[fit]`, and the last one.
    pub const ALL: [Self; 15] = [
        Self::Resistance,
        Self::Inductance,
        Self::TorqueConstant,
        Self::Inertia,
        Self::Viscous,
        Self::Spring,
        Self::SpringRest,
        Self::SpringPreload,
        Self::GravityTorque,
        Self::GravityRest,
        Self::LowerStop,
        Self::UpperStop,
        Self::Coulomb,
        Self::Static,
        Self::InputLead,
    ];

    /// Its name in a machine file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Resistance => "resistance",
            Self::Inductance => "inductance",
            Self::TorqueConstant => "torque_constant",
            Self::Inertia => "inertia",
            Self::Viscous => "viscous",
            Self::Spring => "spring",
            Self::SpringRest => "spring_rest",
            Self::SpringPreload => "spring_preload",
            Self::GravityTorque => "gravity_torque",
            Self::GravityRest => "gravity_rest",
            Self::LowerStop => "lower_stop",
            Self::UpperStop => "upper_stop",
            Self::Coulomb => "coulomb",
            Self::Static => "static",
            Self::InputLead => "input_lead",
        }
    }

    /// What it measures.
    pub fn dimension(self) -> Dimension {
        match self {
            Self::Resistance => Dimension::Resistance,
            Self::Inductance => Dimension::Inductance,
            Self::TorqueConstant => Dimension::TorquePerCurrent,
            Self::Inertia => Dimension::Inertia,
            Self::Viscous => Dimension::TorquePerVelocity,
            Self::Spring => Dimension::TorquePerPosition,
            Self::SpringRest | Self::GravityRest | Self::LowerStop | Self::UpperStop => {
                Dimension::Position
            }
            Self::SpringPreload | Self::GravityTorque | Self::Coulomb | Self::Static => {
                Dimension::Torque
            }
            Self::InputLead => Dimension::Time,
        }
    }

    /// Whether only a machine with a winding has it.
    pub fn is_of_motor(self) -> bool {
        matches!(
            self,
            Self::Resistance | Self::Inductance | Self::TorqueConstant
        )
    }

    /// Whether it may be negative.
    pub fn is_signed(self) -> bool {
        self.dimension() == Dimension::Position || self == Self::GravityTorque
    }

    /// Whether it must be above zero.
    pub fn is_positive(self) -> bool {
        matches!(
            self,
            Self::Resistance | Self::TorqueConstant | Self::Inertia
        )
    }
}

/// A declared actuator and the effects that it has.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Model {
    /// The actuator without effects.
    pub plant: Parameters,
    /// Torque of an unbalanced load at a right angle to hanging, N·m.
    pub gravity_torque: f32,
    /// Where the load hangs, rad.
    pub gravity_rest: f32,
    /// How its current is measured.
    #[cfg_attr(feature = "serde", serde(default))]
    pub current_sensor: CurrentSensor,
    /// How much earlier each input acted than the log has it, s.
    #[cfg_attr(feature = "serde", serde(default))]
    pub input_lead: f32,
    /// Its effects.
    pub effects: Vec<Active, MOST_EFFECTS>,
    /// What was learned where no effect explains the residual.
    pub map: Option<LearnedMap>,
}

impl Model {
    /// An actuator on which no load hangs, without effects.
    ///
    /// ```
    /// use model_core::gap::model::Model;
    /// use model_core::plant::parameters::Parameters;
    /// let model = Model::new(Parameters::free(1e-4));
    /// assert!(model.effects.is_empty() && model.map.is_none());
    /// ```
    pub fn new(plant: Parameters) -> Self {
        Self {
            plant,
            gravity_torque: 0.0,
            gravity_rest: 0.0,
            current_sensor: CurrentSensor::default(),
            input_lead: 0.0,
            effects: Vec::new(),
            map: None,
        }
    }

    /// The model with these numbers of its current's sensor, and the others as in another model. What the sensor is
    /// late by less, a late drive is late by more: the current is late by the sum, and between two samples no fit
    /// carries one over to the other.
    pub fn with_readings(&self, own: &[Reading], other: &Self) -> Self {
        let mut model = self.clone();
        for reading in Reading::ALL {
            if !own.contains(&reading) {
                let value = other.current_sensor.get(reading);
                model.current_sensor.set(reading, value);
            }
        }
        let less = self.current_sensor.lag - model.current_sensor.lag;
        let mut effects = model.effects.iter_mut();
        if let Some(late) = effects.find(|effect| effect.id == Id::InputDelay) {
            late.values[0] += less;
        }
        model
    }

    /// The value of a base parameter. The forward one where the directions differ.
    pub fn get(&self, parameter: Base) -> f32 {
        let winding = match self.plant.drive {
            Drive::Voltage {
                resistance,
                inductance,
                torque_constant,
            } => (resistance, inductance, torque_constant),
            Drive::Torque => (0.0, 0.0, 0.0),
        };
        match parameter {
            Base::Resistance => winding.0,
            Base::Inductance => winding.1,
            Base::TorqueConstant => winding.2,
            Base::Inertia => self.plant.inertia,
            Base::Viscous => self.plant.viscous.forward,
            Base::Spring => self.plant.spring,
            Base::SpringRest => self.plant.spring_rest,
            Base::SpringPreload => self.plant.spring_preload,
            Base::GravityTorque => self.gravity_torque,
            Base::GravityRest => self.gravity_rest,
            Base::LowerStop => self.plant.lower_stop,
            Base::UpperStop => self.plant.upper_stop,
            Base::Coulomb => self.plant.coulomb.forward,
            // Below the Coulomb level it means nothing: the plant raises it, and a fit must see what
            // the plant has, or it finds no slope there.
            Base::Static => {
                let (breakaway, coulomb) = (self.plant.breakaway, self.plant.coulomb);
                breakaway.forward.max(coulomb.forward)
            }
            Base::InputLead => self.input_lead,
        }
    }

    /// Sets a base parameter, in both directions where there are two.
    pub fn set(&mut self, parameter: Base, value: f32) {
        if let Drive::Voltage {
            resistance,
            inductance,
            torque_constant,
        } = &mut self.plant.drive
        {
            match parameter {
                Base::Resistance => *resistance = value,
                Base::Inductance => *inductance = value,
                Base::TorqueConstant => *torque_constant = value,
                _ => {}
            }
        }
        match parameter {
            Base::Resistance | Base::Inductance | Base::TorqueConstant => {}
            Base::Inertia => self.plant.inertia = value,
            Base::Viscous => self.plant.viscous = Directional::both(value),
            Base::Spring => self.plant.spring = value,
            Base::SpringRest => self.plant.spring_rest = value,
            Base::SpringPreload => self.plant.spring_preload = value,
            Base::GravityTorque => self.gravity_torque = value,
            Base::GravityRest => self.gravity_rest = value,
            Base::LowerStop => self.plant.lower_stop = value,
            Base::UpperStop => self.plant.upper_stop = value,
            Base::Coulomb => self.plant.coulomb = Directional::both(value),
            Base::Static => self.plant.breakaway = Directional::both(value),
            Base::InputLead => self.input_lead = value,
        }
    }

    /// Whether the effect is part of it.
    pub fn has(&self, id: Id) -> bool {
        self.effects.iter().any(|effect| effect.id == id)
    }

    /// The plant with the affine effects in it, and what lies before and behind it.
    pub(super) fn bound(&self) -> (Parameters, Chain) {
        let mut plant = self.plant;
        let mut chain = Chain::default();
        for effect in &self.effects {
            effect.law().bind(&mut plant, &mut chain);
        }
        (plant, chain)
    }

    /// The plant with the affine effects in it.
    pub fn bound_plant(&self) -> Parameters {
        self.bound().0
    }

    /// What is held over a step.
    ///
    /// # Errors
    /// More laws than there is room for.
    pub(super) fn held(&self) -> Result<Held, ParameterError> {
        let gravity = (self.gravity_torque != 0.0).then(|| {
            let values = Gravity::values(self.gravity_torque, self.gravity_rest);
            Law::Gravity(Gravity::new(values))
        });
        let effects = self.effects.iter().map(Active::law).filter(Law::is_held);
        Held::new(gravity.into_iter().chain(effects), self.map)
    }

    /// Binds everything for steps of `period` seconds.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn build(&self, period: f32) -> Result<Simulator, ParameterError> {
        Simulator::new(self, period, Modes::build, Ok)
    }
}
