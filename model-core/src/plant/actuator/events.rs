//! A step in which a mode ends: down the ladder to the event, across it, and on.
//!
//! An interrupt has to be over in time with several events in its step, so nothing is worked out twice
//! here, nor what shows that a rung does not last once that is seen.

use super::{Actuator, Change, Hold, InputRefused, Load, Modes, commit};
use crate::plant::modes::{Increment, Ladder, RUNGS};
use crate::plant::{Compensated, Motion, State};
use core::borrow::Borrow;

/// Events handled in one step; after these the actuator stays at rest for what is left of it.
const EVENTS: u32 = 8;

/// The rung of a *cell*, the eighth of the step in which an event is placed: on the parabola through
/// the cell's start, its middle and its end.
const CELL: usize = RUNGS - 2;

/// That of its half.
const HALF: usize = RUNGS - 1;

/// Cells in a step.
const CELLS: f32 = (1 << CELL) as f32;

/// What ends a sliding mode.
#[derive(Clone, Copy)]
enum Event {
    Standstill,
    SpringRest,
    /// At this position.
    Stop(f32),
}

/// What is left of a step.
struct Left {
    /// In cells.
    cells: f32,
    /// The longest rung that may last.
    rung: usize,
    /// Events so far.
    events: u32,
}

impl Left {
    /// The longest rung that may last and is not longer than what is left.
    #[inline(always)]
    fn longest(&self) -> usize {
        // One cell has the exponent 127 and is the rung CELL; twice as much is the rung before it.
        let exponent = (self.cells.to_bits() >> 23) as usize;
        let fitting = (127 + CELL).saturating_sub(exponent);
        self.rung.max(fitting)
    }

    /// A rung has lasted: another one like it ends where twice its length did not last.
    #[inline(always)]
    fn pass(&mut self, rung: usize) {
        self.cells -= CELLS / (1 << rung) as f32;
        self.rung = rung + 1;
    }

    /// A part of a cell has gone by.
    #[inline(always)]
    fn pass_part(&mut self, share: f32) {
        self.cells -= share;
        self.rung = 0;
    }

    /// What is left of the next cell.
    #[inline(always)]
    fn of_cell(&self) -> f32 {
        if self.cells < 1.0 { self.cells } else { 1.0 }
    }
}

/// A sliding state with what its changes are worked out from.
struct Slide<'a> {
    ladder: &'a Ladder,
    /// 1 forwards, −1 backwards.
    sign: f32,
    state: State,
    deflection: f32,
    /// The preload, with its sign.
    push: f32,
    torque: f32,
    input: f32,
    lower_stop: f32,
    upper_stop: f32,
}

impl Slide<'_> {
    /// A row's change.
    #[inline(always)]
    fn row(&self, row: &[f32; 5]) -> f32 {
        row[0] * self.state.current
            + row[1] * self.state.velocity.value()
            + row[2] * self.deflection
            + row[3] * self.input
            + row[4] * self.torque
    }

    #[inline(always)]
    fn change(&self, increment: &Increment) -> Change {
        Change {
            current: self.row(&increment.current),
            velocity: self.row(&increment.velocity),
            position: self.row(&increment.position),
        }
    }

    /// Whether it goes on the same way behind a change of velocity.
    #[inline(always)]
    fn goes_on(&self, change: f32) -> bool {
        self.state.velocity.after(change) * self.sign > 0.0
    }

    /// Whether it is within the stops, and on the same side of the spring's rest, behind a change of position.
    #[inline(always)]
    fn stays_inside(&self, change: f32) -> bool {
        let position = self.state.position.after(change);
        let crosses = (self.deflection + change) * self.push < 0.0;
        position <= self.upper_stop && position >= self.lower_stop && !crosses
    }

    #[inline(always)]
    fn lasts(&self, change: &Change) -> bool {
        self.goes_on(change.velocity) && self.stays_inside(change.position)
    }
}

/// What a cell adds to the state, as a parabola.
struct Cell {
    whole: Change,
    /// Second derivatives.
    bend: Change,
}

impl Cell {
    /// From what all of it and its half add.
    #[inline(always)]
    fn new(whole: Change, half: &Change) -> Self {
        Self {
            whole,
            bend: Change {
                current: bend(whole.current, half.current),
                velocity: bend(whole.velocity, half.velocity),
                position: bend(whole.position, half.position),
            },
        }
    }

    /// What a share of the cell adds to the state.
    #[inline(always)]
    fn part(&self, share: f32) -> Change {
        let of = |whole: f32, bend: f32| part(share, whole, bend);
        Change {
            current: of(self.whole.current, self.bend.current),
            velocity: of(self.whole.velocity, self.bend.velocity),
            position: of(self.whole.position, self.bend.position),
        }
    }
}

/// The second derivative of a parabola from zero, by its share, from its end and its middle.
#[inline(always)]
fn bend(whole: f32, half: f32) -> f32 {
    4.0 * (whole - 2.0 * half)
}

