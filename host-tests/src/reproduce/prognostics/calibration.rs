//! The model's nominal calibration: the paper's Figs. 9 and 10.
//!
//! The declared machine is given inertia, damping and friction that are wrong, as data sheets are, and
//! all of them are fitted at once to healthy logs by least squares (Levenberg–Marquardt on the
//! replay), the breakaway level after them by golden section. Annealing does not scale to four
//! parameters. The winding and the torque constant are the data sheet's, and the bench's: what becomes of
//! the estimates where they are not is in [`super::presumptions`].

use std::path::Path;

use model_core::identify::golden_section;
use model_core::identify::position_error::Levels;
use model_core::numeric::invalid_parameter::InvalidParameter;
use model_core::plant::Directional;
use model_core::plant::parameters::Parameters;

use super::estimate::{self, MOST_BREAKAWAY, Options};
use super::stand::{Friction, Input, LEVELS, Recorded, Stand};
use crate::failure::Failure;
use crate::gap::{declared, engine};
use crate::machine::Machine;
use crate::workspace;

/// The machine file.
const MACHINE: &str = "host-tests/machines/ema-24v.toml";

/// How far off the start is, as factors of inertia, damping, friction.
const START_OFF: [f64; 3] = [1.6, 2.0, 0.6];

/// Windows of the fit, s: the first brings the second near.
const WINDOWS_S: [f64; 2] = [0.2, 1.0];

/// The model before and after, and the log that shows it.
#[derive(Debug, Clone)]
pub struct Calibration {
    /// As declared, with the wrong numbers.
    pub before: Parameters,
    /// Calibrated.
    pub after: Parameters,
    /// A healthy sweep that it was fitted to.
    pub log: Recorded,
    /// Its friction.
    pub friction: Friction,
}

/// The breakaway level by golden section, as a ratio to the Coulomb level, at least 1. A step by least
/// squares loses it: it shows in few samples, and not at all once it is below the Coulomb level.
fn breakaway_per_coulomb(
    model: &Parameters,
    logs: [&Recorded; 2],
) -> Result<f32, InvalidParameter> {
    let logs = logs.map(|log| log.log(false));
    let mut errors = Vec::new();
    for log in &logs {
        errors.push(estimate::error(model, log, &Options::default())?);
    }
    let mut search = golden_section::Parameters {
        lower: 1.0,
        upper: MOST_BREAKAWAY,
        tolerance: 1e-3,
        evaluations: 30,
    }
    .build()?;
    let coulomb = model.coulomb.forward;
    while let Some(ratio) = search.propose() {
        let levels = Levels {
            coulomb,
            breakaway: ratio * coulomb,
        };
        search.report(errors.iter_mut().map(|error| error.at(levels)).sum());
    }
    Ok(search.best().map_or(1.0, |(ratio, _)| ratio))
}

/// Calibrates the model on healthy logs of one bench.
///
/// # Errors
/// A machine file that cannot be read, logs from which no model follows.
pub fn calibrate(stand: &Stand, seed: u64) -> Result<Calibration, Failure> {
    let mut machine = Machine::read(&workspace::root().join(MACHINE))?;
    machine.mechanics.lower_stop = None;
    machine.mechanics.upper_stop = None;
    machine.mechanics.inertia *= START_OFF[0];
    machine.mechanics.viscous *= START_OFF[1];
    machine.friction.coulomb *= START_OFF[2];
    machine.friction.r#static *= START_OFF[2];
    let start = declared::model(&machine)?;
    let friction = Friction::drawn(LEVELS[0], seed);
    let record = |input, seed| {
        stand
            .record(input, friction, seed)
            .map_err(|error| Failure::other(error.to_string()))
    };
    let log = record(Input::Sweep, seed)?;
    let other = record(Input::Random, seed + 1)?;
    let train = [&log, &other].map(|log| log.file(Path::new("healthy.csv")));
    let calibrated = engine::refit(&machine, &train, &start, &WINDOWS_S)?.plant;
    let ratio = breakaway_per_coulomb(&calibrated, [&log, &other])
        .map_err(|error| Failure::other(error.to_string()))?;
    Ok(Calibration {
        before: start.plant,
        after: Parameters {
            breakaway: Directional::both(ratio * calibrated.coulomb.forward),
            ..calibrated
        },
        log,
        friction,
    })
}
