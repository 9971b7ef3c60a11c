//! Back-EMF coefficients of the phases: field shape and static eccentricity (bench paper,
//! section 3.4).
//!
//! The coefficients are both V·s/rad of the back-EMF and N·m/A of the torque. Here they are shares
//! of the nominal one, [`super::torque`]'s:
//!
//! ```text
//! k_j = shape(θ_e − 2πj/3) · N_j · [1 + ζ cos(θ_m − 2πj/3)],   j = 0, 1, 2
//! ```
//!
//! with the sine's shape −sin θ, whose quadrature current alone gives torque. N_j is the share of
//! the phase's turns that is not shorted, ζ the rotor's offset over the air gap: the corrections of
//! the same group's earlier models (P. C. Berri, M. D. L. Dalla Vedova, P. Maggiore, *A smart
//! electromechanical actuator monitor for new model-based prognostic algorithms*, 2018), since the
//! paper shows the block without its equation.

use super::park::{Rotation, inverse_clarke};
use crate::numeric::invalid_parameter::{InvalidParameter, require};
use crate::numeric::sine::sine_cycles;

/// How the rotor's field is spread over the pole pitch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// A sine.
    Sinusoidal,
    /// Flat over 120°, with straight flanks of 60°, as high as gives the sine's fundamental: the
    /// mean torque of a sinusoidal current is the same, with a ripple of six times its frequency.
    Trapezoidal,
}

/// Shape and corrections.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// Of the field.
    pub shape: Shape,
    /// ζ: offset of the rotor over the air gap, 0 (none) to below 1.
    pub static_eccentricity: f32,
    /// N_j: share of each phase's turns that works, 0 to 1 (sound).
    pub turns: [f32; 3],
}

/// Phases lag behind each other by these cycles.
const LAGS: [f32; 3] = [0.0, 1.0 / 3.0, 2.0 / 3.0];

/// Height of a trapezoid of which the fundamental is 1: one of height 1 has (4/π) sin(π/6)/(π/6).
const TRAPEZOID: f32 = core::f32::consts::PI * core::f32::consts::PI / 12.0;

impl Parameters {
    /// A sound motor with a sinusoidal field.
    pub const SOUND: Self = Self {
        shape: Shape::Sinusoidal,
        static_eccentricity: 0.0,
        turns: [1.0; 3],
    };

    pub(super) fn check(&self) -> Result<(), InvalidParameter> {
        require(
            (0.0..1.0).contains(&self.static_eccentricity),
            "static eccentricity",
            "must be at least 0 and below 1",
        )?;
        require(
            self.turns.iter().all(|share| (0.0..=1.0).contains(share)),
            "turns",
            "must be 0 to 1 in every phase",
        )
    }

    /// Shares of the nominal coefficient in each phase, at an electrical and a mechanical angle in
    /// cycles; `rotation` is that of the electrical one.
    #[inline]
    pub fn coefficients(&self, electrical: f32, mechanical: f32, rotation: &Rotation) -> [f32; 3] {
        let shape = match self.shape {
            Shape::Sinusoidal => inverse_clarke([-rotation.sine, rotation.cosine]),
            Shape::Trapezoidal => LAGS.map(|lag| trapezoid(electrical - lag)),
        };
        if *self == Self::SOUND {
            return shape;
        }
        core::array::from_fn(|phase| {
            let offset = sine_cycles(mechanical - LAGS[phase] + 0.25);
            shape[phase] * self.turns[phase] * (1.0 + self.static_eccentricity * offset)
        })
    }
}

/// A trapezoid with the phase of −sin, of an angle in cycles.
fn trapezoid(cycles: f32) -> f32 {
    let within = cycles - libm::rintf(cycles);
    // The triangle of twice the flanks' slope, cut off: ±1 over a third of a cycle each.
    let fold = if within > 0.25 {
        0.5 - within
    } else if within < -0.25 {
        -0.5 - within
    } else {
        within
    };
    -TRAPEZOID * (12.0 * fold).clamp(-1.0, 1.0)
}
