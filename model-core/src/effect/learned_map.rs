//! A torque or a friction level learned as a function of one variable: what is left when no effect
//! of the catalogue explains a residual. It says where the unknown lives, not what it is.

use super::Middle;
use crate::numeric::exponential::decay;
use crate::plant::actuator::Load;
use crate::unit::Dimension;

/// Knots of the piecewise linear map.
pub const KNOTS: usize = 10;

/// Ways over which a hysteresis' deflection follows the motion, as shares of the stroke. A map over the
/// deflection has the rest of the law, if that comes to its level within a tenth of such a way to three
/// times it.
const REACHES: [f32; 4] = [0.15, 0.06, 0.025, 0.4];

/// What a map depends on and how it acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Kind {
    /// A torque over position, the same in both directions.
    PositionTorque,
    /// Friction over position.
    PositionFriction,
    /// A torque over a deflection that follows the position and remembers where the motion has turned:
    /// a hysteresis. What P. R. Dahl's model (*A solid friction model*, 1968) has as a straight line may
    /// have any shape.
    PositionHysteresis,
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
    pub const ALL: [Self; 9] = [
        Self::PositionTorque,
        Self::PositionFriction,
        Self::PositionHysteresis,
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
            Self::PositionTorque | Self::PositionFriction | Self::PositionHysteresis => "position",
            Self::VelocityTorque | Self::SpeedFriction => "velocity",
            Self::CurrentTorque => "current",
            Self::LoadFriction => "load",
            Self::TimeTorque | Self::TimeFriction => "time",
        }
    }

    /// What its knots are laid over: that variable, or the deflection that follows it.
    pub fn over(self) -> &'static str {
        match self {
            Self::PositionHysteresis => "deflection",
            _ => self.variable(),
        }
    }

    /// What it is: a torque, a friction or a hysteresis.
    pub fn acts_as(self) -> &'static str {
        match self {
            Self::PositionHysteresis => "hysteresis",
            _ if self.is_friction() => "friction",
            _ => "torque",
        }
    }

    /// What that variable is measured as: of a current, and of a load, it is the motor's torque.
    pub fn dimension(self) -> Dimension {
        match self {
            Self::PositionTorque | Self::PositionFriction | Self::PositionHysteresis => {
                Dimension::Position
            }
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
    /// Smallest and largest velocity.
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
    /// Maps of zeros over the range of their variable: one, of a hysteresis one for each reach that is
    /// tried.
    pub fn trials(kind: Kind, ranges: &Ranges) -> impl Iterator<Item = Self> {
        let is_stateful = kind == Kind::PositionHysteresis;
        let trials = if is_stateful { REACHES.len() } else { 1 };
        let reaches = REACHES.into_iter().take(trials);
        reaches.map(move |reach| Self::across(kind, ranges, reach))
    }

    /// A map of zeros over the range of its variable.
    pub fn flat(kind: Kind, ranges: &Ranges) -> Self {
        Self::across(kind, ranges, REACHES[0])
    }

    /// A map of zeros over the range of its variable. `reach`: of a deflection, as a share of the stroke.
    fn across(kind: Kind, ranges: &Ranges, reach: f32) -> Self {
        let magnitude = |(lowest, highest): (f32, f32)| (0.0, highest.max(-lowest));
        let (lower, upper) = match kind {
            Kind::PositionTorque | Kind::PositionFriction => ranges.position,
            Kind::PositionHysteresis => {
                let reach = reach * (ranges.position.1 - ranges.position.0);
                (-reach, reach)
            }
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
        let place = ((value - self.lower) * self.inverse_spacing)
            .max(0.0)
            .min((KNOTS - 1) as f32);
        let knot = (place as usize).min(KNOTS - 2);
        let share = place - knot as f32;
        self.knots[knot] + share * (self.knots[knot + 1] - self.knots[knot])
    }

    /// Way over which the deflection that it depends on follows the motion, rad or m, if it depends on
    /// one: the largest one.
    pub fn reach(&self) -> Option<f32> {
        (self.kind == Kind::PositionHysteresis).then_some(-self.lower)
    }

    /// Adds it to what is held over a step.
    #[inline(always)]
    pub fn hold(&self, middle: &Middle, load: &mut Load) {
        let level = self.at(match self.kind {
            Kind::PositionTorque | Kind::PositionFriction => middle.position,
            Kind::PositionHysteresis => middle.deflection,
            Kind::VelocityTorque => middle.velocity,
            Kind::SpeedFriction => middle.velocity.abs(),
            Kind::CurrentTorque => middle.motor_torque,
            Kind::LoadFriction => middle.motor_torque.abs(),
            Kind::TimeTorque | Kind::TimeFriction => middle.time,
        });
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

/// A deflection behind a displacement: it comes to the reach on the side that the motion goes to, over
/// about as long a way, and where the motion turns it turns from where it is.
///
/// ```
/// use model_core::effect::learned_map::deflected;
/// let there = deflected(0.0, 0.2, 0.1);
/// assert!((there - 0.1 * (1.0 - (-2.0_f32).exp())).abs() < 1e-7);
/// // On the way back it is another one than there on the way.
/// assert!(deflected(there, -0.2, 0.1) < -0.07);
/// ```
#[inline(always)]
pub fn deflected(deflection: f32, displacement: f32, reach: f32) -> f32 {
    let towards = if displacement < 0.0 { -reach } else { reach };
    towards - (towards - deflection) * decay(displacement.abs() / reach)
}
