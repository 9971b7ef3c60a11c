//! One actuator in many states at once, with the same bits as one by one.
//!
//! While a mode lasts, a step is a straight line of products and sums. Here it is one loop over the
//! lanes without a branch, which the compiler turns into vectors; the direction of motion chooses
//! among coefficients, not among ways through the code. A lane whose mode does not last is stepped
//! alone from where it was.

use super::{Actuator, Change, INPUT_LIMIT, Load, Modes};
use crate::plant::lanes::{End, Lanes, Numbers, take};
use crate::plant::modes::{Increment, RestIncrement};
use crate::plant::{Compensated, Directional, Motion, State};
use core::borrow::Borrow;

/// States side by side.
#[derive(Debug, Clone, Copy)]
pub(crate) struct States<const N: usize> {
    pub numbers: Numbers<N>,
    /// 1 forwards, −1 backwards, 0 at rest.
    sign: Lanes<N>,
}

impl<const N: usize> States<N> {
    pub const NOTHING: Self = Self {
        numbers: Numbers::NOTHING,
        sign: [0.0; N],
    };

    /// The state in a lane.
    pub fn at(&self, lane: usize) -> State {
        self.numbers.at(lane, Motion::of(self.sign[lane]))
    }

    /// Puts a lane into a state.
    pub fn put(&mut self, lane: usize, state: &State) {
        self.numbers.put(lane, &End::of(state));
        self.sign[lane] = state.motion.sign();
    }

    /// Takes the lanes that are marked from others.
    #[inline(always)]
    pub fn take(&mut self, others: &Self, marked: &[bool; N]) {
        self.numbers.take(&others.numbers, marked);
        take(&mut self.sign, &others.sign, marked);
    }

    /// Whether a lane is at rest.
    #[inline(always)]
    pub fn rests(&self, lane: usize) -> bool {
        self.sign[lane] == 0.0
    }

    /// Whether any lane is.
    #[inline(always)]
    fn any_rests(&self) -> bool {
        self.sign
            .iter()
            .fold(false, |any, &sign| any | (sign == 0.0))
    }

    /// By how much a lane's velocity has changed.
    #[inline(always)]
    pub fn gain(&self, before: &Self, lane: usize) -> f32 {
        let origin = before.numbers.velocity[lane];
        let gained = |states: &Self| states.numbers.velocity_at(lane).from(origin);
        gained(self) - gained(before)
    }

    #[inline(always)]
    fn start(&self, lane: usize) -> Start {
        Start {
            current: self.numbers.current[lane],
            velocity: self.numbers.velocity_at(lane),
            position: self.numbers.position_at(lane),
            forward: self.sign[lane] > 0.0,
            rests: self.rests(lane),
        }
    }
}

/// Loads side by side.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Loads<const N: usize> {
    torque: Lanes<N>,
    coulomb_forward: Lanes<N>,
    coulomb_backward: Lanes<N>,
    breakaway_forward: Lanes<N>,
    breakaway_backward: Lanes<N>,
}

impl<const N: usize> Loads<N> {
    /// The same in each lane.
    #[inline(always)]
    pub fn all(load: &Load) -> Self {
        Self {
            torque: [load.torque; N],
            coulomb_forward: [load.coulomb.forward; N],
            coulomb_backward: [load.coulomb.backward; N],
            breakaway_forward: [load.breakaway.forward; N],
            breakaway_backward: [load.breakaway.backward; N],
        }
    }

    /// The load in a lane.
    #[inline(always)]
    pub fn at(&self, lane: usize) -> Load {
        Load {
            torque: self.torque[lane],
            coulomb: Directional {
                forward: self.coulomb_forward[lane],
                backward: self.coulomb_backward[lane],
            },
            breakaway: Directional {
                forward: self.breakaway_forward[lane],
                backward: self.breakaway_backward[lane],
            },
        }
    }

