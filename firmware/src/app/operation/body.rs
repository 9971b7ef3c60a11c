//! The emulated throttle body of an image that is operated from a console: at the wires of an engine
//! controller, or under its own drive.

use model_core::plant::bridge::Bridge;
use model_core::plant::throttle::Throttle;

use super::calibration::Calibration;
use super::order::{Order, Receiver};
use crate::app::conversion::Converters;
use crate::app::ecu::loopback::Wires;
use crate::app::fault::Fault;
use crate::app::fault::output;
use crate::app::timing::TICKS_PER_CONTROL;
use crate::app::wiring::{Application, Measurement, Truth, Wiring};
use crate::app::work::PlantWork;

/// Supply of its bridge before another one is told, V.
const SUPPLY: f32 = 12.0;

/// The body.
pub struct Body {
    throttle: &'static mut Throttle,
    receiver: Receiver,
    converters: Converters,
    calibration: Calibration,
    supply: f32,
    wires: &'static Wires,
    wiring: &'static Wiring,
    application: Application,
    /// Ticks so far. The first samples the initial state, without a step.
    ticks: u32,
}

impl Body {
    /// A body at its limp-home position.
    pub fn new(
        throttle: &'static mut Throttle,
        receiver: Receiver,
        (converters, calibration): (Converters, Calibration),
        (wires, wiring): (&'static Wires, &'static Wiring),
    ) -> Self {
        wiring.set_supply(SUPPLY);
        Self {
            throttle,
            receiver,
            converters,
            calibration,
            supply: SUPPLY,
            wires,
            wiring,
            application: Application::default(),
            ticks: 0,
        }
    }

    fn obey(&mut self, order: Order) {
        match order {
            Order::Body(command) => {
                if !command.obeyed_by(self.throttle, &mut self.supply) {
                    self.wires.count_refused();
                }
            }
            Order::Calibrate(converters, calibration) => {
                self.converters = converters;
                self.calibration = calibration;
            }
            // There is none here.
            Order::Actuator(_) => {}
            Order::Replace(throttle) => {
                let before = core::mem::replace(&mut self.throttle, throttle);
                // There is one to spare, and one place for it.
                if self.receiver.replaced.enqueue(before).is_err() {
                    self.wiring.trip(Fault::QueueOverflow);
                }
                self.ticks = 0;
            }
        }
    }

    /// What the bridge does: off, as the drive has it, or as the wires have it.
    fn bridge(&self) -> Bridge {
        match self.wiring.latch().outputs().bridge {
            output::Bridge::Off => Bridge::Freewheel,
            output::Bridge::Driven if self.wiring.is_commanded() => {
                let volts = self.converters.bridge.value(self.wiring.duty());
                let duty = volts / self.supply;
                // Without a supply there is no voltage, whatever the duty.
                let duty = if duty.is_finite() { duty } else { 0.0 };
                Bridge::Drive { duty }
            }
            output::Bridge::Driven => self.wires.bridge(),
        }
    }

    /// What the sensors make of the state; none where one of them has no reading.
    fn measure(&self, position: f32) -> Option<Measurement> {
        Some(Measurement {
            position: self.converters.position.counts(position)?.into(),
            current: self.converters.current.counts(self.throttle.current())?,
        })
    }
}

impl PlantWork for Body {
    fn tick(&mut self) -> bool {
        self.wiring.count_tick();
        if self.wiring.control_due() && !self.wiring.is_stalled() {
            self.wiring.trip(Fault::MissedDeadline);
        }
        while let Some(order) = self.receiver.orders.dequeue() {
            self.obey(order);
        }
        let bridge = self.bridge();
        let voltage = bridge.voltage(self.supply);
        let counts = voltage.and_then(|volts| self.converters.bridge.counts(volts));
        self.application.take(counts);
        if self.ticks > 0 && self.throttle.step(bridge, self.supply).is_err() {
            self.wiring.trip(Fault::NonFinite);
        }
        let shares = self.throttle.shares();
        self.wiring.set_tracks(self.calibration.track_codes(shares));
        let current = self.throttle.current();
        self.wiring
            .set_current_output(self.calibration.current_code(current));
        self.wiring.set_supply(self.supply);
        let truth = Truth::from(self.throttle.state());
        match self.measure(truth.position) {
            Some(measurement) => self.wiring.publish(measurement, truth),
            None => self.wiring.trip(Fault::NonFinite),
        }
        let due = self.ticks.is_multiple_of(TICKS_PER_CONTROL);
        if due {
            self.wiring.set_applied(self.application.end());
            self.wiring.set_control_due(true);
        }
        self.ticks = self.ticks.wrapping_add(1);
        due
    }
}
