//! A log as the board keeps it: counts of its sensors and its bridge.

use model_core::control::pid;
use model_core::gap::log::{Channel, Log};
use model_core::plant::State;
use model_core::plant::actuator::Actuator;
use model_core::plant::parameters::Parameters;
use model_core::signal::triangle;

/// Sampling period, s.
pub const PERIOD: f32 = 1e-3;

/// One count of the encoder, rad.
pub const POSITION_COUNT: f32 = core::f32::consts::TAU / 16384.0;

/// One count of the current sensor, A.
const CURRENT_COUNT: f32 = 25.0 / 2048.0;

/// One count of the bridge's voltage, V.
const INPUT_COUNT: f32 = 24.0 / 4200.0;

/// A log of `N` samples.
pub struct Recording<const N: usize> {
    input: [i16; N],
    position: [i16; N],
    current: [i16; N],
}

fn counts(value: f32, unit: f32) -> i16 {
    libm::rintf(value / unit) as i16
}

impl<const N: usize> Recording<N> {
    /// With nothing in it.
    pub const fn new() -> Self {
        Self {
            input: [0; N],
            position: [0; N],
            current: [0; N],
        }
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
        let gains = pid::Parameters {
            proportional: 17.0,
            integral: 60.0,
            derivative: 0.25,
            derivative_filter_time: 3e-3,
            output_minimum: -24.0,
            output_maximum: 24.0,
            ..pid::Parameters::default()
        };
        let (Ok(mut actuator), Ok(command), Ok(controller)) = (
            Actuator::build(declared, PERIOD),
            command.build(PERIOD),
            gains.build(PERIOD),
        ) else {
            return false;
        };
        actuator.set_friction(coulomb, ratio * coulomb);
        let mut state = State::default();
        let mut loop_state = pid::State::default();
        for sample in 0..N {
            self.position[sample] = counts(state.position.value(), POSITION_COUNT);
            self.current[sample] = counts(state.current, CURRENT_COUNT);
            let measured = f32::from(self.position[sample]) * POSITION_COUNT;
            let input = controller.step(&mut loop_state, command.at(sample as u32), measured);
            self.input[sample] = counts(input.unwrap_or(0.0), INPUT_COUNT);
            let held = f32::from(self.input[sample]) * INPUT_COUNT;
            if actuator.step(&mut state, held).is_err() {
                return false;
            }
        }
        true
    }

    /// The log, as it lies in a ring whose end is past its middle.
    pub fn log(&self) -> Log<'_> {
        Log {
            period: PERIOD,
            input: ring(&self.input, INPUT_COUNT),
            position: ring(&self.position, POSITION_COUNT),
            current: Some(ring(&self.current, CURRENT_COUNT)),
            velocity: None,
        }
    }
}

fn ring(counts: &[i16], unit: f32) -> Channel<'_> {
    let (older, newer) = counts.split_at(counts.len() * 2 / 3);
    Channel::Counts { older, newer, unit }
}

impl<const N: usize> Default for Recording<N> {
    fn default() -> Self {
        Self::new()
    }
}
