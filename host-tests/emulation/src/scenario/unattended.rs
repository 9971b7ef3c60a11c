//! An image that nobody operates, by itself: it runs something to its end and logs it.

use std::fs;
use std::num::NonZeroU64;

use super::{MILLISECOND, Setting, USAGE};
use crate::board::CORE_CLOCK;
use crate::running::Running;

/// Where a recorded drive lies: `TAPE` of `memory.x`.
const TAPE: u64 = 0x080A_0000;

/// Virtual time after which no image is waited for, ms.
const LIMIT: u64 = 1_000_000;

/// Runs it at one cycle an instruction, its log at the standard output, until whoever reads that has
/// what he waits for and ends this program.
///
/// # Errors
/// An image that starts anew, or that runs longer than any should.
pub(super) fn run(arguments: &[String]) -> Result<(), String> {
    let (elf, tape) = match arguments {
        [elf] => (elf, None),
        [elf, tape] => (
            elf,
            Some(fs::read(tape).map_err(|e| format!("{tape}: {e}"))?),
        ),
        _ => return Err(USAGE.to_owned()),
    };
    let setting = Setting {
        elf: elf.into(),
        instructions_per_second: NonZeroU64::new(CORE_CLOCK).ok_or(USAGE)?,
        parameters: None,
    };
    let stored = tape.as_deref().map(|tape| (TAPE, tape));
    let mut image = Running::start_with(&setting, stored, true)?;
    while image.now() < LIMIT * MILLISECOND {
        image.run_for(10 * MILLISECOND)?;
        if image.outputs.counts.resets > 0 {
            // What it says of that comes out first.
            image.run_for(100 * MILLISECOND)?;
            return Err("the image started anew".to_owned());
        }
    }
    Err(format!("the image did not end within {} s", LIMIT / 1000))
}
