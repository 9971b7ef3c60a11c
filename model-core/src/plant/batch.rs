//! Many actuators stepped at once, with the same bits as one by one.
//!
//! In a mode a step is a straight line of products and sums, the same for every mode: only the numbers
//! differ. So each lane keeps the coefficients of its own mode, and a step is one loop over the lanes
//! without a branch, which the compiler turns into vectors. A lane in which the mode may not last is
//! found by comparisons and stepped alone, by [`Actuator::step`] from where it was; that is also what
//! takes it into its next mode.

use super::actuator::{Actuator, INPUT_LIMIT};
use super::lanes::{End, Lanes, Numbers};
use super::modes::{Increment, Modes};
use super::{Compensated, InputRefused, Motion, State};
use core::borrow::Borrow;

/// Coefficients of a row of the modes.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Row<const N: usize> {
    current: Lanes<N>,
    velocity: Lanes<N>,
    deflection: Lanes<N>,
    input: Lanes<N>,
    torque: Lanes<N>,
    /// The torque's share where it is constant in the mode.
    constant: Lanes<N>,
}

/// What the lanes' modes are made of.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Held<const N: usize> {
    current: Row<N>,
    velocity: Row<N>,
    position: Row<N>,
    /// 1 forwards, −1 backwards, 0 at rest.
    sign: Lanes<N>,
    /// The stops; at rest there are none.
    lower: Lanes<N>,
    upper: Lanes<N>,
    spring_rest: Lanes<N>,
    /// Torque but for the preload, and the preload.
    torque: Lanes<N>,
    preload: Lanes<N>,
    /// Torque at rest: that of a current, the constant one, that of the spring.
    torque_per_current: Lanes<N>,
    load: Lanes<N>,
    spring: Lanes<N>,
    /// What holds against it, by the preload and by friction; infinite while sliding.
    up: Lanes<N>,
    down: Lanes<N>,
    breakaway_forward: Lanes<N>,
    breakaway_backward: Lanes<N>,
}

impl<const N: usize> Row<N> {
    const NOTHING: Self = Self {
        current: [0.0; N],
        velocity: [0.0; N],
        deflection: [0.0; N],
        input: [0.0; N],
        torque: [0.0; N],
        constant: [0.0; N],
    };

    /// Takes a row of a sliding mode, under a torque.
    fn set(&mut self, lane: usize, row: &[f32; 5], torque: f32) {
        self.current[lane] = row[0];
        self.velocity[lane] = row[1];
        self.deflection[lane] = row[2];
        self.input[lane] = row[3];
        self.torque[lane] = row[4];
        self.constant[lane] = row[4] * torque;
    }

    /// Takes a row of rest. What a sum of −0 is added to keeps its sign.
    fn set_rest(&mut self, lane: usize, current: f32, input: f32) {
        self.set(lane, &[current, -0.0, -0.0, input, -0.0], 0.0);
    }

    /// The change in a step, summed as [`Actuator::step`] does it.
    #[inline(always)]
    fn change<const SPRUNG: bool>(&self, lane: usize, from: &Start) -> f32 {
        let sum = self.current[lane] * from.current + self.velocity[lane] * from.velocity;
        if SPRUNG {
            let sum = sum + self.deflection[lane] * from.deflection;
            sum + self.input[lane] * from.input + self.torque[lane] * from.torque
        } else {
            sum + self.input[lane] * from.input + self.constant[lane]
        }
    }
}

/// What a lane's changes are worked out from.
struct Start {
    current: f32,
    velocity: f32,
    deflection: f32,
    input: f32,
    torque: f32,
}

impl<const N: usize> Held<N> {
    const NOTHING: Self = Self {
        current: Row::NOTHING,
        velocity: Row::NOTHING,
        position: Row::NOTHING,
        sign: [0.0; N],
        lower: [0.0; N],
        upper: [0.0; N],
        spring_rest: [0.0; N],
        torque: [0.0; N],
        preload: [0.0; N],
        torque_per_current: [0.0; N],
        load: [0.0; N],
        spring: [0.0; N],
        up: [0.0; N],
        down: [0.0; N],
        breakaway_forward: [0.0; N],
        breakaway_backward: [0.0; N],
    };