/// That parabola at a share.
#[inline(always)]
fn part(share: f32, whole: f32, bend: f32) -> f32 {
    share * whole + 0.5 * share * (share - 1.0) * bend
}

/// The share of a cell at which a parabola with this start (≥ 0), change to its end and second derivative
/// falls to zero, where it does so within the cell. Each root in the form that does not cancel.
#[inline(never)]
fn fall(start: f32, whole: f32, bend: f32) -> f32 {
    // Not `max`, which is a call.
    let from_zero = |value: f32| if value > 0.0 { value } else { 0.0 };
    let start = from_zero(start);
    let slope = 0.5 * bend - whole;
    let root = libm::sqrtf(from_zero(slope * slope - 2.0 * bend * start));
    let share = if slope < 0.0 {
        // It rises first, even from zero.
        (slope - root) / bend
    } else if start > 0.0 {
        2.0 * start / (slope + root)
    } else {
        0.0
    };
    if (0.0..1.0).contains(&share) {
        share
    } else {
        1.0
    }
}

impl<M: Borrow<Modes>> Actuator<M> {
    /// A step in which the mode does not last.
    #[cold]
    #[inline(never)]
    pub(super) fn step_through_events(
        &self,
        state: &mut State,
        input: f32,
        load: &Load,
    ) -> Result<(), InputRefused> {
        let mut now = *state;
        self.follow_input(&mut now, input);
        if now.motion == Motion::Rest {
            now.motion = self.starts(now, load);
        }
        let mut left = Left {
            cells: CELLS,
            // The whole step has failed already, unless in another mode.
            rung: usize::from(now.motion == state.motion),
            events: 0,
        };
        while left.cells > 0.0 {
            if now.motion == Motion::Rest {
                (now, left) = self.rest_through(now, left, input, load);
            } else if self.slide_on(&mut now, &mut left, input, load) {
                now.velocity = Compensated::new(0.0);
                self.follow_input(&mut now, input);
                // And starts again where friction does not hold.
                now.motion = if left.events < EVENTS {
                    self.starts(now, load)
                } else {
                    Motion::Rest
                };
            }
        }
        if now.is_finite() {
            *state = now;
            Ok(())
        } else {
            Err(InputRefused)
        }
    }

    /// Slides for as long as a rung lasts, or to the next event, or to the end of a cell. Whether it comes to
    /// a standstill.
    #[inline(always)]
    fn slide_on(&self, now: &mut State, left: &mut Left, input: f32, load: &Load) -> bool {
        let slide = self.sliding(now, input, load);
        let longest = left.longest();
        for rung in longest..CELL {
            let increment = &slide.ladder[rung];
            if slide.goes_on(slide.row(&increment.velocity))
                && slide.stays_inside(slide.row(&increment.position))
            {
                commit(now, &slide.change(increment));
                left.pass(rung);
                return false;
            }
        }
        let whole = slide.change(&slide.ladder[CELL]);
        if longest <= CELL && slide.lasts(&whole) {
            commit(now, &whole);
            left.pass(CELL);
            return false;
        }
        let cell = Cell::new(whole, &slide.change(&slide.ladder[HALF]));
        let available = left.of_cell();
        let (share, event) = match self.first_event(&slide, &cell) {
            Some((0.0, Event::Standstill)) if now.velocity.value() == 0.0 => {
                // Let go, but turned back at once: friction balances it for half of this cell.
                let share = if available < 0.5 { available } else { 0.5 };
                now.motion = Motion::Rest;
                now.current = self.rested_for(*now, share, input);
                left.pass_part(share);
                return true;
            }
            Some((share, event)) if share <= available => {
                left.events += 1;
                (share, Some(event))
            }
            _ => (available, None),
        };
        commit(now, &cell.part(share));
        self.confine(now);
        left.pass_part(share);
        match event {
            None => false,
            Some(Event::Standstill) => true,
            Some(Event::Stop(stop)) => {
                now.position = Compensated::new(stop);
                true
            }
            Some(Event::SpringRest) => {
                now.position = Compensated::new(self.spring_rest);
                // It may lie a rounding beyond a stop.
                self.confine(now);
                // Where the preload turns it back within half a cell, crossings follow each other ever
                // faster, without end in a finite time, and it lies on the rest: a deceleration `a`
                // would take it no further than a h²/512 from there in a step of h, 2 nrad for a
                // throttle at 50 µs.
                let slide = self.sliding(now, input, load);
                let change = slide.row(&slide.ladder[HALF].velocity);
                let turns = now.velocity.after(change) * now.velocity.value() <= 0.0;
                left.events == EVENTS || turns && self.starts(*now, load) == Motion::Rest
            }
        }
    }

