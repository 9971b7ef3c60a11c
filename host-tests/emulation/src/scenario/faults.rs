//! The controller by itself, armed, with one fault after the other.

use rigless::device::Level;
use serde::Serialize;

use super::{Alone, Call, Consoles, MILLISECOND};
use crate::chip::{self, pins};
use crate::random::Random;
use crate::running::{ADC, Event, FIRST_INTERRUPT, Running, Setting, Vector};

/// What came of a fault.
#[derive(Debug, Serialize)]
pub(super) struct Fault {
    /// What was wrong.
    fault: &'static str,
    /// From there until the timer and the enable had let go of the bridge, and the brake was on, µs; none if they did not.
    let_go_after_us: Option<f64>,
    /// Whether it was so from then on, and the codes of the tracks at the end: 0 is no position's.
    held: bool,
    tracks: [u16; 2],
    /// Starts that it took.
    resets: usize,
    /// What `faults` says then.
    faults: String,
    /// And `status`: it has the longest interrupts since the last start.
    status: String,
}

/// What came of all of them.
#[derive(Debug, Serialize)]
pub(super) struct Faults {
    faults: Vec<Fault>,
    /// `faults` of a winding that was pressed with until it was too hot.
    faults_overloaded: String,
    /// `faults` and `clear`'s answer behind a reset right after that, and `faults` behind an end of power, in which the RAM
    /// is lost.
    faults_behind_reset: String,
    cleared_behind_reset: String,
    faults_behind_power: String,
    /// `arm`'s answer while the crystal is dead, behind a `clear`.
    armed_without_crystal: String,
    /// The greeting at a start without a crystal.
    greeting_without_crystal: String,
    /// `faults` with the crystal back, behind an end of power.
    faults_with_crystal: String,
    /// `status` while the terminal was flooded and torn.
    status_in_flood: String,
    /// `status` behind a `stop` in the middle of it.
    status_behind_stop: String,
    /// What stands still while a probe has halted the core: `DBGMCU_APB1_FZ` and `DBGMCU_APB2_FZ`.
    debug_freeze: [u64; 2],
}

/// Step in which the outputs are looked at, ns: a plant tick.
const LOOK: u64 = 50_000;

/// Longest that a fault may take to its safe state, ns.
pub(super) const PATIENCE: u64 = 400 * MILLISECOND;

/// From where the plant's ticks end to behind the watchdog's reset, ns.
const RESET: u64 = 30 * MILLISECOND;

/// From a reset to the console's first answer, ns: without a crystal it is waited for.
pub(super) const START: u64 = 250 * MILLISECOND;

/// Supply, mV at its pin: 24 V by the divider of eleven.
const SUPPLY: u32 = 2182;

/// The processor's own supply while it sags, mV: below its detector's 2.93 V, above the reset's 2.83 V.
pub(super) const SAG: u32 = 2900;

/// No current, mV.
const NO_CURRENT: u32 = 1650;

/// What the current's sensor says of an ampere, mV.
const AMPERE: f64 = 66.0;

/// The declared winding's resistance, Ω, and inductance, H.
const WINDING: [f64; 2] = [1.0, 1e-3];

/// What is told before the winding is heated: how much the mechanism holds, as else the encoder may not stand still; and
/// more than the declared continuous current, so that it cools in a tenth of the time.
const HEATED: [&str; 2] = ["set load 3", "set continuous_current 16"];

/// How long the winding cools before, ns: it bears (24.5² − 16²) A² s, and with other numbers than before it may be that
/// hot, which takes 1.3 s.
const COOLING: u64 = 1500 * MILLISECOND;

/// Longest time in which it has to become too hot, ns: at the 20 A that the drive lets flow it takes 2.4 s.
const HEATING: u64 = 3000 * MILLISECOND;

/// USART1's interrupt: RM0090, table 61.
pub(super) const USART1: u16 = 37;

