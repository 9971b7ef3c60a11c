//! States side by side.

use super::{Compensated, Motion, State};

/// A number of each lane.
pub(crate) type Lanes<const N: usize> = [f32; N];

/// The lanes' states but for the direction of motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Numbers<const N: usize> {
    pub current: Lanes<N>,
    pub velocity: Lanes<N>,
    velocity_remainder: Lanes<N>,
    pub position: Lanes<N>,
    position_remainder: Lanes<N>,
}

impl<const N: usize> Numbers<N> {
    pub const NOTHING: Self = Self {
        current: [0.0; N],
        velocity: [0.0; N],
        velocity_remainder: [0.0; N],
        position: [0.0; N],
        position_remainder: [0.0; N],
    };

    /// The state in a lane.
    pub fn at(&self, lane: usize, motion: Motion) -> State {
        State {
            current: self.current[lane],
            velocity: self.velocity_at(lane),
            position: self.position_at(lane),
            motion,
        }
    }

    #[inline(always)]
    pub fn velocity_at(&self, lane: usize) -> Compensated {
        Compensated {
            value: self.velocity[lane],
            remainder: self.velocity_remainder[lane],
        }
    }

    #[inline(always)]
    pub fn position_at(&self, lane: usize) -> Compensated {
        Compensated {
            value: self.position[lane],
            remainder: self.position_remainder[lane],
        }
    }

    /// Puts a lane into a state.
    #[inline(always)]
    pub fn put(&mut self, lane: usize, end: &End) {
        self.current[lane] = end.current;
        self.velocity[lane] = end.velocity.value;
        self.velocity_remainder[lane] = end.velocity.remainder;
        self.position[lane] = end.position.value;
        self.position_remainder[lane] = end.position.remainder;
    }

    /// Takes the lanes that are marked from others.
    #[inline(always)]
    pub fn take(&mut self, others: &Self, marked: &[bool; N]) {
        take(&mut self.current, &others.current, marked);
        take(&mut self.velocity, &others.velocity, marked);
        let (own, other) = (&mut self.velocity_remainder, &others.velocity_remainder);
        take(own, other, marked);
        take(&mut self.position, &others.position, marked);
        let (own, other) = (&mut self.position_remainder, &others.position_remainder);
        take(own, other, marked);
    }
}

/// Takes the numbers that are marked from others.
#[inline(always)]
pub(crate) fn take<const N: usize>(own: &mut Lanes<N>, others: &Lanes<N>, marked: &[bool; N]) {
    for lane in 0..N {
        own[lane] = if marked[lane] {
            others[lane]
        } else {
            own[lane]
        };
    }
}

/// What a lane's step ends with.
#[derive(Clone, Copy)]
pub(crate) struct End {
    pub current: f32,
    pub velocity: Compensated,
    pub position: Compensated,
}

impl End {
    pub fn of(state: &State) -> Self {
        Self {
            current: state.current,
            velocity: state.velocity,
            position: state.position,
        }
    }

    /// Whether it is a number and between the stops; each by itself, without the branches of a chain.
    #[inline(always)]
    pub fn is_within(&self, lower: f32, upper: f32) -> bool {
        let spoilt = 0.0 * (self.current + self.velocity.value + self.position.value);
        let below = self.position.value + spoilt <= upper;
        let above = self.position.value >= lower;
        below & above
    }
}
