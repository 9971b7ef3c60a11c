//! What the error of the campaign presumes, each row with one presumption dropped.
//!
//! Found on sweeps of every level: a winding 10 % above the model's resistance, as after 25 K of
//! warming, takes the estimate up by as much, for what the voltage does not drive is taken for friction. A
//! measured current mends most of it, for then no winding is in the model: 0.3 % in the median, 7 % at
//! worst. A resistance fitted with the friction comes to 1 % in the median and is no cure at worst, 16 %. A
//! torque constant that is off has no cure here. On the logs of a slow drive a free run is better than
//! windows, and than six blocks in a loop of their own.

use model_core::gap::log::{Channel, Log};
use model_core::identify::position_error::PositionError;
use model_core::numeric::invalid_parameter::InvalidParameter;
use model_core::plant::parameters::{Drive, Parameters};
use rayon::prelude::*;

use super::campaign::Spread;
use super::estimate::{self, LOWER, Options, START, UPPER, in_ratio, window_for};
use super::methods::least_squares;
use super::servo::{self, SixBlocks};
use super::stand::{Friction, Input, LEVELS, Recorded, Stand};

/// Resistance of the bench's winding over the model's, where it is off: 25 K of copper.
pub const WARM: f32 = 1.1;

/// Torque constant of the bench over the model's, where it is off.
pub const WEAK: f32 = 0.97;

/// How a log is made and worked on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Condition {
    /// As in the campaign.
    Campaign,
    /// [`WARM`], and the model does not know.
    WarmWinding,
    /// The same, the model driven by the measured current.
    MeasuredCurrent,
    /// The same, the resistance fitted with the friction, without a measured current.
    FittedResistance,
    /// [`WEAK`], and the model does not know.
    WeakMagnets,
    /// The same, the model driven by the measured current.
    WeakMagnetsMeasuredCurrent,
    /// The six-block servo's logs, as [`window_for`] says.
    Servo,
    /// The same in windows all the same.
    ServoInWindows,
    /// The same, with six blocks in their own loop for a model, as in the paper.
    SixBlocks,
}

impl Condition {
    /// All.
    pub const ALL: [Self; 9] = [
        Self::Campaign,
        Self::WarmWinding,
        Self::MeasuredCurrent,
        Self::FittedResistance,
        Self::WeakMagnets,
        Self::WeakMagnetsMeasuredCurrent,
        Self::Servo,
        Self::ServoInWindows,
        Self::SixBlocks,
    ];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Campaign => "as in the campaign",
            Self::WarmWinding => "winding 10 % above the model's",
            Self::MeasuredCurrent => "winding 10 % above, current measured",
            Self::FittedResistance => "winding 10 % above, resistance fitted too",
            Self::WeakMagnets => "torque constant 3 % below the model's",
            Self::WeakMagnetsMeasuredCurrent => "torque constant 3 % below, current measured",
            Self::Servo => "six-block servo, rows of 16 ms, free run",
            Self::ServoInWindows => "six-block servo, in windows all the same",
            Self::SixBlocks => "six-block servo, six blocks in their loop",
        }
    }
}

/// Relative errors of the Coulomb level under a condition.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Which.
    pub condition: Condition,
    /// Logs.
    pub logs: usize,
    /// With its sign, the median.
    pub bias: f64,
    /// Magnitudes.
    pub errors: Spread,
}

/// Estimates the friction of the same actuators under each condition.
///
/// # Errors
/// What the core refuses.
pub fn compare(
    stand: &Stand,
    model: &Parameters,
    seeds: impl Iterator<Item = u64> + Clone,
) -> Result<Vec<Row>, InvalidParameter> {
    let plan: Vec<(f64, u64)> = LEVELS
        .iter()
        .zip(0..)
        .flat_map(|(&level, number)| {
            let seeds = seeds.clone();
            seeds.map(move |seed| (level, seed * LEVELS.len() as u64 + number))
        })
        .collect();
    let logs: Vec<(Friction, Recorded, servo::Recorded, u64)> = plan
        .par_iter()
        .map(|&(level, seed)| {
            let truth = Friction::drawn(level, seed);
            let recorded = stand.record(Input::Sweep, truth, seed)?;
            Ok((truth, recorded, servo::record(truth)?, seed))
        })
        .collect::<Result<_, InvalidParameter>>()?;
    Condition::ALL
        .into_iter()
        .map(|condition| {
            let errors: Vec<f64> = logs
                .par_iter()
                .map(|(truth, recorded, servo, seed)| {
                    let found = find(condition, model, recorded, servo, *seed)?;
                    Ok(f64::from(found) / truth.coulomb - 1.0)
                })
                .collect::<Result<_, InvalidParameter>>()?;
            Ok(Row {
                condition,
                logs: errors.len(),
                bias: super::statistics::quantile(&errors, 0.5),
                errors: Spread::of(errors.into_iter()),
            })
        })
        .collect()
}

