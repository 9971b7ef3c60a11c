//! The semi-automatic identification of an actuator with friction and a return spring: two logs in,
//! six numbers with their intervals out, and machines made of them.
//!
//! Source: the throttle paper, eqs 8–20. A slow triangle gives five ratios by the lines of the
//! input/output characteristic ([`model_core::identify::characteristic`]); a fast multi-step signal
//! gives b₀ by the error of a free run (`gain`), for each of two assemblies. The declared winding turns the six numbers into an
//! inertia, frictions and a spring: with a current that follows the voltage at once
//! (reduced motor) and with its inductance (full motor). Last, all six numbers are polished together on
//! both logs (`polish`); what the paper's procedure found is kept beside it.
//!
//! The ends of the stroke and the open position are the machine file's, which a learning sweep knows;
//! where the logs come to lie near a declared stop again and again, the stop is moved to where
//! the sensor saw it.

pub mod command;
pub(crate) mod figure;
mod gain;
pub(crate) mod machine_file;
mod numbers;
mod page;
mod polish;
mod table;
mod verdict;

use model_core::identify::characteristic::{Characteristic, Refusal, Task};
use model_core::plant::parameters::{Drive, Parameters};
use serde::Serialize;

use crate::error::InputError;
use crate::free_run::{self, Errors};
use crate::gap::declared;
use crate::log::Log;
use crate::machine::{Coordinate, Machine};
pub use numbers::{Number, Numbers};

/// Time over which speeds are averaged, s.
const SMOOTHING_S: f32 = 0.04;

/// Half width of a 95 % interval, as a share of the number, from which on the user is told.
const UNCERTAIN: f64 = 0.3;

/// Rounds of ratios and b₀: the ratios want the inertia's part of the input, see
/// [`Task::acceleration_gain`].
const ROUNDS: usize = 4;

/// Stretches at the end of the stroke after which a stop is taken to be there.
const VISITS: usize = 4;

/// Shortest such stretch, s.
const DWELL_S: f32 = 0.05;

/// Where the identification starts: what is declared.
#[derive(Debug, Clone)]
pub struct Start {
    /// The declared machine, from which the winding, the stops, the spring's rest and the sensor's
    /// resolution are taken; its inertia and damping start the search.
    pub machine: Machine,
    /// The same for the core.
    pub parameters: Parameters,
}

impl Start {
    /// What a machine file declares.
    ///
    /// # Errors
    /// A number that the core does not take; a machine without a return spring's rest inside its stops; one
    /// with effects or gravity, which the six numbers do not know.
    pub fn new(machine: Machine) -> Result<Self, InputError> {
        let model = declared::model(&machine)?;
        if !model.effects.is_empty() || model.gravity_torque != 0.0 {
            let message = "declares effects or gravity, which the six numbers do not know; identify \
                           without them and add them to the machine file that comes of it";
            return Err(InputError::new(&machine.path, None, message));
        }
        let parameters = model.plant;
        let rest = parameters.spring_rest;
        if !(parameters.lower_stop..=parameters.upper_stop).contains(&rest) {
            let message = format!(
                "`spring_rest` is {rest}, outside the stops; set it to where the spring leaves the \
                 actuator without power"
            );
            return Err(InputError::new(&machine.path, None, message));
        }
        Ok(Self {
            machine,
            parameters,
        })
    }
}

/// A log in the core's precision.
#[derive(Debug, Clone)]
pub struct Series {
    /// s
    pub period: f32,
    /// In the drive's unit.
    pub input: Vec<f32>,
    /// rad or m
    pub position: Vec<f32>,
}

impl Series {
    /// The columns that the identification reads.
    pub fn of(log: &Log) -> Self {
        let single = |column: &[f64]| column.iter().map(|&value| value as f32).collect();
        Self {
            period: log.period_s as f32,
            input: single(&log.input),
            position: single(&log.position),
        }
    }

    /// Errors of a free run of these parameters.
    ///
    /// # Errors
    /// Parameters that the core does not take, as a message.
    pub fn free_run(&self, parameters: &Parameters) -> Result<Errors, String> {
        let predicted = free_run::simulate(parameters, self.period, &self.input, self.position[0])
            .map_err(|error| error.to_string())?;
        Ok(free_run::errors(&predicted, &self.position))
    }
}