/// `push {r0-r7, lr}` and a branch to it: a handler that calls itself for ever.
pub(super) const RECURSION: u32 = 0xe7fd_b5ff;

/// `udf #0`, twice: no instruction.
pub(super) const UNDEFINED: u32 = 0xde00_de00;

/// What is told before each fault: the bridge switches, and the winding has no voltage.
const ORDERS: [&str; 4] = ["zero", "mode voltage", "arm", "step 0 0"];

/// A controller at a bench: supply, no current, switches closed, nothing pressed.
pub(super) struct Bench(Alone);

impl Bench {
    pub(super) fn start(setting: &Setting) -> Result<Self, String> {
        let mut running = Running::start(setting)?;
        let levels = [
            (pins::BRIDGE_BREAK, Level::High),
            (pins::EMERGENCY_STOP, Level::Low),
            (pins::LOWER_SWITCH, Level::Low),
            (pins::UPPER_SWITCH, Level::Low),
        ];
        running.next.levels = levels.map(|(pin, level)| (0, pin, level)).to_vec();
        let mut bench = Self(Alone(running));
        bench.convert(NO_CURRENT);
        bench.0.run_for(START)?;
        Ok(bench)
    }

    pub(super) fn board(&mut self) -> &mut Alone {
        &mut self.0
    }

    fn running(&mut self) -> &mut Running {
        &mut self.0.0
    }

    fn convert(&mut self, current: u32) {
        self.running().next.analogue = analogue(current);
    }

    fn lets_go(&mut self) -> bool {
        self.running().outputs.lets_go()
    }

    /// Armed, the bridge switching, no voltage at the winding.
    pub(super) fn arm(&mut self) -> Result<(), String> {
        // Whatever there was before.
        for line in ["disarm", "clear"] {
            self.0.ask((), line)?;
        }
        for line in ORDERS {
            self.0.order((), line)?;
        }
        self.0.run_for(2 * MILLISECOND)?;
        let outputs = &self.running().outputs;
        if outputs.driven().is_some() && outputs.brake_release {
            Ok(())
        } else {
            let faults = self.0.ask((), "faults")?;
            Err(format!("the bridge does not switch: {faults:?}"))
        }
    }

    /// Has something befall the armed drive, waits for the safe state, takes it away again by `end`, and asks.
    fn suffer(
        &mut self,
        fault: &'static str,
        begin: impl FnOnce(&mut Running),
        end: impl FnOnce(&mut Running),
    ) -> Result<Fault, String> {
        let resets = self.running().outputs.counts.resets;
        begin(self.running());
        let began = self.running().now();
        let mut let_go = None;
        while self.running().now() < began + PATIENCE && let_go.is_none() {
            self.0.run_for(LOOK)?;
            if self.lets_go() {
                let_go = Some((self.running().now() - began) as f64 * 1e-3);
            }
        }
        // A reset by the watchdog comes behind the safe state.
        self.0.run_for(2 * MILLISECOND)?;
        end(self.running());
        self.0.run_for(START)?;
        let mut held = self.lets_go();
        let faults = self.0.ask((), "faults")?;
        let status = self.0.ask((), "status")?;
        held &= self.lets_go();
        let outputs = &self.running().outputs;
        let (resets, tracks) = (outputs.counts.resets - resets, outputs.tracks);
        Ok(Fault {
            fault,
            let_go_after_us: let_go,
            held,
            tracks,
            resets,
            faults,
            status,
        })
    }

    /// The same with the drive armed.
    fn suffer_armed(
        &mut self,
        fault: &'static str,
        begin: impl FnOnce(&mut Running),
        end: impl FnOnce(&mut Running),
    ) -> Result<Fault, String> {
        self.arm()?;
        self.suffer(fault, begin, end)
    }
}

/// The supply, and this at the current's input, mV.
fn analogue(current: u32) -> Vec<(u8, u32)> {
    vec![
        (pins::CURRENT_CHANNEL, current),
        (pins::SUPPLY_CHANNEL, SUPPLY),
    ]
}

