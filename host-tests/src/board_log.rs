//! A board's defmt log: raw bytes in, lines and samples out.
//!
//! defmt sends numbers only; the words are in the image that sent them. A frame reads as a word for
//! what it is and then, mostly, as `name=value` for each of its fields: [`Line::value`]. A *recording*
//! is what follows an `experiment` line; its `sample` lines are read into [`Sample`]s.

use std::cell::Cell;
use std::fmt::{self, Write as _};
use std::panic::{self, AssertUnwindSafe};
use std::path::Path;
use std::sync::Once;

use defmt_decoder::{DecodeError, Encoding, Table};
use firmware::app::capture::Quantity;
use firmware::app::conversion::Converters;
use firmware::app::record;
use firmware::app::timing::CONTROL_PERIOD_US;
use firmware::app::wiring::Truth;

use crate::error::{InputError, LARGEST_DATA, read_bytes};

/// What an image should have been, for messages.
pub(crate) const IMAGE: &str = "the board's image (ELF)";

/// The words of an image's log.
pub struct Dictionary {
    table: Table,
}

/// What a board logs of one control step, SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Number of the control step in its recording, from 0.
    pub sequence: u32,
    /// Time of the measurement, µs from the first one.
    pub time_us: u64,
    /// Bridge voltage from this sample to the next, V.
    pub input: f32,
    /// Measured position, rad.
    pub position: f32,
    /// Position asked for, rad.
    pub command: f32,
    /// Measured motor current, A.
    pub current: f32,
    /// The emulated actuator's state behind the measurement.
    pub truth: Truth,
}

impl Sample {
    /// As the board logs it.
    pub fn new(sample: &record::Sample, converters: &Converters) -> Self {
        Self {
            sequence: sample.sequence,
            time_us: u64::from(sample.sequence) * u64::from(CONTROL_PERIOD_US),
            input: converters.bridge.value(sample.duty),
            position: converters.position.value(sample.position),
            command: sample.command,
            current: converters.current.value(sample.current),
            truth: sample.truth,
        }
    }

    /// One of its values.
    fn value(&self, quantity: Quantity) -> f32 {
        match quantity {
            Quantity::Command => self.command,
            Quantity::Input => self.input,
            Quantity::Position => self.position,
            Quantity::Current => self.current,
            Quantity::TruePosition => self.truth.position,
            Quantity::TrueVelocity => self.truth.velocity,
            Quantity::TrueCurrent => self.truth.current,
        }
    }

    /// Every bit of it.
    pub fn bits(&self) -> [u64; 9] {
        let values = [
            self.input,
            self.position,
            self.command,
            self.current,
            self.truth.position,
            self.truth.velocity,
            self.truth.current,
        ];
        let mut bits = [self.sequence.into(), self.time_us, 0, 0, 0, 0, 0, 0, 0];
        for (bits, value) in bits[2..].iter_mut().zip(values) {
            *bits = value.to_bits().into();
        }
        bits
    }
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

impl Line {
    /// What follows `name=` in a line that begins with the word `kind`.
    pub fn value(&self, kind: &str, name: &str) -> Option<&str> {
        let mut words = self.message.split(' ');
        if words.next() != Some(kind) {
            return None;
        }
        words.find_map(|word| word.strip_prefix(name)?.strip_prefix('='))
    }
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

/// The part of a log that belongs to one experiment.
#[derive(Debug, Clone, Copy)]
pub struct Recording<'a> {
    /// The experiment's name; empty for what precedes the first one.
    pub name: &'a str,
    /// Its lines.
    pub lines: &'a [Line],
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
        Self::of_bytes(elf, &read_bytes(elf, IMAGE, LARGEST_DATA)?)
    }

    /// As [`Dictionary::read`], of what a file holds.
    ///
    /// # Errors
    /// As [`Dictionary::read`].
    pub fn of_bytes(elf: &Path, bytes: &[u8]) -> Result<Self, InputError> {
        let fault = |message: String| InputError::new(elf, None, message);
        let table = guarded(|| Table::parse(bytes))
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
    /// The lines that are no samples, in order.
    pub fn messages(&self) -> impl Iterator<Item = &Line> {
        self.lines.iter().filter(|line| line.sample.is_none())
    }

    /// The recordings, in order; those without a sample too.
    pub fn recordings(&self) -> Vec<Recording<'_>> {
        self.lines
            .chunk_by(|_, next| next.value("experiment", "name").is_none())
            .map(|lines| Recording {
                name: lines[0].value("experiment", "name").unwrap_or_default(),
                lines,
            })
            .collect()
    }
}