/// The errors of one set of parameters on both logs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LogErrors {
    /// On the triangle.
    pub slow: Errors,
    /// On the multi-step signal.
    pub fast: Errors,
}

/// One set of parameters.
#[derive(Debug, Clone)]
pub struct Model {
    /// The six numbers.
    pub numbers: Numbers,
    /// The machine for the core.
    pub parameters: Parameters,
    /// How it does in free run.
    pub errors: LogErrors,
}

/// What the logs say.
#[derive(Debug, Clone)]
pub struct Identified {
    /// The characteristic of the slow log: points and lines.
    pub characteristic: Box<Characteristic>,
    /// By the paper's procedure, inductance neglected.
    pub reduced: Model,
    /// By the paper's procedure, with the declared inductance.
    pub full: Model,
    /// All six numbers refitted together, full motor. `None` if that was no better on the sum of both
    /// logs' mean squares.
    pub polished: Option<Model>,
    /// What the user should know.
    pub warnings: Vec<String>,
    /// Simulations of a log.
    pub simulations: usize,
}

impl Identified {
    /// The best model with the full motor.
    pub fn best(&self) -> &Model {
        self.polished.as_ref().unwrap_or(&self.full)
    }
}

/// Identifies a machine from a slow and a fast log.
///
/// # Errors
/// A log that does not give the numbers, a declared winding that contradicts them.
pub fn identify(start: &Start, slow: &Log, fast: &Log) -> Result<Identified, InputError> {
    let refuse = |log: &Log, message: &str| InputError::new(&log.path, None, message);
    if slow.repeats(fast) {
        return Err(refuse(
            fast,
            "has the samples of the slow log; expected a log of fast steps",
        ));
    }
    let (slow_series, fast_series) = (Series::of(slow), Series::of(fast));
    let mut assembly = Assembly::new(start);
    let resolution = declared::resolution(&start.machine, [slow, fast]);
    assembly.seat_stops([&slow_series, &fast_series], resolution);
    let mut b0 = assembly.declared_gain(start);
    let mut a1 = assembly.declared_damping(start);
    let mut settling_time = f32::INFINITY;
    let mut simulations = 0;
    let mut outcome = None;
    // A negative gain is a machine that is wired the other way round.
    let input: Vec<f32> = slow_series
        .input
        .iter()
        .map(|u| u * start.parameters.gain.signum())
        .collect();
    for _ in 0..ROUNDS {
        let task = Task {
            period: slow_series.period,
            input: &input,
            position: &slow_series.position,
            resolution,
            rest: assembly.base.spring_rest,
            lower_stop: assembly.base.lower_stop,
            upper_stop: assembly.base.upper_stop,
            smoothing: SMOOTHING_S,
            acceleration_gain: b0 as f32,
            time_constant: (1.0 / (a1 * b0)) as f32,
            settling_time,
            lag: match assembly.base.drive {
                Drive::Voltage {
                    inductance,
                    resistance,
                    ..
                } => inductance / resistance,
                Drive::Torque => 0.0,
            },
            seed: 1,
        };
        let characteristic =
            Box::new(Characteristic::find(&task).map_err(|refusal| refuse(slow, remedy(refusal)))?);
        let ratios = characteristic
            .ratios(task.rest)
            .map_err(|refusal| refuse(slow, remedy(refusal)))?;
        let ratios = Numbers::of(&ratios, b0);
        if ratios.a0.half_width > ratios.a0.value.abs() {
            return Err(refuse(
                slow,
                "the lines do not give the spring's stiffness, its interval holds zero; expected a \
                 triangle that is slow and reverses at several places (is this the fast log?)",
            ));
        }
        assembly
            .check(&ratios)
            .map_err(|message| InputError::new(&start.machine.path, None, message))?;
        let mut gain = |inductance| {
            let found =
                gain::find(&assembly, &ratios, &fast_series, inductance).ok_or_else(|| {
                    refuse(
                        fast,
                        "no acceleration gain fits this log: its position hardly depends on the \
                     inertia; drive the actuator by steps of the input over most of its stroke",
                    )
                })?;
            simulations += found.simulations;
            Ok(Numbers {
                b0: found.number,
                ..ratios
            })
        };
        let (reduced, full) = (gain(false)?, gain(true)?);
        (b0, a1) = (full.b0.value, ratios.a1.value);
        settling_time = (a1 / ratios.a0.value) as f32;
        outcome = Some((characteristic, reduced, full));
    }
    let (characteristic, reduced, full) = outcome.expect("there is a round");
    let mut warnings = assembly.warnings(&full);
    let model = |numbers: Numbers, inductance: bool| -> Result<Model, InputError> {
        let parameters = assembly.parameters(&numbers.values(), inductance);
        let on = |log: &Log, series: &Series| {
            series
                .free_run(&parameters)
                .map_err(|message| refuse(log, &message))
        };
        Ok(Model {
            numbers,
            parameters,
            errors: LogErrors {
                slow: on(slow, &slow_series)?,
                fast: on(fast, &fast_series)?,
            },
        })
    };
    let polish = polish::polish(&assembly, &full, &[&slow_series, &fast_series]);
    simulations += 4 + polish.simulations;
    let polished = match polish.numbers {
        Some(numbers) => Some(model(numbers, true)?),
        None => {
            warnings.push(
                if full.values().iter().all(|value| *value > 0.0) {
                    "fitting all six numbers together gained nothing"
                } else {
                    "the six numbers are not fitted together, as one of them is not positive"
                }
                .to_owned(),
            );
            None
        }
    };
    Ok(Identified {
        characteristic,
        reduced: model(reduced, false)?,
        full: model(full, true)?,
        polished,
        warnings,
        simulations,
    })
}

