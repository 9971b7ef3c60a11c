//! A machine on the bench: who drives it, for how long, how it is measured.

use crate::bench::Bench;
use crate::controller::Pid;
use crate::effect::Effect;
use crate::machine::{Machine, Motor};
use crate::plant::{Plant, STEP};
use crate::random::Random;
use crate::recording::Recording;
use crate::trajectory::Trajectory;

/// Where the input comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum Excitation {
    /// The machine's position loop follows a trajectory.
    Position(Trajectory),
    /// The input itself is prescribed, evaluated at each row.
    Input(Trajectory),
    /// The input itself is prescribed, one value a row; 0 after the last.
    Recorded(Vec<f64>),
}

/// White noise of the sensors, standard deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Before the encoder quantises, rad or m.
    pub position: f64,
    /// A.
    pub current: f64,
}

impl Noise {
    /// None.
    pub const NONE: Self = Self {
        position: 0.0,
        current: 0.0,
    };

    /// Current noise of a cheap shunt amplifier; the encoder has its quantisation alone.
    pub const SHUNT: Self = Self {
        position: 0.0,
        current: 0.02,
    };

    /// A potentiometer's track: one count of the machine's converter, and [`Noise::SHUNT`].
    pub fn potentiometer(machine: &Machine) -> Self {
        Self {
            position: machine.resolution,
            ..Self::SHUNT
        }
    }
}

/// One run on the bench. Build it with [`Experiment::tracking`] or [`Experiment::driven`], change
/// any field, [`Experiment::run`] it.
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    /// The machine as declared.
    pub machine: Machine,
    /// What it has beyond that.
    pub effects: Vec<Effect>,
    /// Who drives it.
    pub excitation: Excitation,
    /// Length of the log, s.
    pub seconds: f64,
    /// Rows and loop updates a second, Hz.
    pub sample_rate: f64,
    /// Seed of the noise.
    pub seed: u64,
    /// How noisy the sensors are.
    pub noise: Noise,
    /// What else the bench adds.
    pub bench: Bench,
    /// Friction that a brake adds, logged beside the rest, N·m or N; `None` for a bench without a
    /// brake.
    pub brake: Option<Trajectory>,
    /// Integration step, s: 2 µs unless it was changed.
    pub step: f64,
}

impl Experiment {
    /// The position loop follows `trajectory`: 10 s at 1 kHz, shunt noise, no effect.
    pub fn tracking(machine: Machine, trajectory: Trajectory) -> Self {
        Self {
            machine,
            effects: Vec::new(),
            excitation: Excitation::Position(trajectory),
            seconds: 10.0,
            sample_rate: 1000.0,
            seed: 1,
            noise: Noise::SHUNT,
            bench: Bench::IDEAL,
            brake: None,
            step: STEP,
        }
    }

    /// The input follows `trajectory`: 10 s at 1 kHz, shunt noise, no effect.
    pub fn driven(machine: Machine, trajectory: Trajectory) -> Self {
        Self {
            excitation: Excitation::Input(trajectory.clone()),
            ..Self::tracking(machine, trajectory)
        }
    }

    /// The input is `input`, one value a row at `sample_rate`: shunt noise, no effect.
    pub fn replaying(machine: Machine, input: Vec<f64>, sample_rate: f64) -> Self {
        Self {
            seconds: input.len() as f64 / sample_rate,
            sample_rate,
            excitation: Excitation::Recorded(input),
            ..Self::tracking(machine, Trajectory::Constant(0.0))
        }
    }

    /// With these effects, in place of those it had.
    pub fn with_effects(mut self, effects: &[Effect]) -> Self {
        self.effects = effects.to_vec();
        self
    }

    /// With a log of `seconds`.
    pub fn lasting(mut self, seconds: f64) -> Self {
        self.seconds = seconds;
        self
    }

