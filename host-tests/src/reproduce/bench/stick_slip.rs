//! Stick-slip of a mass on a belt, held by a spring: the example of ch. 1.5.1.
//!
//! The belt runs at a constant speed v. While the mass sticks it goes with it and the spring's force
//! grows; at the static friction it slips back, in a swing of the spring about the place where the
//! dynamic friction balances it, until it goes as fast as the belt again.
//!
//! * [`closed_form`]: that motion exactly, and what the paper prints of it;
//! * [`simulated`]: the same by the core's friction schemes.

pub mod closed_form;
pub(super) mod report;
pub mod simulated;

/// A mass, a spring and a belt with friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Example {
    /// Mass, kg.
    pub mass: f64,
    /// Stiffness of the spring, N/m.
    pub stiffness: f64,
    /// Static friction over the normal force.
    pub static_coefficient: f64,
    /// Dynamic friction over the normal force.
    pub dynamic_coefficient: f64,
}

impl Example {
    /// The paper's.
    pub const PAPER: Self = Self {
        mass: 1.0,
        stiffness: 25.0,
        static_coefficient: 1.0,
        dynamic_coefficient: 0.5,
    };

    /// Normal force, N: the weight.
    pub fn normal_force(&self) -> f64 {
        self.mass * super::friction_map::GRAVITY
    }

    /// Angular frequency of the mass on its spring, rad/s.
    pub fn natural_frequency(&self) -> f64 {
        (self.stiffness / self.mass).sqrt()
    }

    /// Deflection of the spring at breakaway beyond that under dynamic friction, m:
    /// (μs − μd) N/k.
    pub fn excess_deflection(&self) -> f64 {
        (self.static_coefficient - self.dynamic_coefficient) * self.normal_force() / self.stiffness
    }

    /// Seconds from an unloaded spring to the first breakaway: μs N/(k v).
    pub fn first_breakaway(&self, belt_speed: f64) -> f64 {
        self.static_coefficient * self.normal_force() / (self.stiffness * belt_speed)
    }
}

/// A period of the motion: a stick and a slip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cycle {
    /// Half of the way between the ends of the swing, m.
    pub amplitude: f64,
    /// How long it sticks, s.
    pub stick: f64,
    /// How long it slips, s.
    pub slip: f64,
}
