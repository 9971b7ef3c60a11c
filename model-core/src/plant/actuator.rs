//! The actuator's step: exact in a mode, split at events.

use super::modes::{self, CELLS, Ladder, RUNGS, RestLadder};
use super::parameters::{Drive, ParameterError, Parameters};
use super::{Compensated, Directional, InputRefused, Motion, State};

/// Largest magnitude of the input that a step takes, in units of the input. Beyond it, as with
/// NaN or infinity, the step refuses and leaves the state as it was.
pub const INPUT_LIMIT: f32 = 1e6;

/// Events handled in one step; after these the actuator stays at rest for what is left of it.
const EVENTS: u32 = 8;

/// Torques and friction levels held over a step, next to the input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// Torque or force on the mechanism, positive towards larger positions.
    pub torque: f32,
    /// Friction while sliding.
    pub coulomb: Directional,
    /// Friction that holds at rest.
    pub breakaway: Directional,
}

/// An actuator with everything that does not depend on its state worked out for one step period.
///
/// ```
/// use model_core::plant::{State, Directional, actuator::Actuator, parameters::{Drive, Parameters}};
/// let parameters = Parameters {
///     drive: Drive::Voltage { resistance: 1.0, inductance: 1e-3, torque_constant: 0.06 },
///     gain: 1.0,
///     inertia: 1.2e-4,
///     viscous: Directional::both(2e-4),
///     coulomb: Directional::both(0.12),
///     breakaway: Directional::both(0.15),
///     spring: 0.0,
///     spring_rest: 0.0,
///     spring_preload: 0.0,
///     offset: 0.0,
///     lower_stop: f32::NEG_INFINITY,
///     upper_stop: f32::INFINITY,
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
pub struct Actuator {
    forward: Ladder,
    backward: Ladder,
    rest: RestLadder,
    load: Load,
    torque_per_current: f32,
    /// Back-EMF and input over resistance, where the winding has no inductance.
    algebraic: Option<(f32, f32)>,
    spring: f32,
    spring_rest: f32,
    spring_preload: f32,
    lower_stop: f32,
    upper_stop: f32,
}

/// What ends a mode.
#[derive(Debug, Clone, Copy)]
enum Event {
    Standstill,
    SpringRest,
    Stop(f32),
    Breakaway(Motion),
}

/// The state after a rung or a part of one, and the first event on the way.
struct Trial {
    current: f32,
    gained: f32,
    travel: f32,
    event: Option<(f32, Event)>,
}