impl Recording<'_> {
    /// The samples, in order.
    pub fn samples(&self) -> impl Iterator<Item = &Sample> {
        self.lines.iter().filter_map(|line| line.sample.as_ref())
    }

    /// What follows `name=` in the first line that begins with the word `kind`.
    pub fn value(&self, kind: &str, name: &str) -> Option<&str> {
        self.lines.iter().find_map(|line| line.value(kind, name))
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

    /// What its CSV has a column for: what a capture says that it recorded, or what every log has.
    fn columns(&self) -> Vec<Quantity> {
        let captured = self.value("capture", "quantities").map(|names| {
            let named = names.split(',').filter_map(Quantity::named);
            named.collect::<Vec<_>>()
        });
        captured.unwrap_or_else(|| LOGGED.to_vec())
    }

    /// The samples as a CSV log. Every value has the digits that give it back unchanged.
    pub fn to_csv(&self) -> String {
        let columns = self.columns();
        let mut text = String::from("time_s");
        for quantity in &columns {
            text.push(',');
            text += quantity.name();
        }
        text.push('\n');
        // A string takes everything.
        for sample in self.samples() {
            let (seconds, microseconds) = (sample.time_us / 1_000_000, sample.time_us % 1_000_000);
            let _ = write!(text, "{seconds}.{microseconds:06}");
            for &quantity in &columns {
                let _ = write!(text, ",{:?}", sample.value(quantity));
            }
            text.push('\n');
        }
        text
    }
}

/// The columns of a log, in the order in which they are written.
const LOGGED: [Quantity; 4] = [
    Quantity::Input,
    Quantity::Position,
    Quantity::Command,
    Quantity::Current,
];

/// A sample from its text, or none if this is another message.
pub(crate) fn parse_sample(message: &str) -> Option<Sample> {
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
        truth: Truth {
            position: value("true_position")?.parse().ok()?,
            velocity: value("true_velocity")?.parse().ok()?,
            current: value("true_current_a")?.parse().ok()?,
        },
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
                        current_a=1e-7 true_position=0.11 true_velocity=NaN true_current_a=2e-7";

    fn line(message: &str, sample: Option<Sample>) -> Line {
        Line {
            time: String::new(),
            level: String::new(),
            message: message.to_owned(),
            sample,
        }
    }

    fn sample(sequence: u32) -> Line {
        let sample = Sample {
            sequence,
            time_us: u64::from(sequence) * 1000,
            input: -1.5,
            position: 0.1,
            command: 0.3,
            current: 1e-7,
            truth: Truth::default(),
        };
        line("", Some(sample))
    }

    fn log(lines: Vec<Line>) -> BoardLog {
        BoardLog { lines, damaged: 0 }
    }

    #[test]
    fn a_sample_is_read_field_by_field() {
        let read = parse_sample(TEXT).unwrap();
        assert_eq!((read.sequence, read.time_us), (7, 7000));
        assert_eq!((read.input, read.position, read.command), (-1.5, 0.1, 0.3));
        assert_eq!(read.current, 1e-7);
        assert_eq!((read.truth.position, read.truth.current), (0.11, 2e-7));
        assert!(read.truth.velocity.is_nan());
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
    fn a_value_is_found_in_lines_of_its_kind_alone() {
        let line = line("refit estimate=0.15 estimate_2=7", None);
        assert_eq!(line.value("refit", "estimate"), Some("0.15"));
        assert_eq!(line.value("refit", "estimate_2"), Some("7"));
        assert_eq!(line.value("refit", "true"), None);
        assert_eq!(line.value("check", "estimate"), None);
    }

    #[test]
    fn a_log_falls_into_recordings_at_its_experiments() {
        let log = log(vec![
            line("hello", None),
            line("experiment name=a", None),
            sample(0),
            sample(1),
            line("experiment name=b", None),
            line("refused", None),
        ]);
        let found: Vec<_> = log
            .recordings()
            .iter()
            .map(|recording| (recording.name, recording.samples().count()))
            .collect();
        assert_eq!(found, [("", 0), ("a", 2), ("b", 0)]);
    }

    #[test]
    fn a_gap_is_found_and_a_whole_log_has_none() {
        let gap = |numbers: &[u32]| {
            let lines = numbers.iter().map(|&number| sample(number)).collect();
            let log: BoardLog = log(lines);
            log.recordings().first().and_then(Recording::first_gap)
        };
        assert_eq!(gap(&[]), None);
        assert_eq!(gap(&[5, 6, 7]), None);
        assert_eq!(gap(&[5, 6, 9, 12]), Some((6, 9)));
        assert_eq!(gap(&[5, 5]), Some((5, 5)));
    }

    #[test]
    fn csv_holds_the_samples() {
        let log = log(vec![sample(0), sample(1)]);
        assert_eq!(
            log.recordings()[0].to_csv(),
            "time_s,input,position,command,current_a\n\
             0.000000,-1.5,0.1,0.3,1e-7\n\
             0.001000,-1.5,0.1,0.3,1e-7\n"
        );
    }

    #[test]
    fn a_panic_in_others_code_is_an_absent_result() {
        assert_eq!(guarded(|| 1), Some(1));
        assert_eq!(guarded(|| -> i32 { panic!("not to be seen") }), None);
    }
}
