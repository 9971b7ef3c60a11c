//! The test bench: a rig in double precision plays the paper's actuator, which is not public.
//!
//! A 24 V brushed DC motor with a peak torque of 1.44 N·m (the paper's: 1.48) in free travel, with the
//! friction that a brake adds. The bench has what the models lack: a position sensor with counts, noise,
//! offset and drift and lost motion before it, a supply and a torque constant that ripple, a current sensor
//! with a 12-bit converter, noise, offset and drift. How much of each is drawn anew for each log.

use std::path::Path;

use model_core::gap::log::{Channel, Log as CoreLog};
use model_core::numeric::invalid_parameter::InvalidParameter;
use model_core::signal::{aprts, ramp, sine, step, sweep};
use rig::{Bench, Experiment, Machine, Noise, Random, Trajectory};

use super::command_file;
use crate::failure::Failure;
use crate::log::Log;

/// Rows a second, and runs of the position loop.
pub const SAMPLE_RATE: f64 = 1000.0;

/// Length of a log, s.
pub const SECONDS: f64 = 10.0;

/// One count of the encoder, rad: 2π/16384, as in the machine file.
pub const RESOLUTION: f64 = 3.834_952e-4;

/// Integration step of the rig, s. Its rule is of second order and places events within a step: with its
/// usual 2 µs the estimates from sweeps are the same, to the width that the search resolves.
const STEP: f64 = 4e-5;

/// The paper's levels of friction and those between, N·m. The first is the healthy one, 0.779 the brake
/// at 11 V of its 24 V.
pub const LEVELS: [f64; 9] = [0.12, 0.2, 0.3, 0.45, 0.6, 0.779, 0.9, 1.05, 1.2];

/// Breakaway level per Coulomb level: least and largest.
pub const BREAKAWAY: (f64, f64) = (1.0, 1.3);

/// Largest breakaway level, N·m: what the motor just overcomes. From 1.06 N·m on it is this that bounds
/// the breakaway level.
pub const OVERCOME: f64 = 1.38;

/// One step of the current sensor's converter, A: ±25 A in 12 bits, as on the board.
const CONVERTER: f64 = 25.0 / 2048.0;

/// Noise of the sensors: half a count of the position's, and a cheap shunt amplifier's.
const NOISE: Noise = Noise {
    position: 0.5 * RESOLUTION,
    ..Noise::SHUNT
};

/// How the actuator is driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Input {
    /// One step of the position command.
    Step,
    /// One ramp.
    Ramp,
    /// A sine.
    Sine,
    /// A sine whose frequency rises linearly: what the paper chose.
    Sweep,
    /// Random steps.
    Random,
    /// Positions from a file.
    File,
    /// A voltage that sweeps, without a position loop.
    OpenLoop,
}

impl Input {
    /// All.
    pub const ALL: [Self; 7] = [
        Self::Step,
        Self::Ramp,
        Self::Sine,
        Self::Sweep,
        Self::Random,
        Self::File,
        Self::OpenLoop,
    ];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Step => "step",
            Self::Ramp => "ramp",
            Self::Sine => "sine",
            Self::Sweep => "sweep",
            Self::Random => "random sequence",
            Self::File => "external file",
            Self::OpenLoop => "open-loop sweep",
        }
    }

    /// Its values, rad or V, one a row. `file` is the external file's.
    fn values(self, seed: u64, file: &[f64]) -> Result<Vec<f64>, InvalidParameter> {
        let period = (1.0 / SAMPLE_RATE) as f32;
        let rows = (SECONDS * SAMPLE_RATE) as u32;
        let series = |at: &dyn Fn(u32) -> f32| (0..rows).map(|tick| f64::from(at(tick))).collect();
        let swept = |amplitude, final_frequency| {
            sweep::Parameters {
                offset: 0.0,
                amplitude,
                initial_frequency: 0.1,
                final_frequency,
                duration: SECONDS as f32,
            }
            .build(period)
        };
        Ok(match self {
            Self::Step => {
                let step = step::Parameters {
                    initial_value: 0.0,
                    final_value: 20.0,
                    time: 0.5,
                };
                let step = step.build(period)?;
                series(&|tick| step.at(tick))
            }
            Self::Ramp => {
                let ramp = ramp::Parameters {
                    initial_value: 0.0,
                    final_value: 60.0,
                    start: 0.5,
                    duration: 9.0,
                };
                let ramp = ramp.build(period)?;
                series(&|tick| ramp.at(tick))
            }
            Self::Sine => {
                let sine = sine::Parameters {
                    offset: 0.0,
                    amplitude: 4.0,
                    frequency: 0.7,
                    phase: 0.0,
                };
                let sine = sine.build(period)?;
                series(&|tick| sine.at(tick))
            }
            Self::Sweep => {
                let sweep = swept(4.0, 2.0)?;
                series(&|tick| sweep.at(tick))
            }
            Self::Random => {
                let steps = aprts::Parameters {
                    lower: -4.0,
                    upper: 4.0,
                    shortest_hold: 0.2,
                    longest_hold: 0.6,
                    seed,
                };
                let steps = steps.build(period)?;
                series(&|tick| steps.at(tick))
            }
            Self::File => file.to_vec(),
            Self::OpenLoop => {
                let sweep = swept(24.0, 4.0)?;
                series(&|tick| sweep.at(tick))
            }
        })
    }
}

