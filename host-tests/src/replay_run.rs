//! A recorded drive replayed by the firmware's plant interrupt: on the emulated chip, in real time,
//! and on this host.

use std::path::{Path, PathBuf};

use firmware::app::machine::THROTTLE;
use firmware::app::replay::{Replay, Row};
use firmware::app::tape::{self, Driven, HEAD_BYTES, Tape};
use firmware::app::timing::{CONTROL_PERIOD, STEPS_PER_SECOND, TICKS_PER_CONTROL};
use model_core::effect::{Active, Id};
use model_core::gap::model::Model;
use model_core::signal::aprts;

use crate::board_log::{BoardLog, Line};
use crate::emulate::unattended;
use crate::failure::Failure;
use crate::image::{self, Size};
use crate::outputs::write_own;
use crate::toolchain::Toolchain;
use crate::workspace;

/// The program.
pub const PROGRAM: &str = "replay";

/// Rows that [`check`] replays: 4 s.
const CHECKED_ROWS: u32 = 4 * STEPS_PER_SECOND;

/// What is replayed: a model that starts at rest, and its input.
#[derive(Debug, Clone, Copy)]
pub struct Drive<'a> {
    /// The model.
    pub model: &'a Driven,
    /// Where it starts, rad or m.
    pub start: f32,
    /// Plant periods for which an input is held.
    pub ticks_per_input: u32,
    /// The input, row by row.
    pub inputs: &'a [f32],
}

impl Drive<'_> {
    /// The tape that holds it.
    ///
    /// # Errors
    /// More inputs than there is flash for.
    pub fn tape(&self) -> Result<Vec<u8>, Failure> {
        let room = image::region("TAPE");
        let room = (room.end - room.start) as usize;
        let mut bytes = vec![0; room];
        let Self {
            model,
            start,
            ticks_per_input,
            inputs,
        } = *self;
        let tape = tape::write(model, start, ticks_per_input, inputs, &mut bytes);
        let most = (room - HEAD_BYTES) / 4;
        let length = tape.map(<[u8]>::len).ok_or_else(|| {
            Failure::other(format!(
                "{} inputs do not fit into the board's flash; replay {most} at most",
                inputs.len()
            ))
        })?;
        bytes.truncate(length);
        Ok(bytes)
    }
}

/// A replay on this host: the functions of the plant interrupt, one tick after the other.
///
/// # Errors
/// A tape that is not in order, a parameter of its model out of range, an input that the plant
/// refuses.
pub fn on_host(tape: &[u8]) -> Result<Vec<Row>, Failure> {
    let other = |error: &dyn std::fmt::Display| Failure::other(error.to_string());
    let tape = Tape::read(tape).map_err(|error| other(&error))?;
    let mut replay = Replay::new(tape).map_err(|error| other(&error))?;
    let mut rows = Vec::new();
    while rows.len() < replay.rows() as usize {
        rows.extend(replay.tick().map_err(|error| other(&error))?);
    }
    Ok(rows)
}

/// A replay on the emulated chip.
#[derive(Debug, Clone, PartialEq)]
pub struct OnBoard {
    /// What it logged, a row of the tape each.
    pub rows: Vec<Row>,
    /// Plant ticks of the run.
    pub ticks: u64,
    /// What the image occupies.
    pub size: Size,
}

/// Builds the program, puts the tape behind it and runs it. The tape is left in `file`.
///
/// # Errors
/// A program that does not build or does not end in order; a log that does not hold every row.
pub fn on_board(toolchain: &Toolchain, tape: &[u8], file: &Path) -> Result<OnBoard, Failure> {
    let build = toolchain.build(PROGRAM)?;
    let size = Size::read(&build.elf)?.fitting()?;
    write_own(file, tape)?;
    let log = unattended::run(&build.elf, Some(file))?.in_order()?.log;
    let (rows, ticks) = read(&log).map_err(Failure::Other)?;
    Ok(OnBoard { rows, ticks, size })
}