/// How often a log comes to lie near a place: stretches of [`DWELL_S`] or more.
fn visits(log: &Series, near: impl Fn(&f32) -> bool) -> usize {
    let least = (DWELL_S / log.period) as usize;
    let stretches = log.position.chunk_by(|a, b| near(a) == near(b));
    stretches
        .filter(|stretch| near(&stretch[0]) && stretch.len() > least)
        .count()
}

/// What to do about a slow log that does not give the ratios.
fn remedy(refusal: Refusal) -> &'static str {
    match refusal {
        Refusal::TooShort => {
            "too short or sampled too slowly for the characteristic; expected at least 0.8 s at \
             125 Hz or more, some ten reversals"
        }
        Refusal::NoUniformMotion => {
            "no stretch of uniform motion both ways; expected a slow triangle over most of the stroke"
        }
        Refusal::TooFewBreakaways => {
            "fewer than four breakaways each way on one side of the spring's rest, away from the \
             stops; expected a slow triangle that reverses at several places and \
             overcomes friction both ways"
        }
        Refusal::TooFewStandstills => {
            "fewer than four standstills each way on one side of the spring's rest, away from the \
             stops; expected a slow triangle that reverses at several places within the stroke"
        }
    }
}

/// Makes machines of the six numbers.
#[derive(Debug, Clone)]
pub(crate) struct Assembly {
    /// The declared machine, its stops where the sensor sees them.
    pub base: Parameters,
    /// k_V: torque for one unit of the input (by magnitude) at standstill.
    strength: f64,
    /// k_EMF/k_V: volts of back-EMF, in units of the input, for one unit of speed.
    back_emf: f64,
    unit: &'static str,
}

impl Assembly {
    fn new(start: &Start) -> Self {
        let base = start.parameters;
        let gain = f64::from(base.gain.abs());
        let (strength, back_emf) = match base.drive {
            Drive::Voltage {
                resistance,
                torque_constant,
                ..
            } => (
                gain * f64::from(torque_constant) / f64::from(resistance),
                f64::from(torque_constant) / gain,
            ),
            Drive::Torque => (gain, 0.0),
        };
        Self {
            base,
            strength,
            back_emf,
            unit: match start.machine.coordinate {
                Coordinate::Radian => "V·s/rad",
                Coordinate::Metre => "V·s/m",
            },
        }
    }

    fn declared_gain(&self, start: &Start) -> f64 {
        self.strength / f64::from(start.parameters.inertia)
    }

    fn declared_damping(&self, start: &Start) -> f64 {
        let viscous = f64::from(start.parameters.viscous.forward);
        // Without any declared damping the inertia settles in a second.
        (viscous / self.strength + self.back_emf).max(1.0 / self.declared_gain(start))
    }

