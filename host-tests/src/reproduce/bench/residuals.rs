//! The two residuals that the paper leaves open (ch. 6.3), closed by the tracing: the model leaves the
//! dead band late, and its current is too low under the brake.
//!
//! At each level of backlash the bench is logged at three levels of friction, and the logs are traced
//! together as `cargo hil gap` would do it: quadrature current in, encoder out, the load cell's brake beside
//! them; the machine file knows neither backlash nor loss. What is found, with its refitted friction, goes
//! into the model of the bench in place of Algorithm 1's backlash, and the closed loop is compared again, on
//! logs that nothing was fitted on.

use std::path::Path;

use model_core::plant::bench::averaged::Averaged;
use model_core::plant::bench::datasheet::{gearbox, motor};
use model_core::plant::bench::{Parameters, electrics, mechanics, torque};
use model_core::plant::ema::friction;
use rayon::prelude::*;
use rig::pmsm_bench::{BacklashLevel, FrictionLevel, Loss, Point, Program, Recording};

use super::points::{Compared, compare, compare_with};
use super::reconstruction::Reconstruction;
use crate::failure::Failure;
use crate::gap::engine;
use crate::gap::outcome::Outcome;
use crate::log::Log;
use crate::machine::Machine;
use crate::outputs::write_own;
use crate::workspace;

pub(super) mod report;

/// The machine file that declares the bench, from the workspace's root.
pub const MACHINE: &str = "host-tests/machines/pmsm-bench.toml";

/// Rows a second, Hz, of the logs that are traced.
const TRACED_RATE: f64 = 250.0;

/// Rows of the bench's recording that make one of these: a row's current is the mean of what acts until
/// the next. The hysteresis of ±0.1 A, 23 N·m at the slow shaft, would else fold down to any frequency.
const MEAN_OF: usize = 8;

/// Frequency, Hz, of a second sine of 10° that is traced with the paper's: of one sine alone nobody can
/// tell an inertia from a spring.
const FAST: f64 = 0.4;

/// How long it is logged, s: lost motion shows behind a reversal alone, and there are two a period.
const FAST_SECONDS: f64 = 20.0;

/// Levels of friction at which it is logged. Under the full brake what is lost is much more than the
/// inertia's torque, and a fit without the loss takes an inertia ten times as large for it.
const FAST_FRICTION: [FrictionLevel; 2] = [FrictionLevel::Low, FrictionLevel::Medium];

/// Recorded rows by which the drive's filter, of 100 Hz, reports the current late: 1.6 ms.
const FILTER_LAG: usize = 3;

/// One level of backlash.
#[derive(Debug, Clone)]
pub struct Traced {
    /// The level.
    pub backlash: BacklashLevel,
    /// What the tracing says, with its errors on the training and on the validation logs.
    pub outcome: Outcome,
    /// What that makes of the bench's model.
    pub found: Found,
}

/// The bench's numbers in the words of an answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// Whole width of the play, rad of the slow shaft; `None` where none was found.
    pub play: Option<f64>,
    /// Share of the motor's torque that friction takes.
    pub load_share: f64,
    /// Fall of the torque constant, 1/A rms.
    pub saturation: f64,
    /// Coulomb friction without the brake, N·m at the motor.
    pub coulomb: f64,
    /// Breakaway level without the brake, N·m at the motor.
    pub breakaway: f64,
    /// Viscous friction, N·m·s/rad at the motor.
    pub viscous: f64,
}

/// The paper's model and the one with what was found, on the same unseen log.
#[derive(Debug, Clone)]
pub struct BeforeAfter {
    /// The paper's.
    pub before: Compared,
    /// With what was found.
    pub after: Compared,
}

/// A whole campaign under one loss.
#[derive(Debug, Clone)]
pub struct Residuals {
    /// What the bench loses its torque to.
    pub loss: Loss,
    /// The levels of backlash.
    pub traced: Vec<Traced>,
    /// The points with these levels of backlash.
    pub points: Vec<BeforeAfter>,
}

fn ratio() -> f64 {
    f64::from(gearbox::RATIO)
}

