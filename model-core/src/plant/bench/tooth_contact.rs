//! Beyond the paper: the encoder's gear as a body of its own, driven through elastic teeth.
//!
//! The paper suspects tooth elasticity and gear inertia behind its late end of the dead band
//! (section 6.3). With δ the distance of the driving side from the driven one and b half the play,
//!
//! ```text
//! J θ̈ = K (δ ∓ b) + D δ̇ − drag   where δ is beyond ±b, and only while the teeth push; else −drag
//! ```
//!
//! all of it on the slow shaft. The body is stepped by Borello's friction scheme, which stays stable
//! while the step is below 2 √(J/K).

use crate::numeric::invalid_parameter::{InvalidParameter, require};
use crate::plant::borello::Borello;
use crate::plant::ema::friction::by_euler;
use crate::plant::parameters::{Drive, Parameters as Plant};
use crate::plant::{Directional, InputRefused, State};

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
    stiffness: f32,
    damping: f32,
    half_width: f32,
    scheme: Borello,
    body: State,
}

impl ToothContact {
    /// In the middle of its play at zero, for steps of `period` seconds.
    ///
    /// # Errors
    /// A parameter outside its range, or a step too long for the teeth.
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
        require(
            stiffness > 0.0 && period * period * stiffness < inertia,
            "tooth stiffness",
            "must be above 0 and below the inertia over the step squared",
        )?;
        require(
            damping >= 0.0 && period * damping < inertia,
            "tooth damping",
            "must be at least 0 and below the inertia over the step",
        )?;
        let plant = Plant {
            drive: Drive::Torque,
            gain: 1.0,
            inertia,
            viscous: Directional::default(),
            coulomb: Directional::both(drag),
            breakaway: Directional::both(drag),
            spring: 0.0,
            spring_rest: 0.0,
            spring_preload: 0.0,
            offset: 0.0,
            lower_stop: f32::NEG_INFINITY,
            upper_stop: f32::INFINITY,
        };
        let scheme = Borello::build(&plant, period).map_err(|error| InvalidParameter {
            name: error.parameter,
            requirement: "of the encoder must be in its range",
        })?;
        Ok(Self {
            stiffness,
            damping,
            half_width,
            scheme,
            body: State::default(),
        })
    }

    /// Sets half the width of the play, rad.
    pub fn set_half_width(&mut self, half_width: f32) {
        self.half_width = half_width;
    }

    /// One step with the driving side at an angle, rad, and a velocity, rad/s. The torque on the
    /// driven side, N·m, which the driving one feels reversed.
    ///
    /// # Errors
    /// [`InputRefused`] for a torque beyond what a step takes.
    #[inline]
    pub fn step(&mut self, angle: f32, velocity: f32) -> Result<f32, InputRefused> {
        let distance = -self.body.position.from(angle);
        let closing = velocity - self.body.velocity.value();
        let torque = if distance > self.half_width {
            (self.stiffness * (distance - self.half_width) + self.damping * closing).max(0.0)
        } else if distance < -self.half_width {
            (self.stiffness * (distance + self.half_width) + self.damping * closing).min(0.0)
        } else {
            0.0
        };
        by_euler(&self.scheme, &mut self.body, torque, 1)?;
        Ok(torque)
    }

    /// Angle of the driven side, rad.
    #[inline]
    pub fn angle(&self) -> f32 {
        self.body.position.value()
    }
}
