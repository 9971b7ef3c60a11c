//! An image that nobody operates, by itself: it runs something to its end and logs it.

use std::fs;

use super::{MILLISECOND, Setting, USAGE};
use crate::running::Running;

/// Virtual time after which no image is waited for, ms: near twice what the longest takes, which traces a log of each verdict.
const LIMIT: u64 = 2_000_000;

/// Runs it, its log at the standard output, until whoever reads that has what he waits for and ends this
/// program. The first argument is the instructions that the core retires in a second.
///
/// # Errors
/// An image that starts anew, or that runs longer than any should.
pub(super) fn run(arguments: &[String]) -> Result<(), String> {
    let (rate, elf, tape) = match arguments {
        [rate, elf] => (rate, elf, None),
        [rate, elf, tape, address] => {
            let bytes = fs::read(tape).map_err(|e| format!("{tape}: {e}"))?;
            (
                rate,
                elf,
                Some((address.parse().map_err(|_| USAGE)?, bytes)),
            )
        }
        _ => return Err(USAGE.to_owned()),
    };
    let setting = Setting {
        elf: elf.into(),
        instructions_per_second: rate.parse().map_err(|_| USAGE)?,
        parameters: None,
    };
    let stored = tape.as_ref().map(|(address, tape)| (*address, &**tape));
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
