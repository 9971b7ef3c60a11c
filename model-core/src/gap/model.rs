//! The declared actuator with its effects.

use super::log::Channel;
use crate::effect::gravity::Gravity;
use crate::effect::learned_map::LearnedMap;
use crate::effect::{Active, Delays, Effect, Id, Law, Middle};
use crate::plant::actuator::{Actuator, Load};
use crate::plant::modes::{Basis, Modes};
use crate::plant::parameters::{Drive, ParameterError, Parameters};
use crate::plant::{Directional, InputRefused, State};
use crate::unit::Dimension;
use core::borrow::Borrow;
use heapless::Vec;

/// Most effects that a model holds.
pub const MOST_EFFECTS: usize = 8;

/// Parts of a step in which a model with held effects is stepped. An effect that varies within a
/// step, as cogging at speed, is of second order in the part.
const PARTS_UNDER_HELD_EFFECTS: u32 = 2;

/// A parameter of the declared actuator, by the name that it has in a machine file.
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
}

impl Base {
    /// Every parameter that a machine file may name in `[fit]`.
    pub const ALL: [Self; 14] = [
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
        }
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
pub struct Model {
    /// The actuator without effects.
    pub plant: Parameters,
    /// Torque of an unbalanced load at a right angle to hanging, N·m.
    pub gravity_torque: f32,
    /// Where the load hangs, rad.
    pub gravity_rest: f32,
    /// Its effects.
    pub effects: Vec<Active, MOST_EFFECTS>,
    /// What was learned where no effect explains the residual.
    pub map: Option<LearnedMap>,
}

impl Model {
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
        }
    }

    /// Whether the effect is part of it.
    pub fn has(&self, id: Id) -> bool {
        self.effects.iter().any(|effect| effect.id == id)
    }

    /// The plant with the affine effects in it, and the delays.
    fn bound(&self) -> (Parameters, Delays) {
        let mut plant = self.plant;
        let mut delays = Delays::default();
        for effect in &self.effects {
            effect.law().bind(&mut plant, &mut delays);
        }
        (plant, delays)
    }

    /// The plant with the affine effects in it.
    pub fn bound_plant(&self) -> Parameters {
        self.bound().0
    }

    /// The laws that are held over a step.
    fn held(&self) -> Result<Vec<Law, MOST_EFFECTS>, ParameterError> {
        let gravity = (self.gravity_torque != 0.0).then(|| {
            let values = Gravity::values(self.gravity_torque, self.gravity_rest);
            Law::Gravity(Gravity::new(values))
        });
        let effects = self.effects.iter().map(Active::law).filter(Law::is_held);
        let mut held = Vec::new();
        for law in gravity.into_iter().chain(effects) {
            held.push(law).map_err(|_| ParameterError {
                parameter: "effects",
                requirement: "at most 8 in one model",
            })?;
        }
        Ok(held)
    }

    /// Binds everything for steps of `period` seconds.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn build(&self, period: f32) -> Result<Simulator, ParameterError> {
        self.build_with(period, Modes::build)
    }

    /// As [`Model::build`], with modes from elsewhere: `modes` gives those of a basis.
    ///
    /// # Errors
    /// A parameter outside its range; whatever `modes` returns.
    pub fn build_with<M: Borrow<Modes>>(
        &self,
        period: f32,
        modes: impl Fn(&Basis) -> Result<M, ParameterError>,
    ) -> Result<Simulator<M>, ParameterError> {
        let (plant, delays) = self.bound();
        plant.check()?;
        let held = self.held()?;
        let parts = if held.is_empty() && self.map.is_none() {
            1
        } else {
            PARTS_UNDER_HELD_EFFECTS
        };
        let built = |share: f32| {
            let basis = Basis::new(&plant, share * period / parts as f32);
            Actuator::with_modes(&plant, modes(&basis)?)
        };
        let input = Lateness::new(delays.input + delays.sensor, period);
        let stepping = if input.share == 0.0 {
            Stepping::Whole(built(1.0)?)
        } else {
            Stepping::Split {
                earlier: built(input.share)?,
                later: built(1.0 - input.share)?,
            }
        };
        Ok(Simulator {
            stepping,
            held,
            map: self.map,
            period,
            parts,
            torque_per_current: plant.torque_per_current(),
            drive: plant.drive,
            gain: plant.gain,
            input,
            current: Lateness::new(delays.sensor, period),
        })
    }
}

/// A delay in samples, whole and part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lateness {
    /// Whole samples.
    pub whole: usize,
    /// What is left, 0 to 1.
    pub share: f32,
}

/// Parts of a sample under which a delay counts as whole: a mode is not worked out for them.
const LEAST_SHARE: f32 = 1e-3;

