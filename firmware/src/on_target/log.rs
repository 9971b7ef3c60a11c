//! A log as the board keeps it: counts of its sensors and its bridge, in its ring.

use model_core::control::pid;
use model_core::gap::log::Log;
use model_core::plant::State;
use model_core::plant::actuator::Actuator;
use model_core::plant::parameters::Parameters;
use model_core::signal::triangle;

use super::control::GAINS;
use crate::app::conversion::Converters;
use crate::app::machine::EMA;
use crate::app::memory::Memory;
use crate::app::record::{Marks, Sample};
use crate::app::timing::CONTROL_PERIOD;
use crate::app::wiring::Truth;

/// Sensors and bridge of the log.
pub const CONVERTERS: Converters = EMA.converters;

/// A log of `N` samples.
pub struct Recording<const N: usize>(Memory<N>);

impl<const N: usize> Recording<N> {
    /// With nothing in it.
    pub const fn new() -> Self {
        Self(Memory::new())
    }

    /// Records the declared actuator with another Coulomb friction, its position loop following a
    /// triangle of 3 rad. False if a constructor refuses what it is given.
    pub fn drive(&mut self, declared: &Parameters, coulomb: f32) -> bool {
        let ratio = declared.breakaway.forward / declared.coulomb.forward;
        let command = triangle::Parameters {
            offset: 0.0,
            amplitude: 3.0,
            frequency: 1.3,
            phase: 0.0,
        };
        let (Ok(mut actuator), Ok(command), Ok(controller)) = (
            Actuator::build(declared, CONTROL_PERIOD),
            command.build(CONTROL_PERIOD),
            GAINS.build(CONTROL_PERIOD),
        ) else {
            return false;
        };
        actuator.set_friction(coulomb, ratio * coulomb);
        // The drive overwrites samples at rest, so that the ring ends in its middle.
        let at_rest = N as u32 / 3;
        for sequence in 0..at_rest {
            self.0.push(&sample(sequence, 0.0, [0; 3]));
        }
        let mut state = State::default();
        let mut loop_state = pid::State::default();
        for tick in 0..N as u32 {
            let (Some(position), Some(current)) = (
                CONVERTERS.position.counts(state.position.value()),
                CONVERTERS.current.counts(state.current),
            ) else {
                return false;
            };
            let command = command.at(tick);
            let measured = CONVERTERS.position.value(position);
            let input = controller.step(&mut loop_state, command, measured);
            let Some(duty) = input.ok().and_then(|input| CONVERTERS.bridge.counts(input)) else {
                return false;
            };
            self.0
                .push(&sample(at_rest + tick, command, [duty, position, current]));
            let held = CONVERTERS.bridge.value(duty);
            if actuator.step(&mut state, held).is_err() {
                return false;
            }
        }
        true
    }

    /// The log.
    pub fn log(&self) -> Log<'_> {
        self.0.log(&CONVERTERS)
    }
}

fn sample(sequence: u32, command: f32, [duty, position, current]: [i16; 3]) -> Sample {
    Sample {
        sequence,
        command,
        duty,
        position: position.into(),
        current,
        truth: Truth::default(),
        marks: Marks::default(),
    }
}

impl<const N: usize> Default for Recording<N> {
    fn default() -> Self {
        Self::new()
    }
}