    /// Puts a load into a lane.
    #[inline(always)]
    pub fn put(&mut self, lane: usize, load: &Load) {
        self.torque[lane] = load.torque;
        self.coulomb_forward[lane] = load.coulomb.forward;
        self.coulomb_backward[lane] = load.coulomb.backward;
        self.breakaway_forward[lane] = load.breakaway.forward;
        self.breakaway_backward[lane] = load.breakaway.backward;
    }

    /// As [`Load::against`], a friction in each lane.
    #[inline(always)]
    pub fn against(&self, frictions: &Lanes<N>) -> Self {
        let mut loads = *self;
        for lane in 0..N {
            loads.put(lane, &self.at(lane).against(frictions[lane]));
        }
        loads
    }

    /// Adds a torque in each lane.
    #[inline(always)]
    pub fn add(&mut self, torques: &Lanes<N>) {
        for lane in 0..N {
            self.torque[lane] += torques[lane];
        }
    }

    /// Friction of what slides, positive against forward motion.
    #[inline(always)]
    pub fn frictions(&self, states: &States<N>) -> Lanes<N> {
        let mut frictions = [0.0; N];
        for lane in 0..N {
            let forward = states.sign[lane] > 0.0;
            let (ahead, back) = (self.coulomb_forward[lane], -self.coulomb_backward[lane]);
            let slides = if forward { ahead } else { back };
            frictions[lane] = if states.rests(lane) { 0.0 } else { slides };
        }
        frictions
    }
}

/// What a lane's changes are worked out from.
struct Start {
    current: f32,
    velocity: Compensated,
    position: Compensated,
    forward: bool,
    rests: bool,
}

/// A rung of all modes.
struct Rung {
    forward: Increment,
    backward: Increment,
    rest: RestIncrement,
}

impl Rung {
    #[inline(always)]
    fn of(modes: &Modes, rung: usize) -> Self {
        Self {
            forward: modes.forward[rung],
            backward: modes.backward[rung],
            rest: modes.rest[rung],
        }
    }
}

/// Current and velocity in the middle of a step, and the travel to there.
pub(crate) struct Ways<const N: usize> {
    pub current: Lanes<N>,
    pub velocity: Lanes<N>,
    pub travel: Lanes<N>,
}

/// What a step without friction comes to, and what a torque held over it adds.
pub(crate) struct Unhelds<const N: usize> {
    current: Lanes<N>,
    velocity: Lanes<N>,
    pub travel: Lanes<N>,
    current_give: Lanes<N>,
    velocity_give: Lanes<N>,
    pub give: Lanes<N>,
}

impl<const N: usize> Unhelds<N> {
    /// As [`Unheld::gain`](super::Unheld::gain).
    #[inline(always)]
    pub fn gain(&self, lane: usize, friction: f32) -> f32 {
        self.velocity[lane] - friction * self.velocity_give[lane]
    }

    /// As [`Unheld::quickening`](super::Unheld::quickening).
    #[inline(always)]
    pub fn quickening(&self, lane: usize) -> f32 {
        self.velocity_give[lane]
    }

    /// As [`Unheld::under`](super::Unheld::under).
    #[inline(always)]
    pub fn load(&mut self, lane: usize, torque: f32) {
        self.current[lane] += torque * self.current_give[lane];
        self.velocity[lane] += torque * self.velocity_give[lane];
        self.travel[lane] += torque * self.give[lane];
    }
}

impl<M: Borrow<Modes>> Actuator<M> {
    /// As [`Actuator::wake`], in all lanes. Those that start from rest lose their mark.
    #[inline(always)]
    pub(crate) fn hold<const N: usize>(
        &self,
        states: &mut States<N>,
        inputs: &Lanes<N>,
        loads: &Loads<N>,
        lasts: &mut [bool; N],
    ) {
        if !states.any_rests() {
            return;
        }
        for lane in 0..N {
            let from = states.start(lane);
            let current = match self.algebraic {
                Some((back_emf, conductance)) if from.rests => {
                    conductance * inputs[lane] - back_emf * from.velocity.value
                }
                _ => from.current,
            };
            lasts[lane] &= !from.rests | self.stays::<true>(&from, current, &loads.at(lane));
            states.numbers.current[lane] = current;
        }
    }

