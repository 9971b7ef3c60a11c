//! The emulated throttle body at the controller's wires: its step is the plant interrupt's work, the
//! controller's the control interrupt's.

use core::sync::atomic::{AtomicI16, AtomicU32, Ordering::Relaxed};

use heapless::spsc::{Consumer, Producer};
use model_core::plant::bridge::Bridge;
use model_core::plant::parameters::Parameters;
use model_core::plant::potentiometer::Track;
use model_core::plant::throttle::{Fault, Settings, Throttle};

use super::Ecu;
use super::calibration::{DUTY, SUPPLY};
use super::observation::Readings;
use super::schedule::{Report, Schedule};
use crate::app::conversion::Converter;
use crate::app::digest::Digest;
use crate::app::fault;
use crate::app::machine::{FULL_DUTY, THROTTLE};
use crate::app::timing::TICKS_PER_CONTROL;
use crate::app::tracks::code;
use crate::app::wiring::{Measurement, Truth, Wiring};
use crate::app::work::{ControlWork, PlantWork};

/// Seed of the board's noise.
pub const SEED: u64 = 1;

/// Noise of the tracks, V.
const NOISE: f32 = 5e-3;

/// A throttle with two tracks, of which the second falls as the first rises.
pub const fn complementary(plant: Parameters, seed: u64) -> Settings {
    let second = Track::complementary(plant.lower_stop, plant.upper_stop);
    settings(plant, second, seed)
}

/// The same with a second track that rises half as far as the first one.
pub const fn half_slope(plant: Parameters, seed: u64) -> Settings {
    let second = Track::half_slope(plant.lower_stop, plant.upper_stop);
    settings(plant, second, seed)
}

const fn settings(plant: Parameters, second: Track, seed: u64) -> Settings {
    Settings {
        actuator: plant,
        tracks: [
            Track {
                noise: NOISE,
                ..Track::rising(plant.lower_stop, plant.upper_stop)
            },
            Track {
                noise: NOISE,
                ..second
            },
        ],
        diode_drop: 0.7,
        seed,
    }
}

/// What the throttle body is told, by a test or a console.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Command {
    /// A fault from now on. One whose number is out of its range is counted, and that is all.
    Inject(Fault),
    /// Every fault ends.
    Heal,
    /// Supply of the bridge, V.
    Supply(f32),
}

impl Command {
    /// Does it to a throttle body and its supply, V. False if a number is out of its range: then
    /// nothing changes.
    pub(in crate::app) fn obeyed_by(self, throttle: &mut Throttle, supply: &mut f32) -> bool {
        match self {
            Self::Inject(fault) => throttle.inject(fault).is_ok(),
            Self::Heal => {
                throttle.heal();
                true
            }
            Self::Supply(volts) => {
                let usable = (0.0..=SUPPLY.value(4095)).contains(&volts);
                if usable {
                    *supply = volts;
                }
                usable
            }
        }
    }
}

/// Commands under way at a time.
pub const COMMANDS: usize = 8;

/// What is on the wires besides [`Wiring`].
#[derive(Debug)]
pub struct Wires {
    bridge: AtomicI16,
    supply: AtomicI16,
    refused: AtomicU32,
}

/// On the bridge's wire, beside the duties.
const FREEWHEEL: i16 = i16::MIN;
const BRAKE: i16 = i16::MAX;

impl Wires {
    /// The bridge switched off.
    pub const fn new() -> Self {
        Self {
            bridge: AtomicI16::new(FREEWHEEL),
            supply: AtomicI16::new(0),
            refused: AtomicU32::new(0),
        }
    }

    /// What the bridge was told last.
    pub fn bridge(&self) -> Bridge {
        match self.bridge.load(Relaxed) {
            FREEWHEEL => Bridge::Freewheel,
            BRAKE => Bridge::Brake,
            counts => Bridge::Drive {
                duty: DUTY.value(counts),
            },
        }
    }

    /// Tells the bridge. A duty that is not a number switches it off.
    pub fn drive(&self, bridge: Bridge) {
        let word = match bridge {
            Bridge::Freewheel => FREEWHEEL,
            Bridge::Brake => BRAKE,
            Bridge::Drive { duty } => DUTY.counts(duty).unwrap_or(FREEWHEEL),
        };
        self.bridge.store(word, Relaxed);
    }

    pub(in crate::app) fn count_refused(&self) {
        let refused = self.refused().saturating_add(1);
        self.refused.store(refused, Relaxed);
    }

    /// Commands that were refused since the start.
    pub fn refused(&self) -> u32 {
        self.refused.load(Relaxed)
    }
}

impl Default for Wires {
    fn default() -> Self {
        Self::new()
    }
}

const _: () = assert!(FULL_DUTY < BRAKE && -FULL_DUTY > FREEWHEEL);

