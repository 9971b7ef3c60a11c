//! Faults of the chip and at its pins at any time in the loop: while a limit switch is sought, and in both modes.

use std::collections::BTreeMap;

use serde::Serialize;

use super::faults::{PATIENCE, RECURSION, SAG, START, UNDEFINED, USART1};
use super::{Call, Consoles, MILLISECOND, Pair, Side, pair, work_off};
use crate::chip;
use crate::harness::{Broken, STEP};
use crate::random::Random;
use crate::running::{ADC, Event, FIRST_INTERRUPT, Vector};

/// Runs of each fault in each state of the drive.
const RUNS: usize = 3;

/// What breaks.
#[derive(Debug, Clone, Copy)]
enum Cause {
    /// At the wires.
    Wire(Broken),
    /// In the chip: what happens, and what takes it away again.
    Chip(fn() -> Event, fn() -> Event),
    /// The crystal, which swings again behind an end of power.
    Crystal,
}

fn own_vector() -> Event {
    Event::Vector(ADC, Vector::Own)
}

/// Each fault, as `faults` has it.
const CAUSES: [(&str, Cause); 13] = [
    ("bridge_break", Cause::Wire(Broken::Bridge)),
    ("emergency_stop", Cause::Wire(Broken::EmergencyStop)),
    ("over_current", Cause::Wire(Broken::CurrentSensor)),
    ("under_voltage", Cause::Wire(Broken::Supply)),
    ("stop_reached", Cause::Wire(Broken::Switches)),
    (
        "brown_out",
        Cause::Chip(|| Event::Supply(SAG), || Event::Supply(chip::SUPPLY)),
    ),
    (
        "converter stands still",
        Cause::Chip(
            || Event::StopConverter(true),
            || Event::StopConverter(false),
        ),
    ),
    (
        "console's interrupt stuck",
        Cause::Chip(
            || Event::StickInterrupt(USART1, true),
            || Event::StickInterrupt(USART1, false),
        ),
    ),
    (
        "missed_deadline",
        Cause::Chip(
            || Event::StickInterrupt(ADC, true),
            || Event::StickInterrupt(ADC, false),
        ),
    ),
    (
        "panic",
        Cause::Chip(
            || Event::Vector(ADC, Vector::Of(FIRST_INTERRUPT)),
            own_vector,
        ),
    ),
    (
        "stack_overflow",
        Cause::Chip(|| Event::Vector(ADC, Vector::To(RECURSION)), own_vector),
    ),
    (
        "processor_fault",
        Cause::Chip(|| Event::Vector(ADC, Vector::To(UNDEFINED)), own_vector),
    ),
    ("clock_failed", Cause::Crystal),
];

/// States of the drive in which a fault comes.
#[derive(Debug, Clone, Copy)]
enum State {
    /// It seeks a limit switch.
    Search,
    /// A command of the position.
    Position,
    /// A command of the voltage.
    Voltage,
}

/// What came of a fault.
#[derive(Debug, Serialize)]
pub(super) struct AnyTime {
    fault: &'static str,
    runs: usize,
    /// The longest until the bridge was off, µs.
    latest_us: f64,
    /// What was latched first, and how often.
    named: BTreeMap<String, usize>,
    /// What was said in runs in which the drive did not move before, or did not let go.
    unsound: Vec<String>,
}

pub(super) fn any_time(call: &Call) -> Result<Vec<AnyTime>, String> {
    let parameters = pair::parameters(call)?;
    // Another seed for each, the same one each time.
    let seeds = (0..).map(|number| Random(0x9e37_79b9 ^ number));
    let causes: Vec<_> = CAUSES.into_iter().zip(seeds).collect();
    work_off(&causes, |&((fault, cause), random)| {
        Drive::start(call, &parameters, random)?.suffer(fault, cause)
    })
}

/// The loop, and what the controller has stored.
struct Drive<'a> {
    pair: Pair,
    parameters: &'a [u8],
    random: Random,
}

impl<'a> Drive<'a> {
    fn start(call: &Call, parameters: &'a [u8], random: Random) -> Result<Self, String> {
        let mut pair = Pair::storing(call, parameters)?;
        pair.run_for(START)?;
        pair.ready_throttle()?;
        Ok(Self {
            pair,
            parameters,
            random,
        })
    }

    fn suffer(&mut self, fault: &'static str, cause: Cause) -> Result<AnyTime, String> {
        let mut found = AnyTime {
            fault,
            runs: 0,
            latest_us: 0.0,
            named: BTreeMap::new(),
            unsound: Vec::new(),
        };
        for _ in 0..RUNS {
            for state in [State::Search, State::Position, State::Voltage] {
                let heard = self.pair.controller.heard.len();
                self.run(state, cause, &mut found).map_err(|reason| {
                    let said = self.pair.controller.transcript(heard);
                    format!("{fault}, {state:?}: {reason}\n{said}")
                })?;
            }
        }
        Ok(found)
    }

