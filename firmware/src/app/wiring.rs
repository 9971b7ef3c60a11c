//! The wires between drive and actuator, and the latch that cuts them.
//!
//! On the way out the duty of the bridge, on the way back what the sensors read, both in counts of
//! their converters. The two ends live in interrupts of different urgency, so every wire is one
//! atomic word: nothing is locked, and an interrupt never waits. The values of one measurement
//! belong together because the control step must end before the next plant tick; one that does not
//! is a [`Fault::MissedDeadline`].

use core::sync::atomic::{
    AtomicBool, AtomicI16, AtomicU16, AtomicU32,
    Ordering::{Acquire, Relaxed, Release},
};

use model_core::plant::State;

use super::fault::Fault;
use super::fault::latch::Latch;
use super::fault::output::{Bridge, Tracks};
use super::tracks::DIAGNOSTIC;

/// What the sensors read, in counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Measurement {
    /// Position.
    pub position: i16,
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

/// All wires of one actuator. Relaxed ordering for values: one core, and interrupts order
/// themselves.
#[derive(Debug, Default)]
pub struct Wiring {
    duty: AtomicI16,
    position: AtomicI16,
    current: AtomicI16,
    tracks: [AtomicU16; 2],
    true_position: Wire,
    true_velocity: Wire,
    true_current: Wire,
    control_due: AtomicBool,
    restarted: AtomicBool,
    latch: Latch,
    ticks: AtomicU32,
    missed: AtomicU32,
}

impl Wiring {
    /// Everything at zero, no fault.
    pub const fn new() -> Self {
        Self {
            duty: AtomicI16::new(0),
            position: AtomicI16::new(0),
            current: AtomicI16::new(0),
            tracks: [AtomicU16::new(0), AtomicU16::new(0)],
            true_position: Wire::new(),
            true_velocity: Wire::new(),
            true_current: Wire::new(),
            control_due: AtomicBool::new(false),
            restarted: AtomicBool::new(false),
            latch: Latch::new(),
            ticks: AtomicU32::new(0),
            missed: AtomicU32::new(0),
        }
    }

    /// Sets the duty of the bridge, in counts.
    pub fn drive(&self, duty: i16) {
        self.duty.store(duty, Relaxed);
    }

    /// The duty at the bridge, in counts: what was asked for, or zero with the bridge off.
    pub fn duty(&self) -> i16 {
        match self.latch.outputs().bridge {
            Bridge::Off => 0,
            Bridge::Driven => self.duty.load(Relaxed),
        }
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
        self.latch.trip(fault, self.ticks());
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
