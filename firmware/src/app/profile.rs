//! The position that the run asks for: steps of different height, both ways.

use super::timing::CONTROL_PERIOD_US;

/// Positions, rad, each held for [`HOLD_US`].
const POSITIONS: [f32; 10] = [0.0, 0.3, 0.8, 0.5, -0.2, -0.7, -0.6, 0.1, 0.6, 0.0];

/// How long a position is held, µs: three times what a move over the whole stroke takes.
const HOLD_US: u32 = 400_000;

/// Control steps in a run.
pub const STEPS: u32 = POSITIONS.len() as u32 * (HOLD_US / CONTROL_PERIOD_US);

/// The position asked for in a control step, rad; none after the last.
pub fn command(step: u32) -> Option<f32> {
    let index = step / (HOLD_US / CONTROL_PERIOD_US);
    POSITIONS.get(index as usize).copied()
}
