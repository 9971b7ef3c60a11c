//! What anti-windup does to a large step (the prognostics paper's Figs 5 and 6).

use model_core::control::pid::AntiWindup;
use model_core::plant::ema::{Command, Ema, Parameters};

use crate::failure::Failure;

/// Position that is asked for, m: the drive is at its limit for most of the way.
pub const STEP_M: f64 = 0.05;

/// Length of the responses, s.
pub const SECONDS: f64 = 8.0;

/// Deviation within which a response is settled, as a share of the step.
pub const BAND: f64 = 0.02;

/// A response to [`STEP_M`], a row for each period of the drive.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// s.
    pub time: Vec<f64>,
    /// Position of the rod by its encoder, m.
    pub position: Vec<f64>,
}

impl Response {
    /// What the position goes beyond the step by, m; 0 where it does not.
    pub fn overshoot(&self) -> f64 {
        let highest = self.position.iter().copied().fold(STEP_M, f64::max);
        highest - STEP_M
    }

    /// From when on the position stays within [`BAND`], s; none where it does not at the end.
    pub fn settling_time(&self) -> Option<f64> {
        let outside = |position: &f64| (position - STEP_M).abs() > BAND * STEP_M;
        let first_within = self
            .position
            .iter()
            .rposition(outside)
            .map_or(0, |row| row + 1);
        self.time.get(first_within).copied()
    }
}

/// The core's servo with this anti-windup, all else as in [`Parameters::ALI_2`].
///
/// # Errors
/// An anti-windup that the controller does not take.
pub fn response(anti_windup: AntiWindup) -> Result<Response, Failure> {
    let mut parameters = Parameters::ALI_2;
    parameters.controller.anti_windup = anti_windup;
    let mut ema = Ema::build(&parameters).map_err(|error| Failure::other(error.to_string()))?;
    let period = f64::from(parameters.drive.period);
    let rows = (SECONDS / period).round() as usize;
    let mut position = Vec::with_capacity(rows);
    for _ in 0..rows {
        let sample = ema
            .step(Command::Position(STEP_M as f32))
            .map_err(|error| Failure::other(error.to_string()))?;
        position.push(f64::from(sample.position));
    }
    let time = (0..rows).map(|row| row as f64 * period).collect();
    Ok(Response { time, position })
}
