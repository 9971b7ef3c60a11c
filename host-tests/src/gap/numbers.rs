//! The numbers of `[fit]` on one log, before any effect is looked for: what a tracing calls `before`.

use model_core::gap::log::Log as CoreLog;
use model_core::gap::replay::Data;
use model_core::gap::select::{LEAST_WINDOWS, fit_base};
use model_core::gap::verdict::Residual;

use super::answer::fitted;
use super::declared::{model, resolution};
use super::disagreement::{self, Disagreement};
use super::engine::{check_logs, with_workbench};
use super::outcome::FittedParameter;
use super::series::Series;
use super::spread::{Known, Spread};
use crate::error::InputError;
use crate::failure::Failure;
use crate::log::Log;
use crate::machine::Machine;

/// What a log says of them.
#[derive(Debug, Clone)]
pub enum Numbers {
    /// Their values, each with its standard deviation, and what the model leaves.
    Fitted {
        /// In the order of the catalogue of parameters.
        fit: Vec<FittedParameter>,
        /// The windowed position error, and how little of it is possible.
        residual: Residual,
    },
    /// Nothing: log and machine file do not belong together.
    Disagree(Vec<Disagreement>),
}

impl Numbers {
    /// Of one log.
    ///
    /// # Errors
    /// A log too short, at rest or without force; a machine that cannot be simulated.
    pub fn of(machine: &Machine, log: &Log) -> Result<Self, Failure> {
        let logs = std::slice::from_ref(log);
        let disagreement = disagreement::look(machine, logs);
        if !disagreement.is_empty() {
            return Ok(Self::Disagree(disagreement));
        }
        let declared = model(machine)?;
        declared
            .build(log.period_s as f32)
            .map_err(|error| InputError::new(&machine.path, None, error.to_string()))?;
        let series = Series::of(logs, machine);
        let cores: Vec<CoreLog> = series.iter().map(Series::log).collect();
        let data = Data::new(&cores, resolution(machine, logs))
            .ok_or_else(|| Failure::other("no log to fit to"))?;
        check_logs(&log.path, &data, &declared, LEAST_WINDOWS)?;
        with_workbench(machine, logs, |bench| {
            let fit = fit_base(bench)?;
            let (fit, _) = bench.within_limits(fit)?;
            let model = &fit.model;
            let residual = Residual {
                position_rms: bench.position_rms(model)?,
                floor: bench.least_error(model)?,
            };
            let (declared, options) = (bench.declared, bench.options);
            let known = Known::of(machine, options);
            let spread = Spread::of(model, (&bench.base, &[]), &bench.data, declared, &known)?;
            let fit = fitted((model, &bench.base), &spread, declared, options, machine);
            Some(Self::Fitted { fit, residual })
        })
    }
}
