//! The controller and the throttle at their wires.

use serde::Serialize;

use crate::harness::STEP;

use super::{Call, Consoles, Counted, MILLISECOND, Pair, Part, Side, part, write};

/// What the controller has to know of the throttle: `host-tests/machines/throttle-loop.toml`. Its position
/// is 0 at the throttle's rest.
const PARAMETERS: [(&str, &str); 24] = [
    ("supply_minimum", "8"),
    ("supply_maximum", "16"),
    ("resistance", "2"),
    ("inductance", "1.2e-3"),
    ("torque_constant", "0.38"),
    ("inertia", "1.6e-3"),
    ("viscous", "8e-3"),
    ("static", "0.28"),
    ("coulomb", "0.24"),
    ("spring", "0"),
    ("spring_rest", "0"),
    ("spring_preload", "0"),
    ("proportional", "25"),
    ("integral", "100"),
    ("derivative", "0.5"),
    ("derivative_filter_time", "4e-3"),
    ("position_unit", "4e-4"),
    ("lower_stop", "-0.18"),
    ("upper_stop", "1.37"),
    ("continuous_current", "3"),
    ("peak_current", "8"),
    ("load", "0.6"),
    ("current_offset", "0"),
    ("command_timeout", "60"),
];

/// What the throttle has and nobody tells the controller: a return spring of 0.4 N·m/rad about its rest.
const THROTTLE: [&str; 3] = ["set spring_preload 0", "set spring 0.4", "arm"];

impl Pair {
    /// Gives the throttle its spring, and arms it.
    pub(super) fn ready_throttle(&mut self) -> Result<(), String> {
        for line in THROTTLE {
            self.order(Side::Throttle, line)?;
        }
        Ok(())
    }
}

/// What came of the parameters.
#[derive(Debug, Serialize)]
pub(super) struct Store {
    /// The controller's greeting at its first start.
    first_greeting: String,
    /// `save`'s answer.
    saved: String,
    /// Sectors erased, words programmed, and stores that tried to set a bit.
    flash: [u64; 3],
    /// The greeting at the start behind the end of power.
    second_greeting: String,
    /// `show torque_constant` behind it.
    shown: String,
    /// With 0.4 set, a second `save` begun, and the power lost in the middle of it: the greeting at the next
    /// start.
    greeting_after_torn_save: String,
    /// `faults` behind it.
    faults_after_torn_save: String,
    /// `show torque_constant` behind it.
    shown_after_torn_save: String,
    /// Words that this `save` had programmed by then.
    torn_after_words: u64,
}

/// What came of the loop.
#[derive(Debug, Serialize)]
pub(super) struct Driven {
    /// Where the controller had the throttle after each command: its name, what was asked for and what the
    /// throttle's tracks say, rad from the rest.
    positions: Vec<(String, f64, f64)>,
    /// `status` of both at the end.
    controller_status: String,
    throttle_status: String,
    controller: Counted,
    throttle: Counted,
    /// Captures in the log, by what was driven meanwhile.
    captures: Vec<String>,
    /// What the controller estimates from its own log of a worn throttle, the spring told to it.
    refit: String,
}

/// The throttle's friction once it is worn, N·m: the controller was told 0.24.
const WORN: [&str; 2] = ["set static 0.36", "set coulomb 0.3"];

/// Wears the throttle, drives it for the ten seconds that the controller's log holds, and has it estimate the friction anew.
fn refit(pair: &mut Pair) -> Result<String, String> {
    for line in ["disarm", "set spring 0.4"] {
        pair.order(Side::Controller, line)?;
    }
    pair.order(Side::Throttle, "disarm")?;
    for line in WORN.into_iter().chain(["arm"]) {
        pair.order(Side::Throttle, line)?;
    }
    // It rests where its new spring has it.
    pair.run_for(500 * MILLISECOND)?;
    for line in ["zero", "arm", "sweep 0.6 0.4 0.7 4 10"] {
        pair.order(Side::Controller, line)?;
    }
    pair.run_for(10_000 * MILLISECOND)?;
    pair.order(Side::Controller, "disarm")?;
    let heard = pair.controller.heard.len();
    pair.order(Side::Controller, "refit")?;
    for _ in 0..100 {
        pair.run_for(100 * MILLISECOND)?;
        let said = pair.controller.transcript(heard);
        if let Some(line) = said.lines().find(|line| line.contains("refit: ")) {
            return Ok(line.to_owned());
        }
    }
    Err("no refit in 10 s".to_owned())
}

/// The store, and the loop with what is stored.
pub(super) fn pair(call: &Call) -> Result<Vec<Part>, String> {
    let (store, parameters) = store(call)?;
    write(&call.directory, super::PARAMETERS, &parameters)?;
    let driven = drive(call, &parameters)?;
    Ok([part("store", store)?, part("driven", driven)?].concat())
}

/// A controller that was told its parameters and saved them.
struct Saved {
    greeting: String,
    /// `save`'s answer.
    answer: String,
    /// Sectors erased, words programmed, and stores that tried to set a bit.
    flash: [u64; 3],
    parameters: Vec<u8>,
}

/// Tells the controller its parameters, has it save them, and cuts its power.
fn save(call: &Call) -> Result<Saved, String> {
    let mut pair = Pair::start(&call.controller, &call.throttle)?;
    pair.run_for(200 * MILLISECOND)?;
    let greeting = pair.controller.transcript(0);
    for (name, value) in PARAMETERS {
        pair.order(Side::Controller, &format!("set {name} {value}"))?;
    }
    let answer = pair.ask(Side::Controller, "save")?;
    let flash = pair.controller.outputs.counts.flash;
    let (parameters, _) = pair.controller.cut_power()?;
    Ok(Saved {
        greeting,
        answer,
        flash,
        parameters,
    })
}

