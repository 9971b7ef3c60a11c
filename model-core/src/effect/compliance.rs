//! `compliance`: an elastic shaft, a second inertia behind a spring between drive and sensor.
//!
//! ```text
//! J₂ ẍ = −k (x − θ) − d (ẋ − θ̇),  the drive θ carries the reaction;  J = J₁ + J₂ as declared
//! ```
//!
//! The strength is s = J₂/k, by which the far side x trails behind for each unit of acceleration; 1/√s
//! is its angular frequency with the drive held, and at 0 the shaft is rigid. Shapes are the share
//! J₂/J, which shows in the free swing alone, √(1/(1 − J₂/J)) times as fast, and the damping ratio d/(2
//! √(k J₂)). Friction, spring and stops act on the drive. Source: the two-mass system of any text on
//! drives (W. Leonhard, *Control of electrical drives*, 2001).
//!
//! What the drive feels of the far side, besides the inertia that it has without a shaft, is −J₂ φ̈
//! with the twist φ = x − θ, sliding or held. So its modes stay those of the rigid machine. Over a step
//! the drive accelerates evenly and the twist obeys the midpoint rule, which keeps energy; its impulse
//! on the drive is that of the same equation, so that the momentum of both is kept too. It is of second
//! order in the step, and stable however stiff the shaft is.
//!
//! Told from backlash and delays by accelerations: what trails behind is −s ẍ, whatever speed and
//! direction are. Motions well below the shaft's frequency show s alone. What lies between small and
//! large is a swing, not a line, so that it is screened at several sizes. Replays start from the far
//! side, which is measured, and with the twist of a run-in, in which a wrong one dies out.

use super::{Bounds, Chain, Description, Effect, MOST_PARAMETERS, Parameter, Role, Scope, Summary, padded};
use crate::plant::parameters::{ParameterError, Parameters};
use crate::unit::Dimension;

/// Sizes at which it is screened, in squared sampling periods: factors of two in frequency from a
/// twelfth of the sampling rate down.
const TRIALS: [f32; 3] = [4.0, 16.0, 64.0];

/// Shapes at which it is screened: the share of the inertia, and the damping ratio.
const SHARE: f32 = 0.25;
const DAMPING: f32 = 0.1;

/// Largest s, s², and largest d/k, s: slower than any log, and what keeps a step finite.
const MOST_TRAILING: f32 = 1e6;
const MOST_CREEP: f32 = 1e6;

/// What lies behind an elastic shaft.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Shaft {
    /// J₂/k, s².
    pub trailing: f32,
    /// d/k, s.
    pub creep: f32,
    /// J₂, kg·m² or kg.
    pub inertia: f32,
    /// J₂/J.
    pub share: f32,
}

/// The far side beside the drive.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Twist {
    /// x − θ, rad or m.
    pub angle: f32,
    /// Its rate, rad/s or m/s.
    pub rate: f32,
}

/// A step of the drive as if the shaft were rigid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rigid {
    /// By how much its velocity changes.
    pub gain: f32,
    /// What a torque held over the step adds to that, for each N·m or N.
    pub give: f32,
    /// Its length, s.
    pub length: f32,
}

/// Torque of the shaft on the drive beside that of a rigid one, held over a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reaction {
    /// Without another torque than what the drive's step knows, N·m or N.
    pub torque: f32,
    /// What it adds to each unit of another one.
    pub share: f32,
}

impl Shaft {
    /// Whether a step can be made with it.
    ///
    /// # Errors
    /// A value that is none, or too large; see [`MOST_TRAILING`].
    pub(crate) fn check(&self, machine: &Parameters) -> Result<(), ParameterError> {
        let refuse = |parameter, requirement| {
            Err(ParameterError {
                parameter,
                requirement,
            })
        };
        if !(0.0..=MOST_TRAILING).contains(&self.trailing) {
            return refuse("trailing", "0 to 1e6 s²");
        }
        if !(0.0..=MOST_CREEP).contains(&self.creep) {
            return refuse("damping", "0 or more, and d/k at most 1e6 s");
        }
        if !(self.share >= 0.0 && self.inertia < machine.inertia) {
            return refuse("share", "0 or more and below 1: the rest is the drive's");
        }
        Ok(())
    }

