//! The controller's power lost in the middle of a `save`: at its first and its last operations of the flash and at
//! each sixteenth between them, within it or behind it. Each start costs 1.3 s of translating the image anew: at all 494
//! operations, within them and behind them, it would be 21 min; `host-tests/tests/operation.rs` cuts at every one, in the
//! store as the host runs it.

use rigless::device::Level;
use serde::Serialize;

use super::{Alone, Call, Consoles, MILLISECOND};
use crate::chip::pins;
use crate::running::{Event, Running};

/// What came of a `save` that was cut short.
#[derive(Debug, Default, Serialize)]
pub(super) struct Cuts {
    /// Operations of the flash that the whole of it takes.
    operations: usize,
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

/// From power on to the end of the greeting, ns.
const START: u64 = 30 * MILLISECOND;

/// Operations at either end of a `save` that are all cut, and how many apart the others are.
const ENDS: usize = 4;
const EVERY: usize = 16;

/// An empty flash.
const ERASED: usize = 3 * 16 * 1024;

/// A `save` in an empty flash, which erases a sector, and one behind it.
pub(super) fn cuts(call: &Call) -> Result<[Cuts; 2], String> {
    let mut running = Running::start(&call.controller)?;
    running.next.levels = vec![(0, pins::EMERGENCY_STOP, Level::Low)];
    let mut board = Alone(running);
    board.run_for(100 * MILLISECOND)?;
    board.0.next.events.push(Event::KeepFlash);
    let empty = vec![0xff; ERASED];
    let first = save(&mut board, &SECOND, empty)?;
    let whole = first.last().cloned().unwrap_or_default();
    let second = save(&mut board, &THIRD, whole)?;
    Ok([
        cut(&mut board, &first, [&FIRST, &SECOND])?,
        cut(&mut board, &second, [&SECOND, &THIRD])?,
    ])
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
fn cut(board: &mut Alone, images: &[Vec<u8>], values: [&Values; 2]) -> Result<Cuts, String> {
    let mut cuts = Cuts {
        operations: images.len() - 1,
        ..Cuts::default()
    };
    let mut random = 0x6c07_8965_u32;
    for (number, pair) in images.windows(2).enumerate() {
        let is_end = number < ENDS || number + ENDS >= cuts.operations;
        let within = is_end || number % (2 * EVERY) == 0;
        let between = is_end || number % (2 * EVERY) == EVERY;
        let torn = within.then(|| torn([&pair[0], &pair[1]], &mut random));
        let whole = between.then(|| pair[1].clone());
        for image in torn.into_iter().chain(whole) {
            cuts.starts += 1;
            let said = start(board, image)?;
            let holds = |values: &Values| {
                let mut lines = values.iter();
                lines.all(|(name, value)| said.contains(&format!("{name} = {value} ")))
            };
            match values.map(holds) {
                [true, false] => cuts.before += 1,
                [false, true] => cuts.behind += 1,
                _ => cuts.otherwise.push(said.clone()),
            }
            cuts.named += usize::from(said.contains("store_corrupt"));
        }
    }
    Ok(cuts)
}

/// An operation half done: each bit that it changes has its old or its new value.
fn torn([before, behind]: [&[u8]; 2], random: &mut u32) -> Vec<u8> {
    let bytes = before.iter().zip(behind);
    bytes
        .map(|(before, behind)| {
            if before == behind {
                return *before;
            }
            *random ^= *random << 13;
            *random ^= *random >> 17;
            *random ^= *random << 5;
            before ^ (before ^ behind) & (*random >> 8) as u8
        })
        .collect()
}

/// What it says behind power on with this in its flash.
fn start(board: &mut Alone, image: Vec<u8>) -> Result<String, String> {
    board.0.next.events.push(Event::PowerOff);
    board.run_for(MILLISECOND)?;
    let heard = board.0.heard.len();
    board.0.next.events.push(Event::PowerOn(image));
    board.run_for(START)?;
    for (name, _) in FIRST {
        board.ask((), &format!("show {name}"))?;
    }
    Ok(board.0.transcript(heard))
}