    /// With another seed.
    pub fn seeded(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// With other noise.
    pub fn with_noise(mut self, noise: Noise) -> Self {
        self.noise = noise;
        self
    }

    /// On another bench.
    pub fn on(mut self, bench: Bench) -> Self {
        self.bench = bench;
        self
    }

    /// Under a brake that adds this to friction, held from each row to the next.
    pub fn braked(mut self, brake: Trajectory) -> Self {
        self.brake = Some(brake);
        self
    }

    /// Integrated in steps of at most `step` seconds.
    pub fn with_step(mut self, step: f64) -> Self {
        self.step = step;
        self
    }

    /// The log. A machine starts at standstill without current: at the spring's rest if it has
    /// one, else where its trajectory starts, else at 0.
    pub fn run(&self) -> Recording {
        let machine = &self.machine;
        let period = 1.0 / self.sample_rate;
        let rows = (self.seconds * self.sample_rate).round() as usize;
        let (input_rows, input_phase) = split(self.delay(Effect::input_delay), period);
        let (sensor_rows, sensor_age) = split(self.delay(Effect::sensor_delay), period);

        let start = match (&machine.spring, &self.excitation) {
            (Some(spring), _) => spring.rest,
            (None, Excitation::Position(trajectory)) => trajectory.at(0.0),
            (None, Excitation::Input(_) | Excitation::Recorded(_)) => 0.0,
        };
        let mut bench = self.bench;
        bench.backlash += self.effects.iter().map(Effect::play).sum::<f64>();
        let mut plant = Plant::new(machine, &self.effects)
            .with_step(self.step)
            .with_torque_ripple(self.bench.torque_ripple, self.bench.ripples_per_turn);
        plant.place(start, 0.0);
        let mut powered = Powered {
            plant,
            bench: &self.bench,
            time: 0.0,
        };
        let mut pid = Pid::new(machine.gains, machine.input_limit, period);
        let mut random = Random::new(self.seed);

        let with = |wanted: bool| Vec::with_capacity(if wanted { rows } else { 0 });
        let has_winding = matches!(machine.motor, Motor::Winding { .. });
        let mut log = Recording {
            machine: machine.clone(),
            time: with(true),
            brake: with(self.brake.is_some()),
            input: with(true),
            position: with(true),
            command: with(true),
            current: with(has_winding),
            true_position: with(true),
            true_velocity: with(true),
        };
        // Positions in the order in which the sensor caught them, one a period.
        let mut caught: Vec<f64> = with(true);
        let mut acting = 0.0;
        let mut behind_the_play = start;
        for row in 0..rows {
            let time = row as f64 * period;
            if let Some(brake) = &self.brake {
                let level = brake.at(time).max(0.0);
                log.brake.push(level);
                powered.plant.brake(level);
            }
            if sensor_age == 0.0 {
                caught.push(powered.plant.sensed());
            }
            let reported = caught.len().checked_sub(1 + sensor_rows);
            let seen = reported.map_or(start, |index| caught[index]);
            behind_the_play = bench.take_up(behind_the_play, seen);
            let position = quantise(
                behind_the_play
                    + self.reading_error(behind_the_play)
                    + self.bench.position_error(time)
                    + self.noise.position * random.normal(),
                machine.resolution,
            );
            let input = match &self.excitation {
                Excitation::Position(trajectory) => {
                    let command = trajectory.at(time);
                    log.command.push(command);
                    pid.step(command, position)
                }
                Excitation::Input(trajectory) => trajectory
                    .at(time)
                    .clamp(-machine.input_limit, machine.input_limit),
                Excitation::Recorded(values) => values
                    .get(row)
                    .copied()
                    .unwrap_or(0.0)
                    .clamp(-machine.input_limit, machine.input_limit),
            };
            log.time.push(time);
            log.input.push(input);
            log.position.push(position);
            log.true_position.push(powered.plant.state().position);
            log.true_velocity.push(powered.plant.state().velocity);
            if has_winding {
                // A winding without inductance answers the new input at once.
                let acting = if input_rows == 0 && input_phase == 0.0 {
                    input
                } else {
                    acting
                };
                let volts = acting * self.bench.supply(time);
                log.current.push(quantise(
                    powered.plant.current(volts)
                        + self.bench.current_error(time)
                        + self.noise.current * random.normal(),
                    self.bench.current_resolution,
                ));
            }

            // Within the period two things happen, each at its own instant: a delayed input
            // arrives, the sensor catches the position that it will report `sensor_age` later.
            let arriving = row.checked_sub(input_rows).map_or(0.0, |k| log.input[k]);
            let catch_phase = period - sensor_age;
            if sensor_age == 0.0 {
                powered.advance(acting, input_phase);
                powered.advance(arriving, period - input_phase);
            } else if catch_phase < input_phase {
                powered.advance(acting, catch_phase);
                caught.push(powered.plant.sensed());
                powered.advance(acting, input_phase - catch_phase);
                powered.advance(arriving, period - input_phase);
            } else {
                powered.advance(acting, input_phase);
                powered.advance(arriving, catch_phase - input_phase);
                caught.push(powered.plant.sensed());
                powered.advance(arriving, sensor_age);
            }
            acting = arriving;
        }
        log
    }

    /// What the effects add to the reading of a position, rad or m.
    fn reading_error(&self, position: f64) -> f64 {
        let errors = self.effects.iter();
        errors.map(|effect| effect.reading_error(position)).sum()
    }

    /// Sum of the delays that `select` finds among the effects, s.
    fn delay(&self, select: fn(&Effect) -> f64) -> f64 {
        self.effects.iter().map(select).sum()
    }
}

/// The plant on the bench's supply.
struct Powered<'a> {
    plant: Plant,
    bench: &'a Bench,
    /// Since the start of the log, s.
    time: f64,
}

impl Powered<'_> {
    /// Lets `seconds` pass; the ripple is held over an eighth of its period at most.
    fn advance(&mut self, input: f64, seconds: f64) {
        let parts = if self.bench.supply_ripple == 0.0 {
            1.0
        } else {
            (8.0 * seconds * self.bench.supply_frequency)
                .ceil()
                .max(1.0)
        };
        let part = seconds / parts;
        for _ in 0..parts as usize {
            let volts = input * self.bench.supply(self.time + 0.5 * part);
            self.plant.advance(volts, part);
            self.time += part;
        }
    }
}

/// A delay as whole periods and a rest in [0, period). A rest within a billionth of a period of
/// either end is rounding, not delay.
fn split(delay: f64, period: f64) -> (usize, f64) {
    let periods = delay / period;
    let whole = (periods + 1e-9).floor();
    let rest = (periods - whole) * period;
    (
        whole as usize,
        if rest < 1e-9 * period { 0.0 } else { rest },
    )
}

/// The nearest multiple of `resolution`, or `value` itself if `resolution` is 0.
fn quantise(value: f64, resolution: f64) -> f64 {
    if resolution > 0.0 {
        (value / resolution).round() * resolution
    } else {
        value
    }
}
