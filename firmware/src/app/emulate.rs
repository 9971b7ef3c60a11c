//! The emulated actuator, stepped in real time in the most urgent interrupt.
//!
//! A tick at time *t* advances the plant over the period that ends there, with the voltage that
//! stands at the bridge. The control step that a tick asks for runs before the next tick, so its
//! voltage acts from its own sampling instant on: the log's `input` holds from its row to the
//! next, exactly.

use model_core::plant::State;
use model_core::plant::actuator::Actuator;

use super::timing::TICKS_PER_CONTROL;
use super::wiring::{Fault, Measurement, Wiring};

/// The plant at the end of the wires.
pub struct Emulation {
    actuator: Actuator,
    state: State,
    wiring: &'static Wiring,
    /// Ticks so far. The first samples the initial state, without a step.
    ticks: u32,
}

impl Emulation {
    /// A plant at rest at position 0.
    pub fn new(actuator: Actuator, wiring: &'static Wiring) -> Self {
        Self {
            actuator,
            state: State::default(),
            wiring,
            ticks: 0,
        }
    }

    /// One plant period. True if a control step is due: it has until the next tick.
    ///
    /// A control step that is still due, and an input that the plant refuses, trip the latch.
    #[must_use]
    pub fn tick(&mut self) -> bool {
        if self.wiring.control_due() {
            self.wiring.trip(Fault::MissedDeadline);
        }
        if self.ticks > 0 {
            let voltage = self.wiring.bridge_voltage();
            if self.actuator.step(&mut self.state, voltage).is_err() {
                self.wiring.trip(Fault::NonFinite);
            }
        }
        self.wiring.publish(Measurement {
            position: self.state.position.value(),
            velocity: self.state.velocity.value(),
            current: self.state.current,
        });
        let due = self.ticks.is_multiple_of(TICKS_PER_CONTROL);
        if due {
            self.wiring.set_control_due(true);
        }
        self.ticks = self.ticks.wrapping_add(1);
        due
    }
}
