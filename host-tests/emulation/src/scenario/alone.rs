//! The throttle by itself: it starts, answers, ticks; and it starts anew when its tick stops.

use serde::Serialize;

use super::{Alone, Call, Consoles, Counted, MILLISECOND, write};
use crate::running::{Event, Running};

/// What came of it.
#[derive(Debug, Serialize)]
pub(super) struct Throttle {
    /// What it says before anything is asked.
    greeting: String,
    /// `status` after a step to 0.8 rad under its own drive.
    status: String,
    /// `status` after its motor was open for a while, the longest tick there is.
    status_with_motor_open: String,
    counted: Counted,
    /// `faults` after its tick had stopped.
    faults_after_stopped_tick: String,
    /// How long it took from there to the reset, ms.
    reset_after_ms: f64,
}

/// What the throttle's own loop is told.
const ORDERS: [&str; 3] = ["mode position", "arm", "step 0.2 0.8"];

/// Most time that the watchdog may take, ms: its oscillator is 17 kHz at least, so 38 ms.
const MOST_WAIT: u64 = 100;

pub(super) fn throttle(call: &Call) -> Result<Throttle, String> {
    let mut board = Alone(Running::start(&call.throttle)?);
    board.run_for(300 * MILLISECOND)?;
    let greeting = board.0.transcript(0);
    for line in ORDERS {
        board.order((), line)?;
    }
    board.run_for(700 * MILLISECOND)?;
    let status = board.ask((), "status")?;
    for line in ["inject motor_open", "step 0.8 0.3"] {
        board.order((), line)?;
    }
    board.run_for(300 * MILLISECOND)?;
    let status_with_motor_open = board.ask((), "status")?;
    let counted = Counted::new(&board.0.outputs.counts, board.0.now());
    board.0.next.events.push(Event::StopTick(true));
    let resets = board.0.outputs.counts.resets;
    let stopped = board.0.now();
    for _ in 0..10 * MOST_WAIT {
        board.run_for(MILLISECOND / 10)?;
        if board.0.outputs.counts.resets > resets {
            break;
        }
    }
    let reset_after_ms = (board.0.now() - stopped) as f64 * 1e-6;
    if board.0.outputs.counts.resets == resets {
        return Err(format!("no reset within {MOST_WAIT} ms of the last tick"));
    }
    board.0.next.events.push(Event::StopTick(false));
    board.run_for(300 * MILLISECOND)?;
    let faults_after_stopped_tick = board.ask((), "faults")?;
    let (_, log) = board.0.cut_power()?;
    write(&call.directory, "throttle.defmt", &log)?;
    Ok(Throttle {
        greeting,
        status,
        status_with_motor_open,
        counted,
        faults_after_stopped_tick,
        reset_after_ms,
    })
}