/// The same with no current.
pub(super) fn at_rest() -> Vec<(u8, u32)> {
    analogue(NO_CURRENT)
}

fn level(pin: pins::Pin, level: Level) -> impl FnOnce(&mut Running) {
    move |running| {
        let now = running.now();
        running.next.levels.push((now, pin, level));
    }
}

fn event(event: Event) -> impl FnOnce(&mut Running) {
    move |running| running.next.events.push(event)
}

/// The ADC's interrupt leads elsewhere.
fn led(vector: Vector) -> impl FnOnce(&mut Running) {
    event(Event::Vector(ADC, vector))
}

fn nothing(_: &mut Running) {}

pub(super) fn faults(call: &Call) -> Result<Faults, String> {
    let mut bench = Bench::start(&call.controller)?;
    let mut faults = vec![
        bench.suffer_armed(
            "break input, a pulse of 1 µs",
            |running| {
                let now = running.now();
                let pulse = [(0, Level::Low), (1000, Level::High)];
                let levels = pulse.map(|(after, level)| (now + after, pins::BRIDGE_BREAK, level));
                running.next.levels.extend(levels);
            },
            nothing,
        )?,
        bench.suffer_armed(
            "emergency stop",
            level(pins::EMERGENCY_STOP, Level::High),
            level(pins::EMERGENCY_STOP, Level::Low),
        )?,
        bench.suffer_armed(
            "the processor's supply sags to 2.9 V",
            event(Event::Supply(SAG)),
            event(Event::Supply(chip::SUPPLY)),
        )?,
        bench.suffer_armed(
            "current sensor at its end",
            |running| running.next.analogue = vec![(pins::CURRENT_CHANNEL, 3300)],
            |running| running.next.analogue = vec![(pins::CURRENT_CHANNEL, NO_CURRENT)],
        )?,
    ];
    let debug_freeze = bench.running().outputs.debug_freeze;
    faults.push(bench.suffer_armed(
        "current sensor stuck at no current, 6 V, shaft blocked",
        |running| running.type_line("step 0 6"),
        nothing,
    )?);
    faults.push(bench.suffer_armed(
        "converter stands still",
        event(Event::StopConverter(true)),
        event(Event::StopConverter(false)),
    )?);
    faults.push(bench.suffer_armed(
        "an interrupt of the console stuck",
        event(Event::StickInterrupt(USART1, true)),
        event(Event::StickInterrupt(USART1, false)),
    )?);
    faults.push(bench.suffer_armed(
        "the most urgent interrupt stuck",
        event(Event::StickInterrupt(ADC, true)),
        event(Event::StickInterrupt(ADC, false)),
    )?);
    for (fault, vector) in [
        (
            "panic, by an interrupt that nobody serves",
            Vector::Of(FIRST_INTERRUPT),
        ),
        ("stack overflow", Vector::To(RECURSION)),
        ("an instruction that is none", Vector::To(UNDEFINED)),
    ] {
        faults.push(bench.suffer_armed(fault, led(vector), led(Vector::Own))?);
    }
    let faults_overloaded = bench.overload()?;
    event(Event::StopConverter(true))(bench.running());
    bench.0.run_for(RESET)?;
    event(Event::StopConverter(false))(bench.running());
    bench.0.run_for(START)?;
    let faults_behind_reset = bench.0.ask((), "faults")?;
    let cleared_behind_reset = bench.0.ask((), "clear")?;
    bench.restart()?;
    let faults_behind_power = bench.0.ask((), "faults")?;
    let (status_in_flood, status_behind_stop) = flood(&mut bench)?;
    faults.push(bench.suffer_armed(
        "crystal stops",
        event(Event::StopCrystal(true)),
        led(Vector::Own),
    )?);
    bench.0.ask((), "clear")?;
    let armed_without_crystal = bench.0.ask((), "arm")?;
    let greeting_without_crystal = bench.restart()?;
    bench.running().next.events.push(Event::StopCrystal(false));
    bench.restart()?;
    let faults_with_crystal = bench.0.ask((), "faults")?;
    Ok(Faults {
        faults,
        faults_overloaded,
        faults_behind_reset,
        cleared_behind_reset,
        faults_behind_power,
        armed_without_crystal,
        greeting_without_crystal,
        faults_with_crystal,
        status_in_flood,
        status_behind_stop,
        debug_freeze,
    })
}