impl Lateness {
    fn new(delay: f32, period: f32) -> Self {
        let samples = (delay / period).max(0.0);
        let whole = samples as usize;
        let share = samples - whole as f32;
        if share < LEAST_SHARE {
            Self { whole, share: 0.0 }
        } else if share > 1.0 - LEAST_SHARE {
            Self {
                whole: whole.saturating_add(1),
                share: 0.0,
            }
        } else {
            Self { whole, share }
        }
    }
}

/// How a step is taken: whole, or split where a late input changes inside it.
#[derive(Debug, Clone, PartialEq)]
// There is no allocator to box the larger variant with.
#[allow(clippy::large_enum_variant)]
enum Stepping<M> {
    Whole(Actuator<M>),
    Split {
        earlier: Actuator<M>,
        later: Actuator<M>,
    },
}

/// A model bound for one step period.
///
/// Time runs at the *reported* position: with a late sensor the simulated state is that of a while
/// ago, and so are the inputs that drive it; the current, measured without delay, is ahead.
///
/// It owns the modes of its actuator, or borrows them, as [`Actuator`] does.
#[derive(Debug, Clone)]
pub struct Simulator<M = Modes> {
    stepping: Stepping<M>,
    held: Vec<Law, MOST_EFFECTS>,
    map: Option<LearnedMap>,
    period: f32,
    parts: u32,
    torque_per_current: f32,
    drive: Drive,
    gain: f32,
    input: Lateness,
    current: Lateness,
}

impl<M: Borrow<Modes>> Simulator<M> {
    /// How late an input drives the reported position.
    pub fn input_lateness(&self) -> Lateness {
        self.input
    }

    /// How late the position is reported beside the current.
    pub fn sensor_lateness(&self) -> Lateness {
        self.current
    }

    /// One step from sample `index`, with the inputs that act over it; before the log its first
    /// input does. Gives the current in the step at the moment to which the measured one belongs.
    ///
    /// # Errors
    /// [`InputRefused`].
    #[inline]
    pub fn step(
        &self,
        state: &mut State,
        input: &Channel,
        index: usize,
    ) -> Result<f32, InputRefused> {
        let before = state.current;
        let late = index.saturating_sub(self.input.whole);
        let time = index as f32 * self.period;
        match &self.stepping {
            Stepping::Whole(actuator) => {
                self.advance(actuator, state, input.at(late), time)?;
                Ok(before + self.current.share * (state.current - before))
            }
            Stepping::Split { earlier, later } => {
                self.advance(earlier, state, input.at(late.saturating_sub(1)), time)?;
                let between = state.current;
                self.advance(later, state, input.at(late), time)?;
                // With a late sensor alone the measurement belongs to the moment of the change.
                let (split, moment) = (self.input.share, self.current.share);
                Ok(if moment <= split {
                    before + moment / split * (between - before)
                } else {
                    between + (moment - split) / (1.0 - split) * (state.current - between)
                })
            }
        }
    }

    #[inline]
    fn advance(
        &self,
        actuator: &Actuator<M>,
        state: &mut State,
        input: f32,
        time: f32,
    ) -> Result<(), InputRefused> {
        if self.held.is_empty() && self.map.is_none() {
            return actuator.step(state, input);
        }
        for _ in 0..self.parts {
            self.advance_held(actuator, state, input, time)?;
        }
        Ok(())
    }

    /// One part of a step under held effects: a predictor to its middle, then the part itself.
    fn advance_held(
        &self,
        actuator: &Actuator<M>,
        state: &mut State,
        input: f32,
        time: f32,
    ) -> Result<(), InputRefused> {
        let position = state.position.value();
        let start = self.load_at(state.current, state.velocity.value(), position, time);
        let (current, velocity, travel) = actuator.middle(state, input, &start);
        let middle = self.load_at(current, velocity, position + travel, time);
        actuator.step_under(state, input, &middle)
    }

    /// What acts on the mechanism next to the motor, at this current, velocity, position and time.
    pub fn load_at(&self, current: f32, velocity: f32, position: f32, time: f32) -> Load {
        let middle = Middle {
            motor_torque: self.torque_per_current * current,
            velocity,
            position,
            time,
        };
        let (Stepping::Whole(actuator)
        | Stepping::Split {
            later: actuator, ..
        }) = &self.stepping;
        let mut load = actuator.load();
        for law in &self.held {
            law.hold(&middle, &mut load);
        }
        if let Some(map) = &self.map {
            map.hold(&middle, &mut load);
        }
        load
    }

    /// Current of a winding at its steady value: what a replay starts from where none was measured.
    pub fn steady_current(&self, velocity: f32, input: f32) -> f32 {
        match self.drive {
            Drive::Voltage {
                resistance,
                torque_constant,
                ..
            } => (self.gain * input - torque_constant * velocity) / resistance,
            Drive::Torque => self.gain * input,
        }
    }
}
