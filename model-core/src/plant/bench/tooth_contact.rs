//! Beyond the paper: the encoder's gear as a body of its own, driven through elastic teeth.
//!
//! The paper suspects tooth elasticity and gear inertia behind its late end of the dead band
//! (section 6.3). With δ the distance of the driving side from the driven one and b half the play,
//!
//! ```text
//! J θ̈ = K (δ ∓ b) + D δ̇ − drag   where δ is beyond ±b, and only while the teeth push; else −drag
//! ```
//!
//! all of it on the slow shaft. Printed teeth creep: D/K may be far above the step and J/D far below
//! it. So the step is implicit (backward Euler): the velocity is the one whose own torques lead to
//! it, dry friction among them, and no step is too long to be stable.

use crate::numeric::invalid_parameter::{InvalidParameter, require, require_positive};
use crate::plant::Compensated;

/// What the teeth and the body behind them are, on the slow shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// K, N·m/rad, > 0.
    pub stiffness: f32,
    /// D, N·m·s/rad, ≥ 0.
    pub damping: f32,
    /// J of the encoder and its gear, kg·m², > 0.
    pub inertia: f32,
    /// Dry friction of the encoder, N·m, ≥ 0.
    pub drag: f32,
}

/// The body at work.
#[derive(Debug, Clone, PartialEq)]
pub struct ToothContact {
    parameters: Parameters,
    half_width: f32,
    period: f32,
    /// Velocity for an impulse: of the body alone, and of the body on the teeth.
    alone: f32,
    in_contact: f32,
    position: Compensated,
    velocity: f32,
}

impl ToothContact {
    /// In the middle of its play at zero, for steps of `period` seconds.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn build(
        parameters: &Parameters,
        half_width: f32,
        period: f32,
    ) -> Result<Self, InvalidParameter> {
        let Parameters {
            stiffness,
            damping,
            inertia,
            drag,
        } = *parameters;
        require_positive(stiffness, "tooth stiffness")?;
        require_positive(inertia, "encoder inertia")?;
        for (value, name) in [(damping, "tooth damping"), (drag, "encoder drag")] {
            require(
                value >= 0.0 && value.is_finite(),
                name,
                "must be at least 0 and finite",
            )?;
        }
        Ok(Self {
            parameters: *parameters,
            half_width,
            period,
            alone: 1.0 / inertia,
            in_contact: 1.0 / (inertia + period * (damping + period * stiffness)),
            position: Compensated::new(0.0),
            velocity: 0.0,
        })
    }

    /// One step that ends with the driving side at an angle, rad, and a velocity, rad/s. The torque on
    /// the driven side, N·m, which the driving one feels reversed.
    #[inline]
    pub fn step(&mut self, angle: f32, velocity: f32) -> f32 {
        let Parameters {
            stiffness,
            damping,
            inertia,
            ..
        } = self.parameters;
        let distance = -self.position.from(angle);
        let beyond = if distance > self.half_width {
            distance - self.half_width
        } else if distance < -self.half_width {
            distance + self.half_width
        } else {
            0.0
        };
        // What the teeth would push with if the body stood.
        let push = stiffness * beyond + damping * velocity;
        let impulse = inertia * self.velocity + self.period * push;
        let driven = self.rubbed(impulse, self.in_contact);
        let torque = push - (damping + self.period * stiffness) * driven;
        // Never a pull.
        let (torque, velocity) = if torque * beyond > 0.0 {
            (torque, driven)
        } else {
            (0.0, self.rubbed(inertia * self.velocity, self.alone))
        };
        self.velocity = velocity;
        self.position.advance(self.period * velocity);
        torque
    }

    /// The velocity that an impulse leaves after dry friction has taken its part, zero at least.
    #[inline]
    fn rubbed(&self, impulse: f32, velocity_of: f32) -> f32 {
        let taken = self.period * self.parameters.drag;
        if impulse > taken {
            (impulse - taken) * velocity_of
        } else if impulse < -taken {
            (impulse + taken) * velocity_of
        } else {
            0.0
        }
    }

    /// Angle of the driven side, rad.
    #[inline]
    pub fn angle(&self) -> f32 {
        self.position.value()
    }
}
