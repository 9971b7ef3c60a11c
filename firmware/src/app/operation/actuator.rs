//! A real actuator at the end of the wires: what its sensors read becomes what the drive measures.
//!
//! A tick follows each conversion, in the middle of a period of the PWM, where the current is its mean
//! over that period. Over a control period the readings are averaged, so that no ripple folds into
//! the loop. A current beyond the peak is latched in the tick that reads it, as is an
//! emergency stop that is pressed, and the duty is bounded in each so that the current stays at its [limit](current_limit).

use core::sync::atomic::{AtomicBool, AtomicU16, Ordering::Relaxed};

use model_core::plant::potentiometer::Track;

use super::bridge;
use super::calibration::{Calibration, Correction};
use super::current_limit;
use super::current_offset;
use super::encoder::Extension;
use super::order::{Order, Receiver};
use super::supply_limit;
use crate::app::conversion::{Converter, Converters};
use crate::app::fault::Fault;
use crate::app::fault::output::Bridge;
use crate::app::timing::TICKS_PER_CONTROL;
use crate::app::wiring::{Application, Measurement, Truth, Wiring};
use crate::app::work::PlantWork;

/// Code of the current sensor without a current: the middle of a 12-bit converter.
pub const CURRENT_MIDDLE: u16 = 2048;

/// Sensor of the bridge's supply: 12 bits of 3.3 V behind a divider by eleven, 47 kΩ over 4.7 kΩ.
pub const SUPPLY: Converter = Converter::new(11.0 * 3.3 / 4096.0, 4095);

/// What the converters and pins read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Readings {
    /// Code of the current sensor, about [`CURRENT_MIDDLE`].
    pub current: u16,
    /// Code of [`SUPPLY`].
    pub supply: u16,
    /// The encoder's counter.
    pub encoder: u16,
    /// Lower and upper limit switch.
    pub switches: [bool; 2],
    /// Whether the bridge's driver holds the break input.
    pub broken: bool,
    /// Whether the emergency stop's contact is open.
    pub stopped: bool,
    /// Codes of the temperature sensors, of the switches and the motor.
    pub temperatures: [u16; 2],
}

/// The readings on their way from a board's vector to the tick behind it.
#[derive(Debug, Default)]
pub struct Inputs {
    current: AtomicU16,
    supply: AtomicU16,
    encoder: AtomicU16,
    lower: AtomicBool,
    upper: AtomicBool,
    broken: AtomicBool,
    stopped: AtomicBool,
    temperatures: [AtomicU16; 2],
}

impl Inputs {
    /// All zero.
    pub const fn new() -> Self {
        Self {
            current: AtomicU16::new(0),
            supply: AtomicU16::new(0),
            encoder: AtomicU16::new(0),
            lower: AtomicBool::new(false),
            upper: AtomicBool::new(false),
            broken: AtomicBool::new(false),
            stopped: AtomicBool::new(false),
            temperatures: [AtomicU16::new(0), AtomicU16::new(0)],
        }
    }

    /// Takes readings for the next tick.
    pub fn set(&self, readings: &Readings) {
        self.current.store(readings.current, Relaxed);
        self.supply.store(readings.supply, Relaxed);
        self.encoder.store(readings.encoder, Relaxed);
        self.lower.store(readings.switches[0], Relaxed);
        self.upper.store(readings.switches[1], Relaxed);
        self.broken.store(readings.broken, Relaxed);
        self.stopped.store(readings.stopped, Relaxed);
        for (input, code) in self.temperatures.iter().zip(readings.temperatures) {
            input.store(code, Relaxed);
        }
    }

    fn get(&self) -> Readings {
        Readings {
            current: self.current.load(Relaxed),
            supply: self.supply.load(Relaxed),
            encoder: self.encoder.load(Relaxed),
            switches: [self.lower.load(Relaxed), self.upper.load(Relaxed)],
            broken: self.broken.load(Relaxed),
            stopped: self.stopped.load(Relaxed),
            temperatures: [0, 1].map(|place: usize| self.temperatures[place].load(Relaxed)),
        }
    }
}

