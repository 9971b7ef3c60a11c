//! The actuator's step: exact in a mode, split at events.

use super::modes::{Basis, Increment, Modes, RestIncrement};
use super::parameters::{Drive, ParameterError, Parameters};
use super::{Compensated, Directional, InputRefused, Motion, State};
use core::borrow::Borrow;

mod events;
pub(crate) mod lanes;

/// Largest magnitude of the input that a step takes, in units of the input. Beyond it, as with
/// NaN or infinity, the step refuses and leaves the state as it was.
pub const INPUT_LIMIT: f32 = 1e6;

/// Torques and friction levels held over a step, next to the input.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Load {
    /// Torque or force on the mechanism, positive towards larger positions.
    pub torque: f32,
    /// Friction while sliding.
    pub coulomb: Directional,
    /// Friction that holds at rest.
    pub breakaway: Directional,
}

/// What acts on the machine from outside, as a log has it: N·m or N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct External {
    /// Friction that a brake adds, sliding and at rest, ≥ 0.
    pub brake: f32,
    /// Torque or force against positive motion.
    pub load: f32,
    /// Whether the drive lets go of the motor: no current flows, whatever the input says.
    pub released: bool,
}

impl External {
    /// Nothing.
    pub const NONE: Self = Self {
        brake: 0.0,
        load: 0.0,
        released: false,
    };
}

impl Load {
    /// What the parameters declare, the breakaway level raised to the Coulomb level.
    pub fn declared(parameters: &Parameters) -> Self {
        let Parameters {
            coulomb, breakaway, ..
        } = *parameters;
        Self {
            torque: parameters.offset,
            coulomb,
            breakaway: Directional {
                forward: breakaway.forward.max(coulomb.forward),
                backward: breakaway.backward.max(coulomb.backward),
            },
        }
    }

    /// With what acts from outside.
    #[inline]
    pub fn under(self, external: External) -> Self {
        let raised = |level: Directional| Directional {
            forward: level.forward + external.brake,
            backward: level.backward + external.brake,
        };
        Self {
            torque: self.torque - external.load,
            coulomb: raised(self.coulomb),
            breakaway: raised(self.breakaway),
        }
    }

    /// With this much of friction as a torque instead of levels, positive against forward motion.
    #[inline]
    pub fn against(self, friction: f32) -> Self {
        Self {
            torque: self.torque - friction,
            coulomb: Directional::both(0.0),
            breakaway: Directional::both(0.0),
        }
    }

    /// Sets the friction levels of both directions. Negative or non-finite levels count as zero, and
    /// the breakaway level is raised to the Coulomb level.
    pub fn set_friction(&mut self, coulomb: f32, breakaway: f32) {
        let level = |value: f32| {
            if value.is_finite() {
                value.max(0.0)
            } else {
                0.0
            }
        };
        self.coulomb = Directional::both(level(coulomb));
        self.breakaway = Directional::both(level(breakaway).max(level(coulomb)));
    }
}

/// An actuator with everything that does not depend on its state worked out for one step period.
///
/// It owns its modes, or borrows them (`M` is `&Modes`) where several actuators have the same: they
/// are most of its size and of the work of building it.
///
/// ```
/// use model_core::plant::{State, Directional, actuator::Actuator, parameters::{Drive, Parameters}};
/// let parameters = Parameters {
///     drive: Drive::Voltage { resistance: 1.0, inductance: 1e-3, torque_constant: 0.06 },
///     viscous: Directional::both(2e-4),
///     coulomb: Directional::both(0.12),
///     breakaway: Directional::both(0.15),
///     ..Parameters::free(1.2e-4)
/// };
/// let actuator = Actuator::build(&parameters, 1e-4)?;
/// let mut state = State::new(0.0, 0.0);
/// for _ in 0..20_000 {
///     actuator.step(&mut state, 12.0)?;
/// }
/// // Closed form of the final speed: (k u / R − coulomb) / (B + k² / R).
/// assert!((state.velocity.value() - 157.894_74).abs() < 1e-4);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Actuator<M = Modes> {
    modes: M,
    load: Load,
    torque_per_current: f32,
    /// Current per velocity and per input, where the winding has no inductance.
    algebraic: Option<(f32, f32)>,
    spring: f32,
    spring_rest: f32,
    spring_preload: f32,
    /// Whether there is a spring, with or without stiffness.
    sprung: bool,
    lower_stop: f32,
    upper_stop: f32,
}