/// Traces these levels of backlash and runs the closed loop at their points, before and after.
/// Training, validation and closed-loop logs have seeds from `seed`, `seed` + 100 and `seed` + 200 on.
///
/// # Errors
/// A file that cannot be written; a log that the tracing or the model refuses.
pub fn run(loss: Loss, levels: &[BacklashLevel], seed: u64) -> Result<Residuals, Failure> {
    let machine = Machine::read(&workspace::root().join(MACHINE))?;
    let directory = workspace::results().join("bench");
    let traced: Vec<Traced> = levels
        .into_par_iter()
        .map(|&backlash| {
            let logs = |name: &str, program: Program, seed: u64, frictions: &[FrictionLevel]| {
                let program = program.sampled_at(TRACED_RATE * MEAN_OF as f64);
                let program = program.seeded(seed);
                record(&directory, name, (loss, backlash), &program, frictions)
            };
            let mut train = logs("train", Program::paper_sine(), seed, &FrictionLevel::ALL)?;
            let fast = Program {
                seconds: FAST_SECONDS,
                ..Program::sine(10.0, FAST)
            };
            train.extend(logs("train-fast", fast, seed + 300, &FAST_FRICTION)?);
            let outcome = engine::run(
                &machine,
                &train,
                || {
                    let validation = Program::validation_sine();
                    logs("validate", validation, seed + 100, &FrictionLevel::ALL)
                },
                |_| (),
            )?
            .outcome;
            let found = Found::of(&outcome);
            Ok(Traced {
                backlash,
                outcome,
                found,
            })
        })
        .collect::<Result<_, Failure>>()?;
    let program = Program::paper_sine();
    let points: Vec<(Point, u64)> = Point::ALL.into_iter().zip(seed + 200..).collect();
    let points = points
        .into_par_iter()
        .filter_map(|(point, seed)| {
            let level = traced.iter().find(|it| it.backlash == point.backlash)?;
            Some((point, level.found, seed))
        })
        .map(|(point, found, seed)| {
            let log = point.bench(loss).run(&program.clone().seeded(seed));
            let before =
                compare::<Averaged>(&Parameters::AVERAGED, point, log, program.sample_rate)?;
            let mut given = before.given.clone();
            if let Some(play) = found.play {
                given.backlash = 0.5 * play;
            }
            let after = compare_with::<Averaged>(
                &found.parameters(),
                point,
                before.log.clone(),
                given,
                program.sample_rate,
            )?;
            Ok(BeforeAfter { before, after })
        })
        .collect::<Result<_, Failure>>()?;
    Ok(Residuals {
        loss,
        traced,
        points,
    })
}

/// The logs of a level of backlash as a user would have them, one for each of these levels of friction, with
/// seeds from the program's on. They stay in `directory` for `cargo hil gap`.
fn record(
    directory: &Path,
    name: &str,
    (loss, backlash): (Loss, BacklashLevel),
    program: &Program,
    frictions: &[FrictionLevel],
) -> Result<Vec<Log>, Failure> {
    let kind = match loss {
        Loss::TorqueSaturation { .. } => "saturation",
        _ => "load",
    };
    let level = BacklashLevel::ALL.iter().position(|it| *it == backlash);
    let level = level.unwrap_or_default();
    frictions
        .iter()
        .enumerate()
        .map(|(index, &friction)| {
            let seed = program.seed + (5 * index + level) as u64;
            let point = Point { friction, backlash };
            let recording = point.bench(loss).run(&program.clone().seeded(seed));
            let file = format!(
                "{name}-{kind}-backlash{}-friction{}.csv",
                level + 1,
                index + 1
            );
            let log = log(&directory.join(file), &recording, program.sample_rate)?;
            write_own(&log.path, log.to_csv())?;
            Ok(log)
        })
        .collect()
}

/// A recording as the tracing takes it, at the slow shaft.
fn log(path: &Path, recording: &Recording, sample_rate: f64) -> Result<Log, Failure> {
    let given = Reconstruction::of(recording, sample_rate)?;
    let rows = (recording.time.len() - FILTER_LAG) / MEAN_OF;
    let first = |column: &[f64]| (0..rows).map(|row| column[MEAN_OF * row]).collect();
    let acting = recording.current_q[FILTER_LAG..].chunks_exact(MEAN_OF);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / MEAN_OF as f64;
    let brake: Vec<f64> = given.friction.iter().map(|it| ratio() * it).collect();
    Ok(Log {
        path: path.to_owned(),
        start_s: 0.0,
        period_s: MEAN_OF as f64 / sample_rate,
        input: acting.map(mean).collect(),
        position: first(&recording.encoder_position),
        command: Some(first(&recording.command)),
        current: None,
        velocity: None,
        brake: Some(first(&brake)),
        ..Log::default()
    })
}

impl Found {
    /// Whatever the answer does not name stays as the paper's model has it.
    fn of(outcome: &Outcome) -> Self {
        let parameter = |effect: &str, name: &str| -> Option<f64> {
            let found = outcome.effects.iter().find(|found| found.id == effect)?;
            let value = found.parameters.iter().find(|it| it.name == name)?.value;
            Some(value)
        };
        let fitted = |name: &str| {
            let fit = outcome.fit.iter().find(|fit| fit.name == name);
            fit.map_or(0.0, |fit| fit.fitted)
        };
        let per_torque = ratio() * f64::from(motor::TORQUE_CONSTANT);
        Self {
            play: parameter("backlash", "width"),
            load_share: parameter("load_dependent_friction", "share").unwrap_or(0.0),
            saturation: per_torque * parameter("torque_saturation", "fall").unwrap_or(0.0),
            coulomb: fitted("coulomb") / ratio(),
            breakaway: fitted("static") / ratio(),
            viscous: fitted("viscous") / (ratio() * ratio()),
        }
    }

    /// The bench's model with these numbers.
    fn parameters(&self) -> Parameters {
        let plain = Parameters::AVERAGED;
        Parameters {
            electrics: electrics::Parameters {
                torque: torque::Parameters {
                    saturation: self.saturation as f32,
                    ..plain.electrics.torque
                },
                ..plain.electrics
            },
            mechanics: mechanics::Parameters {
                motor_viscous: self.viscous as f32,
                tare: friction::Parameters {
                    coulomb: self.coulomb as f32,
                    breakaway: self.breakaway.max(self.coulomb) as f32,
                },
                load_share: self.load_share as f32,
                ..plain.mechanics
            },
            ..plain
        }
    }
}
