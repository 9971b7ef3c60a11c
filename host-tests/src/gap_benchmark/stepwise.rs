//! Stepwise regression on accelerations, as SINDy and FROLS do it, for comparison.
//!
//! The position is filtered without phase and differentiated twice; the motor's load is regressed on
//! inertia, viscous and Coulomb friction (and spring and gravity where they are declared), then on that
//! term of a library which lowers the held-out error most, and so on. It may use what the tracing uses:
//! the same library of effects, the same half-second blocks held out, the same demand of a tenth less
//! error. (S. L. Brunton, J. L. Proctor, J. N. Kutz, *Discovering governing equations from data by sparse
//! identification of nonlinear dynamical systems*, PNAS 113, 2016; S. Chen, S. A. Billings, W. Luo,
//! *Orthogonal least squares methods and their application to non-linear system identification*,
//! Int. J. Control 50, 1989.)

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use super::judgement::Answer;
use crate::gap::zero_phase::{BUTTERWORTH, filter};
use crate::log::Log;
use crate::machine::{Coordinate, Machine};

/// Every so many samples are regressed on: the filter leaves no more independent ones.
const DECIMATE: usize = 5;

/// Samples left out at either end, where filter and differences settle.
const EDGE: usize = 40;

/// Length of a held-out block, s.
const BLOCK: f64 = 0.5;

/// Most terms that are added.
const MOST_TERMS: usize = 4;

/// Held-out error of a step over that before, from which on it is not taken.
const LEAST_GAIN: f64 = 0.9;

/// Ratio of held-out errors up to which terms are equally good.
const EQUALLY_GOOD: f64 = 1.1;

/// Share of the top speed below which the filter smears the step of friction.
const STANDSTILL: f64 = 0.05;

/// The log at the samples that are regressed on.
struct Signals {
    position: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
    load: Vec<f64>,
    load_rate: Vec<f64>,
    block: Vec<usize>,
    top_speed: f64,
    stroke: f64,
}

/// A candidate: the effects that would show as this term, and its columns.
struct Term {
    ids: &'static [&'static str],
    columns: Vec<Vec<f64>>,
}

/// What the regression says of a log.
pub fn answer(machine: &Machine, log: &Log) -> Answer {
    let signals = Signals::of(machine, log);
    let mut columns = base(machine, &signals);
    // A term of the measured load itself would share its noise: the load as the base explains it.
    let explained = signals.explained(&columns);
    let terms = library(machine, &signals, &explained);
    let mut named: Vec<Vec<String>> = Vec::new();
    let mut error = signals.held_out(&columns);
    while named.len() < MOST_TERMS {
        let tried: Vec<(f64, &Term)> = terms
            .iter()
            .filter(|term| !named.iter().any(|class| class[0] == term.ids[0]))
            .map(|term| {
                let with: Vec<&Vec<f64>> = columns.iter().chain(&term.columns).collect();
                (signals.held_out_of(&with), term)
            })
            .collect();
        let best = tried
            .iter()
            .map(|(held_out, _)| *held_out)
            .fold(error, f64::min);
        // Of those that are equally good the one with the fewest columns.
        let chosen = tried
            .into_iter()
            .filter(|(held_out, _)| {
                *held_out <= EQUALLY_GOOD * best && *held_out < LEAST_GAIN * error
            })
            .min_by(|a, b| {
                let columns = a.1.columns.len().cmp(&b.1.columns.len());
                columns.then(a.0.total_cmp(&b.0))
            });
        let Some((least, term)) = chosen else {
            break;
        };
        error = least;
        columns.extend(term.columns.iter().cloned());
        named.push(term.ids.iter().map(|id| (*id).to_owned()).collect());
    }
    Answer {
        named,
        freed: Vec::new(),
        unknown: None,
        proven: false,
        ..Answer::default()
    }
}

fn differentiated(series: &[f64], period: f64) -> Vec<f64> {
    let last = series.len() - 1;
    (0..=last)
        .map(|index| {
            let (before, after) = (index.saturating_sub(1), (index + 1).min(last));
            (series[after] - series[before]) / ((after - before) as f64 * period)
        })
        .collect()
}

