//! The fifteen points of ch. 5.3: three levels of friction by five of backlash, under 10° at 0.1 Hz.
//!
//! The `f64` rig plays the bench. The model is run as the paper runs it ([`super::reconstruction`]):
//! in closed loop, under the command, the backlash and the friction that the log gives. Its position,
//! velocity and quadrature current are compared with the log's by the NRMSE of ch. 6.3.1.

use model_core::plant::bench::averaged::Averaged;
use model_core::plant::bench::electrics::Electrics;
use model_core::plant::bench::encoder;
use model_core::plant::bench::{Bench, Parameters};
use rayon::prelude::*;
use rig::pmsm_bench::{Loss, Point, Program, Recording};

use super::errors::{Errors, errors};
use super::reconstruction::{MOVING, Reconstruction};
use crate::failure::Failure;

pub(super) mod report;

/// Way from its end of travel at which the encoder counts as moving again, rad: 0.05°.
const DEPARTURE: f64 = 0.05 * std::f64::consts::PI / 180.0;

/// What the model says at each row of a log.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Simulated {
    /// Encoder, rad of the slow shaft.
    pub position: Vec<f64>,
    /// rad/s of the motor.
    pub velocity: Vec<f64>,
    /// Filtered quadrature current, A rms.
    pub current: Vec<f64>,
}

/// The model beside the log at one point.
#[derive(Debug, Clone, PartialEq)]
pub struct Compared {
    /// Which one.
    pub point: Point,
    /// What the model was given.
    pub given: Reconstruction,
    /// Of the encoder's position.
    pub position: Errors,
    /// Of the motor's velocity.
    pub velocity: Errors,
    /// Of the quadrature current.
    pub current: Errors,
    /// How much lower the model's current in motion is than the log's, as a share of the log's.
    pub current_shortfall: f64,
    /// How much later than the log's the model's encoder leaves its ends of travel, s.
    pub lateness: f64,
    /// The log.
    pub log: Recording,
    /// The model.
    pub model: Simulated,
}

impl Compared {
    /// NRMSE of the position, %.
    pub fn position_percent(&self) -> f64 {
        100.0 * self.position.nrmse
    }

    /// NRMSE of the velocity, %.
    pub fn velocity_percent(&self) -> f64 {
        100.0 * self.velocity.nrmse
    }

    /// NRMSE of the quadrature current, %.
    pub fn current_percent(&self) -> f64 {
        100.0 * self.current.nrmse
    }

    /// How much lower the model's current in motion is, % of the log's.
    pub fn shortfall_percent(&self) -> f64 {
        100.0 * self.current_shortfall
    }
}

/// Runs the model over a log.
///
/// It passes one period of the command before the first row, with the friction of the log's first
/// period.
///
/// # Errors
/// Parameters that the core does not take.
pub fn simulate<E: Electrics>(
    parameters: &Parameters,
    given: &Reconstruction,
    sample_rate: f64,
) -> Result<Simulated, Failure> {
    let refused = |error: &dyn std::fmt::Display| Failure::other(error.to_string());
    let parameters = Parameters {
        encoder: encoder::Parameters {
            backlash: (2.0 * given.backlash) as f32,
            ..parameters.encoder
        },
        ..*parameters
    };
    let mut bench = Bench::<E>::build(&parameters).map_err(|error| refused(&error))?;
    let period = f64::from(parameters.control.period);
    let divider = (1.0 / (sample_rate * period)).round() as usize;
    let warming = (sample_rate / given.command.frequency).round() as usize;
    let rows = given.friction.len();
    let mut simulated = Simulated::default();
    for row in 0..warming + rows {
        let logged = row.checked_sub(warming);
        bench.set_brake(given.friction[logged.unwrap_or(row % rows)] as f32);
        for part in 0..divider {
            let tick = (row * divider + part) as f64 - (warming * divider) as f64;
            let sample = bench
                .step(given.command.at(tick * period) as f32)
                .map_err(|error| refused(&error))?;
            if logged.is_some() && part == 0 {
                simulated.position.push(sample.position.into());
                simulated.velocity.push(sample.velocity.into());
                simulated.current.push(sample.quadrature_current.into());
            }
        }
    }
    Ok(simulated)
}