    /// The share of the twist that the far side is ahead of the centre of mass; the drive is behind by
    /// the rest. That one does not swing.
    #[inline(always)]
    pub fn ahead(&self) -> f32 {
        1.0 - self.share
    }

    /// The factor that makes a step of `length` implicit.
    #[inline(always)]
    fn inverse(&self, length: f32) -> f32 {
        let half = 0.5 * length;
        1.0 / (self.trailing + half * (self.creep + half))
    }

    /// By how much the twist's rate changes in a step of a drive that keeps its speed.
    #[inline(always)]
    fn slowing(&self, twist: Twist, length: f32) -> f32 {
        let bend = twist.angle + (self.creep + 0.5 * length) * twist.rate;
        -length * bend * self.inverse(length)
    }

    /// The twist behind a step in which the drive gains so much velocity evenly.
    ///
    /// ```
    /// use model_core::effect::compliance::{Shaft, Twist};
    /// // 10 Hz, undamped, the drive at rest: after a quarter of a swing all of the twist is speed.
    /// let angular = 2.0 * core::f32::consts::PI * 10.0;
    /// let shaft = Shaft { trailing: 1.0 / (angular * angular), creep: 0.0, inertia: 0.1, share: 0.2 };
    /// let mut twist = Twist { angle: 0.01, rate: 0.0 };
    /// for _ in 0..50 {
    ///     twist = shaft.after(twist, 0.0, 0.025 / 50.0);
    /// }
    /// assert!(twist.angle.abs() < 2e-6 && (twist.rate + 0.01 * angular).abs() < 1e-4);
    /// ```
    #[inline(always)]
    pub fn after(&self, twist: Twist, gain: f32, length: f32) -> Twist {
        let carried = self.trailing * self.inverse(length);
        let change = self.slowing(twist, length) - carried * gain;
        Twist {
            angle: twist.angle + length * (twist.rate + 0.5 * change),
            rate: twist.rate + change,
        }
    }

    /// Torque on the drive over the step that leads to [`Shaft::after`].
    #[inline(always)]
    pub fn reaction(&self, twist: Twist, rigid: &Rigid) -> Reaction {
        let Rigid { gain, give, length } = *rigid;
        let change = self.slowing(twist, length) - self.trailing * self.inverse(length) * gain;
        let inertia = self.inertia / length;
        let missing = inertia * self.trailing * self.inverse(length);
        let rest = 1.0 / (1.0 - missing * give);
        Reaction {
            torque: -inertia * change * rest,
            share: missing * give * rest,
        }
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
        summary: Summary::Same("an elastic shaft: a second inertia behind a spring"),
        source: "Leonhard 2001",
        parameters: &[
            Parameter {
                name: "trailing",
                dimension: Dimension::SquaredTime,
                role: Role::Strength,
                bounds: Bounds::UpTo(MOST_TRAILING),
            },
            Parameter {
                name: "share",
                dimension: Dimension::Ratio,
                role: Role::Shape,
                bounds: Bounds::Share,
            },
            Parameter {
                name: "damping",
                dimension: Dimension::Ratio,
                role: Role::Shape,
                bounds: Bounds::NotNegative,
            },
        ],
        reported: &[
            ("trailing", Dimension::SquaredTime),
            ("share", Dimension::Ratio),
            ("damping", Dimension::Ratio),
        ],
        rotary_only: false,
    };

    fn new([trailing, share, damping, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self {
            trailing,
            share,
            damping,
        }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        let time = 5.0 * scope.period;
        time * time
    }

    fn trial(scope: &Scope, index: usize) -> Option<[f32; MOST_PARAMETERS]> {
        let trailing = TRIALS.get(index)? * scope.period * scope.period;
        Some(padded([trailing, SHARE, DAMPING]))
    }

    fn bind(&self, plant: &mut Parameters, chain: &mut Chain) {
        chain.shaft = Shaft {
            trailing: self.trailing,
            creep: 2.0 * self.damping * libm::sqrtf(self.trailing),
            inertia: self.share * plant.inertia,
            share: self.share,
        };
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        padded([self.trailing, self.share, self.damping])
    }
}
