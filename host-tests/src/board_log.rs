//! A board's defmt log: frames in, lines and samples out.
//!
//! defmt sends numbers only; the words are in the image that sent them. A frame reads as a word for
//! what it is and then, mostly, as `name=value` for each of its fields: [`Line::value`]. A *recording*
//! is what follows an `experiment` line; its `sample` lines are read into [`Sample`]s.

use std::fmt::{self, Write as _};
use std::io::BufRead;

use firmware::app::capture::Quantity;
use firmware::app::conversion::Converters;
use firmware::app::record;
use firmware::app::timing::CONTROL_PERIOD_US;
use firmware::app::wiring::Truth;
use serde::Deserialize;

/// What an image should have been, for messages.
pub(crate) const IMAGE: &str = "the board's image (ELF)";

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

/// A frame, as the reader in `host-tests/formats` writes it.
#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum Frame {
    Line {
        time: String,
        level: String,
        message: String,
    },
    Damaged,
}

/// The frames that the reader writes, a line of JSON each: a line, or none of a damaged one, as is one that no
/// reader writes.
pub(crate) fn frames(from: impl BufRead) -> impl Iterator<Item = Option<Line>> {
    from.lines()
        .map_while(Result::ok)
        .map(|written| match serde_json::from_str(&written).ok()? {
            Frame::Line {
                time,
                level,
                message,
            } => Some(Line {
                time,
                level,
                sample: parse_sample(&message),
                message,
            }),
            Frame::Damaged => None,
        })
}

impl BoardLog {
    /// The log of all frames that the reader writes.
    pub fn of_frames(from: impl BufRead) -> Self {
        let mut log = Self::default();
        for frame in frames(from) {
            log.push(frame);
        }
        log
    }

    /// Takes in the next frame: a line, or none of a damaged one.
    pub(crate) fn push(&mut self, frame: Option<Line>) {
        match frame {
            Some(line) => self.lines.push(line),
            None => self.damaged += 1,
        }
    }

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
    fn frames_are_lines_and_samples_or_damaged() {
        let written = format!(
            "{{\"line\": {{\"time\": \"0.1\", \"level\": \"INFO\", \"message\": \"{TEXT}\"}}}}\n\"damaged\"\n"
        );
        let log = BoardLog::of_frames(written.as_bytes());
        let [line] = &log.lines[..] else {
            panic!("one line");
        };
        assert_eq!(line.to_string(), format!("0.1 INFO {TEXT}"));
        assert_eq!(line.sample.map(|sample| sample.sequence), Some(7));
        assert_eq!(log.damaged, 1);
        let cut = BoardLog::of_frames(&written.as_bytes()[..20]);
        assert_eq!((cut.lines.len(), cut.damaged), (0, 1));
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
}
