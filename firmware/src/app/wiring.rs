//! The wires between drive and actuator, and the latch that cuts them.
//!
//! On the way out the duty of the bridge, on the way back what the sensors read, both in counts of
//! their converters. The two ends live in interrupts of different urgency, so every wire is one
//! atomic word: nothing is locked, and an interrupt never waits. The values of one measurement
//! belong together because the control step must end before the next plant tick; one that does not
//! is a [`Fault::MissedDeadline`].

use core::sync::atomic::{
    AtomicBool, AtomicI16, AtomicI32, AtomicU8, AtomicU16, AtomicU32,
    Ordering::{Acquire, Relaxed, Release},
};

use model_core::plant::State;

use super::fault::Fault;
use super::fault::latch::Latch;
use super::fault::output::{Bridge, Tracks};
use super::liveness::{Liveness, Task};
use super::tracks::DIAGNOSTIC;

/// What the sensors read, in counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Measurement {
    /// Position. An encoder counts on beyond what a log keeps.
    pub position: i32,
    /// Motor current.
    pub current: i16,
}

/// The emulated actuator's own state, to the last bit: for the log alone, the drive has its sensors.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Truth {
    /// Position, rad.
    pub position: f32,
    /// Velocity, rad/s.
    pub velocity: f32,
    /// Motor current, A.
    pub current: f32,
}

impl From<&State> for Truth {
    fn from(state: &State) -> Self {
        Self {
            position: state.position.value(),
            velocity: state.velocity.value(),
            current: state.current,
        }
    }
}

/// One `f32` on a wire.
#[derive(Debug, Default)]
struct Wire(AtomicU32);

impl Wire {
    const fn new() -> Self {
        Self(AtomicU32::new(0))
    }

    fn get(&self) -> f32 {
        f32::from_bits(self.0.load(Relaxed))
    }

    fn set(&self, value: f32) {
        self.0.store(value.to_bits(), Relaxed);
    }
}

/// What a bridge held over a control period, in counts of its duty.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Applied {
    /// The mean.
    pub mean: i16,
    /// The most less the least.
    pub spread: i16,
}

/// The ticks of a control period, one after the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Application {
    ticks: i32,
    sum: i32,
    range: Option<[i16; 2]>,
    off: bool,
}

impl Application {
    /// What the bridge holds in a tick, in counts of its duty; none with its switches off.
    pub fn take(&mut self, counts: Option<i16>) {
        let Some(counts) = counts else {
            self.off = true;
            return;
        };
        self.ticks += 1;
        self.sum += i32::from(counts);
        let [low, high] = self.range.unwrap_or([counts; 2]);
        self.range = Some([low.min(counts), high.max(counts)]);
    }

    /// The position was told anew in this period: what the bridge does in it explains nothing of how far that goes.
    pub fn forget(&mut self) {
        self.off = true;
    }

    /// Ends the period, and begins the next one.
    pub fn end(&mut self) -> Option<Applied> {
        let Self {
            ticks,
            sum,
            range,
            off,
        } = core::mem::take(self);
        let [low, high] = range.filter(|_| !off)?;
        // The nearest: of equal counts exactly these. A mean lies within its range.
        let mean = (2 * sum + ticks).div_euclid(2 * ticks);
        Some(Applied {
            mean: mean as i16,
            spread: high.saturating_sub(low),
        })
    }
}

/// All wires of one actuator. Relaxed ordering for values: one core, and interrupts order
/// themselves.
#[derive(Debug)]
pub struct Wiring {
    duty: AtomicI16,
    bounds: [AtomicI16; 2],
    current_range: [Wire; 2],
    applied: AtomicI16,
    spread: AtomicI16,
    commanded: AtomicBool,
    position: AtomicI32,
    current: AtomicI16,
    supply: Wire,
    switches: AtomicU8,
    bridge_broken: AtomicBool,
    current_sensor_off: AtomicBool,
    emergency_stop: AtomicBool,
    processor_supply_low: AtomicBool,
    clock_failed: AtomicBool,
    encoder_follows: AtomicBool,
    temperature_codes: [AtomicU16; 2],
    temperatures: [Wire; 2],
    zero_asked: AtomicBool,
    shift: AtomicI32,
    shift_asked: AtomicBool,
    edge: AtomicI32,
    search: AtomicU8,
    heat: AtomicU32,
    tracks: [AtomicU16; 2],
    current_output: AtomicU16,
    true_position: Wire,
    true_velocity: Wire,
    true_current: Wire,
    control_due: AtomicBool,
    restarted: AtomicBool,
    latch: Latch,
    ticks: AtomicU32,
    stood_still: AtomicU32,
    missed: AtomicU32,
    stalled: AtomicBool,
    vouched: AtomicBool,
    commanded_anew: AtomicBool,
    tasks: Liveness,
}