/// The throttle body at the end of the wires.
pub struct Emulation {
    throttle: &'static mut Throttle,
    supply: f32,
    current: Converter,
    commands: Consumer<'static, Command>,
    wires: &'static Wires,
    wiring: &'static Wiring,
    /// Ticks so far. The first samples the initial state, without a step.
    ticks: u32,
}

impl Emulation {
    /// A throttle body at 12 V.
    pub fn new(
        throttle: &'static mut Throttle,
        commands: Consumer<'static, Command>,
        wires: &'static Wires,
        wiring: &'static Wiring,
    ) -> Self {
        Self {
            throttle,
            supply: 12.0,
            current: THROTTLE.converters.current,
            commands,
            wires,
            wiring,
            ticks: 0,
        }
    }

    fn obey(&mut self, command: Command) {
        if !command.obeyed_by(self.throttle, &mut self.supply) {
            self.wires.count_refused();
        }
    }

    /// The bridge: what it was told, or off while a fault is latched.
    fn bridge(&self) -> Bridge {
        if self.wiring.fault().is_some() {
            Bridge::Freewheel
        } else {
            self.wires.bridge()
        }
    }
}

impl PlantWork for Emulation {
    fn tick(&mut self) -> bool {
        self.wiring.count_tick();
        if self.wiring.control_due() {
            self.wiring.trip(fault::Fault::MissedDeadline);
        }
        while let Some(command) = self.commands.dequeue() {
            self.obey(command);
        }
        if self.ticks > 0 && self.throttle.step(self.bridge(), self.supply).is_err() {
            self.wiring.trip(fault::Fault::NonFinite);
        }
        let tracks = self.throttle.shares().map(code);
        self.wiring.set_tracks(tracks);
        let truth = Truth::from(self.throttle.state());
        match (
            self.current.counts(self.throttle.current()),
            SUPPLY.counts(self.supply),
        ) {
            (Some(current), Some(supply)) => {
                // The first track is the position sensor; a 12-bit code fits.
                let position = tracks[0].into();
                self.wiring
                    .publish(Measurement { position, current }, truth);
                self.wires.supply.store(supply, Relaxed);
            }
            _ => self.wiring.trip(fault::Fault::NonFinite),
        }
        let due = self.ticks.is_multiple_of(TICKS_PER_CONTROL);
        if due {
            self.wiring.set_control_due(true);
        }
        self.ticks = self.ticks.wrapping_add(1);
        due
    }
}

/// The controller, its driver and its end of the wires.
pub struct Controller {
    ecu: Ecu,
    schedule: Schedule,
    commands: Producer<'static, Command>,
    reports: Producer<'static, Report>,
    wires: &'static Wires,
    wiring: &'static Wiring,
    digest: Digest,
}

impl Controller {
    /// Key off, at the beginning of the schedule.
    pub fn new(
        ecu: Ecu,
        schedule: Schedule,
        commands: Producer<'static, Command>,
        reports: Producer<'static, Report>,
        (wires, wiring): (&'static Wires, &'static Wiring),
    ) -> Self {
        Self {
            ecu,
            schedule,
            commands,
            reports,
            wires,
            wiring,
            digest: Digest::new(),
        }
    }

    /// Takes what is on the wires into the digest, and the state behind it.
    fn note(&mut self, readings: &Readings) {
        let [first, second] = readings.tracks.map(u32::from);
        let Truth {
            position,
            velocity,
            current,
        } = self.wiring.truth();
        self.digest.word(first << 16 | second);
        // As bits, whatever the sign.
        let [measured, supply, bridge] = [
            readings.current,
            readings.supply,
            self.wires.bridge.load(Relaxed),
        ]
        .map(|counts| u32::from(counts as u16));
        self.digest.word(measured << 16 | supply);
        self.digest.word(bridge);
        for value in [position, velocity, current] {
            self.digest.single(value);
        }
    }
}

impl ControlWork for Controller {
    fn step(&mut self) {
        let readings = Readings {
            tracks: self.wiring.tracks(),
            current: self.wiring.measurement().current,
            supply: self.wires.supply.load(Relaxed),
        };
        self.note(&readings);
        let next = self.schedule.advance(&self.ecu, self.digest.value());
        // Both queues hold more than is sent before the other end looks.
        if let Some(command) = next.command
            && self.commands.enqueue(command).is_err()
        {
            self.wiring.trip(fault::Fault::QueueOverflow);
        }
        if let Some(report) = next.report {
            if self.reports.enqueue(report).is_err() {
                self.wiring.trip(fault::Fault::QueueOverflow);
            }
            self.digest = Digest::new();
        }
        self.wires.drive(self.ecu.step(&readings, &next.demand));
        self.wiring.set_control_due(false);
    }
}