/// Compares a model with a log.
///
/// # Errors
/// A log that the model cannot be run over.
pub fn compare<E: Electrics>(
    parameters: &Parameters,
    point: Point,
    log: Recording,
    sample_rate: f64,
) -> Result<Compared, Failure> {
    let given = Reconstruction::of(&log, sample_rate)?;
    compare_with::<E>(parameters, point, log, given, sample_rate)
}

/// Compares a model with a log from which something else was made of backlash or friction.
///
/// # Errors
/// As [`compare`].
pub fn compare_with<E: Electrics>(
    parameters: &Parameters,
    point: Point,
    log: Recording,
    given: Reconstruction,
    sample_rate: f64,
) -> Result<Compared, Failure> {
    let model = simulate::<E>(parameters, &given, sample_rate)?;
    let [measured, simulated] = [&log.current_q, &model.current].map(|current| {
        let pairs = log.motor_velocity.iter().zip(current);
        let moving = pairs.filter(|(velocity, _)| velocity.abs() > MOVING);
        moving
            .map(|(velocity, i)| i * velocity.signum())
            .sum::<f64>()
    });
    let span = (0.5 * sample_rate / given.command.frequency).round() as usize;
    Ok(Compared {
        point,
        position: errors(&model.position, &log.encoder_position),
        velocity: errors(&model.velocity, &log.motor_velocity),
        current: errors(&model.current, &log.current_q),
        current_shortfall: 1.0 - simulated / measured,
        lateness: lateness(&model.position, &log.encoder_position, span) / sample_rate,
        given,
        log,
        model,
    })
}

/// Rows by which one position leaves its ends of travel later than another, in the mean over the
/// ends, of which there is one in every `span` rows.
fn lateness(position: &[f64], other: &[f64], span: usize) -> f64 {
    let departures = |signal: &[f64]| -> Vec<f64> {
        let mut departures = Vec::new();
        let mut start = 0;
        // From the middle of one stroke to the middle of the next.
        while start + 2 * span <= signal.len() {
            let stroke = &signal[start..start + span];
            let end = farthest(stroke);
            let rest = &signal[start + end..start + 2 * span];
            let moved = rest.iter().position(|x| (x - rest[0]).abs() > DEPARTURE);
            departures.push((start + end + moved.unwrap_or(rest.len())) as f64);
            start += span;
        }
        departures
    };
    let (ours, theirs) = (departures(position), departures(other));
    let pairs = ours.iter().zip(&theirs);
    pairs.map(|(a, b)| a - b).sum::<f64>() / ours.len().max(1) as f64
}

/// The row at which a stroke is farthest from its start.
fn farthest(stroke: &[f64]) -> usize {
    let from = stroke.first().copied().unwrap_or(0.0);
    let far = |row: &usize| (stroke[*row] - from).abs();
    let rows = 0..stroke.len();
    rows.max_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(0)
}

/// The paper's model at the fifteen points, on a bench with this loss.
///
/// # Errors
/// As [`compare`].
pub fn run(loss: Loss, program: &Program) -> Result<Vec<Compared>, Failure> {
    run_with(&Parameters::AVERAGED, loss, program)
}

/// A model with these parameters at the fifteen points.
///
/// # Errors
/// As [`compare`].
pub fn run_with(
    parameters: &Parameters,
    loss: Loss,
    program: &Program,
) -> Result<Vec<Compared>, Failure> {
    let points: Vec<(Point, u64)> = Point::ALL.into_iter().zip(program.seed..).collect();
    points
        .into_par_iter()
        .map(|(point, seed)| {
            let log = point.bench(loss).run(&program.clone().seeded(seed));
            compare::<Averaged>(parameters, point, log, program.sample_rate)
        })
        .collect()
}