/// On the wire of what is applied: every switch of the bridge is off.
const NOTHING: i16 = i16::MIN;

/// On the wire of what came of a search for a switch.
const UNDER_WAY: u8 = 0;
const FOUND: u8 = 1;
const LOST: u8 = 2;

impl Default for Wiring {
    fn default() -> Self {
        Self::new()
    }
}

impl Wiring {
    /// Everything at zero, no fault.
    pub const fn new() -> Self {
        Self {
            duty: AtomicI16::new(0),
            bounds: [AtomicI16::new(i16::MIN), AtomicI16::new(i16::MAX)],
            current_range: [Wire::new(), Wire::new()],
            applied: AtomicI16::new(NOTHING),
            spread: AtomicI16::new(0),
            commanded: AtomicBool::new(true),
            position: AtomicI32::new(0),
            current: AtomicI16::new(0),
            supply: Wire::new(),
            switches: AtomicU8::new(0),
            bridge_broken: AtomicBool::new(false),
            current_sensor_off: AtomicBool::new(false),
            emergency_stop: AtomicBool::new(false),
            processor_supply_low: AtomicBool::new(false),
            clock_failed: AtomicBool::new(false),
            encoder_follows: AtomicBool::new(false),
            temperature_codes: [AtomicU16::new(0), AtomicU16::new(0)],
            temperatures: [Wire::new(), Wire::new()],
            zero_asked: AtomicBool::new(false),
            shift: AtomicI32::new(0),
            shift_asked: AtomicBool::new(false),
            edge: AtomicI32::new(0),
            search: AtomicU8::new(UNDER_WAY),
            heat: AtomicU32::new(0),
            tracks: [AtomicU16::new(0), AtomicU16::new(0)],
            current_output: AtomicU16::new(0),
            true_position: Wire::new(),
            true_velocity: Wire::new(),
            true_current: Wire::new(),
            control_due: AtomicBool::new(false),
            restarted: AtomicBool::new(false),
            latch: Latch::new(),
            ticks: AtomicU32::new(0),
            stood_still: AtomicU32::new(0),
            missed: AtomicU32::new(0),
            stalled: AtomicBool::new(false),
            vouched: AtomicBool::new(false),
            commanded_anew: AtomicBool::new(false),
            tasks: Liveness::new(),
        }
    }

    /// Sets the duty of the bridge, in counts.
    pub fn drive(&self, duty: i16) {
        self.duty.store(duty, Relaxed);
    }

    /// The duty at the bridge, in counts: what was asked for within its bounds, or zero with the bridge
    /// off.
    pub fn duty(&self) -> i16 {
        match self.latch.outputs().bridge {
            Bridge::Off => 0,
            Bridge::Driven => {
                let [low, high] = self.bounds();
                self.duty.load(Relaxed).min(high).max(low)
            }
        }
    }

    /// Range in which the motion keeps the motor's current, A; none before a drive has said so.
    pub(super) fn current_range(&self) -> [f32; 2] {
        [0, 1].map(|side: usize| self.current_range[side].get())
    }

    /// Narrows the range of the motor's current, A.
    pub(super) fn set_current_range(&self, range: [f32; 2]) {
        for (wire, limit) in self.current_range.iter().zip(range) {
            wire.set(limit);
        }
    }

    /// Least and most duty that the motor's current bears now, in counts.
    pub(super) fn bounds(&self) -> [i16; 2] {
        [0, 1].map(|side: usize| self.bounds[side].load(Relaxed))
    }

    /// Bounds the duty.
    pub(super) fn set_bounds(&self, counts: [i16; 2]) {
        for (bound, counts) in self.bounds.iter().zip(counts) {
            bound.store(counts, Relaxed);
        }
    }

    /// Whether the bridge is the drive's. If not, it follows what else stands at the actuator's wires.
    pub fn is_commanded(&self) -> bool {
        self.commanded.load(Relaxed)
    }