    /// As [`Actuator::middle`], in all lanes.
    #[inline(always)]
    pub(crate) fn middles<const N: usize>(
        &self,
        states: &States<N>,
        inputs: &Lanes<N>,
        loads: &Loads<N>,
    ) -> Ways<N> {
        let half = Rung::of(self.modes.borrow(), 1);
        let mut ways = Ways {
            current: [0.0; N],
            velocity: [0.0; N],
            travel: [0.0; N],
        };
        for lane in 0..N {
            let from = states.start(lane);
            let change = self.changed::<true>(&half, &from, inputs[lane], &loads.at(lane));
            let start = from.velocity.value;
            let end = start + change.velocity;
            let stands = end * start < 0.0;
            let to_standstill = change.position * start / (start - end);
            ways.current[lane] = from.current + change.current;
            ways.velocity[lane] = if stands { 0.0 } else { end };
            ways.travel[lane] = if stands {
                to_standstill
            } else {
                change.position
            };
        }
        ways
    }

    /// As [`Actuator::input_that_ends_current`], in all lanes.
    #[inline(always)]
    pub(crate) fn inputs_that_end_current<const N: usize>(
        &self,
        states: &States<N>,
        loads: &Loads<N>,
    ) -> Lanes<N> {
        let whole = Rung::of(self.modes.borrow(), 0);
        let mut inputs = [0.0; N];
        for lane in 0..N {
            let (from, load) = (states.start(lane), loads.at(lane));
            let end = |input: f32| {
                from.current + self.changed::<true>(&whole, &from, input, &load).current
            };
            let (unfed, fed) = (end(0.0), end(1.0));
            inputs[lane] = unfed / (unfed - fed);
        }
        inputs
    }

    /// As [`Actuator::step_under`], in the lanes that `lasts` still marks. One that refuses its step loses
    /// its mark; what becomes of it here has no meaning.
    #[inline(always)]
    pub(crate) fn steps_under<const N: usize>(
        &self,
        states: &mut States<N>,
        inputs: &Lanes<N>,
        loads: &Loads<N>,
        lasts: &mut [bool; N],
    ) {
        let (before, lasted) = (*states, *lasts);
        match (self.sprung, states.any_rests()) {
            (false, false) => self.slides::<false, false, N>(states, inputs, loads, lasts),
            (false, true) => self.slides::<false, true, N>(states, inputs, loads, lasts),
            (true, false) => self.slides::<true, false, N>(states, inputs, loads, lasts),
            (true, true) => self.slides::<true, true, N>(states, inputs, loads, lasts),
        }
        if lasts != &lasted {
            self.step_through(&before, (states, &lasted), inputs, loads, lasts);
        }
    }

    /// Steps the lanes in which the mode has not lasted, each alone from where it was.
    #[cold]
    #[inline(never)]
    fn step_through<const N: usize>(
        &self,
        before: &States<N>,
        (states, lasted): (&mut States<N>, &[bool; N]),
        inputs: &Lanes<N>,
        loads: &Loads<N>,
        lasts: &mut [bool; N],
    ) {
        for lane in 0..N {
            if lasted[lane] && !lasts[lane] {
                let mut state = before.at(lane);
                let stepped = self.step_under(&mut state, inputs[lane], &loads.at(lane));
                states.put(lane, &state);
                lasts[lane] = stepped.is_ok();
            }
        }
    }

