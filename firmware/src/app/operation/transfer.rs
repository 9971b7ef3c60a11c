//! What was recorded, sent a little in each poll: a capture, or the log of the last seconds.
//!
//! Over RTT both are samples of an experiment. Over the console the log is a row of
//! [frames](crate::app::console::frame):
//!
//! ```text
//! log 10000 1000 0.005714286 0.00038349521 0.012207031   rows, µs a row, one count of input, position, current
//! row 0 0014ffee0003…                                    the first row's number, three counts a row
//! end 10000
//! ```
//!
//! A count is two's complement of 16 bits in four hexadecimal digits.

use core::fmt::Write;

use heapless::String;

use super::operator::{ROWS, Station};
use crate::app::capture::{Capture, QUANTITIES, Quantity};
use crate::app::console::frame;
use crate::app::console::request::{Destination, Dump};
use crate::app::conversion::Converters;
use crate::app::memory::Memory;
use crate::app::timing::CONTROL_PERIOD_US;

/// Rows of a log in a frame.
const ROWS_A_FRAME: usize = 16;

/// Characters of one row.
const DIGITS: usize = 12;

/// A transfer that is under way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Transfer {
    what: Dump,
    /// The next row.
    next: usize,
}

impl Transfer {
    /// Begins with the first row.
    pub(super) fn new(what: Dump) -> Self {
        Self { what, next: 0 }
    }

    /// Whether it is the log's, which must not change meanwhile.
    pub(super) fn holds_log(&self) -> bool {
        matches!(self.what, Dump::Log(_))
    }

    /// Sends what there is room for. None once all is sent.
    pub(super) fn advance<S: Station>(
        self,
        capture: &Capture,
        log: Option<(&Memory, &Converters)>,
        station: &mut S,
        out: &mut dyn Write,
    ) -> Option<Self> {
        let (next, rows) = match (self.what, log) {
            (Dump::Capture, _) => {
                let rows = capture.rows().enumerate().skip(self.next).take(ROWS);
                for (number, row) in rows {
                    station.send_row(number as u32, &row);
                }
                (self.next + ROWS, capture.count())
            }
            (Dump::Log(Destination::Rtt), Some((memory, converters))) => {
                for number in self.next..self.next + ROWS {
                    if let Some(counts) = memory.row(number) {
                        station.send_row(number as u32, &values(counts, converters));
                    }
                }
                (self.next + ROWS, memory.samples())
            }
            (Dump::Log(Destination::Console), Some((memory, converters))) => {
                let next = frames(self.next, memory, converters, station, out);
                // One more than its rows: the end.
                (next, memory.samples() + 1)
            }
            (Dump::Log(_), None) => return None,
        };
        (next < rows).then_some(Self { next, ..self })
    }
}

/// A row's values, in the order of [`Quantity`].
fn values([duty, position, current]: [i16; 3], converters: &Converters) -> [f32; QUANTITIES] {
    let mut values = [f32::NAN; QUANTITIES];
    values[Quantity::Input as usize] = converters.bridge.value(duty);
    values[Quantity::Position as usize] = converters.position.value(position);
    values[Quantity::Current as usize] = converters.current.value(current);
    values
}

/// Writes the frame that comes next, if there is room for it: the row behind it.
fn frames<S: Station>(
    next: usize,
    memory: &Memory,
    converters: &Converters,
    station: &S,
    out: &mut dyn Write,
) -> usize {
    // The head goes with the first rows.
    if station.room() < 2 * frame::FRAME {
        return next;
    }
    let rows = memory.samples();
    if next >= rows {
        return end(
            frame::write(out, format_args!("end {rows}")),
            next,
            rows + 1,
        );
    }
    if next == 0 {
        let units = [
            converters.bridge.unit(),
            converters.position.unit(),
            converters.current.unit(),
        ];
        let [input, position, current] = units;
        let head =
            format_args!("log {rows} {CONTROL_PERIOD_US} {input:?} {position:?} {current:?}");
        if frame::write(out, head).is_err() {
            return next;
        }
    }
    let mut digits = String::<{ ROWS_A_FRAME * DIGITS }>::new();
    let last = rows.min(next + ROWS_A_FRAME);
    for counts in (next..last).filter_map(|row| memory.row(row)) {
        for count in counts {
            // There is room for all of them.
            let _ = write!(digits, "{:04x}", count as u16);
        }
    }
    end(
        frame::write(out, format_args!("row {next} {digits}")),
        next,
        last,
    )
}

/// What comes next: the same again where nothing was written.
fn end(written: core::fmt::Result, before: usize, behind: usize) -> usize {
    if written.is_ok() { behind } else { before }
}
