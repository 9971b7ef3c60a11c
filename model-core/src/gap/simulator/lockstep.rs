//! One simulator on its way through several windows at once, with the same bits as one by one.
//!
//! The lanes have everything in common but where they are and what the log says there, so that a step is
//! a few loops over numbers side by side, which the compiler turns into vectors. A lane in which a mode
//! ends is stepped alone.

use super::{Course, Given, Simulator};
use crate::effect::backlash::follow;
use crate::effect::compliance::{Rigid, Shaft, Twist};
use crate::effect::hysteresis::deflected;
use crate::effect::lanes::Middles;
use crate::effect::learned_map::LearnedMap;
use crate::effect::presliding::{Bristles, Free};
use crate::effect::thermal_drift::ThermalDrift;
use crate::effect::{Memory, Middle};
use crate::gap::held::Acting;
use crate::plant::actuator::lanes::{Loads, States, Unhelds, Ways};
use crate::plant::actuator::{Actuator, External};
use crate::plant::lanes::Lanes;
use crate::plant::modes::Modes;
use crate::plant::{Directional, InputRefused};
use core::borrow::Borrow;

/// Lanes that are stepped one by one sooner than together.
const FEW: usize = 2;

/// What the logs say of a step of each lane.
#[derive(Debug, Clone, Copy)]
pub(in crate::gap) struct Givens<const N: usize> {
    /// As in [`Given`].
    pub input: Lanes<N>,
    /// As in [`Given`].
    pub previous: Lanes<N>,
    /// What acts from outside: a brake's friction.
    pub brake: Lanes<N>,
    /// And a torque or force.
    pub load: Lanes<N>,
    /// And whether the drive lets go of the motor: such a lane is stepped alone.
    pub released: [bool; N],
    /// Whether anything does in a lane.
    pub is_loaded: bool,
    /// As in [`Given`].
    pub index: [usize; N],
    /// The same as numbers.
    pub sample: Lanes<N>,
    /// Lanes that stay where they are.
    pub asleep: [bool; N],
    /// How many do not.
    pub awake: usize,
}

impl<const N: usize> Givens<N> {
    #[inline(always)]
    fn external(&self, lane: usize) -> External {
        External {
            brake: self.brake[lane],
            load: self.load[lane],
            released: self.released[lane],
        }
    }

    /// Adds what acts from outside, where anything does.
    #[inline(always)]
    fn act_on(&self, loads: &mut Loads<N>) {
        if self.is_loaded {
            for lane in 0..N {
                let load = loads.at(lane).under(self.external(lane));
                loads.put(lane, &load);
            }
        }
    }

    fn at(&self, lane: usize) -> Given {
        Given {
            input: self.input[lane],
            previous: self.previous[lane],
            external: self.external(lane),
            index: self.index[lane],
        }
    }
}

/// What the effects remember, side by side.
#[derive(Debug, Clone, Copy)]
struct Memories<const N: usize> {
    far: Lanes<N>,
    friction: Lanes<N>,
    warmth: Lanes<N>,
    deflection: Lanes<N>,
    /// Of the shaft: angle and rate.
    twist: Lanes<N>,
    twist_rate: Lanes<N>,
}

impl<const N: usize> Memories<N> {
    #[inline(always)]
    fn twist_at(&self, lane: usize) -> Twist {
        Twist {
            angle: self.twist[lane],
            rate: self.twist_rate[lane],
        }
    }
}

/// [`Reaction`](crate::effect::compliance::Reaction)s of a shaft side by side.
struct Reactions<const N: usize> {
    torque: Lanes<N>,
    share: Lanes<N>,
}

/// Where the lanes are.
#[derive(Debug, Clone, Copy)]
struct Courses<const N: usize> {
    states: States<N>,
    memories: Memories<N>,
}

impl<const N: usize> Courses<N> {
    fn at(&self, lane: usize) -> Course {
        Course {
            state: self.states.at(lane),
            memory: Memory {
                far: self.memories.far[lane],
                friction: self.memories.friction[lane],
                warmth: self.memories.warmth[lane],
                deflection: self.memories.deflection[lane],
                twist: self.memories.twist_at(lane),
            },
        }
    }