/// The Coulomb level, N·m.
fn find(
    condition: Condition,
    model: &Parameters,
    recorded: &Recorded,
    servo: &servo::Recorded,
    seed: u64,
) -> Result<f32, InvalidParameter> {
    let by_voltage = |model: &Parameters| {
        let log = recorded.log(false);
        estimate::one(model, &log, &Options::default(), seed)
    };
    // It is the model that is wrong: the bench has the winding of the data sheet.
    let cold = scaled(model, 1.0 / WARM, 1.0);
    let strong = scaled(model, 1.0, 1.0 / WEAK);
    let slow = Options {
        window: window_for(servo.log().period),
        resolution: servo::RESOLUTION,
        ..Options::default()
    };
    let found = match condition {
        Condition::Campaign => by_voltage(model)?,
        Condition::WarmWinding => by_voltage(&cold)?,
        Condition::MeasuredCurrent => by_current(&cold, recorded, seed)?,
        Condition::FittedResistance => return with_resistance(&cold, &recorded.log(false)),
        Condition::WeakMagnets => by_voltage(&strong)?,
        Condition::WeakMagnetsMeasuredCurrent => by_current(&strong, recorded, seed)?,
        Condition::Servo => estimate::one(model, &servo.log(), &slow, seed)?,
        Condition::ServoInWindows => {
            let windows = Options {
                window: Options::default().window,
                ..slow
            };
            estimate::one(model, &servo.log(), &windows, seed)?
        }
        Condition::SixBlocks => {
            let mut blocks = SixBlocks::new(model, servo).map_err(|_| InvalidParameter {
                name: "servo",
                requirement: "must be one that can be built",
            })?;
            estimate::one_of(&mut blocks, &slow, seed)?
        }
    };
    Ok(found.levels.coulomb)
}

/// The model with another resistance and torque constant, as factors.
fn scaled(model: &Parameters, by_resistance: f32, by_torque_constant: f32) -> Parameters {
    let drive = match model.drive {
        Drive::Voltage {
            resistance,
            inductance,
            torque_constant,
        } => Drive::Voltage {
            resistance: resistance * by_resistance,
            inductance,
            torque_constant: torque_constant * by_torque_constant,
        },
        Drive::Torque => Drive::Torque,
    };
    Parameters { drive, ..*model }
}

/// The model driven by the measured current: neither winding nor back-EMF are in it.
fn by_current(
    model: &Parameters,
    recorded: &Recorded,
    seed: u64,
) -> Result<estimate::Estimate, InvalidParameter> {
    let torque = Parameters {
        drive: Drive::Torque,
        gain: model.torque_per_current(),
        ..*model
    };
    // A row holds until the next one; the current flows from the one reading to the other.
    let mut current: Vec<f32> = recorded
        .current
        .windows(2)
        .map(|pair| 0.5 * (pair[0] + pair[1]))
        .collect();
    current.extend(recorded.current.last());
    let log = Log {
        input: Channel::Values(&current),
        ..recorded.log(false)
    };
    estimate::one(&torque, &log, &Options::default(), seed)
}

/// Coulomb level and resistance together, by least squares on the replay.
fn with_resistance(model: &Parameters, log: &Log) -> Result<f32, InvalidParameter> {
    let options = Options::default();
    // What the search may ask for, the model takes: the first model shows whether the log can be replayed.
    estimate::error(model, log, &options)?;
    let residuals = |[coulomb, resistance]: [f64; 2]| {
        let tried = scaled(model, resistance as f32, 1.0);
        let mut residuals = Vec::new();
        let error = estimate::error(&tried, log, &options);
        if let Ok(mut error) = error {
            PositionError::errors(&mut error, in_ratio(coulomb as f32), |error, weight| {
                residuals.push(f64::from(error) * f64::from(weight).sqrt());
            });
        }
        residuals
    };
    let start = [f64::from(START), 1.0];
    let (lower, upper) = ([f64::from(LOWER), 0.5], [f64::from(UPPER), 2.0]);
    let (at, _) = least_squares::minimise(start, lower, upper, residuals);
    Ok(at[0] as f32)
}