    /// `SPRUNG`: whether there is a spring. `RESTS`: whether a lane is at rest.
    #[inline(always)]
    fn slides<const SPRUNG: bool, const RESTS: bool, const N: usize>(
        &self,
        states: &mut States<N>,
        inputs: &Lanes<N>,
        loads: &Loads<N>,
        lasts: &mut [bool; N],
    ) {
        let whole = Rung::of(self.modes.borrow(), 0);
        let (lower, upper) = (self.lower_stop, self.upper_stop);
        for lane in 0..N {
            let from = states.start(lane);
            let load = loads.at(lane);
            let change = self.changed::<SPRUNG>(&whole, &from, inputs[lane], &load);
            let current = from.current + change.current;
            let (mut velocity, mut position) = (from.velocity, from.position);
            velocity.advance(change.velocity);
            position.advance(change.position);
            let end = End {
                current,
                velocity,
                position,
            };
            let accepted = inputs[lane].abs() <= INPUT_LIMIT;
            let onwards = velocity.value * states.sign[lane] > 0.0;
            let mut slides = onwards & end.is_within(lower, upper);
            if SPRUNG {
                let deflection = from.position.from(self.spring_rest);
                let push = self.push_either(deflection, from.forward);
                let crosses = (deflection + change.position) * push < 0.0;
                slides &= !crosses;
            }
            let lasting = if RESTS && from.rests {
                self.stays::<SPRUNG>(&from, current, &load)
            } else {
                slides
            };
            lasts[lane] &= accepted & lasting;
            // A step of nothing could still move a remainder.
            let kept = |moved: Compensated, still: Compensated| {
                if RESTS && from.rests { still } else { moved }
            };
            let end = End {
                current,
                velocity: kept(velocity, from.velocity),
                position: kept(position, from.position),
            };
            states.numbers.put(lane, &end);
        }
    }

    /// As [`Actuator::step_on`], in all lanes. Those in which the mode does not last lose their mark; what
    /// becomes of them here has no meaning.
    #[inline(always)]
    pub(crate) fn steps_on<const N: usize>(
        &self,
        states: &mut States<N>,
        inputs: &Lanes<N>,
        loads: &Loads<N>,
        lasts: &mut [bool; N],
    ) {
        self.slides::<true, true, N>(states, inputs, loads, lasts);
    }

    /// As [`Actuator::unheld`], in lanes that move.
    #[inline(always)]
    pub(crate) fn unhelds<const N: usize>(
        &self,
        states: &States<N>,
        inputs: &Lanes<N>,
        loads: &Loads<N>,
    ) -> Unhelds<N> {
        let whole = Rung::of(self.modes.borrow(), 0);
        let mut unheld = Unhelds {
            current: [0.0; N],
            velocity: [0.0; N],
            travel: [0.0; N],
            current_give: [0.0; N],
            velocity_give: [0.0; N],
            give: [0.0; N],
        };
        for lane in 0..N {
            let from = states.start(lane);
            let load = loads.at(lane).against(0.0);
            let change = self.changed::<true>(&whole, &from, inputs[lane], &load);
            unheld.current[lane] = change.current;
            unheld.velocity[lane] = change.velocity;
            unheld.travel[lane] = change.position;
            let by_torque = |ahead: &[f32; 5], back: &[f32; 5]| {
                if from.forward { ahead[4] } else { back[4] }
            };
            let (ahead, back) = (&whole.forward, &whole.backward);
            unheld.current_give[lane] = by_torque(&ahead.current, &back.current);
            unheld.velocity_give[lane] = by_torque(&ahead.velocity, &back.velocity);
            unheld.give[lane] = by_torque(&ahead.position, &back.position);
        }
        unheld
    }