/// The actuator's numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Numbers {
    /// Sensors and bridge.
    pub converters: Converters,
    /// What the outputs are off by.
    pub calibration: Calibration,
    /// Current beyond which the bridge is switched off, A, either way.
    pub peak: f32,
    /// What the current sensor is off by, as far as that is declared.
    pub sensor: Correction,
    /// Most current that is let flow, A, either way.
    pub limit: f32,
    /// What keeps it there.
    pub limiter: current_limit::Coefficients,
    /// What keeps the supply's current within its limits.
    pub supply: supply_limit::Coefficients,
    /// Stroke over which the tracks run, rad.
    pub stroke: [f32; 2],
}

/// The actuator.
pub struct Actuator {
    receiver: Receiver,
    inputs: &'static Inputs,
    wiring: &'static Wiring,
    numbers: Numbers,
    encoder: Extension,
    /// Sums over the control period: current and supply.
    sums: [i32; 2],
    ticks: u32,
    limit: current_limit::State,
    block: current_offset::State,
    /// What the current sensor reads without a current, in counts, as far as that was measured.
    zero: Option<i32>,
    /// The part of it that is not declared, in counts.
    offset: i32,
    /// What the bridge holds since the last tick, in counts; none with its switches off.
    held: Option<i16>,
    application: Application,
}

impl Actuator {
    /// At position 0.
    pub fn new(
        receiver: Receiver,
        (inputs, wiring): (&'static Inputs, &'static Wiring),
        numbers: &Numbers,
    ) -> Self {
        Self {
            receiver,
            inputs,
            wiring,
            numbers: *numbers,
            encoder: Extension::default(),
            sums: [0; 2],
            ticks: 0,
            limit: current_limit::State::default(),
            block: current_offset::State::default(),
            zero: None,
            offset: 0,
            held: None,
            application: Application::default(),
        }
    }

    /// Whether the bridge may carry this current, as the sensor reads it and as it is put right, both in counts. The
    /// first, for the sensor may end below the peak once its zero is taken off. A limit that is not a number bears none.
    fn is_borne(&self, read: i32, counts: i32) -> bool {
        let Numbers {
            converters,
            sensor,
            peak,
            ..
        } = &self.numbers;
        let read = converters.current.value(read);
        let amperes = sensor.of(converters.current.value(counts));
        read.abs() <= *peak && amperes.abs() <= *peak
    }

    /// Takes the zero that was measured off all readings from now on, or says that it is too far off.
    fn take_zero_off(&mut self) {
        let Numbers {
            converters, sensor, ..
        } = &self.numbers;
        let Some(zero) = self.zero else {
            return;
        };
        let off = sensor.of(converters.current.value(zero));
        let counts = converters.current.counts(off / sensor.gain);
        let offset = counts.filter(|_| off.abs() <= current_offset::MOST);
        self.wiring.set_current_sensor_off(offset.is_none());
        self.offset = offset.map_or(self.offset, i32::from);
    }

    /// The current in counts, without what the sensor reads of none. One that the bridge does not bear is latched.
    fn current(&mut self, reading: u16) -> i32 {
        let read = i32::from(reading) - i32::from(CURRENT_MIDDLE);
        if let Some(mean) = self.block.take(read, self.held.is_none()) {
            self.zero = Some(mean);
            self.take_zero_off();
        }
        let counts = read - self.offset;
        if !self.is_borne(read, counts) {
            self.wiring.trip(Fault::OverCurrent);
        }
        counts
    }