/// What a whole step is made of in the mode that a state is in: what [`super::batch`] keeps of it.
pub(super) struct Mode<'a> {
    /// While it slides.
    pub sliding: Option<Sliding<'a>>,
    /// At rest.
    pub rest: RestIncrement,
    pub torque_per_current: f32,
    pub load: f32,
    pub spring_rest: f32,
    pub preload: f32,
    /// Lower and upper.
    pub stops: (f32, f32),
    /// Torque of the spring without its preload.
    pub spring: f32,
    /// Preload against a start forwards and backwards; infinite where a stop holds.
    pub held: (f32, f32),
    pub breakaway: Directional,
}

/// What a step that slides is made of.
pub(super) struct Sliding<'a> {
    pub increment: &'a Increment,
    /// Constant torque but for the preload.
    pub torque: f32,
}

/// What a rung or a part of one adds to the state while the mode lasts.
#[derive(Clone, Copy)]
struct Change {
    current: f32,
    velocity: f32,
    position: f32,
}

/// What a step without friction comes to.
#[derive(Clone, Copy)]
pub struct Unheld {
    change: Change,
    /// What a torque held over the step adds to that.
    give: Change,
}

impl Unheld {
    /// Its displacement, rad or m.
    pub fn travel(&self) -> f32 {
        self.change.position
    }

    /// What a torque held over it adds to that, rad/(N·m) or m/N.
    pub fn give(&self) -> f32 {
        self.give.position
    }

    /// By how much the velocity changes under this friction, positive against forward motion.
    pub fn gain(&self, friction: f32) -> f32 {
        self.against(friction).velocity
    }

    /// What a torque held over it adds to that, for each N·m or N.
    pub fn quickening(&self) -> f32 {
        self.give.velocity
    }

    /// The same under another torque besides.
    pub fn under(&self, torque: f32) -> Self {
        Self {
            change: self.against(-torque),
            give: self.give,
        }
    }

    fn against(&self, friction: f32) -> Change {
        Change {
            current: self.change.current - friction * self.give.current,
            velocity: self.change.velocity - friction * self.give.velocity,
            position: self.change.position - friction * self.give.position,
        }
    }
}

/// What holds an actuator at rest, and what is on it besides its motor.
struct Hold {
    torque_per_current: f32,
    torque: f32,
    /// Of the spring, without its preload.
    spring: f32,
    /// The preload against a start forwards, and backwards; infinite where a stop holds.
    up: f32,
    down: f32,
    breakaway: Directional,
}

impl Hold {
    /// Drive beyond what holds: (forward, backward), positive where friction gives way.
    #[inline(always)]
    fn excess(&self, current: f32) -> (f32, f32) {
        let drive = self.torque_per_current * current + self.torque - self.spring;
        (
            drive - self.up - self.breakaway.forward,
            -drive - self.down - self.breakaway.backward,
        )
    }

    /// The breakaway test: which way the actuator starts.
    #[inline(always)]
    fn released(&self, current: f32) -> Motion {
        let (forward, backward) = self.excess(current);
        if forward > 0.0 {
            Motion::Forward
        } else if backward > 0.0 {
            Motion::Backward
        } else {
            Motion::Rest
        }
    }
}

impl Actuator {
    /// Works out the modes for a step of `period` seconds.
    ///
    /// # Errors
    /// A parameter outside its range, a period that is not above 0 and at most 10 s, or parameters
    /// so far apart that `f32` does not hold the step.
    pub fn build(parameters: &Parameters, period: f32) -> Result<Self, ParameterError> {
        parameters.check()?;
        let modes = Modes::build(&Basis::new(parameters, period))?;
        Self::with_modes(parameters, modes)
    }
}

