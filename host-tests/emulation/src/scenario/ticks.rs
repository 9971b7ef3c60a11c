//! The longest interrupts of both images, at several numbers of cycles an instruction.

use std::num::NonZeroU64;

use serde::Serialize;

use super::faults::Bench;
use super::{Alone, Call, Consoles, MILLISECOND};
use crate::board::CORE_CLOCK;
use crate::chip::pins;
use crate::running::{Running, Setting};

/// What was seen of an image; `protected` is the controller with all of [`PROTECTIONS`].
#[derive(Debug, Serialize)]
pub(super) struct Ticks {
    image: &'static str,
    cycles_per_instruction: f64,
    /// `status` at the end: it has the longest plant and control interrupt, cycles.
    status: String,
    /// Longest time from a plant tick to its acknowledgement, µs.
    longest_latency_us: f64,
    /// Plant ticks that found the one before not acknowledged.
    missed: u64,
    /// Bytes of the stack that were used, and those that there are.
    stack_bytes: [u64; 2],
}

const CYCLES_PER_INSTRUCTION: [f64; 4] = [1.0, 1.5, 2.5, 3.0];

/// Every fault that a throttle body may have: `firmware/src/app/console/injection.rs`.
pub(super) const INJECTIONS: [&str; 17] = [
    "plate_jammed",
    "spring_broken",
    "friction_raised 1.8",
    "motor_open",
    "motor_shorted 0.2",
    "first_track_open",
    "first_track_shorted_high",
    "first_track_shorted_low",
    "first_track_stuck",
    "first_track_offset 0.3",
    "first_track_noisy 0.05",
    "second_track_open",
    "second_track_shorted_high",
    "second_track_shorted_low",
    "second_track_stuck",
    "second_track_offset 0.3",
    "second_track_noisy 0.05",
];

pub(super) fn ticks(call: &Call) -> Result<Vec<Ticks>, String> {
    let mut found = Vec::new();
    for cycles in CYCLES_PER_INSTRUCTION {
        let rate = NonZeroU64::new((CORE_CLOCK as f64 / cycles) as u64);
        let at = |setting: &Setting| Setting {
            instructions_per_second: rate.unwrap_or(setting.instructions_per_second),
            ..setting.clone()
        };
        found.push(throttle(&at(&call.throttle), cycles)?);
        let setting = at(&call.controller);
        found.push(controller(&setting, "controller", &[], cycles)?);
        found.push(controller(&setting, "protected", &PROTECTIONS, cycles)?);
    }
    Ok(found)
}

fn seen(
    board: &mut Alone,
    image: &'static str,
    cycles_per_instruction: f64,
) -> Result<Ticks, String> {
    let status = board.ask((), "status")?;
    let stack_bytes = board.0.stack()?;
    let counts = &board.0.outputs.counts;
    Ok(Ticks {
        image,
        cycles_per_instruction,
        status,
        longest_latency_us: counts.longest_latency as f64 * 1e-3,
        missed: counts.timer_ticks[1] + counts.conversions[1],
        stack_bytes,
    })
}

/// What is told before each fault, whatever the one before has latched.
const UP: [&str; 4] = ["disarm", "clear", "arm", "step 0.2 0.8"];

/// The throttle under its own drive, up and down, with one fault after the other from the top of each. What it
/// latches on the way is in the count of `status`.
fn throttle(setting: &Setting, cycles: f64) -> Result<Ticks, String> {
    let mut board = Alone(Running::start(setting)?);
    board.run_for(100 * MILLISECOND)?;
    board.order((), "mode position")?;
    for fault in INJECTIONS {
        for line in UP {
            board.ask((), line)?;
        }
        board.run_for(120 * MILLISECOND)?;
        board.order((), &format!("inject {fault}"))?;
        board.ask((), "step 0.8 0.3")?;
        board.run_for(120 * MILLISECOND)?;
        board.order((), "heal")?;
    }
    seen(&mut board, "throttle", cycles)
}

/// What the controller watches where it is set: all of it, so that each has its part in the longest interrupt.
const PROTECTIONS: [&str; 7] = [
    "speed_limit 30",
    "position_minimum -3",
    "position_maximum 3",
    "supply_current_limit 8",
    "regeneration_limit 2",
    "switch_temperature_maximum 90",
    "motor_temperature_maximum 110",
];

/// A sensor of 10 kΩ at 25 °C above as much: half the supply, mV.
const AT_25: u32 = 1650;

/// The controller armed, with these protections, while it sends a capture to its log. Where instructions take too long for it to be armed, what
/// it has latched is in `status`.
fn controller(
    setting: &Setting,
    name: &'static str,
    protections: &[&str],
    cycles: f64,
) -> Result<Ticks, String> {
    let mut bench = Bench::start(setting)?;
    let board = bench.board();
    let sensors = pins::TEMPERATURE_CHANNELS.map(|channel| (channel, AT_25));
    board.0.next.analogue.extend(sensors);
    for protection in protections {
        board.order((), &format!("set {protection}"))?;
    }
    if bench.arm().is_err() {
        return seen(bench.board(), name, cycles);
    }
    let board = bench.board();
    board.order((), "record 0 682 now input position current_a")?;
    board.run_for(690 * MILLISECOND)?;
    board.order((), "dump")?;
    board.run_for(750 * MILLISECOND)?;
    seen(board, name, cycles)
}
