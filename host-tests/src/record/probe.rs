//! What a debug probe alone can do: listen. Its log (RTT) has a channel from the board and none to it, so somebody
//! arms the drive and asks for the log on the board's console, and the log is taken as it comes.

use std::io::{self, BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use crate::board_log::BoardLog;
use crate::error::tell;
use crate::failure::Failure;
use crate::printed_log;

/// The program that reads the probe.
const PROGRAM: &str = "probe-rs";

/// The chip of the images.
const CHIP: &str = "STM32F405RGTx";

/// The experiment that `dump log` sends.
const LOG: &str = "log";

/// A program that is ended when nobody listens to it any more.
struct Listened(Child);

impl Drop for Listened {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The next whole log that the board with this image sends to its probe.
///
/// # Errors
/// No `probe-rs`, its end before the log is whole, a log of which some is missing.
pub fn listen(image: &Path) -> Result<BoardLog, Failure> {
    let spawned = Command::new(PROGRAM)
        .args(["attach", "--chip", CHIP])
        .arg(image)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn();
    let mut probe = match spawned {
        Ok(child) => Listened(child),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            return Err(Failure::other(
                "probe-rs is not there, which reads the probe; install it by `cargo install probe-rs-tools --locked`",
            ));
        }
        Err(error) => return Err(Failure::system(PROGRAM, error)),
    };
    tell(
        "listening to the probe; on the board's console: `arm`, a signal, `disarm`, then `dump log`; Ctrl-C ends it",
    );
    let out = probe.0.stdout.take();
    let mut out = BufReader::new(out.ok_or_else(|| Failure::other("probe-rs prints nothing"))?);
    let mut log = BoardLog::default();
    let mut row = Vec::new();
    loop {
        row.clear();
        let read = out.read_until(b'\n', &mut row);
        if read.map_err(|error| Failure::system(PROGRAM, error))? == 0 {
            let (have, expected) = progress(&log);
            return Err(Failure::other(format!(
                "probe-rs ended after {have} of {expected} rows of the log, see what it said; nothing is written"
            )));
        }
        // A row that is not whole is one that is missing, which is told below.
        let Ok(Some(printed)) = printed_log::read(Path::new(PROGRAM), &row) else {
            continue;
        };
        for line in printed.log.lines {
            if let Some(name) = line.value("experiment", "name") {
                // What came before belongs to something else.
                log = BoardLog::default();
                if name != LOG {
                    continue;
                }
            } else if log.lines.is_empty() {
                continue;
            }
            log.lines.push(line);
        }
        let (have, expected) = progress(&log);
        let last = log.lines.last().and_then(|line| line.sample.as_ref());
        let is_over = last.is_some_and(|sample| sample.sequence as usize + 1 >= expected);
        if expected > 0 && is_over {
            if have == expected {
                return Ok(log);
            }
            return Err(Failure::other(format!(
                "{} of {expected} rows were lost on the way from the board; nothing is written; the board keeps its \
                 log until it is armed again: run this once more, then `dump log`",
                expected - have
            )));
        }
    }
}

/// Rows of the log that are there, and how many the board has announced.
fn progress(log: &BoardLog) -> (usize, usize) {
    let have = log.lines.iter().filter(|line| line.sample.is_some());
    let head = log.lines.first();
    let steps = head.and_then(|line| line.value("experiment", "steps")?.parse().ok());
    (have.count(), steps.unwrap_or(0))
}