impl<M: Borrow<Modes>> Actuator<M> {
    /// Takes modes that are worked out: those of the [`Basis`] of these parameters.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn with_modes(parameters: &Parameters, modes: M) -> Result<Self, ParameterError> {
        parameters.check()?;
        let algebraic = match parameters.drive {
            Drive::Voltage {
                resistance,
                inductance: 0.0,
                torque_constant,
            } => Some((torque_constant / resistance, parameters.gain / resistance)),
            Drive::Voltage { .. } => None,
            Drive::Torque => Some((0.0, parameters.gain)),
        };
        Ok(Self {
            modes,
            load: Load::declared(parameters),
            torque_per_current: parameters.torque_per_current(),
            algebraic,
            spring: parameters.spring,
            spring_rest: parameters.spring_rest,
            spring_preload: parameters.spring_preload,
            sprung: parameters.spring > 0.0 || parameters.spring_preload > 0.0,
            lower_stop: parameters.lower_stop,
            upper_stop: parameters.upper_stop,
        })
    }

    /// The same actuator with other modes: those of another period.
    #[inline]
    pub fn on<N>(&self, modes: N) -> Actuator<N> {
        Actuator {
            modes,
            load: self.load,
            torque_per_current: self.torque_per_current,
            algebraic: self.algebraic,
            spring: self.spring,
            spring_rest: self.spring_rest,
            spring_preload: self.spring_preload,
            sprung: self.sprung,
            lower_stop: self.lower_stop,
            upper_stop: self.upper_stop,
        }
    }

    /// Its modes.
    #[inline]
    pub(crate) fn modes(&self) -> &Modes {
        self.modes.borrow()
    }

    /// Whether there is a spring, with or without stiffness.
    pub(super) fn is_sprung(&self) -> bool {
        self.sprung
    }

    /// The mode that a state is in.
    pub(super) fn mode(&self, state: &State) -> Mode<'_> {
        let (modes, load) = (self.modes.borrow(), &self.load);
        let deflection = state.position.from(self.spring_rest);
        let (up, down) = self.preloads(deflection);
        let stopped = |stopped: bool, preload: f32| if stopped { f32::INFINITY } else { preload };
        let position = state.position.value();
        Mode {
            sliding: match state.motion {
                Motion::Rest => None,
                Motion::Forward => Some(Sliding {
                    increment: &modes.forward[0],
                    torque: load.torque - load.coulomb.forward,
                }),
                Motion::Backward => Some(Sliding {
                    increment: &modes.backward[0],
                    torque: load.torque + load.coulomb.backward,
                }),
            },
            rest: modes.rest[0],
            torque_per_current: self.torque_per_current,
            load: load.torque,
            spring_rest: self.spring_rest,
            preload: self.spring_preload,
            stops: (self.lower_stop, self.upper_stop),
            spring: self.spring * deflection,
            held: (
                stopped(position >= self.upper_stop, up),
                stopped(position <= self.lower_stop, down),
            ),
            breakaway: load.breakaway,
        }
    }

    /// The load that the parameters declare; effects start from it.
    pub fn load(&self) -> Load {
        self.load
    }

    /// Sets the friction levels without working the modes out again: the annealing loop changes
    /// nothing else. As [`Load::set_friction`].
    pub fn set_friction(&mut self, coulomb: f32, breakaway: f32) {
        self.load.set_friction(coulomb, breakaway);
    }

    /// One step with the input held over it.
    ///
    /// Exact while the mode lasts. An event is placed to third order within an eighth of the step;
    /// two of the same kind within a step, after which the mode looks as before, pass unseen. So the
    /// step must be below half the period of any swing, of the inertia on its spring,
    /// 2π √(J/K), as of it against the winding's back-EMF, 2π √(L J)/k. Where a time constant is
    /// far below an eighth of the step, an event may be that eighth late.
    ///
    /// On a Cortex-M4F a step without an event takes 79 instructions where there is no spring, call
    /// and return included, 37 at rest, and 100 with a spring (`cargo hil test` counts them). A
    /// straight line of loads, 12 products, four comparisons and stores has about 57 of the 79; the
    /// choice of the mode takes 7, the look at the input 5, and call and return 10.
    ///
    /// # Errors
    /// [`InputRefused`] for an input that is not finite or beyond [`INPUT_LIMIT`], and where the step
    /// would leave the range of `f32`; the state is unchanged.
    #[inline]
    pub fn step(&self, state: &mut State, input: f32) -> Result<(), InputRefused> {
        self.step_under(state, input, &self.load)
    }

    /// One step with the input and a load held over it.
    ///
    /// # Errors
    /// As [`Actuator::step`]; a load that is not finite refuses the step once it counts.
    // By itself the compiler calls it where there are several callers; a replay's loop, which keeps
    // the modes in registers, takes a fifth longer then.
    #[inline(always)]
    pub fn step_under(
        &self,
        state: &mut State,
        input: f32,
        load: &Load,
    ) -> Result<(), InputRefused> {
        let accepted = input.abs() <= INPUT_LIMIT;
        if !accepted {
            return Err(InputRefused);
        }
        let lasted = match (state.motion, self.sprung) {
            (Motion::Forward, false) => self.slide::<true, false>(state, input, load),
            (Motion::Backward, false) => self.slide::<false, false>(state, input, load),
            (Motion::Forward, true) => self.slide::<true, true>(state, input, load),
            (Motion::Backward, true) => self.slide::<false, true>(state, input, load),
            (Motion::Rest, _) => self.rest(state, input, load),
        };
        if lasted {
            Ok(())
        } else {
            self.step_through_events(state, input, load)
        }
    }

    /// Current and velocity in the middle of the step, and the travel to there, with the mode as
    /// it is: where effects that are not affine are evaluated.
    #[inline]
    pub fn middle(&self, state: &State, input: f32, load: &Load) -> (f32, f32, f32) {
        let change = self.change(state, 1, input, load);
        let current = state.current + change.current;
        let start = state.velocity.value();
        let end = start + change.velocity;
        if end * start < 0.0 {
            // It stands before the middle.
            return (current, 0.0, change.position * start / (start - end));
        }
        (current, end, change.position)
    }

    /// Starts from rest, unless a stop or the spring's preload holds under this load.
    pub fn wake(&self, state: &mut State, input: f32, load: &Load) {
        if state.motion == Motion::Rest {
            self.follow_input(state, input);
            state.motion = self.released(state.position, state.current, load);
        }
    }

    /// What a step without friction comes to, with the mode as it is.
    #[inline]
    pub fn unheld(&self, state: &State, input: f32, load: &Load) -> Unheld {
        let modes = self.modes.borrow();
        let ladder = match state.motion {
            Motion::Backward => &modes.backward,
            Motion::Forward | Motion::Rest => &modes.forward,
        };
        let by_torque = |row: &[f32; 5]| row[4];
        Unheld {
            change: self.change(state, 0, input, &load.against(0.0)),
            give: Change {
                current: by_torque(&ladder[0].current),
                velocity: by_torque(&ladder[0].velocity),
                position: by_torque(&ladder[0].position),
            },
        }
    }

    /// That step with this friction held over it, positive against forward motion, instead of the load's
    /// levels; gives the displacement. To turn is no event then: viscous friction that differs by
    /// direction goes on as it was until the step's end.
    ///
    /// # Errors
    /// As [`Actuator::step`].
    #[inline]
    pub fn step_unheld(
        &self,
        (state, unheld): (&mut State, &Unheld),
        input: f32,
        load: &Load,
        friction: f32,
    ) -> Result<f32, InputRefused> {
        let accepted = input.abs() <= INPUT_LIMIT;
        if accepted && state.motion != Motion::Rest {
            let change = unheld.against(friction);
            let end = state.position.after(change.position);
            let velocity = state.velocity.after(change.velocity);
            // As in a slide: zero, or no number.
            let spoilt = 0.0 * (state.current + change.current + velocity + end);
            let passes = self.sprung && {
                let deflection = state.position.from(self.spring_rest);
                let push = match state.motion {
                    Motion::Backward => self.push::<false>(deflection),
                    Motion::Forward | Motion::Rest => self.push::<true>(deflection),
                };
                (deflection + change.position) * push < 0.0
            };
            if end + spoilt <= self.upper_stop && end >= self.lower_stop && !passes {
                commit(state, &change);
                state.motion = Motion::of(state.velocity.value());
                return Ok(change.position);
            }
        }
        let origin = state.position.value();
        let before = state.position.from(origin);
        self.step_under(state, input, &load.against(friction))?;
        Ok(state.position.from(origin) - before)
    }

    /// One step in the mode as it is, unless an event ends that before the step does: the state is then
    /// unchanged. Whether it was taken.
    #[inline]
    pub fn step_on(&self, state: &mut State, input: f32, load: &Load) -> bool {
        input.abs() <= INPUT_LIMIT
            && match state.motion {
                Motion::Forward => self.slide::<true, true>(state, input, load),
                Motion::Backward => self.slide::<false, true>(state, input, load),
                Motion::Rest => self.rest(state, input, load),
            }
    }

    /// The input that brings the current to zero at the end of the step, with the mode as it is.
    pub fn input_that_ends_current(&self, state: &State, load: &Load) -> f32 {
        let unfed = state.current + self.change(state, 0, 0.0, load).current;
        let fed = state.current + self.change(state, 0, 1.0, load).current;
        unfed / (unfed - fed)
    }

    /// The input under which the winding's current has no mean over a step of `length` seconds, with the mode as it is.
    /// `inductance`, H; `gain`, V for one unit of input.
    ///
    /// Over a step u h = R ∫i dt + K Δx + L Δi, of which Δx and Δi are linear in u.
    pub fn input_of_no_mean_current(
        &self,
        state: &State,
        load: &Load,
        (inductance, gain, length): (f32, f32, f32),
    ) -> f32 {
        let back = |input: f32| {
            let change = self.change(state, 0, input, load);
            self.torque_per_current * change.position + inductance * change.current
        };
        let unfed = back(0.0);
        unfed / (gain * length - (back(1.0) - unfed))
    }

    /// What a rung adds to the state, without minding events.
    fn change(&self, state: &State, rung: usize, input: f32, load: &Load) -> Change {
        match state.motion {
            Motion::Forward => self.slid::<true, true>(state, rung, input, load),
            Motion::Backward => self.slid::<false, true>(state, rung, input, load),
            Motion::Rest => Change {
                // The winding alone moves.
                current: self.rested(state, rung, input),
                velocity: 0.0,
                position: 0.0,
            },
        }
    }

    /// What a rung adds to the state that slides one way.
    ///
    /// Direction and spring are known to the compiler, so that each of the four ways is a straight
    /// line without what the others need.
    #[inline(always)]
    fn slid<const FORWARD: bool, const SPRUNG: bool>(
        &self,
        state: &State,
        rung: usize,
        input: f32,
        load: &Load,
    ) -> Change {
        let modes = self.modes.borrow();
        let (ladder, mut torque) = if FORWARD {
            (&modes.forward, load.torque - load.coulomb.forward)
        } else {
            (&modes.backward, load.torque + load.coulomb.backward)
        };
        let deflection = state.position.from(self.spring_rest);
        if SPRUNG {
            torque -= self.push::<FORWARD>(deflection);
        }
        let change = |row: &[f32; 5]| {
            let mut sum = row[0] * state.current + row[1] * state.velocity.value();
            // Without a spring its coefficient is zero.
            if SPRUNG {
                sum += row[2] * deflection;
            }
            sum + row[3] * input + row[4] * torque
        };
        let increment = &ladder[rung];
        Change {
            current: change(&increment.current),
            velocity: change(&increment.velocity),
            position: change(&increment.position),
        }
    }

    /// The preload with the sign of the side of the spring's rest that is slid on: on the rest, of
    /// the one ahead.
    #[inline(always)]
    fn push<const FORWARD: bool>(&self, deflection: f32) -> f32 {
        let above = if FORWARD {
            deflection >= 0.0
        } else {
            deflection > 0.0
        };
        if above {
            self.spring_preload
        } else {
            -self.spring_preload
        }
    }

    /// A whole step of a state that slides one way, if no event comes before its end; else the state stays. Whether it
    /// was taken.
    #[inline(always)]
    fn slide<const FORWARD: bool, const SPRUNG: bool>(
        &self,
        state: &mut State,
        input: f32,
        load: &Load,
    ) -> bool {
        let change = self.slid::<FORWARD, SPRUNG>(state, 0, input, load);
        let velocity = state.velocity.after(change.velocity);
        let position = state.position.after(change.position);
        let sum = state.current + change.current + velocity + position;
        // Zero, or no number where one of them is none: then no comparison holds.
        let spoilt = 0.0 * sum;
        let onwards = if FORWARD {
            velocity > 0.0
        } else {
            velocity < 0.0
        };
        // Both stops: a step of several swings may end behind where it began.
        let inside = position + spoilt <= self.upper_stop && position >= self.lower_stop;
        if !(onwards && inside) {
            return false;
        }
        if SPRUNG {
            // Not beyond the spring's rest; without preload nothing happens there.
            let deflection = state.position.from(self.spring_rest);
            if (deflection + change.position) * self.push::<FORWARD>(deflection) < 0.0 {
                return false;
            }
        }
        commit(state, &change);
        true
    }

    /// What a rung adds to the current at rest.
    #[inline(always)]
    fn rested(&self, state: &State, rung: usize, input: f32) -> f32 {
        let increment = &self.modes.borrow().rest[rung];
        increment.current * state.current + increment.input * input
    }

    /// The same of a state at rest.
    #[inline(always)]
    fn rest(&self, state: &mut State, input: f32, load: &Load) -> bool {
        let current = state.current + self.rested(state, 0, input);
        // Most of the time friction holds it alone, whatever stop is near.
        let drive = self.torque_per_current * current + load.torque;
        let held =
            !self.sprung && drive <= load.breakaway.forward && -drive <= load.breakaway.backward;
        let rests = held || self.released(state.position, current, load) == Motion::Rest;
        if rests && current.is_finite() {
            state.current = current;
            return true;
        }
        false
    }

    /// What holds an actuator at rest at a position.
    fn holding(&self, position: Compensated, load: &Load) -> Hold {
        let deflection = position.from(self.spring_rest);
        let (up, down) = self.preloads(deflection);
        let stopped = |stopped: bool, preload: f32| if stopped { f32::INFINITY } else { preload };
        Hold {
            torque_per_current: self.torque_per_current,
            torque: load.torque,
            spring: self.spring * deflection,
            up: stopped(position.value() >= self.upper_stop, up),
            down: stopped(position.value() <= self.lower_stop, down),
            breakaway: load.breakaway,
        }
    }

    /// What the preload holds against a start forwards and one backwards: at the spring's rest it holds
    /// in both directions; beside it, it pushes back.
    fn preloads(&self, deflection: f32) -> (f32, f32) {
        if deflection > 0.0 {
            (self.spring_preload, -self.spring_preload)
        } else if deflection < 0.0 {
            (-self.spring_preload, self.spring_preload)
        } else {
            (self.spring_preload, self.spring_preload)
        }
    }

    /// The breakaway test: which way an actuator at rest starts.
    fn released(&self, position: Compensated, current: f32, load: &Load) -> Motion {
        self.holding(position, load).released(current)
    }

    /// Without inductance the current follows the input and the velocity at once.
    fn follow_input(&self, state: &mut State, input: f32) {
        if let Some((back_emf, conductance)) = self.algebraic {
            state.current = conductance * input - back_emf * state.velocity.value();
        }
    }
}

#[inline(always)]
fn commit(state: &mut State, change: &Change) {
    state.current += change.current;
    state.velocity.advance(change.velocity);
    state.position.advance(change.position);
}
