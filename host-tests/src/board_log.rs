//! A board's defmt log: raw bytes in, lines and samples out.
//!
//! defmt sends numbers only; the words are in the image that sent them. A frame that carries a
//! [`Sample`] reads `sample` and then one `name=value` for each of its fields. Everything else is a
//! line for people.

use std::cell::Cell;
use std::fmt;
use std::fs;
use std::io::{self, BufWriter, Write};
use std::panic::{self, AssertUnwindSafe};
use std::path::Path;
use std::sync::Once;

use defmt_decoder::{DecodeError, Encoding, Table};
use firmware::app::record::Sample;

use crate::error::InputError;
use crate::whole_file;

/// The words of an image's log.
pub struct Dictionary {
    table: Table,
}

/// One frame of the log.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Time of the message on the board, as the board prints it; empty if it has no clock.
    pub time: String,
    /// `ERROR`, `WARN`, `INFO`, `DEBUG`, `TRACE`, or nothing.
    pub level: String,
    /// What it says.
    pub message: String,
    /// The sample that the message is, if it is one.
    pub sample: Option<Sample>,
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for part in [&self.time, &self.level] {
            if !part.is_empty() {
                write!(f, "{part} ")?;
            }
        }
        f.write_str(&self.message)
    }
}

/// A decoded log.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BoardLog {
    /// Frames in the order in which they came.
    pub lines: Vec<Line>,
    /// Frames that could not be decoded.
    pub damaged: usize,
}

impl Dictionary {
    /// The words of the image in an ELF file.
    ///
    /// # Errors
    /// No such file, no ELF file, or one without a defmt log that can be read here.
    pub fn read(elf: &Path) -> Result<Self, InputError> {
        let fault = |message: String| InputError::new(elf, None, message);
        let bytes = read(elf, "the board's image (ELF)")?;
        let table = guarded(|| Table::parse(&bytes))
            .unwrap_or_else(|| Ok(None))
            .map_err(|error| {
                fault(format!(
                    "{error:#}; expected the board's image (ELF) with a defmt log"
                ))
            })?
            .ok_or_else(|| {
                fault("has no defmt log; expected the image that wrote the log".to_owned())
            })?;
        if table.encoding() == Encoding::Rzcobs {
            Ok(Self { table })
        } else {
            Err(fault(
                "logs in another encoding than defmt's default, rzcobs; expected that".to_owned(),
            ))
        }
    }

    /// Decodes a whole log. Frames end with a zero byte; what follows the last is cut off and
    /// counted as damaged.
    pub fn decode(&self, log: &[u8]) -> BoardLog {
        let mut decoded = BoardLog::default();
        for frame in log.split_inclusive(|&byte| byte == 0) {
            // An empty frame is what defmt starts each one with.
            if frame == [0] {
                continue;
            }
            match self.decode_frame(frame) {
                Some(line) => decoded.lines.push(line),
                None => decoded.damaged += 1,
            }
        }
        decoded
    }

    fn decode_frame(&self, frame: &[u8]) -> Option<Line> {
        // A fresh decoder for each frame: one for the whole log moves all of what follows each time.
        let mut decoder = self.table.new_stream_decoder();
        // The decoder trusts its input in places, and a damaged frame may say anything.
        let line: Result<Line, DecodeError> = guarded(|| {
            decoder.received(frame);
            let frame = decoder.decode()?;
            let time = frame.display_timestamp();
            let level = frame.level();
            let message = frame.display_message().to_string();
            Ok(Line {
                time: time.map(|time| time.to_string()).unwrap_or_default(),
                level: level
                    .map(|level| level.as_str().to_uppercase())
                    .unwrap_or_default(),
                sample: parse_sample(&message),
                message,
            })
        })?;
        line.ok()
    }
}

impl BoardLog {
    /// The samples, in order.
    pub fn samples(&self) -> impl Iterator<Item = &Sample> {
        self.lines.iter().filter_map(|line| line.sample.as_ref())
    }

    /// The lines that are no samples, in order.
    pub fn messages(&self) -> impl Iterator<Item = &Line> {
        self.lines.iter().filter(|line| line.sample.is_none())
    }

    /// The first place where a sample is missing: the numbers before and after.
    pub fn first_gap(&self) -> Option<(u32, u32)> {
        let mut numbers = self.samples().map(|sample| sample.sequence);
        let mut last = numbers.next()?;
        for number in numbers {
            if last.checked_add(1) != Some(number) {
                return Some((last, number));
            }
            last = number;
        }
        None
    }

    /// Writes the samples as a CSV log, whole or not at all. Every value has the digits that give
    /// it back unchanged.
    ///
    /// # Errors
    /// What the file system reports.
    pub fn write_csv(&self, path: &Path) -> io::Result<()> {
        whole_file::write(path, |partial| self.write_rows(partial))
    }

