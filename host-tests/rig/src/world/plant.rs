//! The plant of a world: one or two masses, a winding, and the laws that act on them, integrated by the
//! classical Runge–Kutta rule between events.
//!
//! A mass that rests is *stuck* and does not move at all until the load on it exceeds the breakaway level;
//! one that moves slides in one direction until its speed comes to zero. Both are located within the step.
//! Then it sticks, or slides the other way if the load is more than breakaway takes. End stops are reached
//! in the same way and take all speed.

use super::forces::{BUS, CURRENT, Forces, LOAD, MOTOR, Rates};
use super::laws::Law;
use super::machine::Machine;

/// Most steps of one log, about.
const MOST_STEPS: f64 = 8e5;

/// Most events in one step; a mass that has more is held for the rest of it.
const MOST_EVENTS: usize = 8;

/// Most looks for the time of an event within a step.
const MOST_LOOKS: usize = 12;

/// Shortest step that a log of so many seconds is simulated with, s.
pub(super) fn finest_step(seconds: f64) -> f64 {
    (seconds / MOST_STEPS).max(2e-6)
}

/// Where a world's machine is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// s since the log began.
    pub time: f64,
    /// In the order of the constants of [`super::forces`].
    pub(super) values: Rates,
    /// Direction in which each mass slides, −1 or 1; 0 for one that is stuck.
    pub(super) directions: [f64; 2],
}

impl State {
    /// Position of the motor, rad or m, on the load's side of the gear.
    pub fn motor_position(&self) -> f64 {
        self.values[MOTOR]
    }

    /// Its velocity, rad/s or m/s.
    pub fn motor_velocity(&self) -> f64 {
        self.values[MOTOR + 1]
    }

    /// Position of what is behind a joint, rad or m; the motor's where there is no joint.
    pub fn load_position(&self) -> f64 {
        self.values[LOAD]
    }

    /// Its velocity, rad/s or m/s.
    pub fn load_velocity(&self) -> f64 {
        self.values[LOAD + 1]
    }

    /// Current of the winding, A; 0 without one.
    pub fn current(&self) -> f64 {
        self.values[CURRENT]
    }

    /// Whether no mass slides.
    pub fn is_stuck(&self) -> bool {
        self.directions == [0.0, 0.0]
    }
}

/// A machine with its laws, ready to be simulated.
#[derive(Debug, Clone)]
pub struct Plant {
    forces: Forces,
    step: f64,
}

impl Plant {
    /// For logs of `seconds`, with rows every `period`, s.
    pub fn new(machine: &Machine, laws: &[Law], seconds: f64, period: f64) -> Self {
        let forces = Forces::new(machine, laws);
        let step = forces
            .longest_step()
            .min(0.5 * period)
            .clamp(finest_step(seconds), 5e-3);
        Self { forces, step }
    }

    /// Integration step, s.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// At rest at `position`, without a current.
    pub fn at_rest(&self, position: f64) -> State {
        let mut values = Rates::default();
        values[MOTOR] = position;
        values[LOAD] = position;
        values[BUS] = 1.0;
        State {
            time: 0.0,
            values,
            directions: [0.0, 0.0],
        }
    }

    /// Kinetic energy of the masses and energy of springs, joint and magnetic field, J.
    pub fn energy(&self, state: &State) -> f64 {
        self.forces.energy(&state.values)
    }

    /// Carries the state to the time `until`, the input held at `input`.
    pub fn advance(&self, state: &mut State, input: f64, until: f64) {
        while until - state.time > 1e-12 * until.abs().max(1e-3) {
            let left = until - state.time;
            // Steps of equal length, none of them a sliver.
            let step = left / (left / self.step * (1.0 - 1e-9)).ceil().max(1.0);
            self.step_through(state, input, step);
        }
        state.time = until;
    }

    /// One step, with what happens in it.
    fn step_through(&self, state: &mut State, input: f64, step: f64) {
        let mut left = step;
        for event in 0..=MOST_EVENTS {
            if event < MOST_EVENTS {
                self.release(state, input);
            }
            let next = self.runge_kutta(state, input, left);
            let look = Look {
                forces: &self.forces,
                state: *state,
                input,
            };
            let Some(what) = look.first_event(&next, left) else {
                state.values = next;
                state.time += left;
                return;
            };
            let (part, values) = self.located(&look, left, &next, what);
            state.values = values;
            state.time += part;
            self.settle(state, what);
            left -= part;
            if left <= 1e-12 * step {
                return;
            }
        }
        state.time += left.max(0.0);
    }

    /// Lets go of stuck masses on which the load is more than friction takes.
    fn release(&self, state: &mut State, input: f64) {
        for side in 0..self.forces.masses() {
            if state.directions[side] != 0.0 {
                continue;
            }
            if self.forces.bends(side) {
                // Bristles hold by bending: the mass is never held by itself.
                state.directions[side] = 1.0;
                continue;
            }
            let load = self.forces.load_on(side, state, input);
            let breakaway = self.forces.breakaway(side, state, input, load.signum());
            if load.abs() > breakaway && !self.forces.presses_on_stop(side, &state.values, load) {
                state.directions[side] = load.signum();
            }
        }
    }

