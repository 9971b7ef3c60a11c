//! The wires between drive and actuator, and the fault latch that cuts them.
//!
//! On the way out a bridge voltage, on the way back what the sensors read. The two ends live in
//! interrupts of different urgency, so every wire is one atomic word: nothing is locked, and an
//! interrupt never waits. The values of one measurement belong together because the control step
//! must end before the next plant tick; one that does not is a [`Fault::MissedDeadline`].

use core::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, Ordering::Relaxed};

/// Why the bridge was switched off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "tasks", derive(defmt::Format))]
pub enum Fault {
    /// A measurement, a command or a voltage was NaN or infinite.
    NonFinite,
    /// A control step or a plant tick was not finished when the next tick came.
    MissedDeadline,
}

/// What the sensors read.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Measurement {
    /// Position, rad.
    pub position: f32,
    /// Velocity, rad/s.
    pub velocity: f32,
    /// Motor current, A.
    pub current: f32,
}

impl Measurement {
    fn is_finite(&self) -> bool {
        self.position.is_finite() && self.velocity.is_finite() && self.current.is_finite()
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

/// All wires of one actuator. Relaxed ordering throughout: one core, and interrupts order
/// themselves.
#[derive(Debug, Default)]
pub struct Wiring {
    voltage: Wire,
    position: Wire,
    velocity: Wire,
    current: Wire,
    control_due: AtomicBool,
    fault: AtomicU8,
}

impl Wiring {
    /// Everything at zero, no fault.
    pub const fn new() -> Self {
        Self {
            voltage: Wire::new(),
            position: Wire::new(),
            velocity: Wire::new(),
            current: Wire::new(),
            control_due: AtomicBool::new(false),
            fault: AtomicU8::new(0),
        }
    }

    /// Sets the bridge voltage, V. A value that is not finite trips the latch.
    pub fn drive(&self, voltage: f32) {
        if voltage.is_finite() {
            self.voltage.set(voltage);
        } else {
            self.trip(Fault::NonFinite);
        }
    }

    /// The voltage at the bridge, V: what was asked for, or zero for good after a fault.
    pub fn bridge_voltage(&self) -> f32 {
        if self.fault().is_some() {
            0.0
        } else {
            self.voltage.get()
        }
    }

    /// Puts a measurement on the wires. One that is not finite trips the latch.
    pub fn publish(&self, measurement: Measurement) {
        if !measurement.is_finite() {
            self.trip(Fault::NonFinite);
        }
        self.position.set(measurement.position);
        self.velocity.set(measurement.velocity);
        self.current.set(measurement.current);
    }

    /// What the sensors read now.
    pub fn measurement(&self) -> Measurement {
        Measurement {
            position: self.position.get(),
            velocity: self.velocity.get(),
            current: self.current.get(),
        }
    }

    /// Latches a fault and with it the safe state. The first one stays.
    pub fn trip(&self, fault: Fault) {
        // The board's reset is the only way out, so a lost race between two faults costs nothing
        // but which of them is named.
        if self.fault().is_none() {
            self.fault.store(1 + fault as u8, Relaxed);
        }
    }

    /// The latched fault.
    pub fn fault(&self) -> Option<Fault> {
        match self.fault.load(Relaxed) {
            0 => None,
            1 => Some(Fault::NonFinite),
            _ => Some(Fault::MissedDeadline),
        }
    }

    /// Whether a control step was asked for and has not ended.
    pub(super) fn control_due(&self) -> bool {
        self.control_due.load(Relaxed)
    }

    /// Asks for a control step, or ends it.
    pub(super) fn set_control_due(&self, due: bool) {
        self.control_due.store(due, Relaxed);
    }
}
