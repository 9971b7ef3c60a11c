//! Each image by itself. The throttle starts, answers, ticks; it starts anew when its tick stops, and suffers faults. The controller
//! counts its encoder's edges and no spikes, and its clock goes on while it erases its flash.

use rigless::device::Level;
use serde::Serialize;

use super::faults::{Bench, RECURSION, START, UNDEFINED};
use super::{Alone, Call, Consoles, Counted, MILLISECOND, write};
use crate::chip::pins::{ENCODER_A, ENCODER_B, Pin};
use crate::harness::quadrature;
use crate::running::{Event, FIRST_INTERRUPT, Running, Vector};

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
    faults: Vec<Fault>,
}

/// What came of a fault of the chip, the throttle armed.
#[derive(Debug, Serialize)]
struct Fault {
    /// What was wrong.
    fault: &'static str,
    /// What `faults` says then.
    faults: String,
    /// Codes of the tracks at the end, and the share of the current's output: 0 is no position's and no current's.
    tracks: [u16; 2],
    current: f64,
}

/// Interrupt of TIM7, the throttle's most urgent one: RM0090, table 61.
const TIM7: u16 = 55;

/// What befalls the throttle, each with what takes it away again.
fn causes() -> [(&'static str, Event, Event); 4] {
    let led = |vector| Event::Vector(TIM7, vector);
    let own = || led(Vector::Own);
    [
        (
            "panic, by an interrupt that nobody serves",
            led(Vector::Of(FIRST_INTERRUPT)),
            own(),
        ),
        ("stack overflow", led(Vector::To(RECURSION)), own()),
        (
            "an instruction that is none",
            led(Vector::To(UNDEFINED)),
            own(),
        ),
        (
            "the most urgent interrupt stuck",
            Event::StickInterrupt(TIM7, true),
            Event::StickInterrupt(TIM7, false),
        ),
    ]
}

/// Has something befall the armed throttle, and takes it away again.
fn suffer(
    board: &mut Alone,
    (fault, begin, end): (&'static str, Event, Event),
) -> Result<Fault, String> {
    for line in ["disarm", "clear", "arm"] {
        board.ask((), line)?;
    }
    let tracks = board.0.outputs.tracks;
    if tracks.contains(&0) {
        return Err(format!("an armed throttle has its tracks at {tracks:?}"));
    }
    board.0.next.events.push(begin);
    board.run_for(100 * MILLISECOND)?;
    board.0.next.events.push(end);
    board.run_for(START)?;
    let faults = board.ask((), "faults")?;
    let outputs = &board.0.outputs;
    Ok(Fault {
        fault,
        faults,
        tracks: outputs.tracks,
        current: outputs.current,
    })
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
    let faults = causes()
        .into_iter()
        .map(|cause| suffer(&mut board, cause))
        .collect::<Result<_, _>>()?;
    let (_, log) = board.0.cut_power()?;
    write(&call.directory, "throttle.defmt", &log)?;
    Ok(Throttle {
        greeting,
        status,
        status_with_motor_open,
        counted,
        faults_after_stopped_tick,
        reset_after_ms,
        faults,
    })
}

/// What came of the controller.
#[derive(Debug, Serialize)]
pub(super) struct Controller {
    /// `status` before anything, behind spikes on both of its encoder's lines, and behind edges as fast as they may come.
    status: String,
    status_behind_spikes: String,
    status_behind_edges: String,
    /// Spikes, and edges.
    spikes: u64,
    edges: u64,
    /// Time that a `save`, which erases a sector, takes; and by how much the clock in `status` is behind then, ms.
    save_ms: f64,
    clock_lost_ms: f64,
    /// Erases behind which the data cache was not emptied, and what `FLASH_OPTCR` reads.
    unforgotten_erases: u64,
    flash_options: u64,
}

/// Spikes on the encoder's lines, their length and how far the second line's is behind the first one's, ns: without a
/// filter each counts four.
const SPIKES: u64 = 100;
const SPIKE: u64 = 300;
const SKEW: u64 = 60;

/// Edges, and the time from one to the next, ns: two million counts a second.
const EDGES: u64 = 400;
const EDGE: u64 = 500;

pub(super) fn controller(call: &Call) -> Result<Controller, String> {
    let mut bench = Bench::start(&call.controller)?;
    let board = bench.board();
    let level = |at: u64, pin: Pin, high: bool| (at, pin, Level::from(high));
    let rest = [ENCODER_A, ENCODER_B].map(|pin| level(board.0.now(), pin, false));
    board.0.next.levels.extend(rest);
    board.run_for(MILLISECOND)?;
    board.order((), "zero")?;
    let status = board.ask((), "status")?;
    for _ in 0..SPIKES {
        let now = board.0.now();
        board.0.next.levels.extend([
            level(now, ENCODER_A, true),
            level(now + SKEW, ENCODER_B, true),
            level(now + SPIKE, ENCODER_A, false),
            level(now + SKEW + SPIKE, ENCODER_B, false),
        ]);
        board.run_for(MILLISECOND / 50)?;
    }
    let status_behind_spikes = board.ask((), "status")?;
    let now = board.0.now();
    for edge in 1..=EDGES {
        let [a, b] = quadrature(edge as i64);
        let at = now + edge * EDGE;
        let both = [level(at, ENCODER_A, a), level(at, ENCODER_B, b)];
        board.0.next.levels.extend(both);
    }
    board.run_for(EDGES * EDGE + MILLISECOND)?;
    let status_behind_edges = board.ask((), "status")?;
    let before = clock(board)?;
    let began = board.0.now();
    board.order((), "save")?;
    let save_ms = (board.0.now() - began) as f64 * 1e-6;
    let behind = clock(board)?;
    let counts = board.0.outputs.counts;
    Ok(Controller {
        unforgotten_erases: counts.unforgotten_erases,
        flash_options: counts.flash_options,
        status,
        status_behind_spikes,
        status_behind_edges,
        spikes: SPIKES,
        edges: EDGES,
        save_ms,
        clock_lost_ms: behind - before,
    })
}

/// By how much the clock in `status` is behind the time of its question, ms.
fn clock(board: &mut Alone) -> Result<f64, String> {
    let now = board.0.now() as f64 * 1e-6;
    let status = board.ask((), "status")?;
    let told = status.lines().find_map(|line| {
        let (_, time) = line.strip_suffix(" s")?.rsplit_once(", ")?;
        time.parse::<f64>().ok()
    });
    Ok(now - 1e3 * told.ok_or("no time in a `status`")?)
}
