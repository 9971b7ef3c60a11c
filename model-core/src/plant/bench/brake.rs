//! The brake: friction at the motor's shaft from the force on the load cell (bench paper,
//! section 5.1).
//!
//! ```text
//! T_f = F x g/(1000 τ),   τ = 34/23
//! ```
//!
//! The plate that carries the pad turns against the load cell with the torque of the brake's shaft,
//! which the chain divides by τ towards the motor.

use super::datasheet::brake::{DRIVEN_TEETH, DRIVING_TEETH, GRAVITY, LEVER_ARM};

/// Turns of the motor's sprocket for one of the brake's.
pub const CHAIN_RATIO: f32 = DRIVEN_TEETH as f32 / DRIVING_TEETH as f32;

/// Friction at the motor's shaft, N·m, for a force on the load cell in grams-force (the paper's
/// gN).
///
/// ```
/// use model_core::plant::bench::brake::friction;
/// // Table 5.1, pad fully on: 453.3086 gN are 0.70092 N·m.
/// assert!((friction(453.3086) - 0.70092).abs() < 2e-5);
/// ```
#[inline]
pub fn friction(force: f32) -> f32 {
    force * (LEVER_ARM * GRAVITY / 1000.0 / CHAIN_RATIO)
}
