//! How long the interrupts of the images take that nobody operates, at several numbers of cycles an instruction.

use std::path::Path;

use rayon::prelude::*;

use super::summary::AtCycles;
use super::unattended;
use crate::board_log::BoardLog;
use crate::board_run::{ACTUATORS, ECU, FAILURES};
use crate::failure::Failure;
use crate::outputs::write_own;
use crate::replay_run;
use crate::toolchain::Toolchain;

/// The images that have a plant interrupt, the longest run first. Without `verdicts`, which has no other experiments than the
/// first and calls what that calls.
const IMAGES: [&str; 4] = [ACTUATORS, ECU, FAILURES, replay_run::PROGRAM];

/// Those of `host-tests/emulation/src/scenario/ticks.rs`.
const CYCLES_PER_INSTRUCTION: [f64; 4] = [1.0, 1.5, 2.5, 3.0];

/// Runs each image at each number of cycles, as many at a time as there are cores.
///
/// # Errors
/// An image that does not build, or does not say how long its interrupts took.
pub fn longest(toolchain: &Toolchain) -> Result<Vec<AtCycles>, Failure> {
    let tape = replay_run::checked_file();
    write_own(&tape, &replay_run::checked_tape()?)?;
    let mut cases = Vec::new();
    for image in IMAGES {
        let elf = toolchain.build(image)?.elf;
        cases.extend(CYCLES_PER_INSTRUCTION.map(|cycles| (image, elf.clone(), cycles)));
    }
    let runs = cases.par_iter().map(|(image, elf, cycles)| {
        let tape: Option<&Path> = (*image == replay_run::PROGRAM).then_some(&tape);
        let log = unattended::run_at(*cycles, elf, tape)?.log;
        read(image, *cycles, &log).ok_or_else(|| {
            Failure::Other(format!(
                "{image} does not say how long its interrupts took at {cycles} cycles an instruction"
            ))
        })
    });
    runs.collect()
}

fn read(image: &str, cycles_per_instruction: f64, log: &BoardLog) -> Option<AtCycles> {
    let number = |kind: &str, name: &str| -> Option<u64> {
        let said = log.messages().find_map(|line| line.value(kind, name));
        said?.parse().ok()
    };
    Some(AtCycles {
        image: image.to_owned(),
        cycles_per_instruction,
        plant_cycles: Some(number("load", "plant_worst_cycles")?),
        control_cycles: Some(number("load", "control_worst_cycles")?),
        longest_latency_us: None,
        missed: number("deadlines", "missed")?,
        // Where the image paints it.
        stack_bytes: number("stack", "used")
            .zip(number("stack", "of"))
            .map(<[u64; 2]>::from),
    })
}