impl Actuator {
    /// Works out the modes for a step of `period` seconds.
    ///
    /// # Errors
    /// A parameter outside its range, or a period that is not above 0 and at most 10 s.
    pub fn build(parameters: &Parameters, period: f32) -> Result<Self, ParameterError> {
        parameters.check()?;
        let usable = period > 0.0 && period <= 10.0;
        if !usable {
            return Err(ParameterError {
                parameter: "period",
                requirement: "above 0 and at most 10 s",
            });
        }
        let forward = modes::sliding(parameters, parameters.viscous.forward, period);
        let backward = if parameters.viscous.backward == parameters.viscous.forward {
            forward
        } else {
            modes::sliding(parameters, parameters.viscous.backward, period)
        };
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
            forward,
            backward,
            rest: modes::rest(parameters, period),
            load: Load {
                torque: parameters.offset,
                coulomb: parameters.coulomb,
                breakaway: Directional {
                    forward: parameters.breakaway.forward.max(parameters.coulomb.forward),
                    backward: parameters
                        .breakaway
                        .backward
                        .max(parameters.coulomb.backward),
                },
            },
            torque_per_current: parameters.torque_per_current(),
            algebraic,
            spring: parameters.spring,
            spring_rest: parameters.spring_rest,
            spring_preload: parameters.spring_preload,
            lower_stop: parameters.lower_stop,
            upper_stop: parameters.upper_stop,
        })
    }

    /// The load that the parameters declare; effects start from it.
    pub fn load(&self) -> Load {
        self.load
    }

    /// Sets the friction levels without working the modes out again: the annealing loop changes
    /// nothing else. Negative or non-finite levels count as zero, and the breakaway level is
    /// raised to the Coulomb level.
    pub fn set_friction(&mut self, coulomb: f32, breakaway: f32) {
        let level = |value: f32| {
            if value.is_finite() {
                value.max(0.0)
            } else {
                0.0
            }
        };
        self.load.coulomb = Directional::both(level(coulomb));
        self.load.breakaway = Directional::both(level(breakaway).max(level(coulomb)));
    }

    /// One step with the input held over it.
    ///
    /// Exact while the mode lasts; an event is placed to within (h/16)² of the step h.
    ///
    /// # Errors
    /// [`InputRefused`] for an input that is not finite or beyond [`INPUT_LIMIT`].
    #[inline]
    pub fn step(&self, state: &mut State, input: f32) -> Result<(), InputRefused> {
        self.step_under(state, input, &self.load)
    }

    /// One step with the input and a load held over it.
    ///
    /// # Errors
    /// As [`Actuator::step`].
    #[inline]
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
        let trial = self.trial(state, 0, input, load);
        if trial.event.is_none() {
            self.commit(state, &trial, 1.0);
        } else {
            self.step_through_events(state, input, load);
        }
        Ok(())
    }

    /// Current and velocity in the middle of the step, and the travel to there, with the mode as
    /// it is: where effects that are not affine are evaluated.
    #[inline]
    pub fn middle(&self, state: &State, input: f32, load: &Load) -> (f32, f32, f32) {
        let trial = self.trial(state, 1, input, load);
        match trial.event {
            Some((share, Event::Standstill)) => (trial.current, 0.0, trial.travel * share),
            _ => (
                trial.current,
                state.velocity.value() + trial.gained,
                trial.travel,
            ),
        }
    }

    /// Goes over one rung without minding events, and says which came first.
    #[inline(always)]
    fn trial(&self, state: &State, rung: usize, input: f32, load: &Load) -> Trial {
        let (ladder, sign, friction) = match state.motion {
            Motion::Forward => (&self.forward, 1.0, load.coulomb.forward),
            Motion::Backward => (&self.backward, -1.0, -load.coulomb.backward),
            Motion::Rest => return self.trial_at_rest(state, rung, input, load),
        };
        let deflection = state.position.from(self.spring_rest);
        let side = if deflection == 0.0 { sign } else { deflection };
        let torque = load.torque - friction - self.spring_preload.copysign(side);
        let increment = &ladder[rung];
        let change = |row: &[f32; 5]| {
            row[0] * state.current
                + row[1] * state.velocity.value()
                + row[2] * deflection
                + row[3] * input
                + row[4] * torque
        };
        let current = state.current + change(&increment.current);
        let gained = change(&increment.velocity);
        let velocity = state.velocity.value() + gained;
        let travel = change(&increment.position);

        let position = state.position.value() + travel;
        let reached = deflection + travel;
        let quiet = velocity * sign > 0.0
            && position <= self.upper_stop
            && position >= self.lower_stop
            && (self.spring_preload == 0.0 || reached * side > 0.0);
        let event = if quiet {
            None
        } else {
            self.first_event(state, sign, deflection, velocity, travel)
        };
        Trial {
            current,
            gained,
            travel,
            event,
        }
    }

    /// The earliest event of a rung, with the share of the rung at which it happens.
    #[cold]
    fn first_event(
        &self,
        state: &State,
        sign: f32,
        deflection: f32,
        velocity: f32,
        travel: f32,
    ) -> Option<(f32, Event)> {
        let mut first: Option<(f32, Event)> = None;
        let mut offer = |share: f32, event: Event| {
            let share = share.clamp(0.0, 1.0);
            if first.is_none_or(|(earliest, _)| share < earliest) {
                first = Some((share, event));
            }
        };
        if velocity * sign <= 0.0 {
            let fall = state.velocity.value() - velocity;
            let share = if fall == 0.0 {
                0.0
            } else {
                state.velocity.value() / fall
            };
            offer(share, Event::Standstill);
        }
        if self.spring_preload != 0.0 && deflection * (deflection + travel) < 0.0 {
            offer(-deflection / travel, Event::SpringRest);
        }
        let stop = if sign > 0.0 {
            self.upper_stop
        } else {
            self.lower_stop
        };
        let beyond = (state.position.value() + travel - stop) * sign;
        if beyond > 0.0 && travel * sign > 0.0 {
            offer((stop - state.position.value()) / travel, Event::Stop(stop));
        }
        first
    }

    /// Rest over one rung: the winding alone moves, until its torque breaks away.
    #[inline]
    fn trial_at_rest(&self, state: &State, rung: usize, input: f32, load: &Load) -> Trial {
        let increment = &self.rest[rung];
        let current = state.current + (increment.current * state.current + increment.input * input);
        let event = match self.released(state.position, current, load) {
            Motion::Rest => None,
            motion => {
                let share = self.breakaway_share(state, current, motion, load);
                Some((share, Event::Breakaway(motion)))
            }
        };
        Trial {
            current,
            gained: 0.0,
            travel: 0.0,
            event,
        }
    }

    /// Torque on an actuator at rest by everything but friction, the spring's preload and the stops.
    fn drive(&self, position: Compensated, current: f32, load: &Load) -> f32 {
        self.torque_per_current * current + load.torque
            - self.spring * position.from(self.spring_rest)
    }

    /// Drive beyond what holds: (forward, backward), positive where friction gives way.
    fn excess(&self, position: Compensated, current: f32, load: &Load) -> (f32, f32) {
        let drive = self.drive(position, current, load);
        let deflection = position.from(self.spring_rest);
        // At the spring's rest its preload holds in both directions; beside it, it pushes back.
        let (up, down) = if deflection > 0.0 {
            (self.spring_preload, -self.spring_preload)
        } else if deflection < 0.0 {
            (-self.spring_preload, self.spring_preload)
        } else {
            (self.spring_preload, self.spring_preload)
        };
        let forward = if position.value() >= self.upper_stop {
            -1.0
        } else {
            drive - up - load.breakaway.forward
        };
        let backward = if position.value() <= self.lower_stop {
            -1.0
        } else {
            -drive - down - load.breakaway.backward
        };
        (forward, backward)
    }

    /// The breakaway test: which way an actuator at rest starts.
    fn released(&self, position: Compensated, current: f32, load: &Load) -> Motion {
        let (forward, backward) = self.excess(position, current, load);
        if forward > 0.0 {
            Motion::Forward
        } else if backward > 0.0 {
            Motion::Backward
        } else {
            Motion::Rest
        }
    }

    /// Share of a rung at rest after which the drive has grown to the breakaway level.
    fn breakaway_share(&self, state: &State, current: f32, motion: Motion, load: &Load) -> f32 {
        let pick = |(forward, backward): (f32, f32)| match motion {
            Motion::Forward => forward,
            _ => backward,
        };
        let start = pick(self.excess(state.position, state.current, load));
        let end = pick(self.excess(state.position, current, load));
        if start >= 0.0 {
            0.0
        } else {
            start / (start - end)
        }
    }

    #[inline(always)]
    fn commit(&self, state: &mut State, trial: &Trial, share: f32) {
        if share == 1.0 {
            state.current = trial.current;
            state.velocity.advance(trial.gained);
            state.position.advance(trial.travel);
        } else {
            state.current += share * (trial.current - state.current);
            state.velocity.advance(share * trial.gained);
            state.position.advance(share * trial.travel);
        }
    }

    /// A step in which a mode ends: down the ladder to the event, across it, and on.
    #[cold]
    #[inline(never)]
    fn step_through_events(&self, state: &mut State, input: f32, load: &Load) {
        if let (Motion::Rest, Some((_, conductance))) = (state.motion, self.algebraic) {
            // Without inductance the current follows the new input at once, before anything moves.
            state.current = conductance * input;
            state.motion = self.released(state.position, state.current, load);
        }
        let mut remaining = CELLS;
        let mut events = 0;
        while remaining > 0.0 {
            if events == EVENTS {
                state.velocity = Compensated::new(0.0);
                state.motion = Motion::Rest;
            }
            let mut rung = 0;
            let mut cells = CELLS;
            while rung + 1 < RUNGS && cells > remaining {
                rung += 1;
                cells *= 0.5;
            }
            let mut trial = self.trial(state, rung, input, load);
            while trial.event.is_some() && rung + 1 < RUNGS && events < EVENTS {
                rung += 1;
                cells *= 0.5;
                trial = self.trial(state, rung, input, load);
            }
            // In the finest cell the state moves along a line, whole or in part.
            let available = if cells > remaining { remaining } else { cells };
            match trial.event {
                Some((share, event)) if share * cells <= available && events < EVENTS => {
                    self.commit(state, &trial, share);
                    remaining -= share * cells;
                    events += 1;
                    self.cross(state, event, load);
                }
                _ => {
                    self.commit(state, &trial, available / cells);
                    remaining -= available;
                }
            }
        }
    }

    /// Enters the mode behind an event.
    fn cross(&self, state: &mut State, event: Event, load: &Load) {
        match event {
            Event::Standstill => {
                state.velocity = Compensated::new(0.0);
                state.motion = self.released(state.position, state.current, load);
            }
            Event::SpringRest => state.position = Compensated::new(self.spring_rest),
            Event::Stop(stop) => {
                state.position = Compensated::new(stop);
                state.velocity = Compensated::new(0.0);
                state.motion = self.released(state.position, state.current, load);
            }
            Event::Breakaway(motion) => state.motion = motion,
        }
    }
}