/// Friction of an actuator, N·m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction {
    /// While sliding.
    pub coulomb: f64,
    /// At breakaway.
    pub breakaway: f64,
}

impl Friction {
    /// A Coulomb level with a breakaway level that follows from the seed.
    pub fn drawn(coulomb: f64, seed: u64) -> Self {
        let share = Random::new(seed ^ 0x5eed_0001).uniform();
        let most = BREAKAWAY.1.min(OVERCOME / coulomb).max(BREAKAWAY.0);
        Self {
            coulomb,
            breakaway: coulomb * (BREAKAWAY.0 + share * (most - BREAKAWAY.0)),
        }
    }
}

/// What the bench logged, as the core takes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// V.
    pub input: Vec<f32>,
    /// rad.
    pub position: Vec<f32>,
    /// A.
    pub current: Vec<f32>,
    /// What no sensor of the bench sees, rad/s.
    pub velocity: Vec<f64>,
    /// Position asked for, rad; empty without a loop.
    pub command: Vec<f64>,
}

impl Recorded {
    /// For the core. With a current only where it is asked for.
    pub fn log(&self, with_current: bool) -> CoreLog<'_> {
        CoreLog {
            current: with_current.then_some(Channel::Values(&self.current)),
            ..CoreLog::new(
                (1.0 / SAMPLE_RATE) as f32,
                Channel::Values(&self.input),
                Channel::Values(&self.position),
            )
        }
    }

    /// As a file's.
    pub fn file(&self, path: &Path) -> Log {
        let wide = |values: &[f32]| values.iter().map(|&value| f64::from(value)).collect();
        Log {
            path: path.to_owned(),
            start_s: 0.0,
            period_s: 1.0 / SAMPLE_RATE,
            input: wide(&self.input),
            position: wide(&self.position),
            command: (!self.command.is_empty()).then(|| self.command.clone()),
            current: Some(wide(&self.current)),
            ..Log::default()
        }
    }
}

/// The bench, with its external file.
#[derive(Debug, Clone)]
pub struct Stand {
    file: Vec<f64>,
}

impl Stand {
    /// A bench whose external file is `command`.
    ///
    /// # Errors
    /// A file that is no command.
    pub fn new(command: &Path) -> Result<Self, Failure> {
        let file = command_file::read(command, SAMPLE_RATE, SECONDS)?;
        Ok(Self { file })
    }

    /// A log of an actuator with this friction. Bench, noise and random steps follow from the seed.
    ///
    /// # Errors
    /// A signal that the core does not take.
    pub fn record(
        &self,
        input: Input,
        friction: Friction,
        seed: u64,
    ) -> Result<Recorded, InvalidParameter> {
        let machine = Machine {
            coulomb: friction.coulomb,
            static_friction: friction.breakaway,
            resolution: RESOLUTION,
            ..Machine::rotary_ema()
        };
        let trajectory = Trajectory::Sampled {
            rate: SAMPLE_RATE,
            values: input.values(seed, &self.file)?,
        };
        let experiment = match input {
            Input::OpenLoop => Experiment::driven(machine, trajectory),
            _ => Experiment::tracking(machine, trajectory),
        };
        let recording = experiment
            .lasting(SECONDS)
            .with_noise(NOISE)
            .on(bench(seed))
            .with_step(STEP)
            .seeded(seed)
            .run();
        let narrow = |values: &[f64]| values.iter().map(|&value| value as f32).collect();
        Ok(Recorded {
            input: narrow(&recording.input),
            position: narrow(&recording.position),
            current: narrow(&recording.current),
            velocity: recording.true_velocity,
            command: recording.command,
        })
    }
}

/// The imperfections that follow from a seed.
fn bench(seed: u64) -> Bench {
    let mut random = Random::new(seed ^ 0x5eed_0002);
    Bench {
        current_offset: 0.1 * random.normal(),
        current_drift: 0.02 * random.normal(),
        supply_ripple: 0.03 * random.uniform(),
        supply_frequency: 100.0,
        supply_phase: std::f64::consts::TAU * random.uniform(),
        torque_ripple: 0.02 * random.uniform(),
        ripples_per_turn: 12.0,
        backlash: 4.0 * RESOLUTION * random.uniform(),
        current_resolution: CONVERTER,
        position_offset: 0.01 * random.normal(),
        position_drift: 0.001 * random.normal(),
    }
}