    fn write_rows(&self, path: &Path) -> io::Result<()> {
        let mut out = BufWriter::new(fs::File::create(path)?);
        writeln!(out, "time_s,input,position,command,current_a,velocity")?;
        for sample in self.samples() {
            writeln!(
                out,
                "{}.{:06},{:?},{:?},{:?},{:?},{:?}",
                sample.time_us / 1_000_000,
                sample.time_us % 1_000_000,
                sample.input,
                sample.position,
                sample.command,
                sample.current,
                sample.velocity
            )?;
        }
        out.flush()
    }
}

/// The bytes of a user's file. `expected` says what it should have been.
pub fn read(path: &Path, expected: &str) -> Result<Vec<u8>, InputError> {
    fs::read(path).map_err(|error| {
        InputError::new(
            path,
            None,
            format!("cannot be read ({error}); expected {expected}"),
        )
    })
}

/// A sample from its text, or none if this is another message.
fn parse_sample(message: &str) -> Option<Sample> {
    let mut words = message.split(' ');
    if words.next() != Some("sample") {
        return None;
    }
    let mut value = |name: &str| words.next()?.strip_prefix(name)?.strip_prefix('=');
    let sample = Sample {
        sequence: value("sequence")?.parse().ok()?,
        time_us: value("time_us")?.parse().ok()?,
        input: value("input")?.parse().ok()?,
        position: value("position")?.parse().ok()?,
        command: value("command")?.parse().ok()?,
        current: value("current_a")?.parse().ok()?,
        velocity: value("velocity")?.parse().ok()?,
    };
    words.next().is_none().then_some(sample)
}

thread_local! {
    static GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Runs code of others that panics on bad input, and says nothing if it does.
fn guarded<T>(code: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let report = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !GUARDED.get() {
                report(info);
            }
        }));
    });
    GUARDED.set(true);
    // What the code leaves behind after a panic is dropped unseen.
    let result = panic::catch_unwind(AssertUnwindSafe(code));
    GUARDED.set(false);
    result.ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "sample sequence=7 time_us=7000 input=-1.5 position=0.1 command=0.3 \
                        current_a=1e-7 velocity=NaN";

    fn sample(sequence: u32) -> Line {
        Line {
            time: String::new(),
            level: String::new(),
            message: String::new(),
            sample: Some(Sample {
                sequence,
                time_us: u64::from(sequence) * 1000,
                input: -1.5,
                position: 0.1,
                command: 0.3,
                current: 1e-7,
                velocity: 3.0,
            }),
        }
    }

    #[test]
    fn a_sample_is_read_field_by_field() {
        let read = parse_sample(TEXT).unwrap();
        assert_eq!((read.sequence, read.time_us), (7, 7000));
        assert_eq!((read.input, read.position, read.command), (-1.5, 0.1, 0.3));
        assert_eq!(read.current, 1e-7);
        assert!(read.velocity.is_nan());
    }

    #[test]
    fn a_message_that_is_not_quite_a_sample_is_none() {
        assert_eq!(parse_sample("samples sequence=7"), None);
        assert_eq!(parse_sample(&TEXT.replace("input", "inputs")), None);
        assert_eq!(parse_sample(&TEXT.replace("time_us=7000 ", "")), None);
        assert_eq!(parse_sample(&TEXT.replace("=7 ", "=-7 ")), None);
        assert_eq!(parse_sample(&format!("{TEXT} more=1")), None);
    }

    #[test]
    fn a_gap_is_found_and_a_whole_log_has_none() {
        let log = |numbers: &[u32]| BoardLog {
            lines: numbers.iter().map(|&number| sample(number)).collect(),
            damaged: 0,
        };
        assert_eq!(log(&[]).first_gap(), None);
        assert_eq!(log(&[5, 6, 7]).first_gap(), None);
        assert_eq!(log(&[5, 6, 9, 12]).first_gap(), Some((6, 9)));
        assert_eq!(log(&[5, 5]).first_gap(), Some((5, 5)));
    }

    #[test]
    fn csv_holds_the_samples_and_leaves_no_other_file() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("log.csv");
        let log = BoardLog {
            lines: vec![sample(0), sample(1)],
            damaged: 0,
        };
        log.write_csv(&path).unwrap();
        assert_eq!(
            fs::read_to_string(&path).unwrap(),
            "time_s,input,position,command,current_a,velocity\n\
             0.000000,-1.5,0.1,0.3,1e-7,3.0\n\
             0.001000,-1.5,0.1,0.3,1e-7,3.0\n"
        );
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_panic_in_others_code_is_an_absent_result() {
        assert_eq!(guarded(|| 1), Some(1));
        assert_eq!(guarded(|| -> i32 { panic!("not to be seen") }), None);
    }
}
