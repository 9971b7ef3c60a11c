//! A model bound for one step period.

use super::held::{Acting, Held};
use super::model::Model;
use crate::effect::Middle;
use crate::plant::actuator::{Actuator, Load};
use crate::plant::modes::{Basis, Modes};
use crate::plant::parameters::{Drive, ParameterError};
use crate::plant::{InputRefused, State};
use core::borrow::Borrow;

/// Parts of a step in which a model with held effects is stepped. An effect that varies within a
/// step, as cogging at speed, is of second order in the part.
const PARTS_UNDER_HELD_EFFECTS: u32 = 2;

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

/// A model bound for one step period.
///
/// Time runs at the *reported* position: with a late sensor the simulated state is that of a while
/// ago, and so are the inputs that drive it; the current, measured without delay, is ahead.
///
/// It owns its modes and what it holds over a step, or shares them with others.
#[derive(Debug, Clone)]
pub struct Simulator<M = Modes, H = Held> {
    actuator: Actuator<M>,
    /// Modes of the part of a step in which the input before is still acting; the actuator's are
    /// then those of the other part.
    earlier: Option<M>,
    held: H,
    period: f32,
    parts: u32,
    torque_per_current: f32,
    drive: Drive,
    gain: f32,
    input: Lateness,
    current: Lateness,
}

impl<M: Borrow<Modes>, H: Acting> Simulator<M, H> {
    /// Binds a model for steps of `period` seconds. `modes` gives the modes of a basis, `share` what
    /// it makes of the laws and the map.
    ///
    /// # Errors
    /// A parameter outside its range; whatever `modes` and `share` return.
    pub fn new(
        model: &Model,
        period: f32,
        modes: impl Fn(&Basis) -> Result<M, ParameterError>,
        share: impl FnOnce(Held) -> Result<H, ParameterError>,
    ) -> Result<Self, ParameterError> {
        let (plant, delays) = model.bound();
        plant.check()?;
        let held = share(model.held()?)?;
        let parts = if held.is_nothing() {
            1
        } else {
            PARTS_UNDER_HELD_EFFECTS
        };
        let input = Lateness::new(delays.input + delays.sensor, period);
        let modes_over = |share: f32| modes(&Basis::new(&plant, share * period / parts as f32));
        let earlier = if input.share == 0.0 {
            None
        } else {
            Some(modes_over(input.share)?)
        };
        Ok(Self {
            actuator: Actuator::with_modes(&plant, modes_over(1.0 - input.share)?)?,
            earlier,
            held,
            period,
            parts,
            torque_per_current: plant.torque_per_current(),
            drive: plant.drive,
            gain: plant.gain,
            input,
            current: Lateness::new(delays.sensor, period),
        })
    }

    /// How late an input drives the reported position.
    pub fn input_lateness(&self) -> Lateness {
        self.input
    }

    /// How late the position is reported beside the current.
    pub fn sensor_lateness(&self) -> Lateness {
        self.current
    }

    /// One step from sample `index`, with the input that acts in its end and the one before it, which
    /// acts in its beginning where a delay ends inside the step. Gives the current in the step at
    /// the moment to which the measured one belongs.
    ///
    /// # Errors
    /// [`InputRefused`].
    #[inline]
    pub fn step(
        &self,
        state: &mut State,
        (previous, input): (f32, f32),
        index: usize,
    ) -> Result<f32, InputRefused> {
        let before = state.current;
        let time = index as f32 * self.period;
        let Some(earlier) = &self.earlier else {
            self.advance(&self.actuator, state, input, time)?;
            return Ok(before + self.current.share * (state.current - before));
        };
        let first = self.actuator.on(earlier.borrow());
        self.advance(&first, state, previous, time)?;
        let between = state.current;
        self.advance(&self.actuator, state, input, time)?;
        // With a late sensor alone the measurement belongs to the moment of the change.
        let (split, moment) = (self.input.share, self.current.share);
        Ok(if moment <= split {
            before + moment / split * (between - before)
        } else {
            between + (moment - split) / (1.0 - split) * (state.current - between)
        })
    }

    #[inline]
    fn advance(
        &self,
        actuator: &Actuator<impl Borrow<Modes>>,
        state: &mut State,
        input: f32,
        time: f32,
    ) -> Result<(), InputRefused> {
        if self.held.is_nothing() {
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
        actuator: &Actuator<impl Borrow<Modes>>,
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
        let mut load = self.actuator.load();
        self.held.hold(&middle, &mut load);
        load
    }

    /// Current of a winding at its steady value: what a replay starts from where none was measured.
    pub fn steady_current(&self, velocity: f32, input: f32) -> f32 {
        self.drive.steady_current(self.gain, velocity, input)
    }
}