    /// When an event comes within a step of `step`, s, and where everything is then. By the rule of false
    /// position with the Illinois modification.
    fn located(&self, look: &Look, step: f64, next: &Rates, what: Event) -> (f64, Rates) {
        let state = &look.state;
        let (mut early, mut before) = (0.0, look.ahead(what, &state.values, 0.0).max(0.0));
        let (mut late, mut behind) = (step, look.ahead(what, next, step));
        let (mut part, mut values) = (late, *next);
        let enough = 1e-10 * (before - behind);
        let mut last_was_early = None;
        for _ in 0..MOST_LOOKS {
            part = (early * behind - late * before) / (behind - before);
            values = self.runge_kutta(state, look.input, part);
            let ahead = look.ahead(what, &values, part);
            if ahead.abs() <= enough {
                break;
            }
            let is_early = ahead > 0.0;
            if is_early {
                (early, before) = (part, ahead);
            } else {
                (late, behind) = (part, ahead);
            }
            if last_was_early == Some(is_early) {
                if is_early {
                    behind *= 0.5;
                } else {
                    before *= 0.5;
                }
            }
            last_was_early = Some(is_early);
        }
        (part, values)
    }

    /// What an event does.
    fn settle(&self, state: &mut State, what: Event) {
        let side = match what {
            Event::Rest(side, _) => side,
            Event::Stopped(side, _, stop) => {
                state.values[2 * side] = stop;
                side
            }
            Event::Released(side, direction) => {
                state.directions[side] = direction;
                return;
            }
        };
        state.values[2 * side + 1] = 0.0;
        if !self.forces.bends(side) {
            state.directions[side] = 0.0;
        }
    }

    fn runge_kutta(&self, state: &State, input: f64, step: f64) -> Rates {
        let rates =
            |values: &Rates, time: f64| self.forces.rates(values, &state.directions, input, time);
        let along = |rate: &Rates, time: f64| -> Rates {
            std::array::from_fn(|index| state.values[index] + time * rate[index])
        };
        let (time, half) = (state.time, 0.5 * step);
        let first = rates(&state.values, time);
        let second = rates(&along(&first, half), time + half);
        let third = rates(&along(&second, half), time + half);
        let fourth = rates(&along(&third, step), time + step);
        let mut next: Rates = std::array::from_fn(|index| {
            let sum = first[index] + 2.0 * (second[index] + third[index]) + fourth[index];
            state.values[index] + step / 6.0 * sum
        });
        if self.forces.masses() == 1 {
            next[LOAD] = next[MOTOR];
            next[LOAD + 1] = next[MOTOR + 1];
        }
        next
    }
}

/// What ends a step early.
#[derive(Debug, Clone, Copy)]
enum Event {
    /// A mass that slid in this direction came to rest.
    Rest(usize, f64),
    /// A mass reached an end stop that lies in this direction, at this position.
    Stopped(usize, f64, f64),
    /// The load on a stuck mass reached what friction holds in this direction.
    Released(usize, f64),
}

/// A step in which events are looked for.
struct Look<'a> {
    forces: &'a Forces,
    /// At its beginning.
    state: State,
    input: f64,
}

impl Look<'_> {
    /// How far an event is ahead once `passed`, s, have passed: a speed, a way or a load, negative once it has
    /// come.
    fn ahead(&self, event: Event, values: &Rates, passed: f64) -> f64 {
        match event {
            Event::Rest(side, direction) => values[2 * side + 1] * direction,
            Event::Stopped(side, outwards, stop) => (stop - values[2 * side]) * outwards,
            Event::Released(side, direction) => {
                let state = self.after(values, passed);
                let load = self.forces.load_on(side, &state, self.input);
                self.forces.breakaway(side, &state, self.input, direction) - load * direction
            }
        }
    }

    fn after(&self, values: &Rates, passed: f64) -> State {
        State {
            time: self.state.time + passed,
            values: *values,
            directions: self.state.directions,
        }
    }

    /// The first thing that happens on the way to `next`, by straight lines.
    fn first_event(&self, next: &Rates, step: f64) -> Option<Event> {
        let mut first: Option<(f64, Event)> = None;
        let mut see = |event: Event| {
            let before = self.ahead(event, &self.state.values, 0.0);
            let after = self.ahead(event, next, step);
            let share = before / (before - after);
            if first.is_none_or(|(known, _)| share < known) {
                first = Some((share, event));
            }
        };
        for side in 0..self.forces.masses() {
            if let Some((stop, outwards)) = self.forces.stop_passed(side, next) {
                see(Event::Stopped(side, outwards, stop));
            }
            if self.forces.bends(side) {
                continue;
            }
            let direction = self.state.directions[side];
            let event = if direction == 0.0 {
                let state = self.after(next, step);
                let load = self.forces.load_on(side, &state, self.input);
                if self.forces.presses_on_stop(side, next, load) {
                    continue;
                }
                Event::Released(side, load.signum())
            } else {
                Event::Rest(side, direction)
            };
            if self.ahead(event, next, step) < 0.0 {
                see(event);
            }
        }
        first.map(|(_, event)| event)
    }
}