    /// Takes the mode that a lane is in.
    fn enter<M: Borrow<Modes>>(&mut self, lane: usize, actuator: &Actuator<M>, state: &State) {
        let mode = actuator.mode(state);
        self.spring_rest[lane] = mode.spring_rest;
        self.torque_per_current[lane] = mode.torque_per_current;
        self.load[lane] = mode.load;
        match mode.sliding {
            Some(sliding) => {
                let Increment {
                    current,
                    velocity,
                    position,
                } = sliding.increment;
                self.current.set(lane, current, sliding.torque);
                self.velocity.set(lane, velocity, sliding.torque);
                self.position.set(lane, position, sliding.torque);
                self.torque[lane] = sliding.torque;
                self.preload[lane] = mode.preload;
                self.sign[lane] = state.motion.sign();
                (self.lower[lane], self.upper[lane]) = mode.stops;
                (self.up[lane], self.down[lane]) = (f32::INFINITY, f32::INFINITY);
            }
            None => {
                self.current
                    .set_rest(lane, mode.rest.current, mode.rest.input);
                self.velocity.set_rest(lane, -0.0, -0.0);
                self.position.set_rest(lane, -0.0, -0.0);
                (self.torque[lane], self.preload[lane]) = (0.0, 0.0);
                self.sign[lane] = 0.0;
                // Adding nothing would change the bits of a state that no step leaves behind.
                let limit = if stands(state) {
                    f32::INFINITY
                } else {
                    f32::NEG_INFINITY
                };
                (self.lower[lane], self.upper[lane]) = (-limit, limit);
                self.spring[lane] = mode.spring;
                (self.up[lane], self.down[lane]) = mode.held;
                self.breakaway_forward[lane] = mode.breakaway.forward;
                self.breakaway_backward[lane] = mode.breakaway.backward;
            }
        }
    }

    /// A step of every lane as if its mode lasted, and whether it does.
    ///
    /// `RESTS`: whether a lane is at rest. `SPRUNG`: whether the lanes have springs.
    #[inline(always)]
    fn advance<const SPRUNG: bool, const RESTS: bool>(
        &self,
        old: &Numbers<N>,
        new: &mut Numbers<N>,
        inputs: &Lanes<N>,
        lasts: &mut [bool; N],
    ) {
        for lane in 0..N {
            let mut velocity = old.velocity_at(lane);
            let mut position = old.position_at(lane);
            let deflection = position.from(self.spring_rest[lane]);
            let push = self.push::<SPRUNG>(lane, deflection);
            let from = Start {
                current: old.current[lane],
                velocity: velocity.value,
                deflection,
                input: inputs[lane],
                torque: self.torque[lane] - push,
            };
            let travel = self.position.change::<SPRUNG>(lane, &from);
            let current = from.current + self.current.change::<SPRUNG>(lane, &from);
            velocity.advance(self.velocity.change::<SPRUNG>(lane, &from));
            position.advance(travel);
            let end = End {
                current,
                velocity,
                position,
            };

            let accepted = from.input.abs() <= INPUT_LIMIT;
            let within = end.is_within(self.lower[lane], self.upper[lane]);
            let sign = self.sign[lane];
            let mut onwards = velocity.value() * sign > 0.0;
            if RESTS {
                onwards |= (sign == 0.0) & self.holds(lane, current);
            }
            let mut lasting = accepted & within & onwards;
            if SPRUNG {
                let crosses = (deflection + travel) * push < 0.0;
                lasting &= !crosses;
            }
            lasts[lane] = lasting;
            new.put(lane, &end);
        }
    }

    /// The preload with the sign of the side of the spring's rest that a lane slides on.
    #[inline(always)]
    fn push<const SPRUNG: bool>(&self, lane: usize, deflection: f32) -> f32 {
        if !SPRUNG {
            return 0.0;
        }
        let ahead = (deflection == 0.0) & (self.sign[lane] > 0.0);
        if (deflection > 0.0) | ahead {
            self.preload[lane]
        } else {
            -self.preload[lane]
        }
    }

    /// The breakaway test of a lane at rest.
    #[inline(always)]
    fn holds(&self, lane: usize, current: f32) -> bool {
        let drive = self.torque_per_current[lane] * current + self.load[lane] - self.spring[lane];
        let forward = drive - self.up[lane] - self.breakaway_forward[lane];
        let backward = -drive - self.down[lane] - self.breakaway_backward[lane];
        let starts = (forward > 0.0) | (backward > 0.0);
        !starts
    }
}

/// Whether a step of nothing leaves the bits of a state at rest as they are.
fn stands(state: &State) -> bool {
    let mut position = state.position;
    position.advance(0.0);
    bits(state.velocity) == [0, 0] && bits(position) == bits(state.position)
}

fn bits(sum: Compensated) -> [u32; 2] {
    [sum.value.to_bits(), sum.remainder.to_bits()]
}

