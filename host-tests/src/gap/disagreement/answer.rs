//! The answer where logs and machine file disagree: no physics, and the errors of the declared model.

use std::time::Instant;

use model_core::gap::log::Log as CoreLog;
use model_core::gap::model::Model;
use model_core::gap::replay::Data;
use model_core::gap::verdict::Verdict;

use super::Disagreement;
use super::limits::LONGEST_PERIOD;
use crate::failure::Failure;
use crate::gap::declared::resolution;
use crate::gap::demand::Demand;
use crate::gap::engine::AllCores;
use crate::gap::metrics;
use crate::gap::outcome::{
    Correlations, Cost, ErrorSet, Errors, Outcome, Report, Stages, Whiteness,
};
use crate::gap::series::Series;
use crate::log::Log;
use crate::machine::Machine;

/// The answer where logs and machine file disagree in this.
pub(in crate::gap) fn report(
    machine: &Machine,
    declared: &Model,
    train: &[Log],
    disagreement: Vec<Disagreement>,
    started: Instant,
) -> Report {
    let errors = declared_errors(machine, declared, train);
    let stages = Stages {
        declared: errors.clone(),
        before: errors.clone(),
        after: errors,
    };
    let nothing = f64::NAN;
    let outcome = Outcome {
        machine: machine.name.clone(),
        verdict: Verdict::LogAndMachineDisagree,
        disagreement,
        residual: None,
        resampled: Vec::new(),
        effects: Vec::new(),
        unknown: None,
        fit: Vec::new(),
        current_sensor: Vec::new(),
        input_lead: None,
        errors: Errors {
            train: stages,
            validate: None,
        },
        candidates: Vec::new(),
        between_logs: Vec::new(),
        free_run_costs: Vec::new(),
        next_experiment: None,
        machine_out: None,
        whiteness: Whiteness {
            ljung_box: nothing,
            lags: 0,
            p_value: nothing,
            correlations: Correlations {
                input: nothing,
                velocity: nothing,
                direction: nothing,
                input_squared: nothing,
            },
        },
        cost: Cost {
            seconds: started.elapsed().as_secs_f64(),
            simulations: 0,
            samples: train.iter().map(Log::samples).sum(),
        },
    };
    Report {
        outcome,
        coordinate: machine.coordinate.unit().to_owned(),
        load_unit: machine.coordinate.load_unit().to_owned(),
        demand: Demand::default(),
        declared: machine.declared_effects.clone(),
        free_motor: None,
        has_return_spring: false,
        has_page: false,
        without_inductance: None,
        held_within: Vec::new(),
        train: Vec::new(),
        validate: Vec::new(),
    }
}

/// What those say who can do nothing with such files.
pub(in crate::gap) fn failure(report: &Report) -> Failure {
    Failure::other(format!(
        "the log and the machine file do not belong together: {}",
        report.outcome.disagreements().join("; ")
    ))
}

/// Errors of the machine file as it stands; no numbers where it cannot be replayed.
fn declared_errors(machine: &Machine, declared: &Model, train: &[Log]) -> ErrorSet {
    let series = Series::of(train, machine);
    let logs: Vec<CoreLog> = series.iter().map(Series::log).collect();
    let period = train[0].period_s;
    let resolution = resolution(machine, train);
    let data = Data::new(&logs, resolution);
    let data = data.filter(|data| period <= LONGEST_PERIOD && data.windows() > 0);
    let replayed = data.and_then(|data| metrics::errors(&data, &AllCores, declared).ok());
    replayed.unwrap_or(ErrorSet {
        window_s: f64::NAN,
        position_rms: f64::NAN,
        position_max: f64::NAN,
        position_nrmse: f64::NAN,
        current_rms: None,
        torque_rel: f64::NAN,
        free_run_rms: f64::NAN,
    })
}