    /// Rests until friction gives way, or to the step's end.
    // In a frame of its own: what it needs at every rung would be worked out for each step that slides too.
    #[inline(never)]
    fn rest_through(
        &self,
        mut now: State,
        mut left: Left,
        input: f32,
        load: &Load,
    ) -> (State, Left) {
        let hold = self.holding(now.position, load);
        while now.motion == Motion::Rest && left.cells > 0.0 {
            let mut rungs = left.longest()..=CELL;
            let lasting = rungs.find_map(|rung| {
                let current = now.current + self.rested(&now, rung, input);
                let lasts = hold.released(current) == Motion::Rest && current.is_finite();
                lasts.then_some((rung, current))
            });
            if let Some((rung, current)) = lasting {
                now.current = current;
                left.pass(rung);
                continue;
            }
            let [whole, half] = [CELL, HALF].map(|rung| self.rested(&now, rung, input));
            let bend = bend(whole, half);
            let mut share = left.of_cell();
            let motion = hold.released(now.current + whole);
            if motion != Motion::Rest && left.events + 1 < EVENTS {
                let breaks = self.breakaway(now.current, &hold, motion, whole, bend);
                if breaks <= share {
                    share = breaks;
                    left.events += 1;
                    now.motion = motion;
                }
            }
            now.current += part(share, whole, bend);
            self.confine_position(&mut now);
            left.pass_part(share);
        }
        (now, left)
    }

    /// Which way it starts from where it stands.
    // Not within the loop over the cells: the compiler would work out half of it before that, for steps
    // that do not come to a standstill too.
    #[inline(never)]
    fn starts(&self, state: State, load: &Load) -> Motion {
        self.released(state.position, state.current, load)
    }

    /// Rests for a part of a cell.
    #[cold]
    #[inline(never)]
    fn rested_for(&self, state: State, share: f32, input: f32) -> f32 {
        let [whole, half] = [CELL, HALF].map(|rung| self.rested(&state, rung, input));
        state.current + part(share, whole, bend(whole, half))
    }

    /// A sliding state with what its changes are worked out from.
    #[inline(always)]
    fn sliding(&self, state: &State, input: f32, load: &Load) -> Slide<'_> {
        let modes = self.modes.borrow();
        let deflection = state.position.from(self.spring_rest);
        let (ladder, sign, torque, push) = if state.motion == Motion::Backward {
            let torque = load.torque + load.coulomb.backward;
            (
                &modes.backward,
                -1.0,
                torque,
                self.push::<false>(deflection),
            )
        } else {
            let torque = load.torque - load.coulomb.forward;
            (&modes.forward, 1.0, torque, self.push::<true>(deflection))
        };
        Slide {
            ladder,
            sign,
            state: *state,
            deflection,
            push,
            torque: torque - push,
            input,
            lower_stop: self.lower_stop,
            upper_stop: self.upper_stop,
        }
    }

    /// The earliest event in the next cell, with the share of the cell at which it happens.
    #[inline(always)]
    fn first_event(&self, slide: &Slide<'_>, cell: &Cell) -> Option<(f32, Event)> {
        let Slide {
            sign,
            state,
            deflection,
            ..
        } = slide;
        let Change {
            velocity, position, ..
        } = cell.whole;
        let mut first: Option<(f32, Event)> = None;
        let mut offer = |share: f32, event: Event| {
            if first.is_none_or(|(earliest, _)| share < earliest) {
                first = Some((share, event));
            }
        };
        if state.velocity.after(velocity) * sign <= 0.0 {
            let start = state.velocity.value() * sign;
            let share = fall(start, velocity * sign, cell.bend.velocity * sign);
            offer(share, Event::Standstill);
        }
        let fall_to = |distance: f32| fall(distance, -position * sign, -cell.bend.position * sign);
        let ahead = -deflection * sign;
        if self.spring_preload != 0.0 && ahead > 0.0 && position * sign > ahead {
            offer(fall_to(ahead), Event::SpringRest);
        }
        let stop = if *sign > 0.0 {
            self.upper_stop
        } else {
            self.lower_stop
        };
        if (state.position.after(position) - stop) * sign > 0.0 {
            let room = -state.position.from(stop) * sign;
            offer(fall_to(room), Event::Stop(stop));
        }
        first
    }

    /// The share of a cell at rest at which the drive has grown to the breakaway level of a motion, with the
    /// current's change to its end and second derivative.
    fn breakaway(&self, current: f32, hold: &Hold, motion: Motion, whole: f32, bend: f32) -> f32 {
        let (forward, backward) = hold.excess(current);
        let (excess, sign) = match motion {
            Motion::Backward => (backward, -1.0),
            Motion::Forward | Motion::Rest => (forward, 1.0),
        };
        let torque = -sign * self.torque_per_current;
        fall(-excess, torque * whole, torque * bend)
    }

    /// Takes back what a part of a cell goes beyond a standstill or a stop: rounding, or the top of a
    /// parabola that is inside again at the cell's end.
    #[inline(always)]
    fn confine(&self, state: &mut State) {
        if Motion::of(state.velocity.value()) != state.motion {
            state.velocity = Compensated::new(0.0);
        }
        self.confine_position(state);
    }

    #[inline(always)]
    fn confine_position(&self, state: &mut State) {
        let position = state.position.value();
        if position > self.upper_stop {
            state.position = Compensated::new(self.upper_stop);
        } else if position < self.lower_stop {
            state.position = Compensated::new(self.lower_stop);
        }
    }
}