impl Bench {
    /// Power off and on; the greeting behind it.
    fn restart(&mut self) -> Result<String, String> {
        let parameters = Vec::new();
        self.running().next.events.push(Event::PowerOff);
        self.0.run_for(MILLISECOND)?;
        let heard = self.running().heard.len();
        self.running().next.events.push(Event::PowerOn(parameters));
        self.convert(NO_CURRENT);
        self.0.run_for(START)?;
        Ok(self.running().transcript(heard))
    }

    /// Presses against what holds the shaft with all that the supply drives, until the drive ends it; what `faults`
    /// says then.
    fn overload(&mut self) -> Result<String, String> {
        for line in HEATED {
            self.0.order((), line)?;
        }
        self.0.run_for(COOLING)?;
        self.arm()?;
        self.running().type_line("step 0 24");
        let [resistance, inductance] = WINDING;
        let mut current = 0.0;
        let end = self.running().now() + HEATING;
        while self.running().now() < end && !self.lets_go() {
            let supply = f64::from(SUPPLY) * 11e-3;
            let voltage = self.running().outputs.bridge.unwrap_or(0.0) * supply;
            current += (voltage - resistance * current) / inductance * LOOK as f64 * 1e-9;
            self.convert((f64::from(NO_CURRENT) + AMPERE * current).round() as u32);
            self.0.run_for(LOOK)?;
        }
        self.convert(NO_CURRENT);
        // What it says by itself would be taken for the answer.
        self.0.run_for(START)?;
        self.0.ask((), "faults")
    }

    fn line_errors(&mut self, per_million: u32) {
        let events = &mut self.running().next.events;
        events.push(Event::LineErrors(per_million));
    }
}

/// Bytes that flood the terminal: half a second of its line without a pause.
const FLOOD: usize = 5760;

/// Words in a million that come with a framing error while the terminal is flooded, and as many with noise: two in
/// ten bytes.
const LINE_ERRORS: u32 = 100_000;

/// Floods the armed drive's terminal with anything, lines torn among it, over a line that garbles words; then `stop`
/// in the middle of it.
fn flood(bench: &mut Bench) -> Result<(String, String), String> {
    bench.arm()?;
    let mut random = Random(0x2545_f491);
    let mut bytes = Vec::new();
    while bytes.len() < FLOOD {
        let word = random.bits();
        match word % 8 {
            // The beginning of a line, and the end of another one.
            0 => bytes.extend(b"set coulo"),
            1 => bytes.extend(b"ition\r"),
            _ => bytes.extend(word.to_le_bytes()),
        }
    }
    // What the flood says by chance is no order.
    bytes.retain(|byte| *byte != b'\n');
    bench.line_errors(LINE_ERRORS);
    bench.running().next.typed.extend(&bytes);
    bench.0.run_for(700 * MILLISECOND)?;
    bench.line_errors(0);
    bench.running().next.typed.push(b'\r');
    bench.0.run_for(600 * MILLISECOND)?;
    let in_flood = bench.0.ask((), "status")?;
    let half = &bytes[..FLOOD / 2];
    let typed = &mut bench.running().next.typed;
    typed.extend(half);
    typed.extend(b" stop\r");
    typed.extend(half);
    bench.0.run_for(700 * MILLISECOND)?;
    bench.running().next.typed.push(b'\r');
    bench.0.run_for(600 * MILLISECOND)?;
    let behind_stop = bench.0.ask((), "status")?;
    Ok((in_flood, behind_stop))
}