    /// Moves a declared stop to where the logs come to lie next to it, again and again.
    fn seat_stops(&mut self, logs: [&Series; 2], resolution: f32) {
        let stroke = self.base.upper_stop - self.base.lower_stop;
        if !stroke.is_finite() {
            return;
        }
        let margin = (2e-3 * stroke).max(3.0 * resolution);
        let mut sorted: Vec<f32> = logs.iter().flat_map(|log| log.position.clone()).collect();
        sorted.sort_unstable_by(f32::total_cmp);
        let seat = |stop: f32, extreme: f32| {
            let near = |y: &f32| (y - extreme).abs() <= margin;
            // Where friction holds a single turn of the input, the actuator dwells as well.
            let visits: usize = logs.iter().map(|log| visits(log, near)).sum();
            let near: Vec<f32> = sorted.iter().copied().filter(near).collect();
            let seated = visits >= VISITS && (extreme - stop).abs() < 0.03 * stroke;
            seated.then(|| near[near.len() / 2])
        };
        let few = sorted.len() / 1000;
        let (lower, upper) = (
            seat(self.base.lower_stop, sorted[few]),
            seat(self.base.upper_stop, sorted[sorted.len() - 1 - few]),
        );
        let rest_at = |stop: f32| self.base.spring_rest == stop;
        let (rest_low, rest_high) = (rest_at(self.base.lower_stop), rest_at(self.base.upper_stop));
        if let Some(stop) = lower {
            self.base.lower_stop = stop;
            if rest_low {
                self.base.spring_rest = stop;
            }
        }
        if let Some(stop) = upper {
            self.base.upper_stop = stop;
            if rest_high {
                self.base.spring_rest = stop;
            }
        }
    }

    /// Refuses numbers that no machine with a return spring has.
    fn check(&self, numbers: &Numbers) -> Result<(), String> {
        let a0 = numbers.a0;
        if a0.value <= 0.0 {
            return Err(format!(
                "the log shows no return spring (a0/b0 = {:.3} ± {:.3}); the line procedure needs one",
                a0.value, a0.half_width
            ));
        }
        Ok(())
    }

    fn warnings(&self, numbers: &Numbers) -> Vec<String> {
        let mut warnings = Vec::new();
        for ((symbol, name, _), number) in table::NUMBERS.iter().zip(numbers.all()) {
            if number.half_width > UNCERTAIN * number.value.abs() {
                warnings.push(format!(
                    "{symbol}, {name}, is known to {:.0} % only",
                    100.0 * (number.half_width / number.value).abs()
                ));
            }
        }
        if numbers.a1.value < self.back_emf {
            warnings.push(format!(
                "the declared winding's back-EMF alone damps more ({:.4} {}) than the log shows \
                 ({:.4} ± {:.4}): viscous friction is set to 0. Either the machine has effects that \
                 the model lacks, or `torque_constant` is too large; at most {:.4} fits",
                self.back_emf,
                self.unit,
                numbers.a1.value,
                numbers.a1.half_width,
                numbers.a1.value * f64::from(self.base.gain.abs()),
            ));
        }
        if numbers.ch.value < numbers.c1.value {
            warnings.push(
                "static friction was identified below Coulomb friction and is set equal to it"
                    .to_owned(),
            );
        }
        if numbers.c0.value < 0.0 {
            warnings.push(
                "the spring's preload was identified as negative and is set to 0; check `spring_rest`"
                    .to_owned(),
            );
        }
        warnings
    }

    /// The machine of six numbers, with the declared inductance or without.
    pub fn parameters(&self, values: &[f64; 6], inductance: bool) -> Parameters {
        use model_core::plant::Directional;
        let [a0, a1, c0, c1, ch, b0] = *values;
        let torque = |volts: f64| (volts * self.strength).max(0.0) as f32;
        let mut parameters = Parameters {
            inertia: (self.strength / b0) as f32,
            viscous: Directional::both(torque(a1 - self.back_emf)),
            coulomb: Directional::both(torque(c1)),
            breakaway: Directional::both(torque(ch.max(c1))),
            spring: torque(a0),
            spring_preload: torque(c0),
            ..self.base
        };
        if let (
            Drive::Voltage {
                inductance: neglected,
                ..
            },
            false,
        ) = (&mut parameters.drive, inductance)
        {
            *neglected = 0.0;
        }
        parameters
    }
}