    /// Gives the bridge to the drive, or takes it away.
    pub(super) fn set_commanded(&self, commanded: bool) {
        self.commanded.store(commanded, Relaxed);
    }

    /// What the bridge held at the winding over the control period that ended last; none if its switches
    /// were off in any of its ticks.
    pub fn applied(&self) -> Option<Applied> {
        let mean = self.applied.load(Relaxed);
        let spread = self.spread.load(Relaxed);
        (mean != NOTHING).then_some(Applied { mean, spread })
    }

    /// Says what the bridge held at the winding.
    pub(super) fn set_applied(&self, applied: Option<Applied>) {
        let mean = applied.map_or(NOTHING, |applied| applied.mean);
        let spread = applied.map_or(0, |applied| applied.spread);
        self.applied.store(mean, Relaxed);
        self.spread.store(spread, Relaxed);
    }

    /// Supply of the bridge, V.
    pub fn supply(&self) -> f32 {
        self.supply.get()
    }

    /// Puts the supply on its wire.
    pub fn set_supply(&self, volts: f32) {
        self.supply.set(volts);
    }

    /// Lower and upper limit switch: true where the actuator is on it.
    pub fn switches(&self) -> [bool; 2] {
        let bits = self.switches.load(Relaxed);
        [bits & 1 != 0, bits & 2 != 0]
    }

    /// Puts the limit switches on their wires.
    pub(super) fn set_switches(&self, [lower, upper]: [bool; 2]) {
        let bits = u8::from(lower) | u8::from(upper) << 1;
        self.switches.store(bits, Relaxed);
    }

    /// Whether the bridge's driver holds the timer's break input.
    pub fn is_bridge_broken(&self) -> bool {
        self.bridge_broken.load(Relaxed)
    }

    /// Puts the break input on its wire.
    pub(super) fn set_bridge_broken(&self, broken: bool) {
        self.bridge_broken.store(broken, Relaxed);
    }

    /// Whether the emergency stop is pressed.
    pub(super) fn is_emergency_stop(&self) -> bool {
        self.emergency_stop.load(Relaxed)
    }

    /// Puts the emergency stop on its wire.
    pub(super) fn set_emergency_stop(&self, pressed: bool) {
        self.emergency_stop.store(pressed, Relaxed);
    }

    /// Whether the processor's own supply is too low.
    pub(super) fn is_processor_supply_low(&self) -> bool {
        self.processor_supply_low.load(Relaxed)
    }

    /// Says before each plant tick whether the processor's own supply is too low, which is latched.
    pub fn set_processor_supply_low(&self, low: bool) {
        self.processor_supply_low.store(low, Relaxed);
        if low {
            self.trip(Fault::BrownOut);
        }
    }

    /// Whether the clocks no longer come from the crystal.
    pub(super) fn is_clock_failed(&self) -> bool {
        self.clock_failed.load(Relaxed)
    }

    /// Says before each plant tick whether the clocks no longer come from the crystal, which is latched.
    pub fn set_clock_failed(&self, failed: bool) {
        self.clock_failed.store(failed, Relaxed);
        if failed {
            self.trip(Fault::ClockFailed);
        }
    }

    /// Whether the encoder was seen to follow the rotor.
    pub fn encoder_follows(&self) -> bool {
        self.encoder_follows.load(Relaxed)
    }

    /// Says whether the encoder was seen to follow the rotor.
    pub(super) fn set_encoder_follows(&self, follows: bool) {
        self.encoder_follows.store(follows, Relaxed);
    }

    /// Codes of the temperature sensors, of the switches and the motor.
    pub(super) fn temperature_codes(&self) -> [u16; 2] {
        [0, 1].map(|place: usize| self.temperature_codes[place].load(Relaxed))
    }

    /// Puts the temperature sensors' codes on their wires.
    pub(super) fn set_temperature_codes(&self, codes: [u16; 2]) {
        for (wire, code) in self.temperature_codes.iter().zip(codes) {
            wire.store(code, Relaxed);
        }
    }

    /// Temperatures of the switches and the motor, °C; NaN where there is none.
    pub fn temperatures(&self) -> [f32; 2] {
        [0, 1].map(|place: usize| self.temperatures[place].get())
    }

