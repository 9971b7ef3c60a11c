//! A model bound for one step period.

use super::current_sensor::CurrentSensor;
use super::held::{Acting, Held};
use super::lateness::Lateness;
use super::log::Channel;
use super::model::Model;
use crate::effect::backlash::follow;
use crate::effect::compliance::{Reaction, Rigid, Shaft, Twist};
use crate::effect::encoder_eccentricity::EncoderEccentricity;
use crate::effect::hysteresis::deflected;
use crate::effect::presliding::{Bristles, Free};
use crate::effect::thermal_drift::ThermalDrift;
use crate::effect::{Memory, Middle};
use crate::plant::actuator::{Actuator, External, Load, Unheld};
use crate::plant::modes::{Basis, Deviation, Modes};
use crate::plant::parameters::{Drive, ParameterError, Winding};
use crate::plant::{Compensated, InputRefused, Motion, State};
use core::borrow::Borrow;

pub(super) mod lockstep;

/// Parts of a step in which a model with held effects is stepped. An effect that varies within a
/// step, as cogging at speed, is of second order in the part.
const PARTS_UNDER_HELD_EFFECTS: u8 = 2;

/// Where a model is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Course {
    /// Its actuator.
    pub state: State,
    /// What its effects remember.
    pub memory: Memory,
}

impl Course {
    /// At a state that is reported as it is.
    pub fn new(state: State) -> Self {
        let far = state.position.value();
        Self {
            state,
            memory: Memory {
                far,
                ..Memory::default()
            },
        }
    }

    /// The same with the warmth and the deflection of another memory: what the log led to, not the state.
    pub fn with_history(state: State, memory: &Memory) -> Self {
        let mut course = Self::new(state);
        course.memory.warmth = memory.warmth;
        course.memory.deflection = memory.deflection;
        course
    }
}

