//! The controller's power lost in the middle of a `save`: at its first and its last operations of the flash and at
//! each sixteenth between them, within it or behind it; or at every one, within it and behind it. Each start costs
//! 1.3 s of translating the image anew, which a reset in rigless throws away: 21 min for every one of them.

use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use rigless::device::Level;
use serde::Serialize;

use super::{Alone, Call, Consoles, MILLISECOND, cores, faults, side_by_side};
use crate::chip::pins;
use crate::random::Random;
use crate::running::{Event, Running};

/// What came of a `save` that was cut short.
#[derive(Debug, Default, Serialize)]
pub(super) struct Cuts {
    /// Operations of the flash that the whole of it takes.
    operations: usize,
    /// Those of them that set bits: erases of a sector in which something stands.
    erases: usize,
    /// Starts behind a cut, between two operations or within one.
    starts: usize,
    /// Those at which the values were those before the `save`, and those behind it.
    before: usize,
    behind: usize,
    /// Starts at which `store_corrupt` was latched.
    named: usize,
    /// What was said at starts with values of both, or of neither.
    otherwise: Vec<String>,
}

/// The values that a `save` stores: which parameter, and what it is, as `show` prints it.
type Values = [(&'static str, &'static str); 2];

/// Those of the image.
const FIRST: Values = [("torque_constant", "0.06"), ("resistance", "1.0")];
const SECOND: Values = [("torque_constant", "0.38"), ("resistance", "2.0")];
const THIRD: Values = [("torque_constant", "0.4"), ("resistance", "2.5")];

/// From power on to behind the end of the greeting, ns: that takes 20 ms for each cycle an instruction, of which there are three
/// at most.
const START: u64 = 60 * MILLISECOND;

/// Operations at either end of a `save` that are all cut, and how many apart the others are.
const ENDS: usize = 4;
const EVERY: usize = 16;

/// More than the saves that the three sectors hold: one of them erases a used sector.
const MOST_SAVES: usize = 100;

/// An empty flash.
const ERASED: usize = 3 * 16 * 1024;

/// The first `save` in an empty flash, and the first that erases a sector in which something stands.
pub(super) fn cuts(call: &Call) -> Result<[Cuts; 2], String> {
    let place = |number: usize, operations: usize| {
        let is_end = number < ENDS || number + ENDS >= operations;
        [0, EVERY].map(|place| is_end || number % (2 * EVERY) == place)
    };
    cut_at(call, &place, 1)
}

/// The same with the power lost within and behind every operation.
pub(super) fn every_cut(call: &Call) -> Result<[Cuts; 2], String> {
    cut_at(call, &|_, _| [true; 2], cores())
}

/// Whether the power is lost within an operation, and behind it, by its number and how many there are.
type Places<'a> = &'a (dyn Fn(usize, usize) -> [bool; 2] + Sync);

fn cut_at(call: &Call, places: Places<'_>, workers: usize) -> Result<[Cuts; 2], String> {
    let mut board = begin(call)?;
    let empty = vec![0xff; ERASED];
    let first = save(&mut board, &SECOND, empty)?;
    let mut values = [&SECOND, &THIRD];
    let mut second = save(&mut board, values[1], last(&first))?;
    for _ in 0..MOST_SAVES {
        if second.windows(2).any(erases) {
            break;
        }
        values.swap(0, 1);
        second = save(&mut board, values[1], last(&second))?;
    }
    drop(board);
    Ok([
        cut(call, &first, [&FIRST, &SECOND], (places, workers))?,
        cut(call, &second, values, (places, workers))?,
    ])
}

/// What the flash holds behind the last operation.
fn last(images: &[Vec<u8>]) -> Vec<u8> {
    images.last().cloned().unwrap_or_default()
}

/// Whether an operation sets bits, of what is before and behind it.
fn erases(operation: &[Vec<u8>]) -> bool {
    let mut bytes = operation[0].iter().zip(&operation[1]);
    bytes.any(|(before, behind)| !before & behind != 0)
}