/// What the flash holds where parameters are once the controller has saved what it has to know.
pub(super) fn parameters(call: &Call) -> Result<Vec<u8>, String> {
    save(call).map(|saved| saved.parameters)
}

/// The store over ends of power, and the parameters in it.
fn store(call: &Call) -> Result<(Store, Vec<u8>), String> {
    let Saved {
        greeting: first_greeting,
        answer: saved,
        flash,
        parameters,
    } = save(call)?;
    let mut pair = Pair::storing(call, &parameters)?;
    pair.run_for(200 * MILLISECOND)?;
    let second_greeting = pair.controller.transcript(0);
    let shown = pair.ask(Side::Controller, "show torque_constant")?;
    let (torn, torn_after_words) = tear(pair)?;
    let mut pair = Pair::storing(call, &torn)?;
    pair.run_for(200 * MILLISECOND)?;
    let greeting_after_torn_save = pair.controller.transcript(0);
    let faults_after_torn_save = pair.ask(Side::Controller, "faults")?;
    let shown_after_torn_save = pair.ask(Side::Controller, "show torque_constant")?;
    let store = Store {
        first_greeting,
        saved,
        flash,
        second_greeting,
        shown,
        greeting_after_torn_save,
        faults_after_torn_save,
        shown_after_torn_save,
        torn_after_words,
    };
    Ok((store, parameters))
}

/// Words that a `save` is let program before its power is cut: fewer than it needs.
const TORN_AFTER: u64 = 20;

/// Cuts the power in the middle of a `save`. What the flash holds then, and how many words were programmed.
fn tear(mut pair: Pair) -> Result<(Vec<u8>, u64), String> {
    pair.order(Side::Controller, "set torque_constant 0.4")?;
    let words = |pair: &Pair| pair.controller.outputs.counts.flash[1];
    let before = words(&pair);
    pair.controller.type_line("save");
    for _ in 0..LONGEST_SAVE {
        pair.run_for(STEP)?;
        let programmed = words(&pair) - before;
        if programmed >= TORN_AFTER {
            return Ok((pair.controller.cut_power()?.0, programmed));
        }
    }
    Err(format!("`save` did not program {TORN_AFTER} words in 1 s"))
}

/// Steps of the harness that a `save` may take: 1 s.
const LONGEST_SAVE: u64 = 1_000_000_000 / STEP;

/// A capture of the controller, dumped.
pub(super) fn capture(pair: &mut Pair) -> Result<(), String> {
    pair.order(
        Side::Controller,
        "record 0 682 now input position current_a",
    )?;
    pair.run_for(690 * MILLISECOND)?;
    pair.order(Side::Controller, "dump")?;
    pair.run_for(750 * MILLISECOND)
}

/// Captures of each drive.
const CAPTURES: usize = 3;

/// The loop behind its start, the throttle with its spring, the controller with what it has to know, armed.
pub(super) fn armed(call: &Call) -> Result<Pair, String> {
    let mut pair = Pair::start(&call.controller, &call.throttle)?;
    pair.run_for(200 * MILLISECOND)?;
    for (name, value) in PARAMETERS {
        pair.order(Side::Controller, &format!("set {name} {value}"))?;
    }
    // Its own supply was another one.
    pair.order(Side::Controller, "clear")?;
    arm(&mut pair)?;
    Ok(pair)
}

/// Gives the throttle its spring, and arms both.
fn arm(pair: &mut Pair) -> Result<(), String> {
    pair.ready_throttle()?;
    pair.order(Side::Controller, "zero")?;
    pair.order(Side::Controller, "arm")
}

/// Drives the throttle by the controller: to a position, by a sweep and by a triangle, and records.
fn drive(call: &Call, parameters: &[u8]) -> Result<Driven, String> {
    let mut pair = Pair::storing(call, parameters)?;
    pair.run_for(100 * MILLISECOND)?;
    arm(&mut pair)?;
    let rest = pair
        .harness
        .position()
        .ok_or("the throttle has no tracks")?;
    let mut positions = Vec::new();
    for (name, target) in [("step", 0.6), ("step back", 0.1)] {
        pair.order(Side::Controller, &format!("step {target} {target}"))?;
        pair.run_for(600 * MILLISECOND)?;
        let position = pair.harness.position().unwrap_or(f64::NAN) - rest;
        positions.push((name.to_owned(), target, position));
    }
    let mut captures = Vec::new();
    for (name, signal) in [
        ("sweep", "sweep 0.6 0.4 0.7 4 5"),
        ("triangle", "triangle 0.55 0.4 1.3"),
    ] {
        pair.order(Side::Controller, signal)?;
        for _ in 0..CAPTURES {
            capture(&mut pair)?;
            captures.push(name.to_owned());
        }
    }
    let refit = refit(&mut pair)?;
    pair.order(Side::Controller, "arm")?;
    let controller_status = pair.ask(Side::Controller, "status")?;
    let throttle_status = pair.ask(Side::Throttle, "status")?;
    let Pair {
        controller,
        throttle,
        ..
    } = pair;
    let counted = [&controller, &throttle]
        .map(|running| Counted::new(&running.outputs.counts, running.now()));
    let [counted_controller, counted_throttle] = counted;
    let transcript = controller.transcript(0);
    write(&call.directory, "controller.txt", transcript.as_bytes())?;
    let (_, log) = controller.cut_power()?;
    write(&call.directory, "controller.defmt", &log)?;
    Ok(Driven {
        positions,
        controller_status,
        throttle_status,
        controller: counted_controller,
        throttle: counted_throttle,
        captures,
        refit,
    })
}