/// What a log says of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Given {
    /// Input that acts in its end.
    pub input: f32,
    /// Input before that one, which acts in the step's beginning where a delay ends inside it.
    pub previous: f32,
    /// What acts from outside.
    pub external: External,
    /// Sample from which it starts.
    pub index: usize,
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
    winding: Winding,
    parts: u8,
    /// Whether something adds to the winding's voltage.
    electric: bool,
    gain: f32,
    input: Lateness,
    current: Lateness,
    /// How the current is measured.
    sensor: CurrentSensor,
    /// Half the width of the play before the sensor; negative without one.
    half_play: f32,
    /// What friction yields by, where a model says so.
    bristles: Option<Bristles>,
    /// The elastic shaft before the sensor; without trailing there is none.
    shaft: Shaft,
    /// How the sensor errs.
    reading: EncoderEccentricity,
    /// Whether the winding's resistance is one that heats.
    heats: bool,
    /// Way over which the deflection of a hysteresis follows the motion, where there is one.
    reach: Option<f32>,
    /// Periods in which the winding's current comes to a share of 1 − 1/e of its steady value.
    electric_periods: f32,
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
        let (plant, chain) = model.bound();
        plant.check()?;
        let held = share(model.held()?)?;
        let shaft = chain.shaft;
        shaft.check(&plant)?;
        let rigid = chain.bristles.is_none_or(|it| it.compliance == 0.0) && shaft.trailing == 0.0;
        let parts = if held.is_nothing() && rigid {
            1
        } else {
            PARTS_UNDER_HELD_EFFECTS
        };
        let winding = plant.drive.winding();
        let electric = winding.is_there() && held.is_electric();
        let delay = chain.input_delay + chain.sensor_delay;
        let input = Lateness::new(delay - model.input_lead, period);
        let modes_over = |share: f32| modes(&Basis::new(&plant, share * period / f32::from(parts)));
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
            winding,
            parts,
            electric,
            gain: plant.gain,
            input,
            current: Lateness::new(chain.sensor_delay - model.current_sensor.lag, period),
            sensor: model.current_sensor,
            half_play: chain.play.map_or(-1.0, |width| 0.5 * width),
            bristles: chain.bristles,
            shaft,
            reading: chain.reading,
            heats: winding.is_there() && chain.heats,
            reach: chain.reach,
            electric_periods: match plant.drive {
                Drive::Voltage {
                    resistance,
                    inductance,
                    ..
                } => inductance / resistance / period,
                Drive::Torque => 0.0,
            },
        })
    }

    /// How late an input drives the reported position: its share of a step is driven by the input before.
    pub fn input_lateness(&self) -> Lateness {
        self.input
    }

    /// Whether an effect remembers the last clear motion, which no measured state restores.
    pub fn is_stateful(&self) -> bool {
        self.half_play().is_some() || self.bristles.is_some()
    }

    /// Whether what it remembers is the same as in another simulator, and so are run-ins to that but for
    /// the rest of the machine.
    pub fn runs_in_like(&self, other: &Self) -> bool {
        self.half_play == other.half_play
            && self.bristles == other.bristles
            && self.shaft == other.shaft
    }

    /// Moves the drive of a measured state to where it is while it moves that way, for the measurement
    /// is of the far side, and bends the bristles as sliding does.
    pub fn lean(&self, course: &mut Course, motion: Motion) {
        let lead = match motion {
            Motion::Forward => self.half_play().unwrap_or(0.0),
            Motion::Backward => -self.half_play().unwrap_or(0.0),
            Motion::Rest => 0.0,
        };
        let near = course.memory.far + lead;
        course.state.position = Compensated::new(near - course.memory.twist.angle);
        let levels = self.actuator.load().coulomb;
        course.memory.friction = match motion {
            Motion::Forward => levels.forward,
            Motion::Backward => -levels.backward,
            Motion::Rest => 0.0,
        };
    }

    /// Bends the bristles by a measured displacement.
    pub fn drag(&self, course: &mut Course, displacement: f32) {
        if let Some(bristles) = self.yielding() {
            let levels = self.actuator.load().coulomb;
            let friction = &mut course.memory.friction;
            *friction = bristles.after(*friction, displacement, levels.of(displacement));
        }
    }

    /// Puts the drive where a simulation that has run up to here has it, within the play around the
    /// measured far side, and bends the bristles as there. `moved`: how much further the drive is than
    /// that simulation has it.
    pub fn resume(&self, course: &mut Course, run_in: &Course, moved: f32) {
        let near = behind_shaft(run_in) + moved;
        let within = follow(near, course.memory.far, self.half_play().unwrap_or(0.0));
        course.state.position = Compensated::new(within - course.memory.twist.angle);
        course.memory.friction = run_in.memory.friction;
    }

    /// Half the width of the play before the sensor, where there is one.
    #[inline]
    fn half_play(&self) -> Option<f32> {
        (self.half_play >= 0.0).then_some(self.half_play)
    }

    /// The elastic shaft before the sensor, where there is one: no measured state restores its twist.
    #[inline]
    pub fn shaft(&self) -> Option<&Shaft> {
        (self.shaft.trailing > 0.0).then_some(&self.shaft)
    }

    /// Puts drive and far side of a state of their centre of mass where a twisted shaft has them.
    /// `own_velocity`: the velocity is the drive's already.
    pub fn twist(&self, course: &mut Course, shaft: &Shaft, twist: Twist, own_velocity: bool) {
        let Course { state, memory } = course;
        let centre = state.position.value();
        memory.twist = twist;
        memory.far = centre + shaft.ahead() * twist.angle;
        state.position = Compensated::new(centre - shaft.share * twist.angle);
        if state.motion != Motion::Rest && !own_velocity {
            let velocity = state.velocity.value() - shaft.share * twist.rate;
            state.velocity = Compensated::new(velocity);
            state.motion = Motion::of(velocity);
        }
    }

    /// Distance of the reported position from `measured`.
    #[inline]
    pub fn reported_from(&self, course: &Course, measured: f32) -> f32 {
        let distance = match self.half_play() {
            Some(_) => course.memory.far - measured,
            None => course.state.position.from(measured) + course.memory.twist.angle,
        };
        if self.reading.is_nothing() {
            distance
        } else {
            distance + self.reading.error(self.sensed(course))
        }
    }

    /// The position that the sensor sits at.
    #[inline]
    fn sensed(&self, course: &Course) -> f32 {
        match self.half_play() {
            Some(_) => course.memory.far,
            None => behind_shaft(course),
        }
    }

    /// The reported position.
    pub fn reported(&self, course: &Course) -> f32 {
        let sensed = self.sensed(course);
        sensed + self.reading.error(sensed)
    }

    /// The position that the sensor sits at when it reports this one.
    pub fn position_behind(&self, reported: f32) -> f32 {
        if self.reading.is_nothing() {
            reported
        } else {
            self.reading.position_behind(reported)
        }
    }

    /// The state that the sensor sits at when it reports this one. `own_velocity`: the velocity is that
    /// of a sensor of its own.
    pub fn state_behind(&self, reported: State, own_velocity: bool) -> State {
        if self.reading.is_nothing() {
            return reported;
        }
        let position = self.position_behind(reported.position.value());
        let velocity = reported.velocity.value();
        let gain = if own_velocity {
            1.0
        } else {
            self.reading.gain(position)
        };
        State::new(position, velocity / gain)
    }

    /// Way over which the deflection of a hysteresis follows the motion, where there is one.
    pub fn reach(&self) -> Option<f32> {
        self.reach
    }

    /// How the winding heats, if it does.
    pub fn heating(&self) -> Option<ThermalDrift> {
        if self.heats {
            self.held.heating()
        } else {
            None
        }
    }

    /// Which reading of the current belongs to a step, and to which part of it: the position may be reported late beside it.
    pub fn current_lateness(&self) -> Lateness {
        self.current
    }

    /// How the current is measured.
    #[inline]
    pub fn current_sensor(&self) -> &CurrentSensor {
        &self.sensor
    }

    /// The current that a log has of the step from this sample.
    pub fn read(&self, current: Channel, sample: usize) -> f32 {
        self.sensor.current(self.current.read(current, sample))
    }

    /// Periods in which the winding's current comes to a share of 1 − 1/e of its steady value; 0 without a
    /// winding.
    #[inline]
    pub fn electric_periods(&self) -> f32 {
        self.electric_periods
    }

    /// One step under what the log says of it. Gives the current in the step at the moment to which
    /// the measured one belongs.
    ///
    /// # Errors
    /// [`InputRefused`].
    #[inline]
    pub fn step(&self, course: &mut Course, given: &Given) -> Result<f32, InputRefused> {
        let current = self.step_actuator(course, given)?;
        if let Some(heating) = self.heating() {
            let warmth = &mut course.memory.warmth;
            *warmth = heating.after(*warmth, course.state.current, self.period);
        }
        if let Some(half_play) = self.half_play() {
            let near = behind_shaft(course);
            course.memory.far = follow(course.memory.far, near, half_play);
        }
        Ok(current)
    }

    #[inline]
    fn step_actuator(&self, course: &mut Course, given: &Given) -> Result<f32, InputRefused> {
        let before = course.state.current;
        let (split, moment) = (self.input.share, self.current.share);
        let Some(earlier) = &self.earlier else {
            self.advance((&self.actuator, 1.0), course, given.input, given)?;
            return Ok(before + moment * (course.state.current - before));
        };
        let first = self.actuator.on(earlier.borrow());
        self.advance((&first, split), course, given.previous, given)?;
        let between = course.state.current;
        self.advance((&self.actuator, 1.0 - split), course, given.input, given)?;
        // With a late sensor alone the measurement belongs to the moment of the change.
        Ok(if moment <= split {
            before + moment / split * (between - before)
        } else {
            between + (moment - split) / (1.0 - split) * (course.state.current - between)
        })
    }

    /// What becomes of a deviation over a sample in which the motion does not change, by its plant alone.
    #[inline]
    pub fn carry(&self, deviation: &mut Deviation, motion: Motion) {
        let earlier = self.earlier.as_ref().map(Borrow::borrow);
        for modes in earlier.into_iter().chain([self.actuator.modes()]) {
            for _ in 0..self.parts {
                modes.carry(deviation, motion);
            }
        }
    }

    /// What friction yields by, unless it is rigid.
    #[inline]
    fn yielding(&self) -> Option<&Bristles> {
        let bristles = self.bristles.as_ref();
        bristles.filter(|bristles| bristles.compliance > 0.0)
    }

    /// Advances by the share of a period that the actuator's modes are worked out for. While the drive lets go, no current
    /// flows.
    #[inline]
    fn advance(
        &self,
        drive: (&Actuator<impl Borrow<Modes>>, f32),
        course: &mut Course,
        input: f32,
        given: &Given,
    ) -> Result<(), InputRefused> {
        if given.external.released {
            course.state.current = 0.0;
        }
        self.advance_parts(drive, course, input, given)?;
        if given.external.released {
            course.state.current = 0.0;
        }
        Ok(())
    }

    // Not inlined: eight copies of it are 16 KB of an image.
    fn advance_parts(
        &self,
        (actuator, share): (&Actuator<impl Borrow<Modes>>, f32),
        course: &mut Course,
        input: f32,
        given: &Given,
    ) -> Result<(), InputRefused> {
        let drive = (actuator, share * self.period / f32::from(self.parts));
        let (shaft, bristles) = (self.shaft(), self.yielding());
        if shaft.is_none() && bristles.is_none() && self.held.is_nothing() {
            let state = &mut course.state;
            if given.external == External::NONE {
                return actuator.step(state, input);
            }
            // Without held effects there is one part.
            let load = actuator.load().under(given.external);
            let fed = self.driven(drive, state, input, (&load, given.external));
            return actuator.step_under(state, fed, &load);
        }
        for _ in 0..self.parts {
            let before = course.state.position.value();
            if let Some(shaft) = shaft {
                self.advance_twisted(drive, shaft, course, input, given)?;
            } else if let Some(bristles) = bristles {
                self.advance_yielding(drive, bristles, course, input, given)?;
            } else {
                let Course { state, memory } = course;
                self.advance_held(drive, (state, memory), input, given)?;
            }
            if let Some(reach) = self.reach {
                let displacement = course.state.position.value() - before;
                let deflection = &mut course.memory.deflection;
                *deflection = deflected(*deflection, displacement, reach);
            }
        }
        Ok(())
    }

    /// One part of a step before an elastic shaft: the drive under its reaction, then the twist that the
    /// drive's motion leads to.
    fn advance_twisted(
        &self,
        (actuator, length): (&Actuator<impl Borrow<Modes>>, f32),
        shaft: &Shaft,
        course: &mut Course,
        input: f32,
        given: &Given,
    ) -> Result<(), InputRefused> {
        let before = *course;
        let drive = (actuator, length);
        match self.yielding() {
            Some(bristles) => self.advance_yielding(drive, bristles, course, input, given)?,
            None => {
                let Course { state, memory } = course;
                self.advance_held(drive, (state, memory), input, given)?;
            }
        }
        let origin = before.state.velocity.value();
        let gain = course.state.velocity.from(origin) - before.state.velocity.from(origin);
        let twist = shaft.after(before.memory.twist, gain, length);
        if !(twist.angle.is_finite() && twist.rate.is_finite()) {
            *course = before;
            return Err(InputRefused);
        }
        course.memory.twist = twist;
        Ok(())
    }

    /// One part of a step under held effects.
    fn advance_held(
        &self,
        drive: (&Actuator<impl Borrow<Modes>>, f32),
        (state, memory): (&mut State, &Memory),
        input: f32,
        given: &Given,
    ) -> Result<(), InputRefused> {
        let actuator = drive.0;
        let (fed, load) = if self.held.is_nothing() {
            let load = actuator.load().under(given.external);
            let fed = self.driven(drive, state, input, (&load, given.external));
            (fed, load)
        } else {
            self.held_over(drive, (state, memory), input, given)
        };
        let mut twisted = self.twisted(drive, (state, memory), fed, load);
        if self.shaft().is_some() && state.motion == Motion::Rest {
            // What lets go takes the far side with it from the step's beginning.
            actuator.wake(state, fed, &twisted);
            twisted = self.twisted(drive, (state, memory), fed, load);
        }
        actuator.step_under(state, fed, &twisted)
    }

    /// What is fed and what acts over a part of a step under held effects: in its middle, by a predictor
    /// to there.
    #[inline]
    fn held_over(
        &self,
        drive: (&Actuator<impl Borrow<Modes>>, f32),
        (state, memory): (&State, &Memory),
        input: f32,
        given: &Given,
    ) -> (f32, Load) {
        let actuator = drive.0;
        let mut start = self.start((state, memory), input, given);
        let load = self.load_at(&start, given.external);
        let fed = self.fed(drive, (state, input), (&load, given.external), &mut start);
        let load = self.twisted(drive, (state, memory), fed, load);
        let way = actuator.middle(state, fed, &load);
        let mut middle = self.behind(&start, way);
        let load = self.load_at(&middle, given.external);
        let fed = self.fed(drive, (state, input), (&load, given.external), &mut middle);
        (fed, load)
    }

    /// The load with the shaft's reaction to it, where there is a shaft.
    #[inline]
    fn twisted(
        &self,
        (actuator, length): (&Actuator<impl Borrow<Modes>>, f32),
        (state, memory): (&State, &Memory),
        input: f32,
        mut load: Load,
    ) -> Load {
        if let Some(shaft) = self.shaft() {
            let unheld = actuator.unheld(state, input, &load);
            let friction = match state.motion {
                Motion::Forward => load.coulomb.forward,
                Motion::Backward => -load.coulomb.backward,
                Motion::Rest => 0.0,
            };
            let reaction = reaction(shaft, memory, (state, &unheld), (friction, length));
            load.torque += reaction.torque;
        }
        load
    }

    /// The same where friction yields before it slides: its force is a torque then, and nothing is held
    /// at rest.
    fn advance_yielding(
        &self,
        (actuator, length): (&Actuator<impl Borrow<Modes>>, f32),
        bristles: &Bristles,
        course: &mut Course,
        input: f32,
        given: &Given,
    ) -> Result<(), InputRefused> {
        let Course { state, memory } = course;
        let drive = (actuator, length);
        let slides_on = |state: &mut State, fed: f32, load: &Load| {
            let load = self.twisted(drive, (state, memory), fed, *load);
            slide_on((actuator, bristles), (state, memory.friction), fed, &load)
        };
        let alone = self.held.is_nothing();
        if alone {
            let load = actuator.load().under(given.external);
            let fed = self.driven(drive, state, input, (&load, given.external));
            if slides_on(state, fed, &load) {
                return Ok(());
            }
        }
        let mut start = self.start((state, memory), input, given);
        let load = self
            .load_at(&start, given.external)
            .against(memory.friction);
        let fed = self.fed(drive, (state, input), (&load, given.external), &mut start);
        let load = self.twisted(drive, (state, memory), fed, load);
        actuator.wake(state, fed, &load);
        let mut middle = self.behind(&start, actuator.middle(state, fed, &load));
        let mut load = self.load_at(&middle, given.external);
        let against = load.against(memory.friction);
        let outside = (&against, given.external);
        let fed = self.fed(drive, (state, input), outside, &mut middle);
        if !alone && slides_on(state, fed, &load) {
            return Ok(());
        }
        let levels = bristles.levels(&load, middle.velocity);
        let mut unheld = actuator.unheld(state, fed, &load);
        let reaction = self.shaft().map_or(NO_REACTION, |shaft| {
            reaction(shaft, memory, (state, &unheld), (0.0, length))
        });
        let free = Free {
            travel: unheld.travel() + reaction.torque * unheld.give(),
            give: unheld.give() + reaction.share * unheld.give(),
            length,
        };
        let friction = bristles.held(memory.friction, &free, &levels);
        if self.shaft().is_some() {
            let torque = reaction.torque - reaction.share * friction;
            load.torque += torque;
            unheld = unheld.under(torque);
        }
        let moved = actuator.step_unheld((state, &unheld), fed, &load, friction)?;
        memory.friction = bristles.after(memory.friction, moved, levels.of(moved));
        Ok(())
    }

    /// The actuator in the beginning of a step.
    #[inline]
    fn start(&self, (state, memory): (&State, &Memory), input: f32, given: &Given) -> Middle {
        Middle {
            motor_torque: self.winding.torque(state.current),
            torque_constant: self.winding.torque_constant,
            resistance: self.winding.resistance,
            warmth: memory.warmth,
            voltage: self.gain * input,
            excess: 0.0,
            velocity: state.velocity.value(),
            position: state.position.value(),
            deflection: memory.deflection,
            time: given.index as f32 * self.period,
            step: self.period,
        }
    }

    /// The actuator in the middle of a step, with the way to there.
    #[inline]
    fn behind(&self, start: &Middle, (current, velocity, travel): (f32, f32, f32)) -> Middle {
        Middle {
            motor_torque: self.winding.torque(current),
            velocity,
            position: start.position + travel,
            deflection: self.reach.map_or(start.deflection, |reach| {
                deflected(start.deflection, travel, reach)
            }),
            ..*start
        }
    }

    /// The input, or where the drive lets go of the motor what leaves the rotor to itself.
    #[inline]
    fn driven(
        &self,
        (actuator, length): (&Actuator<impl Borrow<Modes>>, f32),
        state: &State,
        input: f32,
        (load, external): (&Load, External),
    ) -> f32 {
        if !external.released {
            input
        } else if self.winding.is_there() {
            let inductance = self.electric_periods * self.period * self.winding.resistance;
            actuator.input_of_no_mean_current(state, load, (inductance, self.gain, length))
        } else {
            0.0
        }
    }

    /// What is driven, with what effects add to the input's voltage. Leaves in `middle` the voltage beyond that which
    /// would end the current with the step.
    #[inline]
    fn fed(
        &self,
        drive: (&Actuator<impl Borrow<Modes>>, f32),
        (state, input): (&State, f32),
        outside: (&Load, External),
        middle: &mut Middle,
    ) -> f32 {
        let driven = self.driven(drive, state, input, outside);
        middle.excess = 0.0;
        if outside.1.released || !self.electric {
            return driven;
        }
        let ends = drive.0.input_that_ends_current(state, outside.0);
        middle.excess = self.gain * input - self.gain * ends;
        input + self.held.voltage(middle) / self.gain
    }

    /// Voltage that effects add to the input's.
    pub fn voltage_at(&self, middle: &Middle) -> f32 {
        if self.electric {
            self.held.voltage(middle)
        } else {
            0.0
        }
    }

    /// What acts next to the motor, with what acts from outside.
    pub fn load_at(&self, middle: &Middle, external: External) -> Load {
        let mut load = self.actuator.load();
        self.held.hold(middle, &mut load);
        // The brake is not the machine's: what scales its friction leaves the brake's.
        load.under(external)
    }

    /// Current of a cold winding at its steady value: what a replay starts from where none was measured.
    pub fn steady_current(&self, velocity: f32, input: f32) -> f32 {
        let winding = self.winding;
        let voltage = self.gain * input;
        let current = winding.steady_current(voltage, velocity);
        if !winding.is_there() {
            return current;
        }
        let Winding {
            resistance,
            torque_constant,
        } = winding;
        let middle = Middle {
            motor_torque: winding.torque(current),
            torque_constant,
            resistance,
            warmth: 0.0,
            voltage,
            excess: resistance * current,
            velocity,
            position: 0.0,
            deflection: 0.0,
            time: 0.0,
            step: self.period,
        };
        current + self.voltage_at(&middle) / resistance
    }
}