    /// As [`Actuator::step_unheld`], with the marks of [`Actuator::steps_on`]; gives the displacements.
    #[inline(always)]
    pub(crate) fn steps_unheld<const N: usize>(
        &self,
        (states, unheld): (&mut States<N>, &Unhelds<N>),
        inputs: &Lanes<N>,
        frictions: &Lanes<N>,
        lasts: &mut [bool; N],
    ) -> Lanes<N> {
        let (lower, upper, sprung) = (self.lower_stop, self.upper_stop, self.sprung);
        let mut moved = [0.0; N];
        for lane in 0..N {
            let from = states.start(lane);
            let friction = frictions[lane];
            let travel = unheld.travel[lane] - friction * unheld.give[lane];
            let current =
                from.current + (unheld.current[lane] - friction * unheld.current_give[lane]);
            let (mut velocity, mut position) = (from.velocity, from.position);
            velocity.advance(unheld.velocity[lane] - friction * unheld.velocity_give[lane]);
            position.advance(travel);
            let end = End {
                current,
                velocity,
                position,
            };
            let accepted = inputs[lane].abs() <= INPUT_LIMIT;
            let deflection = from.position.from(self.spring_rest);
            let push = self.push_either(deflection, from.forward);
            let passes = sprung & ((deflection + travel) * push < 0.0);
            lasts[lane] &= accepted & !from.rests & end.is_within(lower, upper) & !passes;
            moved[lane] = travel;
            states.numbers.put(lane, &end);
            let forward = if velocity.value > 0.0 { 1.0 } else { 0.0 };
            let backward = if velocity.value < 0.0 { -1.0 } else { 0.0 };
            states.sign[lane] = forward + backward;
        }
        moved
    }

    /// Whether a state at rest stays there with this current: as [`Actuator::rest`].
    #[inline(always)]
    fn stays<const SPRUNG: bool>(&self, from: &Start, current: f32, load: &Load) -> bool {
        let drive = self.torque_per_current * current + load.torque;
        let held = (drive <= load.breakaway.forward) & (-drive <= load.breakaway.backward);
        let deflection = from.position.from(self.spring_rest);
        let drive = drive - self.spring * deflection;
        let preload = self.spring_preload;
        let up = if deflection < 0.0 { -preload } else { preload };
        let down = if deflection > 0.0 { -preload } else { preload };
        let stopped_above = from.position.value >= self.upper_stop;
        let stopped_below = from.position.value <= self.lower_stop;
        let forward = !stopped_above & (drive - up - load.breakaway.forward > 0.0);
        let backward = !stopped_below & (-drive - down - load.breakaway.backward > 0.0);
        let finite = current.abs() < f32::INFINITY;
        finite & ((!SPRUNG & held) | !(forward | backward))
    }

    /// As [`Actuator::change`], where `SPRUNG` as in [`Actuator::slid`].
    #[inline(always)]
    fn changed<const SPRUNG: bool>(
        &self,
        rung: &Rung,
        from: &Start,
        input: f32,
        load: &Load,
    ) -> Change {
        let forward = from.forward;
        let mut torque = if forward {
            load.torque - load.coulomb.forward
        } else {
            load.torque + load.coulomb.backward
        };
        let deflection = from.position.from(self.spring_rest);
        if SPRUNG {
            torque -= self.push_either(deflection, forward);
        }
        let change = |ahead: &[f32; 5], back: &[f32; 5]| {
            let row = |column: usize| {
                if forward { ahead[column] } else { back[column] }
            };
            let mut sum = row(0) * from.current + row(1) * from.velocity.value;
            if SPRUNG {
                sum += row(2) * deflection;
            }
            sum + row(3) * input + row(4) * torque
        };
        let (ahead, back) = (&rung.forward, &rung.backward);
        let rested = rung.rest.current * from.current + rung.rest.input * input;
        let slid = Change {
            current: change(&ahead.current, &back.current),
            velocity: change(&ahead.velocity, &back.velocity),
            position: change(&ahead.position, &back.position),
        };
        Change {
            current: if from.rests { rested } else { slid.current },
            velocity: if from.rests { 0.0 } else { slid.velocity },
            position: if from.rests { 0.0 } else { slid.position },
        }
    }

    /// As [`Actuator::push`], either way.
    #[inline(always)]
    fn push_either(&self, deflection: f32, forward: bool) -> f32 {
        let above = (deflection > 0.0) | (forward & (deflection == 0.0));
        if above {
            self.spring_preload
        } else {
            -self.spring_preload
        }
    }
}
