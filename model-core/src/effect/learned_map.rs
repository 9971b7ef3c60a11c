//! A torque or a friction level learned as a function of one variable: what is left when no effect
//! of the catalogue explains a residual. It says where the unknown lives, not what it is.

use super::Middle;
use super::lanes::Middles;
use crate::plant::actuator::Load;
use crate::plant::actuator::lanes::Loads;
use crate::plant::lanes::Lanes;
use crate::unit::Dimension;

/// Knots of the piecewise linear map.
pub const KNOTS: usize = 10;

/// What a map depends on and how it acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Kind {
    /// A torque over position, the same in both directions.
    PositionTorque,
    /// Friction over position.
    PositionFriction,
    /// A torque over velocity, its own in each direction.
    VelocityTorque,
    /// Friction over the speed: any law that is the same in both directions.
    SpeedFriction,
    /// A torque over current: a motor that is not linear.
    CurrentTorque,
    /// Friction over the motor torque's magnitude.
    LoadFriction,
    /// A torque over time: somebody pushes.
    TimeTorque,
    /// Friction over time: it warms up or wears.
    TimeFriction,
}

impl Kind {
    /// Every kind.
    pub const ALL: [Self; 8] = [
        Self::PositionTorque,
        Self::PositionFriction,
        Self::VelocityTorque,
        Self::SpeedFriction,
        Self::CurrentTorque,
        Self::LoadFriction,
        Self::TimeTorque,
        Self::TimeFriction,
    ];

    /// The variable that it depends on, as the contract names it.
    pub fn variable(self) -> &'static str {
        match self {
            Self::PositionTorque | Self::PositionFriction => "position",
            Self::VelocityTorque | Self::SpeedFriction => "velocity",
            Self::CurrentTorque => "current",
            Self::LoadFriction => "load",
            Self::TimeTorque | Self::TimeFriction => "time",
        }
    }

    /// What it is: a torque or a friction.
    pub fn acts_as(self) -> &'static str {
        if self.is_friction() {
            "friction"
        } else {
            "torque"
        }
    }

    /// What that variable is measured as: of a current, and of a load, it is the motor's torque.
    pub fn dimension(self) -> Dimension {
        match self {
            Self::PositionTorque | Self::PositionFriction => Dimension::Position,
            Self::VelocityTorque | Self::SpeedFriction => Dimension::Velocity,
            Self::CurrentTorque | Self::LoadFriction => Dimension::Torque,
            Self::TimeTorque | Self::TimeFriction => Dimension::Time,
        }
    }

    /// Whether it is a friction level, which opposes motion and holds at rest.
    pub fn is_friction(self) -> bool {
        matches!(
            self,
            Self::PositionFriction | Self::SpeedFriction | Self::LoadFriction | Self::TimeFriction
        )
    }
}

/// Ranges of the variables over a log: where the knots of a map are laid.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ranges {
    /// Smallest and largest position.
    pub position: (f32, f32),
    /// Smallest and largest velocity, without rare peaks.
    pub velocity: (f32, f32),
    /// Smallest and largest motor torque.
    pub motor_torque: (f32, f32),
    /// First and last time, s.
    pub time: (f32, f32),
}

/// A piecewise linear torque or friction level over one variable, constant beyond its ends.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LearnedMap {
    /// What it depends on and how it acts.
    pub kind: Kind,
    /// N·m or N at evenly spaced values of the variable.
    pub knots: [f32; KNOTS],
    lower: f32,
    inverse_spacing: f32,
}

impl LearnedMap {
    /// A map of zeros over the range of its variable.
    pub fn flat(kind: Kind, ranges: &Ranges) -> Self {
        let magnitude = |(lowest, highest): (f32, f32)| (0.0, highest.max(-lowest));
        let (lower, upper) = match kind {
            Kind::PositionTorque | Kind::PositionFriction => ranges.position,
            Kind::VelocityTorque => ranges.velocity,
            Kind::SpeedFriction => magnitude(ranges.velocity),
            Kind::CurrentTorque => ranges.motor_torque,
            Kind::LoadFriction => magnitude(ranges.motor_torque),
            Kind::TimeTorque | Kind::TimeFriction => ranges.time,
        };
        let span = (upper - lower).max(f32::MIN_POSITIVE);
        Self {
            kind,
            knots: [0.0; KNOTS],
            lower,
            inverse_spacing: (KNOTS - 1) as f32 / span,
        }
    }