/// Without a shaft.
const NO_REACTION: Reaction = Reaction {
    torque: 0.0,
    share: 0.0,
};

/// What a shaft adds to the drive's load over a step under this friction, positive against forward
/// motion.
#[inline]
fn reaction(
    shaft: &Shaft,
    memory: &Memory,
    (state, unheld): (&State, &Unheld),
    (friction, length): (f32, f32),
) -> Reaction {
    let rigid = if state.motion == Motion::Rest {
        Rigid {
            gain: 0.0,
            give: 0.0,
            length,
        }
    } else {
        Rigid {
            gain: unheld.gain(friction),
            give: unheld.quickening(),
            length,
        }
    };
    shaft.reaction(memory.twist, &rigid)
}

/// The position behind the shaft, where there is one.
#[inline]
fn behind_shaft(course: &Course) -> f32 {
    course.state.position.value() + course.memory.twist.angle
}

/// One step of bristles with this force that slide all through it: as rigid friction, without a search
/// for what they hold. Whether they do; else the state is unchanged.
#[inline]
fn slide_on(
    (actuator, bristles): (&Actuator<impl Borrow<Modes>>, &Bristles),
    (state, force): (&mut State, f32),
    input: f32,
    load: &Load,
) -> bool {
    let slide = |state: &State| bristles.slide(force, load.coulomb, state.velocity.value());
    let mut end = *state;
    let slides = slide(state) && actuator.step_on(&mut end, input, load) && slide(&end);
    if slides {
        *state = end;
    }
    slides
}