    /// Says what the temperatures are.
    pub(super) fn set_temperatures(&self, celsius: [Option<f32>; 2]) {
        for (wire, celsius) in self.temperatures.iter().zip(celsius) {
            wire.set(celsius.unwrap_or(f32::NAN));
        }
    }

    /// Whether the current sensor's zero is too far off, where it was last measured.
    pub(super) fn is_current_sensor_off(&self) -> bool {
        self.current_sensor_off.load(Relaxed)
    }

    /// Says whether the current sensor's zero is too far off.
    pub(super) fn set_current_sensor_off(&self, off: bool) {
        self.current_sensor_off.store(off, Relaxed);
    }

    /// Asks for the position to be 0 where the actuator is.
    pub(super) fn ask_zero(&self) {
        self.zero_asked.store(true, Release);
    }

    /// Whether that was asked for since this was last asked.
    pub(super) fn take_zero(&self) -> bool {
        // A load and a store do: the plant tick that takes is never interrupted.
        let asked = self.zero_asked.load(Acquire);
        if asked {
            self.zero_asked.store(false, Relaxed);
        }
        asked
    }

    /// Asks for the position to be so many counts more than it is, where the actuator is.
    pub(super) fn ask_shift(&self, counts: i32) {
        self.shift.store(counts, Relaxed);
        self.shift_asked.store(true, Release);
    }

    /// By how much that was asked for since this was last asked.
    pub(super) fn take_shift(&self) -> Option<i32> {
        // A load and a store do: the plant tick that takes is never interrupted.
        let asked = self.shift_asked.load(Acquire);
        asked.then(|| {
            self.shift_asked.store(false, Relaxed);
            self.shift.load(Relaxed)
        })
    }

    /// Says where a switch opened that was sought, in counts; none where it was not found.
    pub(super) fn end_search(&self, edge: Option<i32>) {
        self.edge.store(edge.unwrap_or(0), Relaxed);
        let search = if edge.is_some() { FOUND } else { LOST };
        self.search.store(search, Release);
    }

    /// What came of a search, if it ended since this was last asked.
    pub(super) fn take_search(&self) -> Option<Option<i32>> {
        let edge = match self.search.load(Acquire) {
            FOUND => Some(self.edge.load(Relaxed)),
            LOST => None,
            // It may end right now, which must not be overwritten.
            _ => return None,
        };
        // A search that has ended does not end once more before the next one is begun.
        self.search.store(UNDER_WAY, Relaxed);
        Some(edge)
    }

    /// The winding's heat, as a [word](super::fault::overload::Heat::word).
    pub fn heat(&self) -> u32 {
        self.heat.load(Relaxed)
    }

    /// Says how hot the winding is: before a drive begins what was kept, then what the drive reckons.
    pub fn set_heat(&self, word: u32) {
        self.heat.store(word, Relaxed);
    }

    /// Whether the processor is about to stand still, disarmed, for as long as flash is written. What
    /// comes late meanwhile is no fault, and what is measured belongs to no log.
    pub fn is_stalled(&self) -> bool {
        self.stalled.load(Acquire)
    }

    /// Begins or ends such a time.
    pub(super) fn set_stalled(&self, stalled: bool) {
        self.stalled.store(stalled, Release);
    }

    /// A task goes on.
    pub fn goes_on(&self, task: Task) {
        self.tasks.goes_on(task, self.ticks());
    }

    /// Whether none has been silent for too long.
    pub(super) fn all_tasks_go_on(&self) -> bool {
        self.tasks.all_go_on(self.ticks())
    }

    /// Whether a control step has vouched for the program since this was last asked: its deadline
    /// held, its numbers were finite, and every task goes on. Then the watchdog may be fed.
    pub fn take_vouched(&self) -> bool {
        // A load and a store do: the plant tick that takes is never interrupted.
        let vouched = self.vouched.load(Acquire);
        if vouched {
            self.vouched.store(false, Relaxed);
        }
        vouched
    }

    /// A control step vouches for the program.
    pub(super) fn vouch(&self) {
        self.vouched.store(true, Release);
    }

    /// A valid command came from the terminal.
    pub(super) fn sign_of_life(&self) {
        self.commanded_anew.store(true, Release);
    }

    /// Whether one came since this was last asked.
    pub(super) fn take_sign_of_life(&self) -> bool {
        // A load and a store do: the control step that takes is never interrupted by the task that sets.
        let commanded = self.commanded_anew.load(Acquire);
        if commanded {
            self.commanded_anew.store(false, Relaxed);
        }
        commanded
    }