    /// Takes the lanes that are marked from others.
    #[inline(always)]
    fn take(&mut self, others: &Self, marked: &[bool; N]) {
        self.states.take(&others.states, marked);
        let (own, other) = (&mut self.memories, &others.memories);
        for lane in 0..N {
            if marked[lane] {
                own.far[lane] = other.far[lane];
                own.friction[lane] = other.friction[lane];
                own.warmth[lane] = other.warmth[lane];
                own.deflection[lane] = other.deflection[lane];
                own.twist[lane] = other.twist[lane];
                own.twist_rate[lane] = other.twist_rate[lane];
            }
        }
    }

    fn put(&mut self, lane: usize, course: &Course) {
        self.states.put(lane, &course.state);
        self.memories.far[lane] = course.memory.far;
        self.memories.friction[lane] = course.memory.friction;
        self.memories.warmth[lane] = course.memory.warmth;
        self.memories.deflection[lane] = course.memory.deflection;
        self.memories.twist[lane] = course.memory.twist.angle;
        self.memories.twist_rate[lane] = course.memory.twist.rate;
    }
}

/// A simulator in several windows.
#[derive(Debug, Clone)]
pub(in crate::gap) struct Lockstep<'a, M, H, const N: usize> {
    simulator: &'a Simulator<M, H>,
    map: Option<LearnedMap>,
    heating: Option<ThermalDrift>,
    courses: Courses<N>,
}

impl<'a, M: Borrow<Modes>, H: Acting, const N: usize> Lockstep<'a, M, H, N> {
    /// Starts from these courses.
    pub fn new(simulator: &'a Simulator<M, H>, courses: &[Course; N]) -> Self {
        let mut lanes = Courses {
            states: States::NOTHING,
            memories: Memories {
                far: [0.0; N],
                friction: [0.0; N],
                warmth: [0.0; N],
                deflection: [0.0; N],
                twist: [0.0; N],
                twist_rate: [0.0; N],
            },
        };
        for (lane, course) in courses.iter().enumerate() {
            lanes.put(lane, course);
        }
        Self {
            simulator,
            map: simulator.held.map(),
            heating: simulator.heating(),
            courses: lanes,
        }
    }

