//! An elastic shaft: a second inertia behind a spring.
//!
//! The far side is stepped exactly for a drive that accelerates evenly over the step, the drive under
//! the shaft's torque in the middle of the step: of second order in the step.

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
/// use model_core::plant::shaft::{Shaft, Swing, Twist};
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
            [
                -angular * angular / ringing * sine,
                cosine - decay / ringing * sine,
            ],
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