/// The tape of [`check`]: steps of the throttle's input, with cogging and a late drive.
///
/// # Errors
/// None as long as the throttle's declared model is in order.
pub fn checked_tape() -> Result<Vec<u8>, Failure> {
    let other = |error: &dyn std::fmt::Display| Failure::other(error.to_string());
    let steps = aprts::Parameters {
        lower: -THROTTLE.position_loop.output_maximum,
        upper: THROTTLE.position_loop.output_maximum,
        shortest_hold: 0.02,
        longest_hold: 0.3,
        seed: 1,
    };
    let steps = steps.build(CONTROL_PERIOD).map_err(|error| other(&error))?;
    let inputs: Vec<f32> = (0..CHECKED_ROWS).map(|tick| steps.at(tick)).collect();
    let effects = [
        (Id::Cogging, [0.02, 0.03, 0.12]),
        (Id::InputDelay, [0.0021, 0.0, 0.0]),
    ];
    let model = Driven::Physical(Model {
        effects: effects
            .into_iter()
            .map(|(id, values)| Active::new(id, values))
            .collect(),
        ..Model::new(THROTTLE.plant)
    });
    let drive = Drive {
        model: &model,
        start: THROTTLE.rest,
        ticks_per_input: TICKS_PER_CONTROL,
        inputs: &inputs,
    };
    drive.tape()
}

/// Where [`checked_tape`] is left.
pub fn checked_file() -> PathBuf {
    workspace::results().join("check.tape")
}

/// Replays [`checked_tape`] on the emulated chip and compares with this host.
///
/// # Errors
/// What [`on_board`] returns; bits that differ.
pub fn check(toolchain: &Toolchain) -> Result<OnBoard, Failure> {
    let tape = checked_tape()?;
    let board = on_board(toolchain, &tape, &checked_file())?;
    match differing_bits(&board.rows, &on_host(&tape)?) {
        0 => Ok(board),
        bits => Err(Failure::Other(format!(
            "the replay on the emulated chip differs from this host's in {bits} bits"
        ))),
    }
}

/// The rows of a board's log, and its ticks.
fn read(log: &BoardLog) -> Result<(Vec<Row>, u64), String> {
    let number = |line: &Line, kind: &str, name: &str| line.value(kind, name)?.parse().ok();
    let rows: Vec<Row> = log.lines.iter().filter_map(row).collect();
    let find = |kind: &str, name: &str| -> Option<u64> {
        log.lines.iter().find_map(|line| number(line, kind, name))
    };
    let (Some(expected), Some(ticks)) = (find("replay", "rows"), find("deadlines", "ticks")) else {
        return Err("the emulated chip does not say how many rows and ticks there were".into());
    };
    let whole = rows.len() as u64 == expected
        && rows.iter().zip(0..).all(|(row, number)| row.row == number);
    if whole {
        Ok((rows, ticks))
    } else {
        Err(format!(
            "the emulated chip logged {} of {expected} rows",
            rows.len()
        ))
    }
}

fn row(line: &Line) -> Option<Row> {
    Some(Row {
        row: line.value("row", "number")?.parse().ok()?,
        position: line.value("row", "position")?.parse().ok()?,
        current: line.value("row", "current_a")?.parse().ok()?,
    })
}

/// Bits in which the rows of two replays differ; every bit of a row that only one of them has.
pub fn differing_bits(one: &[Row], other: &[Row]) -> u32 {
    let bits = |row: &Row| [row.row, row.position.to_bits(), row.current.to_bits()];
    let longer = one.len().abs_diff(other.len()) as u32;
    let common = one.iter().zip(other).map(|(one, other)| {
        let pairs = bits(one).into_iter().zip(bits(other));
        pairs
            .map(|(one, other)| (one ^ other).count_ones())
            .sum::<u32>()
    });
    common.sum::<u32>() + longer * 96
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
    fn a_log_is_read_whole_or_not_at_all() {
        let first = "row number=0 position=0.5 current_a=0.0";
        let second = "row number=1 position=-1.5e-3 current_a=2.0";
        let end = "deadlines ticks=41 missed=0";
        let (rows, ticks) = read(&log(&["replay rows=2", first, second, end])).unwrap();
        let expected = Row {
            row: 1,
            position: -1.5e-3,
            current: 2.0,
        };
        assert_eq!((rows[1], rows.len(), ticks), (expected, 2, 41));
        for damaged in [
            &["replay rows=2", first, end][..],
            &["replay rows=2", second, first, end],
            &["replay rows=2", first, second],
            &[first, second, end],
        ] {
            assert!(read(&log(damaged)).is_err(), "{damaged:?}");
        }
    }

    #[test]
    fn every_differing_bit_counts() {
        let row = Row {
            row: 3,
            position: 1.0,
            current: 2.0,
        };
        let near = Row {
            position: f32::from_bits(1.0_f32.to_bits() + 1),
            ..row
        };
        assert_eq!(differing_bits(&[row, row], &[row, row]), 0);
        assert_eq!(differing_bits(&[row, row], &[row, near]), 1);
        assert_eq!(differing_bits(&[row, row], &[row]), 96);
    }
}