/// A controller that keeps what its flash holds behind each operation.
fn begin(call: &Call) -> Result<Alone, String> {
    let mut running = Running::start(&call.controller)?;
    running.next.levels = vec![(0, pins::EMERGENCY_STOP, Level::Low)];
    running.next.analogue = faults::at_rest();
    let mut board = Alone(running);
    board.run_for(100 * MILLISECOND)?;
    board.0.next.events.push(Event::KeepFlash);
    Ok(board)
}

/// What the flash held before a `save` and behind each operation of it.
fn save(board: &mut Alone, values: &Values, before: Vec<u8>) -> Result<Vec<Vec<u8>>, String> {
    for (name, value) in values {
        board.order((), &format!("set {name} {value}"))?;
    }
    board.0.kept = vec![before];
    board.order((), "save")?;
    Ok(std::mem::take(&mut board.0.kept))
}

/// Starts it with each of these in its flash, and with operations between two of them half done.
fn cut(
    call: &Call,
    images: &[Vec<u8>],
    values: [&Values; 2],
    (places, workers): (Places<'_>, usize),
) -> Result<Cuts, String> {
    let operations = images.len() - 1;
    let next = AtomicUsize::new(0);
    let work = || {
        let mut board = begin(call)?;
        let mut cuts = Cuts::default();
        loop {
            let number = next.fetch_add(1, Relaxed);
            if number >= operations {
                return Ok::<_, String>(cuts);
            }
            let [before, behind] = [&images[number], &images[number + 1]];
            let [within, between] = places(number, operations);
            let torn = within.then(|| torn([before, behind], number));
            let whole = between.then(|| behind.clone());
            for image in torn.into_iter().chain(whole) {
                cuts.count(start(&mut board, image)?, values);
            }
        }
    };
    let parts = side_by_side(workers, work)?;
    let whole = Cuts {
        operations,
        erases: images.windows(2).filter(|images| erases(images)).count(),
        ..Cuts::default()
    };
    Ok(parts.into_iter().fold(whole, Cuts::with))
}

impl Cuts {
    /// Takes what was said at a start.
    fn count(&mut self, said: String, values: [&Values; 2]) {
        let holds = |values: &Values| {
            let mut lines = values.iter();
            lines.all(|(name, value)| said.contains(&format!("{name} = {value} ")))
        };
        self.starts += 1;
        self.named += usize::from(said.contains("store_corrupt"));
        match values.map(holds) {
            [true, false] => self.before += 1,
            [false, true] => self.behind += 1,
            _ => self.otherwise.push(said),
        }
    }

    /// These and others.
    fn with(mut self, other: Self) -> Self {
        self.starts += other.starts;
        self.before += other.before;
        self.behind += other.behind;
        self.named += other.named;
        self.otherwise.extend(other.otherwise);
        self
    }
}

/// An operation half done: each bit that it changes has its old or its new value.
fn torn([before, behind]: [&Vec<u8>; 2], number: usize) -> Vec<u8> {
    let mut random = Random(0x6c07_8965 ^ (number as u32).wrapping_mul(0x9e37_79b9));
    let bytes = before.iter().zip(behind);
    bytes
        .map(|(before, behind)| {
            if before == behind {
                return *before;
            }
            before ^ (before ^ behind) & (random.bits() >> 8) as u8
        })
        .collect()
}

/// What it says behind power on with this in its flash.
fn start(board: &mut Alone, image: Vec<u8>) -> Result<String, String> {
    board.0.next.events.push(Event::PowerOff);
    board.run_for(MILLISECOND)?;
    let heard = board.0.heard.len();
    board.0.next.events.push(Event::PowerOn(image));
    // A fault that comes between two answers would be taken for one.
    board.0.next.analogue = faults::at_rest();
    board.run_for(START)?;
    for (name, _) in FIRST {
        board.ask((), &format!("show {name}"))?;
    }
    Ok(board.0.transcript(heard))
}
