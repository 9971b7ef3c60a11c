//! Errors of a model on a log: windowed replay, free run, torque balance.

use super::outcome::ErrorSet;
use super::zero_phase::{BUTTERWORTH, DECIMATION, filter};
use model_core::effect::Middle;
use model_core::effect::hysteresis::deflected;
use model_core::gap::lateness::Lateness;
use model_core::gap::log::{Channel, Log};
use model_core::gap::model::Model;
use model_core::gap::replay::{self, Data, MARGIN, Row, Runner, Schedule};
use model_core::gap::simulator::Simulator;
use model_core::plant::actuator::External;
use model_core::plant::parameters::{Drive, ParameterError, Winding};

use crate::quantity::decimal;

/// Samples at the start of a free run that are not counted.
const FREE_RUN_START: usize = 20;

/// Decimation of the torque balance.
const DECIMATE: usize = 10;

/// Decimated samples left out at either end of the torque balance, where the filters settle.
const EDGE: usize = 5;

/// The same before the decimation.
pub const SETTLING: usize = EDGE * DECIMATE;

/// Entries of the torque balance of a log with so many samples.
pub fn balance_entries(samples: usize) -> usize {
    samples.div_ceil(DECIMATE).saturating_sub(2 * EDGE)
}

/// Fewest entries of the torque balance: two autocorrelations for the whiteness test.
pub const LEAST_ENTRIES: usize = 8;

/// Fewest samples of a log whose torque balance says something.
pub fn least_balanced_samples() -> usize {
    (LEAST_ENTRIES + 2 * EDGE - 1) * DECIMATE + 1
}

/// The torque residual of one log, decimated.
#[derive(Debug, Clone, Default)]
pub struct TorqueBalance {
    /// Sample of the log of each entry.
    pub sample: Vec<usize>,
    /// Motor torque or force less what the model needs for the measured motion.
    pub residual: Vec<f64>,
    /// Motor torque or force.
    pub torque: Vec<f64>,
    /// Measured velocity, filtered.
    pub velocity: Vec<f64>,
    /// Measured position, filtered.
    pub position: Vec<f64>,
    /// Deflection of a learned hysteresis behind it; 0 without one.
    pub deflection: Vec<f64>,
}

/// Central differences of two samples or more, one-sided at the ends.
pub(super) fn differentiate(series: &[f64], period: f64) -> Vec<f64> {
    let last = series.len() - 1;
    (0..=last)
        .map(|index| {
            let (before, after) = (index.saturating_sub(1), (index + 1).min(last));
            (series[after] - series[before]) / ((after - before) as f64 * period)
        })
        .collect()
}

/// Speed below which a sensor of this resolution does not tell motion from rest, rad/s or m/s.
pub fn standstill(log: &Log, resolution: f64) -> f64 {
    resolution / (2.0 * DECIMATE as f64 * f64::from(log.period))
}

