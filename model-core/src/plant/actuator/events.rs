//! A step in which a mode ends: down the ladder to the event, across it, and on.
//!
//! An interrupt has to be over in time with several events in its step, so nothing is worked out twice
//! here, nor what shows that a rung does not last once that is seen.

use super::{Actuator, Change, Hold, InputRefused, Load, Modes, commit};
use crate::plant::modes::{CELLS, Increment, Ladder, RUNGS};
use crate::plant::{Compensated, Motion, State};
use core::borrow::Borrow;

/// Events handled in one step; after these the actuator stays at rest for what is left of it.
const EVENTS: u32 = 8;

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
    /// In finest cells.
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
        // Sixteen cells have the exponent 4, and are the first rung.
        let exponent = (self.cells.to_bits() >> 23) as usize;
        let fitting = (127 + RUNGS - 1).saturating_sub(exponent);
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

/// The finest cell as a parabola through its start, its end and the end of the next one.
struct Cell {
    first: Change,
    /// Second differences.
    bend: Change,
}

impl Cell {
    /// From what a cell and what two of them add.
    #[inline(always)]
    fn new(first: Change, both: &Change) -> Self {
        Self {
            first,
            bend: Change {
                current: both.current - 2.0 * first.current,
                velocity: both.velocity - 2.0 * first.velocity,
                position: both.position - 2.0 * first.position,
            },
        }
    }

    /// What a share of the cell adds to the state.
    #[inline(always)]
    fn part(&self, share: f32) -> Change {
        let of = |first: f32, bend: f32| part(share, first, bend);
        Change {
            current: of(self.first.current, self.bend.current),
            velocity: of(self.first.velocity, self.bend.velocity),
            position: of(self.first.position, self.bend.position),
        }
    }
}

/// A parabola from zero at a share of its first step.
#[inline(always)]
fn part(share: f32, first: f32, bend: f32) -> f32 {
    share * first + 0.5 * share * (share - 1.0) * bend
}

/// The share of a cell at which a parabola with this start (≥ 0), first and second difference falls
/// to zero, where it does so within the cell. Each root in the form that does not cancel.
#[inline(never)]
fn fall(start: f32, first: f32, bend: f32) -> f32 {
    // Not `max`, which is a call.
    let from_zero = |value: f32| if value > 0.0 { value } else { 0.0 };
    let start = from_zero(start);
    let slope = 0.5 * bend - first;
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
            now.motion = self.released(now.position, now.current, load);
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
                // And starts again where friction does not hold.
                now.velocity = Compensated::new(0.0);
                self.follow_input(&mut now, input);
                now.motion = self.released(now.position, now.current, load);
            }
            if left.events == EVENTS {
                now.velocity = Compensated::new(0.0);
                now.motion = Motion::Rest;
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
        for rung in longest..RUNGS - 2 {
            let increment = &slide.ladder[rung];
            if slide.goes_on(slide.row(&increment.velocity))
                && slide.stays_inside(slide.row(&increment.position))
            {
                commit(now, &slide.change(increment));
                left.pass(rung);
                return false;
            }
        }
        // What the last two rungs add makes the cell.
        let mut both = None;
        if longest <= RUNGS - 2 {
            let change = slide.change(&slide.ladder[RUNGS - 2]);
            if slide.lasts(&change) {
                commit(now, &change);
                left.pass(RUNGS - 2);
                return false;
            }
            both = Some(change);
        }
        let first = slide.change(&slide.ladder[RUNGS - 1]);
        if longest <= RUNGS - 1 && slide.lasts(&first) {
            commit(now, &first);
            left.pass(RUNGS - 1);
            return false;
        }
        let both = both.unwrap_or_else(|| slide.change(&slide.ladder[RUNGS - 2]));
        let cell = Cell::new(first, &both);
        let available = left.of_cell();
        let (share, event) = match self.first_event(&slide, &cell) {
            Some((0.0, Event::Standstill)) if now.velocity.value() == 0.0 => {
                // Let go, but turned back at once: friction balances it for this cell.
                now.motion = Motion::Rest;
                let [first, both] =
                    [RUNGS - 1, RUNGS - 2].map(|rung| self.rested(now, rung, input));
                now.current += part(available, first, both - 2.0 * first);
                left.pass_part(available);
                return true;
            }
            Some((share, event)) if share <= available && left.events < EVENTS => {
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
                // Where the preload turns it back within a cell, crossings follow each other ever
                // faster, without end in a finite time, and it lies on the rest.
                let slide = self.sliding(now, input, load);
                let change = slide.row(&slide.ladder[RUNGS - 1].velocity);
                let turns = now.velocity.after(change) * now.velocity.value() <= 0.0;
                turns && self.released(now.position, now.current, load) == Motion::Rest
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
            let mut rungs = left.longest()..RUNGS;
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
            let [first, both] = [RUNGS - 1, RUNGS - 2].map(|rung| self.rested(&now, rung, input));
            let bend = both - 2.0 * first;
            let mut share = left.of_cell();
            let motion = hold.released(now.current + first);
            if motion != Motion::Rest && left.events < EVENTS {
                let breaks = self.breakaway(now.current, &hold, motion, first, bend);
                if breaks <= share {
                    share = breaks;
                    left.events += 1;
                    now.motion = motion;
                }
            }
            now.current += part(share, first, bend);
            self.confine_position(&mut now);
            left.pass_part(share);
        }
        (now, left)
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
        } = cell.first;
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
    /// current's first and second difference.
    fn breakaway(&self, current: f32, hold: &Hold, motion: Motion, first: f32, bend: f32) -> f32 {
        let (forward, backward) = hold.excess(current);
        let (excess, sign) = match motion {
            Motion::Backward => (backward, -1.0),
            Motion::Forward | Motion::Rest => (forward, 1.0),
        };
        let torque = -sign * self.torque_per_current;
        fall(-excess, torque * first, torque * bend)
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