    /// Bounds the duty so that the current stays in its range, and says what the bridge holds from now on.
    fn limit(&mut self, counts: i32) {
        let Numbers {
            converters,
            sensor,
            limit,
            limiter,
            supply,
            ..
        } = &self.numbers;
        let current = sensor.of(converters.current.value(counts));
        let voltage = self.held.map(|counts| converters.bridge.value(counts));
        let [low, high] = self.wiring.current_range();
        let [least, most] = supply.range(self.limit.observed(), self.wiring.supply());
        let range = [low.max(-limit), high.min(*limit)].map(|current| current.min(most).max(least));
        let bounds = limiter.step(&mut self.limit, current, voltage, range);
        // What the bridge cannot make is not what stands at the winding.
        let most = bridge::reach(self.wiring.supply());
        let [low, high] =
            bounds.map(|voltage| converters.bridge.counts(voltage.min(most).max(-most)));
        match (low, high) {
            (Some(low), Some(high)) => self.wiring.set_bounds([low, high]),
            _ => self.wiring.trip(Fault::NonFinite),
        }
        let driven = self.wiring.latch().outputs().bridge == Bridge::Driven;
        self.held = driven.then(|| self.wiring.duty());
        self.application.take(self.held);
    }

    fn publish(&mut self, position: i32) {
        let mean = |sum: i32| sum as f32 / TICKS_PER_CONTROL as f32;
        let [current, supply] = core::mem::take(&mut self.sums).map(mean);
        // Means of 12-bit counts: the conversion only rounds.
        let current = (current + 0.5f32.copysign(current)) as i16;
        let measurement = Measurement { position, current };
        self.wiring.publish(measurement, Truth::default());
        self.wiring.set_supply(supply * SUPPLY.unit());
    }

    /// Puts the measurement on the outputs.
    fn show(&self) {
        let Measurement { position, current } = self.wiring.measurement();
        let Numbers {
            converters,
            calibration,
            stroke: [lower, upper],
            ..
        } = &self.numbers;
        let position = converters.position.value(position);
        let tracks = [
            Track::rising(*lower, *upper),
            Track::complementary(*lower, *upper),
        ];
        let shares = tracks.map(|track| track.share(position));
        self.wiring.set_tracks(calibration.track_codes(shares));
        let amperes = converters.current.value(current);
        self.wiring
            .set_current_output(calibration.current_code(amperes));
    }
}

impl PlantWork for Actuator {
    fn tick(&mut self) -> bool {
        self.wiring.count_tick();
        if self.wiring.control_due() && !self.wiring.is_stalled() {
            self.wiring.trip(Fault::MissedDeadline);
        }
        while let Some(order) = self.receiver.orders.dequeue() {
            // What is for an emulated body is not sent here.
            if let Order::Actuator(numbers) = order {
                self.numbers = numbers;
                self.take_zero_off();
            }
        }
        let readings = self.inputs.get();
        // What a person did goes before what may come of it.
        if readings.stopped {
            self.wiring.trip(Fault::EmergencyStop);
        }
        self.wiring.set_emergency_stop(readings.stopped);
        let current = self.current(readings.current);
        if readings.broken {
            self.wiring.trip(Fault::BridgeBreak);
        }
        self.wiring.set_bridge_broken(readings.broken);
        self.wiring.set_switches(readings.switches);
        self.limit(current);
        self.sums[0] += current;
        self.sums[1] += i32::from(readings.supply);
        if self.wiring.take_zero() {
            self.encoder.zero();
            self.application.forget();
        }
        if let Some(counts) = self.wiring.take_shift() {
            self.encoder.shift(counts);
            self.application.forget();
        }
        let position = self.encoder.take(readings.encoder);
        self.ticks += 1;
        let due = self.ticks == TICKS_PER_CONTROL;
        if due {
            self.ticks = 0;
            self.publish(position);
            self.wiring.set_temperature_codes(readings.temperatures);
            self.wiring.set_applied(self.application.end());
            self.wiring.set_control_due(true);
        } else if self.ticks == 1 {
            // In the tick behind that, which has the time: the control step waits for the other one.
            self.show();
        }
        due
    }
}
