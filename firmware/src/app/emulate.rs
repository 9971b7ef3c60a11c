//! The emulated actuator, stepped in real time in the most urgent interrupt.
//!
//! A tick at time *t* advances the plant over the period that ends there, with the voltage that
//! stands at the bridge. The control step that a tick asks for runs before the next tick, so its
//! voltage acts from its own sampling instant on: the log's `input` holds from its row to the
//! next, exactly.

use heapless::spsc::Consumer;
use model_core::effect::backlash;
use model_core::plant::actuator::Actuator;
use model_core::plant::{InputRefused, State};

use super::conversion::Converters;
use super::experiment::{Peculiarity, Wear};
use super::fault::Fault;
use super::timing::TICKS_PER_CONTROL;
use super::tracks::Tracks;
use super::wiring::{Measurement, Truth, Wiring};
use super::work::PlantWork;

/// A plant to emulate from now on.
#[derive(Debug, Clone)]
pub struct Setup {
    /// The actuator, built for the plant's period.
    pub actuator: Actuator,
    /// Where it starts.
    pub start: State,
    /// Its sensors and its bridge.
    pub converters: Converters,
    /// The sensor that it plays for others.
    pub tracks: Tracks,
    /// What it has that no number of its parameters says.
    pub peculiarity: Option<Peculiarity>,
    /// A change of its friction.
    pub wear: Option<Wear>,
    /// Control step from which on the position sensor reads what is not a number.
    pub sensor_fails: Option<u32>,
}

/// The plant at the end of the wires.
pub struct Emulation {
    setup: Option<Setup>,
    setups: Consumer<'static, Setup>,
    state: State,
    /// Position at the sensor's side of the play, rad; that of the drive without one.
    reported: f32,
    wiring: &'static Wiring,
    /// Ticks so far. The first samples the initial state, without a step.
    ticks: u32,
}

impl Emulation {
    /// No plant yet: it comes through `setups`, and each one replaces the one before.
    pub fn new(setups: Consumer<'static, Setup>, wiring: &'static Wiring) -> Self {
        Self {
            setup: None,
            setups,
            state: State::default(),
            reported: 0.0,
            wiring,
            ticks: 0,
        }
    }
}

impl PlantWork for Emulation {
    /// A control step that is still due, and an input that the plant refuses, trip the latch.
    fn tick(&mut self) -> bool {
        self.wiring.count_tick();
        if self.wiring.control_due() {
            self.wiring.trip(Fault::MissedDeadline);
        }
        if let Some(setup) = self.setups.dequeue() {
            self.state = setup.start;
            self.reported = setup.start.position.value();
            self.setup = Some(setup);
            self.ticks = 0;
            self.wiring.rearm();
        }
        let Some(setup) = &mut self.setup else {
            return false;
        };
        if let Some(wear) = setup.wear
            && wear.step * TICKS_PER_CONTROL == self.ticks
        {
            setup.actuator.set_friction(wear.coulomb, wear.breakaway);
        }
        if self.ticks > 0 {
            let voltage = setup.converters.bridge.value(self.wiring.duty());
            if step(setup, &mut self.state, voltage).is_err() {
                self.wiring.trip(Fault::NonFinite);
            }
        }
        let position = self.state.position.value();
        self.reported = match setup.peculiarity {
            Some(Peculiarity::Play(width)) => {
                backlash::follow(self.reported, position, 0.5 * width)
            }
            _ => position,
        };
        self.wiring.set_tracks(setup.tracks.codes(self.reported));
        let due = self.ticks.is_multiple_of(TICKS_PER_CONTROL);
        let truth = Truth::from(&self.state);
        match measure(setup, self.ticks, (self.reported, truth.current)) {
            Some(measurement) => self.wiring.publish(measurement, truth),
            None => self.wiring.trip(Fault::NonFinite),
        }
        if due {
            self.wiring.set_control_due(true);
        }
        self.ticks = self.ticks.wrapping_add(1);
        due
    }
}

/// A step of the plant under the friction that it has where it is.
#[inline(always)]
fn step(setup: &Setup, state: &mut State, voltage: f32) -> Result<(), InputRefused> {
    let Some(Peculiarity::RoughSpot { from, to, more }) = setup.peculiarity else {
        return setup.actuator.step(state, voltage);
    };
    let mut load = setup.actuator.load();
    if (from..to).contains(&state.position.value()) {
        for friction in [&mut load.coulomb, &mut load.breakaway] {
            friction.forward += more;
            friction.backward += more;
        }
    }
    setup.actuator.step_under(state, voltage, &load)
}

/// What the sensors make of a position and a current; none where one of them has no reading.
fn measure(setup: &Setup, tick: u32, (position, current): (f32, f32)) -> Option<Measurement> {
    let failed = setup
        .sensor_fails
        .is_some_and(|step| tick >= step * TICKS_PER_CONTROL);
    let position = if failed { f32::NAN } else { position };
    Some(Measurement {
        position: setup.converters.position.counts(position)?.into(),
        current: setup.converters.current.counts(current)?,
    })
}