/// The torque balance of a model on filtered, decimated data with the held input aligned.
///
/// The position is filtered (Butterworth, 4th order, a tenth of the sampling rate, forward and
/// backward) and differentiated centrally. The input acts from its row to the next, so that the
/// torque *at* a sample is the mean of the two inputs held around it; comparing with the input of
/// the row alone would find a delay of half a sample that is not there.
///
/// # Errors
/// A parameter of the model outside its range.
pub fn torque_balance(
    log: &Log,
    model: &Model,
    resolution: f64,
) -> Result<TorqueBalance, ParameterError> {
    let simulator = model.build(log.period)?;
    let period = f64::from(log.period);
    let samples = log.samples();
    let plant = model.bound_plant();
    let actual = |reported: f32| f64::from(simulator.position_behind(reported));
    let measured: Vec<f64> = log.position.iter().take(samples).map(actual).collect();
    let position = filter(&BUTTERWORTH, &measured);
    let velocity = differentiate(&position, period);
    let acceleration = differentiate(&velocity, period);
    let back = |series: Channel, index: usize, late: Lateness| {
        let at = |index: usize| f64::from(late.read(series, index));
        let (now, before) = (at(index), at(index.saturating_sub(1)));
        now + f64::from(late.share) * (before - now)
    };
    let held = |index: usize| {
        let late = simulator.input_lateness();
        let now = back(log.input, index, late);
        0.5 * (now + back(log.input, index.saturating_sub(1), late))
    };
    // Share of the time around a sample in which the drive has the motor.
    let driven = |index: usize| {
        let has = |index: usize| f64::from(u8::from(!log.is_released(index)));
        0.5 * (has(index) + has(index.saturating_sub(1)))
    };
    let Winding {
        resistance,
        torque_constant,
    } = plant.drive.winding();
    let mut warmth = vec![0.0; samples];
    if let Some(heating) = simulator.heating() {
        for index in 1..samples {
            let current = match log.current {
                Some(current) => simulator.current_sensor().current(current.at(index - 1)),
                None => {
                    let steady =
                        simulator.steady_current(velocity[index] as f32, held(index) as f32);
                    driven(index) as f32 * steady
                }
            };
            warmth[index] = heating.after(warmth[index - 1], current, log.period);
        }
    }
    let mut deflection = vec![0.0; samples];
    if let Some(reach) = simulator.reach() {
        for index in 1..samples {
            let displacement = (position[index] - position[index - 1]) as f32;
            let before = deflection[index - 1] as f32;
            deflection[index] = f64::from(deflected(before, displacement, reach));
        }
    }
    let middle = |motor_torque: f32, index: usize| Middle {
        motor_torque,
        torque_constant,
        resistance,
        warmth: warmth[index],
        voltage: plant.gain * held(index) as f32,
        // Of a winding at its steady current.
        excess: if torque_constant > 0.0 {
            resistance * motor_torque / torque_constant
        } else {
            0.0
        },
        velocity: velocity[index] as f32,
        position: position[index] as f32,
        deflection: deflection[index] as f32,
        time: index as f32 * log.period,
        step: log.period,
    };
    let motor: Vec<f64> = (0..samples)
        .map(|index| match (plant.drive, log.current) {
            (
                Drive::Voltage {
                    torque_constant, ..
                },
                Some(current),
            ) => {
                // The reading of a moment within the step that begins here, carried back to its beginning.
                let read = |index: usize| f64::from(simulator.read(current, index));
                let share = f64::from(simulator.current_lateness().share);
                let before = read(index.saturating_sub(1));
                let now = read(index) + share * (before - read(index));
                f64::from(torque_constant) * now
            }
            (
                Drive::Voltage {
                    resistance,
                    torque_constant,
                    ..
                },
                None,
            ) => {
                let constant = f64::from(torque_constant);
                let voltage = f64::from(plant.gain) * held(index) - constant * velocity[index];
                let torque = constant * voltage / f64::from(resistance);
                let added = simulator.voltage_at(&middle(torque as f32, index));
                driven(index) * (torque + constant * f64::from(added) / f64::from(resistance))
            }
            (Drive::Torque, _) => driven(index) * f64::from(plant.gain) * held(index),
        })
        .collect();
    let rest = standstill(log, resolution);
    let residual: Vec<f64> = (0..samples)
        .map(|index| {
            let per_current = plant.torque_per_current();
            let current = motor[index] as f32 / per_current;
            let external = External {
                brake: log.brake.map_or(0.0, |brake| brake.at(index)),
                load: log.load.map_or(0.0, |load| load.at(index)),
                released: log.is_released(index),
            };
            let load = simulator.load_at(&middle(per_current * current, index), external);
            let deflection = f64::from(position[index] as f32) - f64::from(plant.spring_rest);
            let drive = motor[index] + f64::from(load.torque)
                - f64::from(plant.spring) * deflection
                - f64::from(plant.spring_preload).copysign(deflection)
                - f64::from(plant.inertia) * acceleration[index];
            let speed = velocity[index];
            if speed.abs() < rest {
                // At rest friction takes what it must, up to the breakaway level.
                let (lowest, highest) = (load.breakaway.backward, load.breakaway.forward);
                // Not `clamp`, which panics where an overflow has left no number.
                drive - drive.max(-f64::from(lowest)).min(f64::from(highest))
            } else if speed > 0.0 {
                drive - f64::from(load.coulomb.forward) - f64::from(plant.viscous.forward) * speed
            } else {
                drive + f64::from(load.coulomb.backward) - f64::from(plant.viscous.backward) * speed
            }
        })
        .collect();
    let residual = filter(&DECIMATION, &residual);
    let torque = filter(&DECIMATION, &motor);
    let kept: Vec<usize> = (0..samples)
        .step_by(DECIMATE)
        .skip(EDGE)
        .take(balance_entries(samples))
        .collect();
    let pick = |series: &[f64]| kept.iter().map(|&index| series[index]).collect();
    Ok(TorqueBalance {
        residual: pick(&residual),
        torque: pick(&torque),
        velocity: pick(&velocity),
        position: pick(&position),
        deflection: pick(&deflection),
        sample: kept,
    })
}