impl Signals {
    fn of(machine: &Machine, log: &Log) -> Self {
        let period = log.period_s;
        let position = filter(&BUTTERWORTH, &log.position);
        let velocity = differentiated(&position, period);
        let acceleration = differentiated(&velocity, period);
        // The input is held from its row to the next: at a row, the mean of the two around it.
        let held: Vec<f64> = (0..log.samples())
            .map(|row| 0.5 * (log.input[row] + log.input[row.saturating_sub(1)]) * machine.gain)
            .collect();
        let load: Vec<f64> = match (&machine.motor, &log.current) {
            (Some(motor), Some(current)) => current
                .iter()
                .map(|current| motor.torque_constant * current)
                .collect(),
            (Some(motor), None) => held
                .iter()
                .zip(&velocity)
                .map(|(volt, velocity)| {
                    motor.torque_constant * (volt - motor.torque_constant * velocity)
                        / motor.resistance
                })
                .collect(),
            (None, _) => held,
        };
        let load = filter(&BUTTERWORTH, &load);
        let load_rate = differentiated(&load, period);
        let top_speed = velocity.iter().fold(0.0_f64, |top, v| top.max(v.abs()));
        let (low, high) = position
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| {
                (low.min(x), high.max(x))
            });
        // At rest friction is no function of speed.
        let rows: Vec<usize> = (EDGE..log.samples().saturating_sub(EDGE))
            .step_by(DECIMATE)
            .filter(|&row| velocity[row].abs() > STANDSTILL * top_speed)
            .collect();
        let per_block = (BLOCK / period) as usize;
        let pick = |series: &[f64]| rows.iter().map(|&row| series[row]).collect();
        Self {
            position: pick(&position),
            velocity: pick(&velocity),
            acceleration: pick(&acceleration),
            load: pick(&load),
            load_rate: pick(&load_rate),
            block: rows.iter().map(|row| row / per_block).collect(),
            top_speed,
            stroke: high - low,
        }
    }

    fn column(&self, of: impl Fn(usize) -> f64) -> Vec<f64> {
        (0..self.load.len()).map(of).collect()
    }

    fn held_out(&self, columns: &[Vec<f64>]) -> f64 {
        self.held_out_of(&columns.iter().collect::<Vec<_>>())
    }

    /// The load that the columns explain.
    fn explained(&self, columns: &[Vec<f64>]) -> Vec<f64> {
        let matrix = DMatrix::from_fn(self.load.len(), columns.len(), |row, column| {
            columns[column][row]
        });
        let load = DVector::from_column_slice(&self.load);
        let coefficients = matrix.clone().svd(true, true).solve(&load, 1e-12);
        coefficients.map_or_else(
            |_| self.load.clone(),
            |coefficients| (matrix * coefficients).as_slice().to_vec(),
        )
    }

    /// Mean squared error on the blocks between those that were fitted, both ways.
    fn held_out_of(&self, columns: &[&Vec<f64>]) -> f64 {
        let mut sum = 0.0;
        for odd in [0, 1] {
            let (fitted, held): (Vec<usize>, Vec<usize>) =
                (0..self.load.len()).partition(|&row| self.block[row] % 2 == odd);
            let matrix = |rows: &[usize]| {
                DMatrix::from_fn(rows.len(), columns.len(), |row, column| {
                    columns[column][rows[row]]
                })
            };
            let load = |rows: &[usize]| DVector::from_fn(rows.len(), |row, _| self.load[rows[row]]);
            let Ok(coefficients) = matrix(&fitted).svd(true, true).solve(&load(&fitted), 1e-12)
            else {
                return f64::INFINITY;
            };
            sum += (load(&held) - matrix(&held) * coefficients).norm_squared();
        }
        sum / self.load.len() as f64
    }
}

/// What the declared machine has.
fn base(machine: &Machine, signals: &Signals) -> Vec<Vec<f64>> {
    let mut columns = vec![
        signals.acceleration.clone(),
        signals.velocity.clone(),
        signals.column(|row| signals.velocity[row].signum()),
    ];
    let mechanics = &machine.mechanics;
    if mechanics.spring != 0.0 || mechanics.spring_preload != 0.0 {
        let rest = mechanics.spring_rest;
        columns.push(signals.column(|row| signals.position[row] - rest));
        columns.push(signals.column(|row| (signals.position[row] - rest).signum()));
    }
    columns
}

/// Every effect of the catalogue that is a function of load, position and speed at one instant, or of
/// the load's rate.
fn library(machine: &Machine, signals: &Signals, explained: &[f64]) -> Vec<Term> {
    let (x, v) = (&signals.position, &signals.velocity);
    let one = |ids, column| Term {
        ids,
        columns: vec![column],
    };
    let mut terms = vec![
        one(
            &["offset_torque", "asymmetric_coulomb"],
            signals.column(|_| 1.0),
        ),
        one(&["asymmetric_viscous"], signals.column(|row| v[row].abs())),
        one(
            &["quadratic_drag"],
            signals.column(|row| v[row] * v[row].abs()),
        ),
        one(
            &["load_dependent_friction"],
            signals.column(|row| v[row].signum() * explained[row].abs()),
        ),
        // To first order a delay adds the rate of what is late.
        one(&["input_delay", "sensor_delay"], signals.load_rate.clone()),
    ];
    if machine.mechanics.spring == 0.0 {
        terms.push(Term {
            ids: &["spring"],
            columns: vec![x.clone(), signals.column(|_| 1.0)],
        });
    }
    if machine.coordinate == Coordinate::Radian {
        terms.push(Term {
            ids: &["gravity"],
            columns: vec![
                signals.column(|row| x[row].sin()),
                signals.column(|row| x[row].cos()),
            ],
        });
    }
    for share in [0.02, 0.05, 0.1, 0.2, 0.4] {
        let speed = share * signals.top_speed;
        terms.push(one(
            &["stribeck"],
            signals.column(|row| v[row].signum() * (-v[row].abs() / speed).exp()),
        ));
    }
    for index in 0..120 {
        // Periods from the stroke's fortieth up to the stroke.
        let period = signals.stroke / 40.0_f64.powf(f64::from(index) / 119.0);
        terms.push(Term {
            ids: &["cogging"],
            columns: vec![
                signals.column(|row| (TAU * x[row] / period).sin()),
                signals.column(|row| (TAU * x[row] / period).cos()),
            ],
        });
    }
    terms
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap_benchmark::cases::{Case, Group, Motion, machines};
    use rig::{Effect, EffectKind};

    /// A comparison that could not find anything would be none.
    #[test]
    fn what_is_plain_to_see_is_found() {
        let directory = tempfile::tempdir().unwrap();
        for (kind, id) in [
            (EffectKind::OffsetTorque, "offset_torque"),
            (EffectKind::AsymmetricCoulomb, "offset_torque"),
        ] {
            let rig = machines()[0].clone();
            let case = Case {
                group: Group::Named,
                declared: None,
                effects: vec![Effect::nominal(kind, &rig).scaled(4.0)],
                rig,
                strength: 4.0,
                motion: Motion::Sines,
                seed: 5,
            };
            let machine = case.machine_file(directory.path()).unwrap();
            let answer = answer(&machine, &case.log());
            assert_eq!(answer.named[0][0], id, "{answer:?}");
        }
    }
}