    /// The simulator.
    #[inline(always)]
    pub fn simulator(&self) -> &'a Simulator<M, H> {
        self.simulator
    }

    /// Where a lane is.
    pub fn at(&self, lane: usize) -> Course {
        self.courses.at(lane)
    }

    /// Puts a lane somewhere else.
    pub fn put(&mut self, lane: usize, course: &Course) {
        self.courses.put(lane, course);
    }

    /// The windings' currents.
    #[inline(always)]
    pub fn currents(&self) -> Lanes<N> {
        self.courses.states.numbers.current
    }

    /// The drives' velocities.
    #[inline(always)]
    pub fn velocities(&self) -> &Lanes<N> {
        &self.courses.states.numbers.velocity
    }

    /// As [`Simulator::reported_from`].
    #[inline(always)]
    pub fn reported_from(&self, measured: &Lanes<N>) -> Lanes<N> {
        let Courses { states, memories } = &self.courses;
        let mut distances = [0.0; N];
        let played = self.simulator.half_play().is_some();
        for lane in 0..N {
            distances[lane] = if played {
                memories.far[lane] - measured[lane]
            } else {
                states.numbers.position_at(lane).from(measured[lane]) + memories.twist[lane]
            };
        }
        let reading = &self.simulator.reading;
        if !reading.is_nothing() {
            for lane in 0..N {
                let sensed = if played {
                    memories.far[lane]
                } else {
                    states.numbers.position[lane] + memories.twist[lane]
                };
                distances[lane] += reading.error(sensed);
            }
        }
        distances
    }

    /// As [`Simulator::step`], with the current where a step is refused.
    #[inline(always)]
    pub fn step(&mut self, given: &Givens<N>) -> Lanes<N> {
        let before = self.courses;
        if given.awake <= FEW {
            let mut currents = [0.0; N];
            self.step_alone(&before, given, &given.asleep, &mut currents);
            return currents;
        }
        // Not `map`, whose closure is no part of this loop where the vectors are wider than the program's.
        let mut lasts = [true; N];
        for lane in 0..N {
            lasts[lane] = !given.asleep[lane];
        }
        let mut currents = self.step_actuators(given, &mut lasts);
        let Courses { states, memories } = &mut self.courses;
        if let Some(heating) = self.heating {
            let period = self.simulator.period;
            for lane in 0..N {
                let warmth = &mut memories.warmth[lane];
                *warmth = heating.after(*warmth, states.numbers.current[lane], period);
            }
        }
        if let Some(half_play) = self.simulator.half_play() {
            for lane in 0..N {
                let near = states.numbers.position[lane] + memories.twist[lane];
                memories.far[lane] = follow(memories.far[lane], near, half_play);
            }
        }
        if given.is_loaded {
            for lane in 0..N {
                lasts[lane] &= !given.released[lane];
            }
        }
        if given.awake < N {
            self.courses.take(&before, &given.asleep);
            for lane in 0..N {
                lasts[lane] |= given.asleep[lane];
            }
        }
        if !all(&lasts) {
            self.step_alone(&before, given, &lasts, &mut currents);
        }
        currents
    }

    /// Steps the lanes that together could not be stepped, from where they were.
    #[cold]
    #[inline(never)]
    fn step_alone(
        &mut self,
        before: &Courses<N>,
        given: &Givens<N>,
        lasts: &[bool; N],
        currents: &mut Lanes<N>,
    ) {
        for lane in 0..N {
            if !lasts[lane] {
                let mut course = before.at(lane);
                let stepped: Result<f32, InputRefused> =
                    self.simulator.step(&mut course, &given.at(lane));
                currents[lane] = stepped.unwrap_or(course.state.current);
                self.courses.put(lane, &course);
            }
        }
    }

    #[inline(always)]
    fn step_actuators(&mut self, given: &Givens<N>, lasts: &mut [bool; N]) -> Lanes<N> {
        let simulator = self.simulator;
        let before = self.courses.states.numbers.current;
        let (split, moment) = (simulator.input.share, simulator.current.share);
        let own = simulator.actuator.on(simulator.actuator.modes());
        let first = match &simulator.earlier {
            Some(earlier) => simulator.actuator.on(earlier.borrow()),
            None => own,
        };
        let whole = simulator.earlier.is_none();
        let mut between = before;
        // A loop instead of two calls: what is below is compiled into this once.
        let ways = [
            (&first, split, &given.previous),
            (&own, 1.0 - split, &given.input),
        ];
        for (actuator, share, inputs) in ways.into_iter().skip(usize::from(whole)) {
            between = self.courses.states.numbers.current;
            self.advance((actuator, share), inputs, given, lasts);
        }
        let mut currents = before;
        for lane in 0..N {
            let after = self.courses.states.numbers.current[lane];
            currents[lane] = if whole {
                before[lane] + moment * (after - before[lane])
            } else if moment <= split {
                before[lane] + moment / split * (between[lane] - before[lane])
            } else {
                between[lane] + (moment - split) / (1.0 - split) * (after - between[lane])
            };
        }
        currents
    }

    /// As [`Simulator::advance`].
    #[inline(always)]
    fn advance(
        &mut self,
        (actuator, share): (&Actuator<&Modes>, f32),
        inputs: &Lanes<N>,
        given: &Givens<N>,
        lasts: &mut [bool; N],
    ) {
        let simulator = self.simulator;
        let drive = (
            actuator,
            share * simulator.period / f32::from(simulator.parts),
        );
        let shaft = simulator.shaft();
        let bristles = simulator.yielding();
        if bristles.is_none() && shaft.is_none() && simulator.held.is_nothing() {
            let mut loads = Loads::all(&actuator.load());
            given.act_on(&mut loads);
            actuator.steps_under(&mut self.courses.states, inputs, &loads, lasts);
            return;
        }
        for _ in 0..simulator.parts {
            let before = self.courses.states;
            match bristles {
                Some(bristles) => self.advance_yielding(drive, bristles, inputs, given, lasts),
                None => self.advance_held(drive, inputs, given, lasts),
            }
            if let Some(shaft) = shaft {
                self.twist(shaft, &before, drive.1, lasts);
            }
            if let Some(reach) = simulator.reach {
                let Courses { states, memories } = &mut self.courses;
                for lane in 0..N {
                    let last = before.numbers.position[lane];
                    let displacement = states.numbers.position[lane] - last;
                    let deflection = &mut memories.deflection[lane];
                    *deflection = deflected(*deflection, displacement, reach);
                }
            }
        }
    }

    /// As [`Simulator::advance_twisted`] behind the drive's step.
    #[inline(always)]
    fn twist(&mut self, shaft: &Shaft, before: &States<N>, length: f32, lasts: &mut [bool; N]) {
        let Courses { states, memories } = &mut self.courses;
        for lane in 0..N {
            let twist = shaft.after(memories.twist_at(lane), states.gain(before, lane), length);
            memories.twist[lane] = twist.angle;
            memories.twist_rate[lane] = twist.rate;
            lasts[lane] &= twist.angle.is_finite() & twist.rate.is_finite();
        }
    }

    /// As [`Simulator::advance_held`].
    #[inline(always)]
    fn advance_held(
        &mut self,
        drive: (&Actuator<&Modes>, f32),
        inputs: &Lanes<N>,
        given: &Givens<N>,
        lasts: &mut [bool; N],
    ) {
        let actuator = drive.0;
        let mut middle = self.starts(inputs, given);
        let alone = self.simulator.held.is_nothing();
        // From the start to the middle, and from there on: a loop, for the laws are compiled into it.
        for ahead in [true, false].into_iter().skip(usize::from(alone)) {
            let loads = self.loads_at(&middle, given);
            self.exceed(&mut middle, actuator, inputs, &loads);
            let fed = self.fed(inputs, &middle);
            let loads = self.twisted(drive, &fed, &loads);
            let states = &mut self.courses.states;
            if ahead {
                let ways = actuator.middles(states, &fed, &loads);
                self.go(&mut middle, &ways);
            } else {
                if self.simulator.shaft().is_some() {
                    actuator.hold(states, &fed, &loads, lasts);
                }
                actuator.steps_under(states, &fed, &loads, lasts);
            }
        }
    }

    /// As [`Simulator::twisted`].
    #[inline(always)]
    fn twisted(
        &self,
        (actuator, length): (&Actuator<&Modes>, f32),
        inputs: &Lanes<N>,
        loads: &Loads<N>,
    ) -> Loads<N> {
        let mut twisted = *loads;
        if let Some(shaft) = self.simulator.shaft() {
            let states = &self.courses.states;
            let unheld = actuator.unhelds(states, inputs, loads);
            let frictions = loads.frictions(states);
            twisted.add(&self.reactions(shaft, &unheld, &frictions, length).torque);
        }
        twisted
    }

    /// As [`super::reaction`].
    #[inline(always)]
    fn reactions(
        &self,
        shaft: &Shaft,
        unheld: &Unhelds<N>,
        frictions: &Lanes<N>,
        length: f32,
    ) -> Reactions<N> {
        let Courses { states, memories } = &self.courses;
        let mut reactions = Reactions {
            torque: [0.0; N],
            share: [0.0; N],
        };
        for lane in 0..N {
            let rests = states.rests(lane);
            let moving = |number: f32| if rests { 0.0 } else { number };
            let rigid = Rigid {
                gain: moving(unheld.gain(lane, frictions[lane])),
                give: moving(unheld.quickening(lane)),
                length,
            };
            let reaction = shaft.reaction(memories.twist_at(lane), &rigid);
            reactions.torque[lane] = reaction.torque;
            reactions.share[lane] = reaction.share;
        }
        reactions
    }

    /// As [`Simulator::advance_yielding`].
    #[inline(always)]
    fn advance_yielding(
        &mut self,
        (actuator, length): (&Actuator<&Modes>, f32),
        bristles: &Bristles,
        inputs: &Lanes<N>,
        given: &Givens<N>,
        lasts: &mut [bool; N],
    ) {
        let before = self.courses.states;
        let forces = self.courses.memories.friction;
        let alone = self.simulator.held.is_nothing();
        let mut middle = self.starts(inputs, given);
        let mut fed = *inputs;
        let mut loads = Loads::all(&actuator.load());
        let mut slid = (before, [false; N]);
        for ahead in [true, false] {
            loads = self.loads_at(&middle, given);
            let against = loads.against(&forces);
            self.exceed(&mut middle, actuator, inputs, &against);
            fed = self.fed(inputs, &middle);
            // Alone, they are under the same load all the time.
            if alone == ahead {
                let twisted = self.twisted((actuator, length), &fed, &loads);
                slid = slide_on((actuator, bristles), (&before, &forces), &fed, &twisted);
                if all(&slid.1) {
                    self.courses.states = slid.0;
                    return;
                }
            }
            if ahead {
                let against = self.twisted((actuator, length), &fed, &against);
                let ways = actuator.middles(&before, &fed, &against);
                self.go(&mut middle, &ways);
            }
        }
        let mut unheld = actuator.unhelds(&before, &fed, &loads);
        let (mut ahead, mut back) = ([0.0; N], [0.0; N]);
        for lane in 0..N {
            let levels = bristles.levels(&loads.at(lane), middle.velocity[lane]);
            ahead[lane] = levels.forward;
            back[lane] = levels.backward;
        }
        let levels = |lane: usize| Directional {
            forward: ahead[lane],
            backward: back[lane],
        };
        let reactions = self
            .simulator
            .shaft()
            .map(|shaft| self.reactions(shaft, &unheld, &[0.0; N], length));
        let free = |lane: usize| {
            let (travel, give) = (unheld.travel[lane], unheld.give[lane]);
            match &reactions {
                Some(reactions) => Free {
                    travel: travel + reactions.torque[lane] * give,
                    give: give + reactions.share[lane] * give,
                    length,
                },
                None => Free {
                    travel,
                    give,
                    length,
                },
            }
        };
        let frictions = bristles.all_held((&forces, &slid.1), free, levels);
        if let Some(reactions) = &reactions {
            for lane in 0..N {
                let torque = reactions.torque[lane] - reactions.share[lane] * frictions[lane];
                unheld.load(lane, torque);
            }
        }
        let Courses { states, memories } = &mut self.courses;
        let mut yielded = [true; N];
        let moved = actuator.steps_unheld((states, &unheld), &fed, &frictions, &mut yielded);
        if any(&slid.1) {
            states.take(&slid.0, &slid.1);
        }
        for lane in 0..N {
            let level = levels(lane).of(moved[lane]);
            let after = bristles.after(forces[lane], moved[lane], level);
            let slides = slid.1[lane];
            memories.friction[lane] = if slides { forces[lane] } else { after };
            lasts[lane] &= slides | yielded[lane];
        }
    }

    /// As [`Simulator::start`].
    #[inline(always)]
    fn starts(&self, inputs: &Lanes<N>, given: &Givens<N>) -> Middles<N> {
        let simulator = self.simulator;
        let Courses { states, memories } = &self.courses;
        Middles {
            common: Middle {
                torque_constant: simulator.winding.torque_constant,
                resistance: simulator.winding.resistance,
                step: simulator.period,
                ..Middle::default()
            },
            motor_torque: scaled(&states.numbers.current, simulator.winding.torque(1.0)),
            warmth: memories.warmth,
            voltage: scaled(inputs, simulator.gain),
            excess: [0.0; N],
            velocity: states.numbers.velocity,
            position: states.numbers.position,
            deflection: memories.deflection,
            time: scaled(&given.sample, simulator.period),
        }
    }

    /// As [`Simulator::behind`].
    #[inline(always)]
    fn go(&self, middle: &mut Middles<N>, ways: &Ways<N>) {
        middle.motor_torque = scaled(&ways.current, self.simulator.winding.torque(1.0));
        for lane in 0..N {
            middle.velocity[lane] = ways.velocity[lane];
            middle.position[lane] += ways.travel[lane];
        }
        if let Some(reach) = self.simulator.reach {
            for lane in 0..N {
                let deflection = &mut middle.deflection[lane];
                *deflection = deflected(*deflection, ways.travel[lane], reach);
            }
        }
    }

    /// As [`Simulator::load_at`].
    #[inline(always)]
    fn loads_at(&self, middles: &Middles<N>, given: &Givens<N>) -> Loads<N> {
        let mut loads = Loads::all(&self.simulator.actuator.load());
        for law in self.simulator.held.laws() {
            law.hold_all(middles, &mut loads);
        }
        if let Some(map) = &self.map {
            map.hold_all(middles, &mut loads);
        }
        given.act_on(&mut loads);
        loads
    }

    /// As [`Simulator::excess`].
    #[inline(always)]
    fn exceed(
        &self,
        middles: &mut Middles<N>,
        actuator: &Actuator<&Modes>,
        inputs: &Lanes<N>,
        loads: &Loads<N>,
    ) {
        middles.excess = [0.0; N];
        if self.simulator.electric {
            let ends = actuator.inputs_that_end_current(&self.courses.states, loads);
            let gain = self.simulator.gain;
            for lane in 0..N {
                middles.excess[lane] = gain * inputs[lane] - gain * ends[lane];
            }
        }
    }

    /// As [`Simulator::fed`].
    #[inline(always)]
    fn fed(&self, inputs: &Lanes<N>, middles: &Middles<N>) -> Lanes<N> {
        let mut fed = *inputs;
        if self.simulator.electric {
            let mut left = *middles;
            let mut sums = [0.0; N];
            for law in self.simulator.held.laws() {
                let voltages = law.voltages(&left);
                for lane in 0..N {
                    left.excess[lane] += voltages[lane];
                    sums[lane] += voltages[lane];
                }
            }
            for lane in 0..N {
                fed[lane] = inputs[lane] + sums[lane] / self.simulator.gain;
            }
        }
        fed
    }
}