/// Position errors of one replay of the whole log without restarts, of the samples that count. It starts from the first
/// sample with a smoothed state.
fn free_run<'a>(
    data: &'a Data,
    log: &'a Log,
    simulator: &'a Simulator,
) -> impl Iterator<Item = f64> + use<'a> {
    let start = MARGIN;
    let mut runner = Runner::new(simulator, log, start, &data.settings);
    let errors = (start..log.samples() - 1).map(move |index| {
        let (position, _) = runner.advance(&Row::new(log, index));
        f64::from(position)
    });
    errors.skip((FREE_RUN_START - 1).saturating_sub(start))
}

/// How far the free runs of two models are apart, rms, rad or m.
///
/// # Errors
/// A parameter of a model outside its range.
pub fn free_runs_apart(data: &Data, models: [&Model; 2]) -> Result<f64, ParameterError> {
    let period = data.logs[0].period;
    let [one, other] = [models[0].build(period)?, models[1].build(period)?];
    let (mut square, mut samples) = (0.0, 0usize);
    for log in data.logs {
        for (one, other) in free_run(data, log, &one).zip(free_run(data, log, &other)) {
            square += (one - other) * (one - other);
            samples += 1;
        }
    }
    Ok((square / samples as f64).sqrt())
}

/// All errors of one model on a set of logs.
///
/// # Errors
/// A parameter of the model outside its range.
pub fn errors(
    data: &Data,
    schedule: &impl Schedule,
    model: &Model,
) -> Result<ErrorSet, ParameterError> {
    let period = data.logs[0].period;
    let simulator = model.build(period)?;
    let total = replay::total_error(data, schedule, &simulator);
    let position_rms = total.position_rms();

    let resolution = f64::from(data.settings.resolution);
    let (mut residual, mut torque) = (0.0, 0.0);
    let (mut free, mut counted) = (0.0, 0usize);
    let (mut mean, mut square, mut samples) = (0.0, 0.0, 0usize);
    for log in data.logs {
        let balance = torque_balance(log, model, resolution)?;
        residual += balance.residual.iter().map(|r| r * r).sum::<f64>();
        torque += balance.torque.iter().map(|t| t * t).sum::<f64>();
        for error in free_run(data, log, &simulator) {
            free += error * error;
            counted += 1;
        }
        for p in log.position.iter().take(log.samples()) {
            mean += f64::from(p);
            square += f64::from(p) * f64::from(p);
        }
        samples += log.samples();
    }
    mean /= samples as f64;
    let deviation = (square / samples as f64 - mean * mean).max(0.0).sqrt();
    Ok(ErrorSet {
        window_s: data.settings.window as f64 * decimal(period),
        position_rms,
        position_max: decimal(total.largest),
        position_nrmse: position_rms / deviation,
        current_rms: data
            .logs
            .iter()
            .all(|log| log.current.is_some())
            .then(|| total.current_rms()),
        torque_rel: (residual / torque).sqrt(),
        free_run_rms: (free / counted as f64).sqrt(),
    })
}
