//! `compliance`: an elastic shaft, a second inertia behind a spring between drive and sensor.
//!
//! ```text
//! J₂ ẍ = −k (x − θ) − d (ẋ − θ̇),  the drive carries the reaction;  J = J₁ + J₂ as declared
//! ```
//!
//! Its parameters are s = J₂/k, by which the far side trails behind for each unit of acceleration
//! (1/√s is its angular frequency with the drive held), the share J₂/J, and the damping ratio
//! d/(2 √(k J₂)). Source: the two-mass system of any text on drives (W. Leonhard, *Control of
//! electrical drives*, 2001).
//!
//! The far side is stepped exactly for a drive that accelerates evenly over the step, the drive under
//! the reaction in the middle of the step: of second order in the step, as every held effect.
//!
//! It may be declared; the tracing does not look for it. A replay restarts it from the acceleration and
//! the jerk of a smoothed position. So it starts otherwise than every other model, which on logs
//! without a shaft explains enough of what restarts leave to be taken for one.

use super::{Chain, Description, Effect, MOST_PARAMETERS, Parameter, Role, Scope};
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Largest damping ratio: what does not swing is the sensor's own filter.
const MOST_DAMPING: f32 = 0.4;

/// Largest angle that a swing passes in a step, rad: a shaft that is stiffer is taken as one that
/// swings so fast.
const FASTEST: f32 = 1.0;

/// What lies behind an elastic shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shaft {
    /// J₂/k, s².
    pub trailing: f32,
    /// J₂, kg·m² or kg.
    pub inertia: f32,
    /// Damping ratio.
    pub damping: f32,
}

/// The far side beside the drive.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Twist {
    /// x − θ, rad or m.
    pub angle: f32,
    /// Its rate, rad/s or m/s.
    pub rate: f32,
}

/// A shaft worked out for one step.
///
/// ```
/// use model_core::effect::compliance::{Shaft, Swing, Twist};
/// // 10 Hz, undamped: after a quarter of a swing all of the twist is speed.
/// let angular = 2.0 * core::f32::consts::PI * 10.0;
/// let shaft = Shaft { trailing: 1.0 / (angular * angular), inertia: 0.1, damping: 0.0 };
/// let swing = Swing::new(&shaft, 0.025 / 50.0);
/// let mut twist = Twist { angle: 0.01, rate: 0.0 };
/// for _ in 0..50 {
///     twist = swing.step(twist, 0.0);
/// }
/// assert!(twist.angle.abs() < 1e-6 && (twist.rate + 0.01 * angular).abs() < 1e-5);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Swing {
    /// Rows of the transition of (angle, rate).
    transition: [[f32; 2]; 2],
    stiffness: f32,
    resistance: f32,
    trailing: f32,
    /// J₂, kg·m² or kg.
    pub(crate) inertia: f32,
    /// Of the step, s.
    pub(crate) period: f32,
}

impl Swing {
    /// Of a shaft over `period` seconds.
    pub fn new(shaft: &Shaft, period: f32) -> Self {
        let fastest = period / FASTEST;
        let trailing = shaft.trailing.max(fastest * fastest);
        let angular = 1.0 / libm::sqrt(f64::from(trailing));
        let damping = f64::from(shaft.damping.clamp(0.0, 0.99));
        let decay = damping * angular;
        let ringing = angular * libm::sqrt(1.0 - damping * damping);
        let time = f64::from(period);
        let fall = libm::exp(-decay * time);
        let (sine, cosine) = (libm::sin(ringing * time), libm::cos(ringing * time));
        let entries = [
            [cosine + decay / ringing * sine, sine / ringing],
            [-angular * angular / ringing * sine, cosine - decay / ringing * sine],
        ];
        let stiffness = f64::from(shaft.inertia) * angular * angular;
        Self {
            transition: entries.map(|row| row.map(|entry| (fall * entry) as f32)),
            stiffness: stiffness as f32,
            resistance: (2.0 * damping * angular * f64::from(shaft.inertia)) as f32,
            trailing,
            inertia: shaft.inertia,
            period,
        }
    }

    /// The twist a step later, while the drive accelerates evenly.
    #[inline]
    pub fn step(&self, twist: Twist, acceleration: f32) -> Twist {
        // It swings about where it would trail for ever.
        let rest = -acceleration * self.trailing;
        let angle = twist.angle - rest;
        let [to_angle, to_rate] = self.transition;
        Twist {
            angle: rest + to_angle[0] * angle + to_angle[1] * twist.rate,
            rate: to_rate[0] * angle + to_rate[1] * twist.rate,
        }
    }

    /// The twist at which the far side has this acceleration and jerk.
    pub fn twist(&self, acceleration: f32, jerk: f32) -> Twist {
        let creep = self.resistance / self.stiffness;
        let rate = -self.trailing * jerk;
        Twist {
            angle: -self.trailing * acceleration - creep * rate,
            rate,
        }
    }

    /// Torque or force of the shaft on the drive.
    #[inline]
    pub fn torque(&self, twist: Twist) -> f32 {
        self.stiffness * twist.angle + self.resistance * twist.rate
    }
}

/// A second inertia behind a spring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compliance {
    trailing: f32,
    share: f32,
    damping: f32,
}

impl Effect for Compliance {
    const DESCRIPTION: Description = Description {
        id: "compliance",
        summary: "an elastic shaft: a second inertia behind a spring",
        source: "Leonhard 2001",
        parameters: &[
            Parameter {
                name: "trailing",
                dimension: Dimension::SquaredTime,
                role: Role::Strength,
            },
            Parameter {
                name: "share",
                dimension: Dimension::Ratio,
                role: Role::Shape,
            },
            Parameter {
                name: "damping",
                dimension: Dimension::Ratio,
                role: Role::Shape,
            },
        ],
        reported: &[
            ("frequency", Dimension::Frequency),
            ("inertia", Dimension::Inertia),
            ("damping", Dimension::Ratio),
        ],
        rotary_only: false,
    };
    const TRACED: bool = false;

    fn new([trailing, share, damping]: [f32; MOST_PARAMETERS]) -> Self {
        Self {
            trailing,
            share: share.clamp(0.0, 0.95),
            damping: damping.clamp(0.0, MOST_DAMPING),
        }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        let time = 5.0 * scope.period;
        time * time
    }

    fn bind(&self, plant: &mut Parameters, chain: &mut Chain) {
        let far = self.share * plant.inertia;
        plant.inertia -= far;
        chain.shaft = Some(Shaft {
            trailing: self.trailing,
            inertia: far,
            damping: self.damping,
        });
    }

    fn report(&self, plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        let angular = 1.0 / libm::sqrtf(self.trailing.max(f32::MIN_POSITIVE));
        [
            angular / core::f32::consts::TAU,
            self.share * plant.inertia,
            self.damping,
        ]
    }
}
