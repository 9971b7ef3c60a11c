//! The log that `dump log console` sends, put together again.

use firmware::app::capture::{Quantities, Quantity};
use firmware::app::wiring::Truth;

use super::demultiplexer::Demultiplexer;
use crate::board_log::{BoardLog, Line, Sample};

/// Counts of one row: input, position, current.
type Counts = [i16; 3];

/// A log on its way.
#[derive(Debug, Default)]
pub struct LogTransfer {
    head: Option<Head>,
    rows: Vec<Counts>,
    ended: bool,
}

#[derive(Debug, Clone, Copy)]
struct Head {
    rows: usize,
    period_us: u64,
    units: [f32; 3],
}

impl LogTransfer {
    /// Takes a frame. One that is none of a log is left alone.
    ///
    /// # Errors
    /// A row that does not follow the one before: a frame was lost.
    pub fn take(&mut self, text: &str) -> Result<(), String> {
        let mut words = text.split(' ');
        match words.next() {
            Some("log") => {
                let head = head(&mut words).ok_or_else(|| format!("cannot read {text:?}"))?;
                *self = Self {
                    head: Some(head),
                    ..Self::default()
                };
            }
            Some("row") => {
                let number = words.next().and_then(|word| word.parse().ok());
                let counts = words.next().and_then(counts);
                let (Some(number), Some(counts)) = (number, counts) else {
                    return Err(format!("cannot read {text:?}"));
                };
                self.follows(number)?;
                self.rows.extend(counts);
            }
            Some("end") => {
                let rows = words.next().and_then(|word| word.parse().ok());
                self.follows(rows.unwrap_or(usize::MAX))?;
                self.ended = true;
            }
            _ => (),
        }
        Ok(())
    }

    /// The last log in what a terminal program kept of a board's console; none where no log begins.
    ///
    /// # Errors
    /// A log that is not whole.
    pub fn captured(bytes: &[u8]) -> Result<Option<BoardLog>, String> {
        let mut received = Demultiplexer::default();
        received.take(bytes);
        let mut transfer = Self::default();
        for frame in received.frames() {
            transfer.take(&frame)?;
        }
        match (transfer.head, transfer.log()) {
            (Some(head), None) => Err(format!(
                "the log on the console ends behind row {} of {}; keep what comes until the prompt is there again",
                transfer.rows.len(),
                head.rows
            )),
            (_, log) => Ok(log),
        }
    }

    fn follows(&self, number: usize) -> Result<(), String> {
        if self.head.is_some() && number == self.rows.len() {
            return Ok(());
        }
        Err(format!(
            "the line lost a part of the log behind row {}; dump it again, over a shorter cable or without \
             other programs on the port",
            self.rows.len()
        ))
    }

    /// Rows that are there, and those that there will be.
    pub fn progress(&self) -> (usize, usize) {
        (self.rows.len(), self.head.map_or(0, |head| head.rows))
    }

    /// The log as `cargo hil decode` would read it of RTT; none before its end.
    pub fn log(&self) -> Option<BoardLog> {
        let head = self.head.filter(|_| self.ended)?;
        let mut log = BoardLog::default();
        let [input, position, current] = head.units;
        let quantities = [Quantity::Input, Quantity::Position, Quantity::Current]
            .into_iter()
            .fold(Quantities::default(), Quantities::with);
        log.lines.push(line("experiment name=log".to_owned(), None));
        log.lines
            .push(line(format!("capture quantities={quantities}"), None));
        for (number, counts) in self.rows.iter().enumerate() {
            let [duty, angle, amperes] = counts.map(f32::from);
            let sample = Sample {
                sequence: number as u32,
                time_us: number as u64 * head.period_us,
                input: duty * input,
                position: angle * position,
                command: f32::NAN,
                current: amperes * current,
                truth: Truth::default(),
            };
            log.lines.push(line(String::new(), Some(sample)));
        }
        Some(log)
    }
}

fn line(message: String, sample: Option<Sample>) -> Line {
    Line {
        time: String::new(),
        level: "INFO".to_owned(),
        message,
        sample,
    }
}

fn head<'a>(words: &mut impl Iterator<Item = &'a str>) -> Option<Head> {
    let head = Head {
        rows: words.next()?.parse().ok()?,
        period_us: words.next()?.parse().ok()?,
        units: [
            words.next()?.parse().ok()?,
            words.next()?.parse().ok()?,
            words.next()?.parse().ok()?,
        ],
    };
    words.next().is_none().then_some(head)
}

/// Three counts of four digits a row.
fn counts(digits: &str) -> Option<Vec<Counts>> {
    let bytes = digits.as_bytes();
    let (rows, rest) = bytes.as_chunks::<12>();
    rest.is_empty().then_some(())?;
    let count = |digits: &[u8]| {
        let digits = str::from_utf8(digits).ok()?;
        u16::from_str_radix(digits, 16).ok().map(u16::cast_signed)
    };
    let row = |row: &[u8; 12]| Some([count(&row[..4])?, count(&row[4..8])?, count(&row[8..])?]);
    rows.iter().map(row).collect()
}
