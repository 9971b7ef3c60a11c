//! The log that the controller recorded of the loop: decoded as `cargo hil decode` does, traced as
//! `cargo hil gap` does.

use std::path::PathBuf;

use super::run::{Images, Outcome, directory};
use crate::dictionary::Dictionary;
use crate::error::{LARGEST_DATA, read_bytes};
use crate::failure::Failure;
use crate::gap::engine;
use crate::gap::outcome::Report;
use crate::log::Log;
use crate::machine::Machine;
use crate::outputs::write_own;
use crate::workspace;

/// The loop's throttle as its controller knows it, from the workspace's root.
pub const MACHINE: &str = "host-tests/machines/throttle-loop.toml";

/// The drive whose captures the effect is looked for in. What it is judged on are the others.
const TRAINING: &str = "sweep";

/// What the tracing found, and in what.
#[derive(Debug)]
pub struct Traced {
    /// What `cargo hil gap` makes of them.
    pub report: Report,
    /// Rows of all captures.
    pub samples: usize,
    /// Captures of the training drive, as CSV.
    pub train: Vec<PathBuf>,
    /// Captures of the other drive.
    pub validate: Vec<PathBuf>,
}

/// Decodes the controller's log into one CSV a capture, and traces them.
///
/// # Errors
/// A log that is damaged or lacks a sample; what `cargo hil gap` refuses.
pub fn trace(images: &Images, outcome: &Outcome) -> Result<Traced, Failure> {
    let path = directory().join("controller.defmt");
    let dictionary = Dictionary::read(&images.controller.elf)?;
    let log = dictionary.decode(&read_bytes(&path, "the controller's log", LARGEST_DATA)?)?;
    let refused = |reason: String| Failure::Other(format!("{}: {reason}", workspace::shown(&path)));
    if log.damaged > 0 {
        return Err(refused(format!("{} damaged frames", log.damaged)));
    }
    let recordings: Vec<_> = log.recordings();
    let captures: Vec<_> = recordings
        .iter()
        .filter(|recording| recording.samples().next().is_some())
        .collect();
    if captures.len() != outcome.driven.captures.len() {
        return Err(refused(format!(
            "holds {} captures of {}",
            captures.len(),
            outcome.driven.captures.len()
        )));
    }
    let mut traced = (Vec::new(), Vec::new());
    let mut samples = 0;
    for (number, (capture, drive)) in captures.iter().zip(&outcome.driven.captures).enumerate() {
        if let Some((before, after)) = capture.first_gap() {
            return Err(refused(format!(
                "samples of capture {number} are missing between {before} and {after}"
            )));
        }
        samples += capture.samples().count();
        let csv = directory().join(format!("{drive}-{number}.csv"));
        write_own(&csv, capture.to_csv())?;
        if drive == TRAINING {
            traced.0.push(csv);
        } else {
            traced.1.push(csv);
        }
    }
    let (train, validate) = traced;
    let machine = Machine::read(&workspace::root().join(MACHINE))?;
    let report = engine::run(&machine, &read(&train)?, || read(&validate), |_| ())?;
    Ok(Traced {
        report,
        samples,
        train,
        validate,
    })
}

fn read(paths: &[PathBuf]) -> Result<Vec<Log>, Failure> {
    let read = |path: &PathBuf| {
        let log = Log::read(path)?;
        // As the report is to name it, on whatever machine.
        let path = workspace::shown(path).into();
        Ok(Log { path, ..log })
    };
    paths.iter().map(read).collect()
}
