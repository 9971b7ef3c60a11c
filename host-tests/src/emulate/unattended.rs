//! An image that nobody operates, on an emulated STM32F405: the ELF file as it is flashed.

use std::io::Read;
use std::path::Path;
use std::process::{Child, ChildStdout, Stdio};
use std::thread::{self, JoinHandle};

use super::run::{build, rate};
use crate::board_log::{BoardLog, Line};
use crate::dictionary::Dictionary;
use crate::failure::Failure;
use crate::image;
use crate::toolchain::clean_command;

/// What the emulation is called.
pub const CHIP: &str = "rigless 0.4.0, STM32F427 as STM32F405";

/// Last lines of the log that an error quotes, where none of all lines is an error itself.
const QUOTED_LINES: usize = 5;

/// A run to the image's end.
pub struct Run {
    /// What the image sent, decoded.
    pub log: BoardLog,
    /// Whether it says that everything was in order.
    pub sound: bool,
}

impl Run {
    /// The run, if everything was in order.
    ///
    /// # Errors
    /// It was not, and what the image says of that.
    pub fn in_order(self) -> Result<Self, Failure> {
        if self.sound {
            return Ok(self);
        }
        Err(refused(
            "says that not everything was in order",
            &self.log,
            "",
        ))
    }
}

/// Runs an image at one cycle an instruction until it says that it ends, and decodes its log. With a tape, that
/// lies behind the program.
///
/// # Errors
/// An emulation that does not build, an image that starts anew or does not end, or a damaged log.
pub fn run(elf: &Path, tape: Option<&Path>) -> Result<Run, Failure> {
    run_at(1.0, elf, tape)
}

/// As [`run`], at so many cycles an instruction.
///
/// # Errors
/// As [`run`].
pub fn run_at(
    cycles_per_instruction: f64,
    elf: &Path,
    tape: Option<&Path>,
) -> Result<Run, Failure> {
    follow(cycles_per_instruction, elf, tape, sound)
}

/// Runs an image as [`run`] does, but ends it at the first line of its log for which `is_enough` holds: what comes
/// behind that would take longer than what came before.
///
/// # Errors
/// As [`run`], and an image that ends before there is such a line.
pub fn run_up_to(elf: &Path, is_enough: impl Fn(&Line) -> bool) -> Result<BoardLog, Failure> {
    let run = follow(1.0, elf, None, |line| {
        is_enough(line)
            .then_some(true)
            .or_else(|| sound(line).map(|_| false))
    })?;
    if run.sound {
        return Ok(run.log);
    }
    Err(refused("ended before it was told to", &run.log, ""))
}

/// Whether everything was in order, in the line in which an image says that it ends.
fn sound(line: &Line) -> Option<bool> {
    line.value("exit", "sound")?.parse().ok()
}

/// Runs an image up to the line of its log of which `ending` says something.
fn follow(
    cycles_per_instruction: f64,
    elf: &Path,
    tape: Option<&Path>,
    ending: impl Fn(&Line) -> Option<bool>,
) -> Result<Run, Failure> {
    let dictionary = Dictionary::read(elf)?;
    let emulation = build()?;
    let mut command = clean_command(&emulation);
    command
        .arg("unattended")
        .arg(rate(cycles_per_instruction))
        .arg(elf);
    if let Some(tape) = tape {
        let address = image::region("TAPE").start.to_string();
        command.arg(tape).arg(address);
    }
    let mut child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| Failure::system(emulation.display(), &error))?;
    let complaints = collect(child.stderr.take());
    let run = read(child.stdout.take(), &dictionary, ending);
    end(&mut child);
    let complaints = complaints.join().unwrap_or_default();
    match run? {
        (log, Some(sound)) if log.damaged == 0 => Ok(Run { log, sound }),
        (log, Some(_)) => {
            let said = format!("sent {} damaged log frames", log.damaged);
            Err(refused(&said, &log, ""))
        }
        (log, None) => Err(refused(
            "did not end by itself",
            &log,
            &String::from_utf8_lossy(&complaints),
        )),
    }
}

/// Reads a log up to the line of which `ending` says something, and what it says; none if the stream ended
/// before.
fn read(
    stream: Option<ChildStdout>,
    dictionary: &Dictionary,
    ending: impl Fn(&Line) -> Option<bool>,
) -> Result<(BoardLog, Option<bool>), Failure> {
    let mut log = BoardLog::default();
    let Some(stream) = stream else {
        return Ok((log, None));
    };
    let mut decoding = dictionary.follow(stream)?;
    for frame in decoding.frames() {
        let sound = frame.as_ref().and_then(&ending);
        log.push(frame);
        if sound.is_some() {
            return Ok((log, sound));
        }
    }
    decoding.end()?;
    Ok((log, None))
}

/// Reads a stream to its end, beside what else is going on.
fn collect(stream: Option<impl Read + Send + 'static>) -> JoinHandle<Vec<u8>> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut stream) = stream {
            // What was read before an error is as good as there is.
            let _ = stream.read_to_end(&mut bytes);
        }
        bytes
    })
}

/// Ends a process that may have ended by itself.
fn end(child: &mut Child) {
    let _ = child.kill();
    let _ = child.wait();
}

fn refused(what: &str, log: &BoardLog, complaints: &str) -> Failure {
    Failure::Other(format!(
        "the image on the emulated chip {what}{}{}",
        telling_lines(log),
        indented(complaints)
    ))
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
}