/// As [`super::slide_on`]: where they come to, and which of them do slide.
#[inline(always)]
fn slide_on<const N: usize>(
    (actuator, bristles): (&Actuator<&Modes>, &Bristles),
    (states, forces): (&States<N>, &Lanes<N>),
    inputs: &Lanes<N>,
    loads: &Loads<N>,
) -> (States<N>, [bool; N]) {
    let slide = |lane: usize, states: &States<N>| {
        let velocity = states.numbers.velocity[lane];
        bristles.slide(forces[lane], loads.at(lane).coulomb, velocity)
    };
    let mut ends = *states;
    let mut slides = [false; N];
    for lane in 0..N {
        slides[lane] = slide(lane, states);
    }
    // Where the machine rests, none does.
    if any(&slides) {
        actuator.steps_on(&mut ends, inputs, loads, &mut slides);
        for lane in 0..N {
            slides[lane] &= slide(lane, &ends);
        }
    }
    (ends, slides)
}

/// Whether one is marked.
#[inline(always)]
fn any<const N: usize>(marks: &[bool; N]) -> bool {
    marks.iter().fold(false, |any, &mark| any | mark)
}

/// Whether all are marked.
#[inline(always)]
fn all<const N: usize>(marks: &[bool; N]) -> bool {
    marks.iter().fold(true, |all, &mark| all & mark)
}

#[inline(always)]
fn scaled<const N: usize>(numbers: &Lanes<N>, factor: f32) -> Lanes<N> {
    let mut scaled = *numbers;
    for number in &mut scaled {
        *number *= factor;
    }
    scaled
}
