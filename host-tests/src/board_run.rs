//! The firmware built and run on the emulated board, and what is expected of such a run.

use std::time::Duration;

use firmware::app::profile::STEPS;
use firmware::app::record::Sample;

use crate::app_on_host::AppOnHost;
use crate::board_log::BoardLog;
use crate::emulator;
use crate::failure::Failure;
use crate::image::Size;
use crate::toolchain::{Build, Toolchain};

/// The board: its feature, its program and its image.
pub const BOARD: &str = "emulated";

/// Host's time for a run that takes seconds: a slow, loaded machine gets there too.
const TIME_LIMIT: Duration = Duration::from_secs(300);

/// A run of the image that was found in order.
pub struct BoardRun {
    /// What it was built with.
    pub toolchain: Toolchain,
    /// What it was built to.
    pub build: Build,
    /// What it occupies.
    pub size: Size,
    /// What it logged, byte for byte.
    pub sent: Vec<u8>,
    /// The same, decoded.
    pub log: BoardLog,
}

/// Sets up what is missing, builds the image, runs it and checks the run. `announce` is told each
/// of these before it begins.
///
/// # Errors
/// Whatever is not in order, first of all.
pub fn run(mut announce: impl FnMut(&str)) -> Result<BoardRun, Failure> {
    announce("toolchain and emulator");
    let toolchain = Toolchain::set_up()?;
    announce(&format!(
        "firmware, built with {}",
        toolchain.route().describe()
    ));
    let build = toolchain.build(BOARD)?;
    let size = Size::read(&build.elf)?.fitting()?;
    announce("firmware on the emulated board");
    let emulator::Run { sent, log } = emulator::run(&build.elf, TIME_LIMIT)?;
    check(&log, &AppOnHost::new().run()).map_err(Failure::Other)?;
    Ok(BoardRun {
        toolchain,
        build,
        size,
        sent,
        log,
    })
}

/// Checks a log: no error line, every sample of the profile once, and each the same as on the host
/// to the last bit.
fn check(log: &BoardLog, expected: &[Sample]) -> Result<(), String> {
    if let Some(line) = log.messages().find(|line| line.level == "ERROR") {
        return Err(format!("the emulated board reports: {line}"));
    }
    if let Some((before, after)) = log.first_gap() {
        return Err(format!("samples between {before} and {after} are missing"));
    }
    let received = log.samples().count();
    if received != STEPS as usize || expected.len() != received {
        return Err(format!(
            "{received} samples from the emulated board and {} from the host, expected {STEPS}",
            expected.len()
        ));
    }
    let differing = log
        .samples()
        .zip(expected)
        .find(|(board, host)| bits(board) != bits(host));
    match differing {
        None => Ok(()),
        Some((board, host)) => Err(format!(
            "board and host differ\n  board {board:?}\n  host  {host:?}"
        )),
    }
}

fn bits(sample: &Sample) -> (u32, u64, [u32; 5]) {
    let values = [
        sample.input,
        sample.position,
        sample.command,
        sample.current,
        sample.velocity,
    ];
    (sample.sequence, sample.time_us, values.map(f32::to_bits))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board_log::Line;

    fn line(level: &str, sample: Option<Sample>) -> Line {
        Line {
            time: String::new(),
            level: level.to_owned(),
            message: "said".to_owned(),
            sample,
        }
    }

    fn log_of(samples: &[Sample]) -> BoardLog {
        BoardLog {
            lines: samples
                .iter()
                .map(|&sample| line("INFO", Some(sample)))
                .collect(),
            damaged: 0,
        }
    }

    #[test]
    fn a_run_is_checked_to_the_last_bit() {
        let samples = AppOnHost::new().run();
        assert_eq!(check(&log_of(&samples), &samples), Ok(()));

        let mut other = samples.clone();
        other[100].velocity = f32::from_bits(other[100].velocity.to_bits() ^ 1);
        assert!(
            check(&log_of(&other), &samples)
                .unwrap_err()
                .starts_with("board and host differ")
        );
    }

    #[test]
    fn missing_samples_and_error_lines_fail() {
        let samples = AppOnHost::new().run();
        let mut holed = samples.clone();
        holed.remove(7);
        assert_eq!(
            check(&log_of(&holed), &samples),
            Err("samples between 6 and 8 are missing".to_owned())
        );
        let cut = log_of(&samples[..10]);
        assert!(check(&cut, &samples).unwrap_err().starts_with("10 samples"));
        let mut faulty = log_of(&samples);
        faulty.lines.push(line("ERROR", None));
        assert_eq!(
            check(&faulty, &samples),
            Err("the emulated board reports: ERROR said".to_owned())
        );
    }
}