    fn run(&mut self, state: State, cause: Cause, found: &mut AnyTime) -> Result<(), String> {
        self.begin(state)?;
        let wait = STEP + self.random.below(200 * MILLISECOND);
        self.pair.run_for(wait)?;
        found.runs += 1;
        if !self.drives() {
            let status = self.ask("status")?;
            found
                .unsound
                .push(format!("{state:?}: off before: {status}"));
            return Ok(());
        }
        match cause {
            Cause::Wire(broken) => self.pair.harness.broken = broken,
            Cause::Chip(begin, _) => self.befall(begin()),
            Cause::Crystal => self.befall(Event::StopCrystal(true)),
        }
        let began = self.pair.controller.now();
        while !self.lets_go() && self.pair.controller.now() < began + PATIENCE {
            self.pair.run_for(STEP)?;
        }
        let after = (self.pair.controller.now() - began) as f64 * 1e-3;
        found.latest_us = found.latest_us.max(after);
        // A reset by the watchdog comes behind the safe state.
        self.pair.run_for(2 * MILLISECOND)?;
        self.heal(cause)?;
        let faults = self.ask("faults")?;
        let outputs = &self.pair.controller.outputs;
        let is_safe = outputs.lets_go() && outputs.tracks == [0; 2];
        let first = faults.split_once("first: ").and_then(|(_, rest)| {
            let name = rest.split_whitespace().next()?;
            Some(name.to_owned())
        });
        *found.named.entry(first.unwrap_or_default()).or_default() += 1;
        if !is_safe {
            found
                .unsound
                .push(format!("{state:?}: not in the safe state: {faults}"));
        }
        if let Cause::Crystal = cause {
            self.restart()?;
        }
        Ok(())
    }

    /// Takes a cause away, and waits for a start that it may have brought.
    fn heal(&mut self, cause: Cause) -> Result<(), String> {
        match cause {
            Cause::Wire(_) => self.pair.harness.broken = Broken::Nothing,
            Cause::Chip(_, end) => self.befall(end()),
            // rigless's exception that cannot be masked comes by the converter's vector.
            Cause::Crystal => self.befall(own_vector()),
        }
        self.pair.run_for(START)
    }

    /// Power off and on, with a crystal that swings.
    fn restart(&mut self) -> Result<(), String> {
        self.befall(Event::StopCrystal(false));
        self.befall(Event::PowerOff);
        self.pair.run_for(MILLISECOND)?;
        self.befall(Event::PowerOn(self.parameters.to_vec()));
        self.pair.run_for(START)
    }

    /// Seeks the lower limit switch, or what comes behind that.
    fn begin(&mut self, state: State) -> Result<(), String> {
        for line in ["disarm", "clear", "mode position"] {
            self.ask(line)?;
        }
        let speed = self.random.between(0.4, 1.2);
        self.order(&format!("home lower -0.175 {speed:.2}"))?;
        self.order("arm")?;
        if let State::Search = state {
            return Ok(());
        }
        self.found_switch()?;
        self.order("arm")?;
        if let State::Position = state {
            let target = self.random.between(0.4, 1.2);
            return self.order(&format!("step {target:.2} {target:.2}"));
        }
        self.order("step 0.5 0.5")?;
        self.pair.run_for(500 * MILLISECOND)?;
        for line in ["disarm", "mode voltage", "arm"] {
            self.order(line)?;
        }
        let [amplitude, frequency] = [
            self.random.between(2.0, 4.0),
            self.random.between(6.0, 12.0),
        ];
        self.order(&format!("triangle 0 {amplitude:.2} {frequency:.2}"))
    }

    /// Waits until the search has taken the drive's power.
    fn found_switch(&mut self) -> Result<(), String> {
        for _ in 0..80 {
            self.pair.run_for(50 * MILLISECOND)?;
            if !self.drives() {
                // It says so, behind the prompt.
                return self.pair.run_for(50 * MILLISECOND);
            }
        }
        let status = self.ask("status")?;
        Err(format!("the limit switch was not found in 4 s: {status}"))
    }

    fn drives(&self) -> bool {
        self.pair.controller.outputs.driven().is_some()
    }

    fn lets_go(&self) -> bool {
        self.pair.controller.outputs.lets_go()
    }

    fn befall(&mut self, event: Event) {
        self.pair.controller.next.events.push(event);
    }

    fn ask(&mut self, line: &str) -> Result<String, String> {
        self.pair.ask(Side::Controller, line)
    }

    fn order(&mut self, line: &str) -> Result<(), String> {
        self.pair.order(Side::Controller, line)
    }
}
