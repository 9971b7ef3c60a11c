//! The core's tests built and run on the emulated chip, and held against this host.

use firmware::on_target::CHECKS;

use crate::board_log::{BoardLog, Line};
use crate::board_run;
use crate::emulate::unattended;
use crate::failure::Failure;
use crate::figures::Figures;
use crate::toolchain::{Build, Toolchain};

/// The program.
pub const PROGRAM: &str = "on_target";

/// What the message of a figure starts with.
const COUNT: &str = "count ";

/// A run in which every test passed, with the bits that this host has.
pub struct OnTargetRun {
    /// What the program was built to.
    pub build: Build,
    /// What it said.
    log: BoardLog,
    /// Instructions, by name.
    pub counts: Figures,
}

impl OnTargetRun {
    /// What does not depend on the compiler: everything but the counts.
    pub fn messages(&self) -> impl Iterator<Item = &Line> {
        let is_count = |line: &&Line| line.message.starts_with(COUNT);
        board_run::messages(&self.log).filter(move |line| !is_count(line))
    }
}

/// Builds the program, runs it and compares.
///
/// # Errors
/// A test that fails, by name; tests whose bits differ from this host's, by name; a program that
/// does not build or does not end.
pub fn run(toolchain: &Toolchain) -> Result<OnTargetRun, Failure> {
    let build = toolchain.build(PROGRAM)?;
    let log = unattended::run(&build.elf, None)?.in_order()?.log;
    let host = CHECKS.iter().map(|check| {
        let digest = check.run().digest();
        (check.name, format!("{digest:016x}"))
    });
    compare(&log, host).map_err(Failure::Other)?;
    let counts = counts(&log).map_err(Failure::Other)?;
    Ok(OnTargetRun { build, log, counts })
}

/// Looks for every test of the host in the board's log.
fn compare(
    log: &BoardLog,
    host: impl Iterator<Item = (&'static str, String)>,
) -> Result<(), String> {
    let differing: Vec<&str> = host
        .filter(|(name, digest)| {
            let expected = format!("check {name} {digest}");
            !log.messages().any(|line| line.message == expected)
        })
        .map(|(name, _)| name)
        .collect();
    if differing.is_empty() {
        Ok(())
    } else {
        Err(format!(
            "not the same bits on the emulated chip as on this host: {}",
            differing.join(", ")
        ))
    }
}

fn counts(log: &BoardLog) -> Result<Figures, String> {
    log.messages()
        .filter_map(|line| line.message.strip_prefix(COUNT))
        .map(|figure| {
            let parsed = figure
                .split_once(' ')
                .and_then(|(name, count)| Some((name.to_owned(), count.parse().ok()?)));
            parsed.ok_or_else(|| format!("the emulated chip counts {figure:?}"))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(messages: &[&str]) -> BoardLog {
        let line = |message: &&str| Line {
            time: String::new(),
            level: "INFO".to_owned(),
            message: (*message).to_owned(),
            sample: None,
        };
        BoardLog {
            lines: messages.iter().map(line).collect(),
            damaged: 0,
        }
    }

    #[test]
    fn tests_with_other_bits_and_tests_that_are_missing_are_named() {
        let host = || {
            ["a", "b", "c"]
                .map(|name| (name, "00ff".to_owned()))
                .into_iter()
        };
        let same = log(&["check a 00ff", "check b 00ff", "check c 00ff", "count d 7"]);
        assert_eq!(compare(&same, host()), Ok(()));
        let other = log(&["check a 00ff", "check b 00fe"]);
        let complaint = compare(&other, host()).unwrap_err();
        assert!(complaint.ends_with(": b, c"), "{complaint}");
    }

    #[test]
    fn counts_are_figures_and_no_messages() {
        let run = |messages: &[&str]| counts(&log(messages));
        let figures = run(&["check a 00ff", "count ema_rest 37", "count pid 63"]).unwrap();
        let expected = [("ema_rest".to_owned(), 37), ("pid".to_owned(), 63)];
        assert_eq!(figures, Figures::from(expected));
        assert!(run(&["count pid many"]).is_err());
        assert!(run(&["count pid"]).is_err());
    }
}