    /// The value of its variable at a knot, from 0.
    ///
    /// ```
    /// use model_core::effect::learned_map::{Kind, LearnedMap, Ranges};
    /// let ranges = Ranges { position: (-1.0, 3.5), ..Ranges::default() };
    /// let map = LearnedMap::flat(Kind::PositionFriction, &ranges);
    /// assert_eq!((map.place(0), map.place(4)), (-1.0, 1.0));
    /// ```
    pub fn place(&self, knot: usize) -> f32 {
        self.lower + knot as f32 / self.inverse_spacing
    }

    /// The map at a value of its variable.
    ///
    /// ```
    /// use model_core::effect::learned_map::{Kind, LearnedMap, Ranges};
    /// let ranges = Ranges { time: (0.0, 9.0), ..Ranges::default() };
    /// let mut map = LearnedMap::flat(Kind::TimeTorque, &ranges);
    /// map.knots[3] = 2.0;
    /// assert_eq!((map.at(3.0), map.at(2.5), map.at(-7.0)), (2.0, 1.0, 0.0));
    /// ```
    #[inline(always)]
    pub fn at(&self, value: f32) -> f32 {
        let place = self.along(value);
        let knot = (place as usize).min(KNOTS - 2);
        let share = place - knot as f32;
        self.knots[knot] + share * (self.knots[knot + 1] - self.knots[knot])
    }

    /// How many knots lie before a value of its variable, with the part of the way to the next.
    #[inline(always)]
    fn along(&self, value: f32) -> f32 {
        ((value - self.lower) * self.inverse_spacing)
            .max(0.0)
            .min((KNOTS - 1) as f32)
    }

    /// As [`at`](Self::at), in all lanes. The knots are picked by comparisons, which become vectors; a table look-up does not.
    #[inline(always)]
    fn at_all<const N: usize>(&self, values: Lanes<N>) -> Lanes<N> {
        let mut places = values;
        let (mut first, mut lower, mut upper) = ([0.0; N], [0.0; N], [0.0; N]);
        for place in &mut places {
            *place = self.along(*place);
        }
        for knot in 0..KNOTS - 1 {
            let (own, next) = (self.knots[knot], self.knots[knot + 1]);
            for lane in 0..N {
                let is_behind = places[lane] >= knot as f32;
                first[lane] = if is_behind { knot as f32 } else { first[lane] };
                lower[lane] = if is_behind { own } else { lower[lane] };
                upper[lane] = if is_behind { next } else { upper[lane] };
            }
        }
        for lane in 0..N {
            places[lane] = lower[lane] + (places[lane] - first[lane]) * (upper[lane] - lower[lane]);
        }
        places
    }

    /// The value of its variable.
    #[inline(always)]
    fn variable_at(&self, middle: &Middle) -> f32 {
        match self.kind {
            Kind::PositionTorque | Kind::PositionFriction => middle.position,
            Kind::VelocityTorque => middle.velocity,
            Kind::SpeedFriction => middle.velocity.abs(),
            Kind::CurrentTorque => middle.motor_torque,
            Kind::LoadFriction => middle.motor_torque.abs(),
            Kind::TimeTorque | Kind::TimeFriction => middle.time,
        }
    }

    /// As [`hold`](Self::hold), in all lanes.
    #[inline(always)]
    pub(crate) fn hold_all<const N: usize>(&self, middles: &Middles<N>, loads: &mut Loads<N>) {
        let mut values = [0.0; N];
        for lane in 0..N {
            values[lane] = self.variable_at(&middles.at(lane));
        }
        let levels = self.at_all(values);
        for lane in 0..N {
            let mut load = loads.at(lane);
            self.add(levels[lane], &mut load);
            loads.put(lane, &load);
        }
    }

    /// Adds it to what is held over a step.
    #[inline(always)]
    pub fn hold(&self, middle: &Middle, load: &mut Load) {
        self.add(self.at(self.variable_at(middle)), load);
    }

    #[inline(always)]
    fn add(&self, level: f32, load: &mut Load) {
        if self.kind.is_friction() {
            for friction in [&mut load.coulomb, &mut load.breakaway] {
                friction.forward = (friction.forward + level).max(0.0);
                friction.backward = (friction.backward + level).max(0.0);
            }
        } else {
            load.torque += level;
        }
    }
}
