//! The emulated board: QEMU's `netduinoplus2`, an STM32F405.

use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::board_log::{BoardLog, Dictionary};
use crate::failure::Failure;
use crate::toolchain::EMULATOR;

/// How the machine is emulated. An instruction takes 8 ns of the board's time whatever the host
/// does, so a run repeats itself bit for bit.
const ARGUMENTS: [&str; 12] = [
    "-machine",
    "netduinoplus2",
    "-icount",
    "shift=3,align=off",
    "-nographic",
    "-monitor",
    "none",
    "-serial",
    "none",
    "-semihosting-config",
    "enable=on,target=native",
    "-kernel",
];

/// Last lines of the log that an error quotes, where none of all lines is an error itself.
const QUOTED_LINES: usize = 5;

/// A run that ended well.
pub struct Run {
    /// What the board sent, byte for byte.
    pub sent: Vec<u8>,
    /// The same, decoded.
    pub log: BoardLog,
}

/// Runs an image until it ends by itself, and decodes its log.
///
/// # Errors
/// An emulator that cannot be run, an image that has not ended after `limit` of the host's time or
/// that ends with another status than 0, or a damaged log.
pub fn run(elf: &Path, limit: Duration) -> Result<Run, Failure> {
    start(elf, limit, &[])
}

/// As [`run`], with the bytes of a file in the board's memory before it starts.
///
/// # Errors
/// As [`run`].
pub fn run_with(
    elf: &Path,
    (file, address): (&Path, u64),
    limit: Duration,
) -> Result<Run, Failure> {
    // A comma would end the name; doubled it stands for itself.
    let name = file.display().to_string().replace(',', ",,");
    let loader = format!("loader,file={name},addr={address:#x},force-raw=on");
    start(elf, limit, &["-device", &loader])
}

fn start(elf: &Path, limit: Duration, more: &[&str]) -> Result<Run, Failure> {
    let dictionary = Dictionary::read(elf)?;
    let mut emulator = Command::new(EMULATOR)
        .args(ARGUMENTS)
        .arg(elf)
        .args(more)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| Failure::system(format_args!("{EMULATOR} cannot be run"), &error))?;
    let sent = collect(emulator.stdout.take());
    let complaints = collect(emulator.stderr.take());
    let status = wait(&mut emulator, limit);
    let sent = sent.join().unwrap_or_default();
    let log = dictionary.decode(&sent);
    let complaints = complaints.join().unwrap_or_default();

    let ended = match status.map_err(|error| Failure::system(EMULATOR, &error))? {
        None => format!("did not end within {} s", limit.as_secs()),
        Some(status) if !status.success() => format!("ended with {status}"),
        Some(_) if log.damaged > 0 => format!("sent {} damaged log frames", log.damaged),
        Some(_) => return Ok(Run { sent, log }),
    };
    Err(Failure::Other(format!(
        "the emulated board {ended}{}{}",
        telling_lines(&log),
        indented(&String::from_utf8_lossy(&complaints))
    )))
}

/// Reads a stream to its end, beside what else is going on.
fn collect(stream: Option<impl Read + Send + 'static>) -> JoinHandle<Vec<u8>> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut stream) = stream {
            // What was read before an error is as good a log as there is.
            let _ = stream.read_to_end(&mut bytes);
        }
        bytes
    })
}

/// The exit status, or none for a process that had to be ended.
fn wait(process: &mut Child, limit: Duration) -> std::io::Result<Option<ExitStatus>> {
    let start = Instant::now();
    loop {
        if let Some(status) = process.try_wait()? {
            return Ok(Some(status));
        }
        if start.elapsed() > limit {
            process.kill()?;
            process.wait()?;
            return Ok(None);
        }
        thread::sleep(Duration::from_millis(10));
    }
}

fn telling_lines(log: &BoardLog) -> String {
    let errors = log.messages().filter(|line| line.level == "ERROR");
    let mut lines: Vec<String> = errors.map(ToString::to_string).collect();
    if lines.is_empty() {
        lines = log.messages().map(ToString::to_string).collect();
        lines.drain(..lines.len().saturating_sub(QUOTED_LINES));
    }
    indented(&lines.join("\n"))
}

fn indented(text: &str) -> String {
    text.lines().map(|line| format!("\n  {line}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board_log::Line;

    fn sleeper(seconds: &str) -> Child {
        Command::new("sleep").arg(seconds).spawn().unwrap()
    }

    #[test]
    fn a_process_that_does_not_end_is_ended() {
        let mut process = sleeper("600");
        assert_eq!(wait(&mut process, Duration::ZERO).unwrap(), None);
        assert!(process.try_wait().unwrap().is_some());
    }

    #[test]
    fn errors_are_quoted_wherever_they_are_else_the_last_lines() {
        let line = |level: &str, number: usize| Line {
            time: String::new(),
            level: level.to_owned(),
            message: number.to_string(),
            sample: None,
        };
        let mut log = BoardLog::default();
        log.lines.extend((0..9).map(|number| line("INFO", number)));
        assert_eq!(
            telling_lines(&log),
            "\n  INFO 4\n  INFO 5\n  INFO 6\n  INFO 7\n  INFO 8"
        );
        log.lines[1] = line("ERROR", 1);
        assert_eq!(telling_lines(&log), "\n  ERROR 1");
    }

    #[test]
    fn a_process_that_ends_gives_its_status() {
        let status = wait(&mut sleeper("0"), Duration::from_secs(600)).unwrap();
        assert!(status.is_some_and(|status| status.success()));
    }
}