/// Actuators side by side, each with its own parameters, state and input.
///
/// As fast as its lanes are many: with eight the sums of a step wait for each other, with 32 they do
/// not. On a processor without vectors it is [`Actuator::step`] and some copying.
///
/// ```
/// # use model_core::plant::{Directional, State, actuator::Actuator, batch::Batch};
/// # use model_core::plant::parameters::{Drive, Parameters};
/// # let declared = Parameters {
/// #     drive: Drive::Voltage { resistance: 1.0, inductance: 1e-3, torque_constant: 0.06 },
/// #     viscous: Directional::both(2e-4),
/// #     coulomb: Directional::both(0.12),
/// #     breakaway: Directional::both(0.15),
/// #     ..Parameters::free(1.2e-4)
/// # };
/// let actuators = [0.10, 0.12, 0.14, 0.16].map(|coulomb| {
///     let plant = Parameters { coulomb: Directional::both(coulomb), ..declared };
///     Actuator::build(&plant, 1e-4).unwrap()
/// });
/// let mut batch = Batch::new(actuators, [State::default(); 4]);
/// let mut alone = State::default();
/// for _ in 0..10_000 {
///     batch.step(&[12.0; 4])?;
///     actuators[2].step(&mut alone, 12.0)?;
/// }
/// assert_eq!(batch.state(2), alone);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Batch<M, const N: usize> {
    actuators: [Actuator<M>; N],
    motion: [Motion; N],
    held: Held<N>,
    /// The lanes' states now and in the step before, and which is now.
    numbers: [Numbers<N>; 2],
    now: usize,
    /// Lanes at rest.
    resting: usize,
    sprung: bool,
}

impl<M: Borrow<Modes>, const N: usize> Batch<M, N> {
    /// Actuators and where they are.
    pub fn new(actuators: [Actuator<M>; N], states: [State; N]) -> Self {
        let sprung = actuators.iter().any(Actuator::is_sprung);
        let mut batch = Self {
            actuators,
            motion: [Motion::Rest; N],
            held: Held::NOTHING,
            numbers: [Numbers::NOTHING; 2],
            now: 0,
            resting: N,
            sprung,
        };
        for (lane, state) in states.iter().enumerate() {
            batch.put(lane, state);
        }
        batch
    }

    /// Where a lane is.
    ///
    /// # Panics
    /// Beyond the last lane.
    pub fn state(&self, lane: usize) -> State {
        self.state_in(self.now, lane)
    }

    fn state_in(&self, now: usize, lane: usize) -> State {
        self.numbers[now].at(lane, self.motion[lane])
    }

    /// Puts a lane where it is to be now, in the mode that it is in there.
    fn put(&mut self, lane: usize, state: &State) {
        self.numbers[self.now].put(lane, &End::of(state));
        self.resting -= usize::from(self.motion[lane] == Motion::Rest);
        self.resting += usize::from(state.motion == Motion::Rest);
        self.motion[lane] = state.motion;
        self.held.enter(lane, &self.actuators[lane], state);
    }

    /// One step of every lane, with its input held over it: as [`Actuator::step`].
    ///
    /// # Errors
    /// [`InputRefused`] if a lane refuses its input: it is where it was, and the others are stepped.
    #[inline(always)]
    pub fn step(&mut self, inputs: &[f32; N]) -> Result<(), InputRefused> {
        let mut lasts = [true; N];
        let [first, second] = &mut self.numbers;
        let (old, new) = if self.now == 0 {
            (&*first, second)
        } else {
            (&*second, first)
        };
        match (self.sprung, self.resting > 0) {
            (false, false) => self
                .held
                .advance::<false, false>(old, new, inputs, &mut lasts),
            (false, true) => self
                .held
                .advance::<false, true>(old, new, inputs, &mut lasts),
            (true, false) => self
                .held
                .advance::<true, false>(old, new, inputs, &mut lasts),
            (true, true) => self
                .held
                .advance::<true, true>(old, new, inputs, &mut lasts),
        }
        let before = self.now;
        self.now = 1 - before;
        if lasts.iter().fold(true, |all, &lasts| all & lasts) {
            return Ok(());
        }
        self.step_alone(before, inputs, &lasts)
    }

    /// Steps the lanes in which the mode may not last.
    #[cold]
    #[inline(never)]
    fn step_alone(
        &mut self,
        before: usize,
        inputs: &[f32; N],
        lasts: &[bool; N],
    ) -> Result<(), InputRefused> {
        let mut stepped = Ok(());
        for lane in 0..N {
            if !lasts[lane] {
                let mut state = self.state_in(before, lane);
                stepped = stepped.and(self.actuators[lane].step(&mut state, inputs[lane]));
                self.put(lane, &state);
            }
        }
        stepped
    }
}
