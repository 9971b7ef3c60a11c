//! The JSON of `cargo hil onboard`.

use serde::Serialize;

use crate::emulate::summary::{Chip, Loop};

/// The answer, serialised as it stands. Keys beyond the contract are additions.
#[derive(Debug, Serialize)]
pub struct Onboard {
    /// The chip, and which key is of which image.
    pub target: &'static str,
    /// What ran them.
    pub chip: Chip,
    /// What the log lacks that the controller recorded of the throttle.
    pub r#loop: Loop,
    /// The board's samples beside this host's.
    pub parity: Parity,
    /// Friction estimated anew on the board.
    pub refit: Refit,
    /// The same under the brake of the prognostics paper, 0.779 N·m.
    pub brake: Refit,
    /// What the board finds in its own log.
    pub gap: Gap,
    /// What it finds in a log of each kind of verdict.
    pub verdicts: Vec<Gap>,
    /// Instructions of one step: exact, of this compiler.
    pub instructions_per_step: PerStep,
    /// What the image occupies.
    pub image: Image,
    /// Deadlines missed in the whole run of the demonstration, and plant ticks in it.
    pub deadlines: Deadlines,
}

/// The board's samples beside this host's.
#[derive(Debug, Clone, Serialize)]
pub struct Parity {
    /// Samples compared: position, velocity, current, control output, and what the sensors read.
    pub samples: usize,
    /// Bits that differ.
    pub differing_bits: u32,
    /// Samples by experiment.
    pub experiments: Vec<ParityOf>,
    /// Whether every refit and every check came to the same numbers, to the last bit.
    pub same_evaluations: bool,
}

/// One experiment's samples beside this host's.
#[derive(Debug, Clone, Serialize)]
pub struct ParityOf {
    /// Its name.
    pub name: &'static str,
    /// Samples compared.
    pub samples: usize,
    /// Bits that differ.
    pub differing_bits: u32,
}

/// Friction estimated anew on the board.
#[derive(Debug, Clone, Serialize)]
pub struct Refit {
    /// What was estimated.
    pub parameter: String,
    /// What it was before, and where the search started, N·m.
    pub present: f64,
    /// What it really is, N·m.
    #[serde(rename = "true")]
    pub truth: f64,
    /// What the board says, N·m.
    pub estimate: f64,
    /// Replays of the log: by annealing and by golden section.
    pub evaluations: u32,
    /// Samples of the log.
    pub samples: u32,
    /// Without those of the interrupts.
    pub instructions: u64,
    /// At one instruction a cycle and 168 MHz, beside the interrupts.
    pub seconds: f64,
    /// Plant ticks meanwhile.
    pub ticks: u32,
    /// Deadlines missed meanwhile.
    pub missed_ticks: u32,
}

/// What the board finds in its own log.
#[derive(Debug, Clone, Serialize)]
pub struct Gap {
    /// The experiment's name.
    pub experiment: &'static str,
    /// As in the answer of `cargo hil gap`.
    pub verdict: String,
    /// Ids of the effects.
    pub effects: Vec<String>,
    /// The variable that carries what is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unknown: Option<String>,
    /// Numbers of the machine that turned out wrong.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub freed: Vec<String>,
    /// Windowed position error, rms, of the machine with its parameters fitted, rad.
    pub position_rms_before: f64,
    /// With what was found, rad.
    pub position_rms_after: f64,
    /// Samples of the log.
    pub samples: u32,
    /// Without those of the interrupts.
    pub instructions: u64,
    /// At one instruction a cycle and 168 MHz, beside the interrupts.
    pub seconds: f64,
    /// Plant ticks meanwhile.
    pub ticks: u32,
    /// Deadlines missed meanwhile.
    pub missed_ticks: u32,
}

/// Instructions of one step.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct PerStep {
    /// The actuator, sliding forward.
    pub ema: u64,
    /// The throttle, sliding, with its spring and its stops.
    pub throttle: u64,
    /// The controller.
    pub pid: u64,
    /// The test bench by its averaged electrics, without its control.
    pub bench: u64,
    /// The test bench by its switching electrics, without its control.
    pub bench_switching: u64,
    /// The actuator in a step in which it turns round.
    pub ema_reversal: u64,
    /// A sample of the log in one evaluation of the refit.
    pub refit_sample: u64,
}

/// What the image occupies, bytes.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Image {
    /// Of the flash.
    pub flash_bytes: u64,
    /// Of the RAM.
    pub ram_bytes: u64,
    /// What is left of the flash.
    pub flash_room_bytes: u64,
    /// What is left of the RAM: the stack's.
    pub ram_room_bytes: u64,
    /// What of that the stack has used, in the run that used most.
    pub stack_bytes: u64,
}

/// Deadlines of the whole run of the demonstration.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Deadlines {
    /// Plant ticks.
    pub ticks: u32,
    /// Deadlines missed.
    pub missed: u32,
}