    /// Puts a measurement on the wires, and the state behind it.
    pub fn publish(&self, measurement: Measurement, truth: Truth) {
        self.position.store(measurement.position, Relaxed);
        self.current.store(measurement.current, Relaxed);
        self.true_position.set(truth.position);
        self.true_velocity.set(truth.velocity);
        self.true_current.set(truth.current);
    }

    /// What the sensors read now.
    pub fn measurement(&self) -> Measurement {
        Measurement {
            position: self.position.load(Relaxed),
            current: self.current.load(Relaxed),
        }
    }

    /// Puts the position on the two tracks of the emulated sensor, as codes of a 12-bit converter.
    pub fn set_tracks(&self, codes: [u16; 2]) {
        for (track, code) in self.tracks.iter().zip(codes) {
            track.store(code, Relaxed);
        }
    }

    /// Puts the motor's current on its output, as a code of it.
    pub(super) fn set_current_output(&self, code: u16) {
        self.current_output.store(code, Relaxed);
    }

    /// The code on the current's output: the current's, or the ground, which stands for none.
    pub fn current_output(&self) -> u16 {
        match self.latch.outputs().tracks {
            Tracks::Diagnostic => 0,
            Tracks::Position => self.current_output.load(Relaxed),
        }
    }

    /// The codes on the two tracks: the position's, or what no position gives.
    pub fn tracks(&self) -> [u16; 2] {
        match self.latch.outputs().tracks {
            Tracks::Diagnostic => DIAGNOSTIC,
            Tracks::Position => [self.tracks[0].load(Relaxed), self.tracks[1].load(Relaxed)],
        }
    }

    /// The state behind the measurement.
    pub fn truth(&self) -> Truth {
        Truth {
            position: self.true_position.get(),
            velocity: self.true_velocity.get(),
            current: self.true_current.get(),
        }
    }

    /// Latches a fault and with it the safe state.
    pub fn trip(&self, fault: Fault) {
        if fault == Fault::MissedDeadline {
            // One writer at a time: both are plant ticks.
            self.missed.store(self.missed().saturating_add(1), Relaxed);
        }
        self.latch.trip(fault, self.time());
    }

    /// The first fault that is latched.
    pub fn fault(&self) -> Option<Fault> {
        self.latch.first().map(|cause| cause.fault)
    }

    /// The fault latch, which decides over the outputs.
    pub fn latch(&self) -> &Latch {
        &self.latch
    }

    /// Plant ticks since the start.
    pub fn ticks(&self) -> u32 {
        self.ticks.load(Relaxed)
    }

    /// Deadlines missed since the start.
    pub fn missed(&self) -> u32 {
        self.missed.load(Relaxed)
    }

    /// Time since the start, in plant ticks: those too for which the processor stood still.
    pub fn time(&self) -> u32 {
        self.ticks().wrapping_add(self.stood_still.load(Relaxed))
    }

    /// Says for how many more ticks than were counted the processor stood still. The operator alone does.
    pub(super) fn stood_still_for(&self, ticks: u32) {
        let before = self.stood_still.load(Relaxed);
        self.stood_still.store(before.wrapping_add(ticks), Relaxed);
    }

    pub(super) fn count_tick(&self) {
        self.ticks.store(self.ticks().wrapping_add(1), Relaxed);
    }

    /// Whether a control step was asked for and has not ended.
    pub(super) fn control_due(&self) -> bool {
        self.control_due.load(Relaxed)
    }

    /// Asks for a control step, or ends it.
    pub(super) fn set_control_due(&self, due: bool) {
        self.control_due.store(due, Relaxed);
    }

    /// The plant begins anew: the bridge is armed and at zero, no fault is latched, and the next
    /// control step is the first.
    pub(super) fn rearm(&self) {
        self.duty.store(0, Relaxed);
        self.latch.begin_anew();
        self.restarted.store(true, Release);
    }

    /// Whether the plant has begun anew since this was last asked.
    pub(super) fn take_restart(&self) -> bool {
        // A load and a store do: only the control step takes, and the plant tick that sets is over.
        let restarted = self.restarted.load(Acquire);
        if restarted {
            self.restarted.store(false, Relaxed);
        }
        restarted
    }
}
