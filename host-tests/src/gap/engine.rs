//! From files to the answer: the host's side of the tracing in `model_core::gap`.

use std::f64::consts::TAU;
use std::path::Path;
use std::time::Instant;

use model_core::effect::learned_map::{Kind, Ranges};
use model_core::effect::{Active, Id, MOST_PARAMETERS, Role, Scope};
use model_core::gap::fit::{Fit, Variables};
use model_core::gap::held_out::Refusal;
use model_core::gap::log::Log as CoreLog;
use model_core::gap::model::{Base, Model, Simulator};
use model_core::gap::replay::{Data, MARGIN, Runner, Schedule, Settings};
use model_core::gap::select::{self, Consideration, Decision, Subject, Trace};
use model_core::gap::workbench::Options;
use model_core::numeric::ljung_box::ljung_box;
use model_core::plant::Directional;
use model_core::plant::parameters::{Drive, Parameters};
use model_core::unit::Dimension;
use rayon::prelude::*;

use super::metrics::{
    self, TorqueBalance, balance_entries, balanced_samples, decimal, torque_balance,
};
use super::outcome::{
    Candidate, Correlations, Cost, Errors, Estimate, Evidence, FittedParameter, FoundEffect,
    Outcome, Report, Stages, Unknown, Verdict, Whiteness,
};
use super::table::quantity::probability;
use crate::error::InputError;
use crate::failure::Failure;
use crate::log::Log;
use crate::machine::{Coordinate, Machine};

/// Length of a replay window by which models are judged, s.
const WINDOW_S: f64 = 0.2;

/// Length of a replay window for screening, s.
const SCREEN_WINDOW_S: f64 = 0.04;

/// Fewest windows that a model can be chosen and fitted on, and judged on.
const LEAST_TRAIN_WINDOWS: usize = 4;
const LEAST_VALIDATE_WINDOWS: usize = 1;

/// Longest delay that may be declared, s. What is meant in milliseconds is beyond it.
const LONGEST_DELAY_S: f64 = 1.0;

/// Fewest entries of the torque balance: two autocorrelations for the whiteness test.
const LEAST_ENTRIES: usize = 8;

/// Length of a held-out block, s.
const BLOCK_S: f64 = 0.5;

/// Samples on either side of a restart that its state is smoothed over, until the tracing has
/// chosen.
const HALF_WIDTH: usize = 8;

/// Lags of the whiteness test.
const LAGS: usize = 20;

/// All cores; results are folded in the order of the windows, so that the sums have the same bits
/// as on one core.
#[derive(Debug, Clone, Copy, Default)]
pub struct AllCores;

impl Schedule for AllCores {
    fn run<R: Send>(
        &self,
        count: usize,
        work: impl Fn(usize) -> R + Send + Sync,
        mut fold: impl FnMut(usize, R),
    ) {
        let results: Vec<R> = (0..count).into_par_iter().map(work).collect();
        for (index, result) in results.into_iter().enumerate() {
            fold(index, result);
        }
    }
}

/// A log in the core's numbers.
struct Series {
    label: String,
    period: f32,
    input: Vec<f32>,
    position: Vec<f32>,
    current: Option<Vec<f32>>,
    velocity: Option<Vec<f32>>,
}

impl Series {
    /// With a torque input there is no motor in the model, and nothing to compare a current with.
    fn new(log: &Log, has_motor: bool) -> Self {
        let narrow = |series: &[f64]| series.iter().map(|&value| value as f32).collect();
        Self {
            label: log.path.display().to_string(),
            period: log.period_s as f32,
            input: narrow(&log.input),
            position: narrow(&log.position),
            current: log.current.as_deref().filter(|_| has_motor).map(narrow),
            velocity: log.velocity.as_deref().map(narrow),
        }
    }

    fn log(&self) -> CoreLog<'_> {
        CoreLog {
            period: self.period,
            input: &self.input,
            position: &self.position,
            current: self.current.as_deref(),
            velocity: self.velocity.as_deref(),
        }
    }
}

/// The core's model of a machine file.
///
/// # Errors
/// A number beyond what the plant takes. A declared effect that the catalogue does not have, that
/// is there twice or has no meaning along a stroke; a parameter that it does not have, lacks, or
/// may not have with that value.
pub fn model(machine: &Machine) -> Result<Model, InputError> {
    let mechanics = &machine.mechanics;
    let plant = Parameters {
        drive: match &machine.motor {
            Some(motor) => Drive::Voltage {
                resistance: motor.resistance as f32,
                inductance: motor.inductance as f32,
                torque_constant: motor.torque_constant as f32,
            },
            None => Drive::Torque,
        },
        gain: machine.gain as f32,
        inertia: mechanics.inertia as f32,
        viscous: Directional::both(mechanics.viscous as f32),
        coulomb: Directional::both(machine.friction.coulomb as f32),
        breakaway: Directional::both(machine.friction.r#static as f32),
        spring: mechanics.spring as f32,
        spring_rest: mechanics.spring_rest as f32,
        spring_preload: mechanics.spring_preload as f32,
        offset: 0.0,
        lower_stop: mechanics
            .lower_stop
            .map_or(f32::NEG_INFINITY, |stop| stop as f32),
        upper_stop: mechanics
            .upper_stop
            .map_or(f32::INFINITY, |stop| stop as f32),
    };
    plant
        .check()
        .map_err(|error| InputError::new(&machine.path, None, error.to_string()))?;
    let mut model = Model {
        plant,
        gravity_torque: mechanics.gravity_torque as f32,
        gravity_rest: mechanics.gravity_rest as f32,
        effects: Default::default(),
        map: None,
    };
    for declared in &machine.declared_effects {
        let known = || {
            let ids: Vec<&str> = Id::ALL.iter().map(|id| id.description().id).collect();
            ids.join(", ")
        };
        let id = Id::from_id(&declared.id).ok_or_else(|| {
            let message = format!(
                "unknown effect `{}`: expected one of {}",
                declared.id,
                known()
            );
            machine.error_at(declared.line, message)
        })?;
        if model.has(id) {
            let message = format!("effect `{}` is declared twice; remove one", declared.id);
            return Err(machine.error_at(declared.line, message));
        }
        if id.description().rotary_only && machine.coordinate == Coordinate::Metre {
            let message = format!(
                "effect `{}` is for rotary machines only; remove it, or set `coordinate = \"rad\"`",
                declared.id
            );
            return Err(machine.error_at(declared.line, message));
        }
        let parameters = id.description().parameters;
        let form: Vec<&str> = parameters.iter().map(|parameter| parameter.name).collect();
        let mut values = [0.0; MOST_PARAMETERS];
        for (name, value) in &declared.parameters {
            let Some(index) = form.iter().position(|known| known == name) else {
                let message = format!(
                    "effect `{}` has no parameter `{name}`: expected {}",
                    declared.id,
                    form.join(", ")
                );
                return Err(machine.error_at(declared.line, message));
            };
            let expected = match parameters[index].role {
                Role::Strength if *value < 0.0 => "0 or more",
                Role::Shape if *value <= 0.0 => "more than 0",
                _ if parameters[index].dimension == Dimension::Time && *value > LONGEST_DELAY_S => {
                    "1 s at most"
                }
                _ => {
                    values[index] = *value as f32;
                    continue;
                }
            };
            let message = format!(
                "`{name}` of effect `{}` is {value:?}, expected {expected}",
                declared.id
            );
            return Err(machine.error_at(declared.line, message));
        }
        if let Some(missing) = form
            .iter()
            .find(|name| !declared.parameters.contains_key(**name))
        {
            let message = format!(
                "effect `{}` lacks its parameter `{missing}`; expected {}",
                declared.id,
                form.join(", ")
            );
            return Err(machine.error_at(declared.line, message));
        }
        if model.effects.push(Active { id, values }).is_err() {
            let message = "too many declared effects: at most 8";
            return Err(machine.error_at(declared.line, message));
        }
        // What an effect adds to the plant must leave it one; the period does not matter here.
        model.build(1.0).map_err(|error| {
            let message = format!("with effect `{}`, {error}", declared.id);
            machine.error_at(declared.line, message)
        })?;
    }
    Ok(model)
}

/// The base parameters that a machine file lets be fitted; its reader has checked their names.
fn base_parameters(machine: &Machine) -> Vec<Base> {
    Base::ALL
        .into_iter()
        .filter(|base| machine.fit.iter().any(|name| name == base.name()))
        .collect()
}

/// Typical sizes and ranges, from the declared model and the training logs.
fn scope(model: &Model, simulator: &Simulator, logs: &[CoreLog], rotary: bool) -> (Scope, Ranges) {
    let mut all = TorqueBalance::default();
    let mut longest = 0;
    for log in logs {
        let balance = torque_balance(log, simulator, 0.0);
        all.torque.extend(balance.torque);
        all.velocity.extend(balance.velocity);
        all.position.extend(balance.position);
        longest = longest.max(log.samples());
    }
    let range = |series: &[f64]| {
        let lowest = series.iter().copied().fold(f64::MAX, f64::min);
        let highest = series.iter().copied().fold(f64::MIN, f64::max);
        (lowest as f32, highest as f32)
    };
    let rms = |series: &[f64]| {
        let squares: f64 = series.iter().map(|x| x * x).sum();
        (squares / series.len().max(1) as f64).sqrt().max(1e-9) as f32
    };
    let ranges = Ranges {
        position: range(&all.position),
        velocity: range(&all.velocity),
        motor_torque: range(&all.torque),
        time: (0.0, longest as f32 * logs[0].period),
    };
    let fastest = ranges.velocity.1.max(-ranges.velocity.0);
    // Rests say nothing about how fast the machine moves.
    let moving: Vec<f64> = all
        .velocity
        .into_iter()
        .filter(|velocity| velocity.abs() > 0.02 * f64::from(fastest))
        .collect();
    let torque = rms(&all.torque);
    let coulomb = model.plant.coulomb.forward;
    let scope = Scope {
        friction: if coulomb > 0.0 { coulomb } else { 0.1 * torque },
        torque,
        speed: rms(&moving),
        stroke: (ranges.position.1 - ranges.position.0).max(1e-9),
        period: logs[0].period,
        rotary,
    };
    (scope, ranges)
}

/// Traces the training logs, then opens the validation logs.
///
/// `validate` is called once, when nothing is left to be chosen or fitted.
///
/// # Errors
/// What [`model`] refuses; a machine whose replay diverges; logs too short, at rest or without force throughout, or of different
/// sampling periods; whatever `validate` returns.
pub fn run(
    machine: &Machine,
    train: &[Log],
    validate: impl FnOnce() -> Result<Vec<Log>, Failure>,
    mut progress: impl FnMut(&str),
) -> Result<Report, Failure> {
    let started = Instant::now();
    let declared = model(machine)?;
    let base = base_parameters(machine);
    let rotary = machine.coordinate == Coordinate::Radian;
    let series: Vec<Series> = train
        .iter()
        .map(|log| Series::new(log, machine.motor.is_some()))
        .collect();
    let logs: Vec<CoreLog> = series.iter().map(Series::log).collect();
    let period = same_period(train, None)?;
    let simulator = declared
        .build(period as f32)
        .map_err(|error| InputError::new(&machine.path, None, error.to_string()))?;
    let data = Data {
        logs: &logs,
        settings: settings(machine, period),
    };
    check_logs(&train[0].path, &data, &simulator, LEAST_TRAIN_WINDOWS)?;
    let (scope, ranges) = scope(&declared, &simulator, &logs, rotary);
    let options = Options {
        base: &base,
        scope,
        ranges,
        screen_window: samples(SCREEN_WINDOW_S, period, 4),
        block: samples(BLOCK_S, period, 1),
    };
    let schedule = AllCores;
    let mut candidates: Vec<Candidate> = Vec::new();
    let trace = select::trace(&data, &schedule, &declared, &options, |look| {
        let entry = candidate(look);
        // An effect that was taken in an earlier round and is not any more: that look gets the last
        // word on it.
        let taken = |known: &&mut Candidate| known.accepted && known.id == entry.id;
        if !entry.accepted
            && let Some(taken) = candidates.iter_mut().find(taken)
        {
            taken.accepted = false;
            taken.reason = entry.reason;
            return;
        }
        if entry.accepted {
            progress(&format!("round {}: {} accepted", entry.round, entry.id));
        }
        candidates.push(entry);
    })
    .ok_or_else(|| {
        Failure::other(
            "the fit left the range in which the machine can be simulated; \
             name fewer `parameters` in [fit], end stops last",
        )
    })?;
    let seconds = started.elapsed().as_secs_f64();

    let judged = Data {
        settings: trace.settings,
        ..data
    };
    let models = [&declared, &trace.before.model, &trace.after.model];
    let train_errors = stages(&judged, &schedule, models)?;
    if !train_errors.before.position_rms.is_finite() {
        let message = "the replay of the training data diverges with these numbers, fitted or not; \
                       expected a machine in SI units that can move as the logs do";
        return Err(InputError::new(&machine.path, None, message).into());
    }
    let train_evidence = evidence(&series, &judged, &trace)?;

    let held_back = validate()?;
    let (validate_errors, validate_evidence) = if held_back.is_empty() {
        (None, Vec::new())
    } else {
        same_period(&held_back, Some(period))?;
        let series: Vec<Series> = held_back
            .iter()
            .map(|log| Series::new(log, machine.motor.is_some()))
            .collect();
        let logs: Vec<CoreLog> = series.iter().map(Series::log).collect();
        let data = Data {
            logs: &logs,
            ..judged
        };
        check_logs(
            &held_back[0].path,
            &data,
            &simulator,
            LEAST_VALIDATE_WINDOWS,
        )?;
        (
            Some(stages(&data, &schedule, models)?),
            evidence(&series, &data, &trace)?,
        )
    };

    let outcome = Outcome {
        machine: machine.name.clone(),
        verdict: if !trace.accepted.is_empty() {
            Verdict::EffectsFound
        } else if trace.unknown.is_some() {
            Verdict::UnknownEffect
        } else {
            Verdict::NoMissingEffect
        },
        effects: found(&trace, &declared, rotary),
        unknown: trace.unknown.as_ref().map(|unknown| Unknown {
            depends_on: unknown.kind.variable().to_owned(),
            score: decimal(unknown.score),
        }),
        fit: fitted(&trace, &declared, &base, rotary),
        errors: Errors {
            train: train_errors,
            validate: validate_errors,
        },
        candidates,
        whiteness: whiteness(&judged, &trace.before.model)?,
        cost: Cost {
            seconds,
            simulations: trace.simulated / judged.windows() as u64,
            samples: logs.iter().map(CoreLog::samples).sum(),
        },
    };
    Ok(Report {
        outcome,
        coordinate: machine.coordinate.unit().to_owned(),
        load_unit: machine.coordinate.load_unit().to_owned(),
        train: train_evidence,
        validate: validate_evidence,
    })
}

fn samples(seconds: f64, period: f64, least: usize) -> usize {
    ((seconds / period).round() as usize).max(least)
}

fn settings(machine: &Machine, period: f64) -> Settings {
    Settings {
        window: samples(WINDOW_S, period, 5),
        half_width: HALF_WIDTH,
        measured_velocity: false,
        resolution: machine.resolution.unwrap_or(0.0) as f32,
        position_weight: 1.0,
        current_weight: 0.0,
    }
}

/// The sampling period that all logs share.
fn same_period(logs: &[Log], expected: Option<f64>) -> Result<f64, InputError> {
    let period = expected.unwrap_or(logs[0].period_s);
    for log in logs {
        if (log.period_s - period).abs() > 0.01 * period {
            let message = format!(
                "sampled every {} s where the other logs have {period} s: expected one sampling period",
                log.period_s
            );
            return Err(InputError::new(&log.path, None, message));
        }
    }
    Ok(period)
}

/// Refuses logs in which there is too little to trace or to judge, or on which an error relative to
/// the motion or to the torque has no meaning. `path`: the file to blame.
fn check_logs(
    path: &Path,
    data: &Data,
    simulator: &Simulator,
    windows: usize,
) -> Result<(), InputError> {
    let fail = |message: String| Err(InputError::new(path, None, message));
    let entries: usize = data
        .logs
        .iter()
        .map(|log| balance_entries(log.samples()))
        .sum();
    if data.windows() < windows || entries < LEAST_ENTRIES {
        let settings = &data.settings;
        let replayed = windows * settings.window + 2 * MARGIN + 1;
        let samples = replayed.max(balanced_samples(LEAST_ENTRIES));
        return fail(format!(
            "too short; expected at least {samples} samples ({:.3} s) in one log",
            samples as f64 * decimal(data.logs[0].period)
        ));
    }
    let still = |log: &CoreLog| log.position.iter().all(|p| *p == log.position[0]);
    if data.logs.iter().all(still) {
        return fail("`position` never changes; expected a log of the machine in motion".into());
    }
    let idle = |log: &CoreLog| {
        let balance = torque_balance(log, simulator, 0.0);
        balance.torque.iter().all(|torque| *torque == 0.0)
    };
    if data.logs.iter().all(idle) {
        return fail("`input` is 0 throughout; expected a log of the machine being driven".into());
    }
    Ok(())
}

fn stages(data: &Data, schedule: &impl Schedule, models: [&Model; 3]) -> Result<Stages, Failure> {
    let errors = |model: &Model| {
        metrics::errors(data, schedule, model).map_err(|error| Failure::other(error.to_string()))
    };
    Ok(Stages {
        declared: errors(models[0])?,
        before: errors(models[1])?,
        after: errors(models[2])?,
    })
}

/// Why a candidate was taken or refused, in words.
fn candidate(look: &Consideration) -> Candidate {
    let id = |id: Id| id.description().id;
    let share = |ratio: f64| format!("{:.0} %", 100.0 * (1.0 - ratio));
    let reason = match (look.decision, look.held_out) {
        (Decision::Accepted, Some(held_out)) => format!(
            "held-out error falls by {}, p = {:.1e}",
            share(held_out.ratio),
            held_out.p_value
        ),
        (Decision::Outdone { by }, Some(held_out)) => format!(
            "would take {} off the held-out error, {} takes more",
            share(held_out.ratio),
            id(by)
        ),
        (Decision::Refused(Refusal::NotSignificant { required }), Some(held_out)) => format!(
            "gain on held-out blocks not significant: p = {}, with so many looks {} is required",
            probability(held_out.p_value),
            probability(required)
        ),
        (Decision::Refused(Refusal::GainTooSmall), Some(held_out)) => format!(
            "held-out error falls by {} only, 10 % is required",
            share(held_out.ratio)
        ),
        (Decision::Refused(Refusal::Uncertain), _) => {
            "its fitted strength is within three standard deviations of zero".to_owned()
        }
        (Decision::LeastBad, _) => {
            "not proven on held-out blocks, but the error is far beyond the sensor's and this map \
             comes nearest to it"
                .to_owned()
        }
        (Decision::Refused(Refusal::GainNotCommon), _) => {
            "the gain comes from few of the held-out blocks".to_owned()
        }
        (Decision::SameAs { other }, _) => format!("the same model as {} here", id(other)),
        (Decision::Absorbed, _) => format!(
            "absorbed by the fitted parameters (identifiability {:.3})",
            look.identifiability
        ),
        (Decision::WrongSign, _) => "the residual asks for a sign that physics forbids".to_owned(),
        (Decision::ScoreTooLow, _) => "explains under 1 % of the residual".to_owned(),
        (Decision::NotShortlisted, _) => "eight others score higher".to_owned(),
        (Decision::Dropped, _) => {
            "taken at first, not needed beside the effects found later".to_owned()
        }
        (Decision::OutdoneByMap { by }, Some(held_out)) => format!(
            "would take {} off the held-out error, {} takes more",
            share(held_out.ratio),
            map_name(by)
        ),
        (Decision::OutdoneByMap { by }, None) => {
            format!("taken at first, but {} explains clearly more", map_name(by))
        }
        (Decision::Accepted | Decision::Outdone { .. }, None) | (Decision::Refused(_), None) => {
            String::new()
        }
    };
    Candidate {
        round: look.round,
        id: match look.subject {
            Subject::Effect(effect) => id(effect).to_owned(),
            Subject::Map(kind) => map_name(kind),
        },
        score: decimal(look.score),
        identifiability: decimal(look.identifiability),
        held_out_ratio: look.held_out.map(|held_out| held_out.ratio),
        p_value: look.held_out.map(|held_out| held_out.p_value),
        accepted: matches!(look.decision, Decision::Accepted | Decision::LeastBad),
        reason,
    }
}

/// A learned map among the candidates.
fn map_name(kind: Kind) -> String {
    let what = if kind.is_friction() {
        "friction"
    } else {
        "torque"
    };
    format!("map:{} ({what})", kind.variable())
}

/// Standard deviations of functions of the fitted model, by linear propagation of the covariance.
/// `dimensions`: what the functions measure.
fn propagate(
    fit: &Fit,
    variables: &Variables,
    dimensions: &[Dimension],
    quantity: impl Fn(&Model) -> [f32; MOST_PARAMETERS],
) -> [f64; MOST_PARAMETERS] {
    let covariance = fit.covariance(variables);
    let start = quantity(&fit.model);
    let slopes: Vec<[f64; MOST_PARAMETERS]> = variables
        .iter()
        .map(|variable| {
            let mut moved = fit.model.clone();
            let step = 0.01 * variable.scale;
            variable.set(&mut moved, variable.get(&fit.model) + step);
            let end = quantity(&moved);
            std::array::from_fn(|index| {
                let mut change = f64::from(end[index] - start[index]);
                if dimensions.get(index) == Some(&Dimension::Phase) {
                    // A phase may step across ±π.
                    change -= TAU * (change / TAU).round();
                }
                change / f64::from(step)
            })
        })
        .collect();
    std::array::from_fn(|index| {
        let mut variance = 0.0;
        for (row, a) in slopes.iter().enumerate() {
            for (column, b) in slopes.iter().enumerate() {
                let product = a[index] * b[index];
                if product != 0.0 {
                    variance += product * covariance[row][column];
                }
            }
        }
        variance.max(0.0).sqrt()
    })
}

fn found(trace: &Trace, declared: &Model, rotary: bool) -> Vec<FoundEffect> {
    trace
        .accepted
        .iter()
        .enumerate()
        .map(|(index, accepted)| {
            let slot = declared.effects.len() + index;
            let report = |model: &Model| model.effects[slot].report(&model.plant);
            let values = report(&trace.after.model);
            let description = accepted.candidate.effect.id.description();
            let mut declare = format!("{{ id = \"{}\"", description.id);
            let parameters = description.parameters.iter();
            for (parameter, value) in parameters.zip(trace.after.model.effects[slot].values) {
                declare += &format!(", {} = {}", parameter.name, decimal(value));
            }
            declare += " }";
            let dimensions: Vec<Dimension> = description
                .reported
                .iter()
                .map(|(_, dimension)| *dimension)
                .collect();
            let stds = propagate(&trace.after, &trace.variables, &dimensions, report);
            FoundEffect {
                id: description.id.to_owned(),
                parameters: description
                    .reported
                    .iter()
                    .zip(values.iter().zip(stds))
                    .map(|((name, dimension), (value, std))| Estimate {
                        name: (*name).to_owned(),
                        value: decimal(*value),
                        std,
                        unit: dimension.unit(rotary).to_owned(),
                    })
                    .collect(),
                declare,
                score: decimal(accepted.candidate.score),
                identifiability: decimal(accepted.candidate.identifiability),
                p_value: accepted.p_value,
                equivalent: accepted
                    .equivalent
                    .iter()
                    .map(|id| id.description().id.to_owned())
                    .collect(),
            }
        })
        .collect()
}

fn fitted(trace: &Trace, declared: &Model, base: &[Base], rotary: bool) -> Vec<FittedParameter> {
    base.iter()
        .map(|&parameter| {
            let value = |model: &Model| [model.get(parameter), 0.0, 0.0];
            let dimensions = [parameter.dimension()];
            let std = propagate(&trace.after, &trace.variables, &dimensions, value)[0];
            let fitted = trace.after.model.get(parameter);
            FittedParameter {
                name: parameter.name().to_owned(),
                declared: decimal(declared.get(parameter)),
                fitted: decimal(fitted),
                std: std.is_finite().then_some(std),
                unit: parameter.dimension().unit(rotary).to_owned(),
            }
        })
        .collect()
}

/// Correlation of two series of equal length; 0 where one does not vary.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |series: &[f64]| series.iter().sum::<f64>() / series.len() as f64;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let (mut shared, mut own_a, mut own_b) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (a - mean_a, b - mean_b);
        shared += a * b;
        own_a += a * a;
        own_b += b * b;
    }
    let norm = (own_a * own_b).sqrt();
    if norm > 0.0 { shared / norm } else { 0.0 }
}

/// Whiteness of the base fit's torque residual, and what it goes along with.
fn whiteness(data: &Data, model: &Model) -> Result<Whiteness, Failure> {
    let simulator = model
        .build(data.logs[0].period)
        .map_err(|error| Failure::other(error.to_string()))?;
    let (mut residual, mut input, mut velocity) = (Vec::new(), Vec::new(), Vec::new());
    for log in data.logs {
        let balance = torque_balance(log, &simulator, f64::from(data.settings.resolution));
        residual.extend(balance.residual);
        velocity.extend(balance.velocity);
        input.extend(balance.sample.iter().map(|&at| f64::from(log.input[at])));
    }
    let along = |series: &[f64], of: fn(f64) -> f64| {
        let series: Vec<f64> = series.iter().map(|&value| of(value)).collect();
        correlation(&residual, &series)
    };
    let correlations = Correlations {
        input: along(&input, |u| u),
        velocity: along(&velocity, |v| v),
        direction: along(&velocity, f64::signum),
        input_squared: along(&input, |u| u * u),
    };
    let mean = residual.iter().sum::<f64>() / residual.len() as f64;
    let product = |lag: usize| -> f64 {
        residual
            .iter()
            .zip(&residual[lag..])
            .map(|(a, b)| (a - mean) * (b - mean))
            .sum()
    };
    let lags = LAGS.min(residual.len() / 4);
    let variance = product(0);
    let autocorrelations: Vec<f32> = (1..=lags)
        // At rest friction takes whatever acts: a residual may be zero throughout.
        .map(|lag| {
            if variance > 0.0 {
                product(lag) / variance
            } else {
                0.0
            }
        })
        .map(|autocorrelation| autocorrelation as f32)
        .collect();
    let test = ljung_box(&autocorrelations, residual.len() as u32, 0)
        .map_err(|error| Failure::other(error.to_string()))?;
    Ok(Whiteness {
        ljung_box: f64::from(test.statistic as f32) / lags as f64,
        lags,
        p_value: test.p_value,
        correlations,
    })
}

/// Positions of a model replayed in windows; the measurement where no window reaches.
fn windowed(data: &Data, log: usize, model: &Model) -> Result<(Vec<f32>, Vec<usize>), Failure> {
    let series = &data.logs[log];
    let simulator = model
        .build(series.period)
        .map_err(|error| Failure::other(error.to_string()))?;
    let mut positions = series.position.to_vec();
    let mut starts = Vec::new();
    for number in 0..data.windows() {
        let Some(window) = data.window(number).filter(|window| window.log == log) else {
            continue;
        };
        starts.push(window.start);
        let mut runner = Runner::new(&simulator, series, window.start, &data.settings);
        for index in window.start..window.start + data.settings.window {
            runner.advance(index);
            positions[index + 1] = runner.state().position.value();
        }
    }
    Ok((positions, starts))
}

fn evidence(series: &[Series], data: &Data, trace: &Trace) -> Result<Vec<Evidence>, Failure> {
    series
        .iter()
        .enumerate()
        .map(|(index, series)| {
            let log = series.log();
            let (before, window_starts) = windowed(data, index, &trace.before.model)?;
            let (after, _) = windowed(data, index, &trace.after.model)?;
            let balance = |model: &Model| {
                model
                    .build(series.period)
                    .map(|simulator| {
                        torque_balance(&log, &simulator, f64::from(data.settings.resolution))
                    })
                    .map_err(|error| Failure::other(error.to_string()))
            };
            let (torque_before, torque_after) =
                (balance(&trace.before.model)?, balance(&trace.after.model)?);
            let narrow =
                |series: &[f64]| -> Vec<f32> { series.iter().map(|&value| value as f32).collect() };
            let time = |sample: usize| (sample as f64 * decimal(series.period)) as f32;
            let samples = log.samples();
            let half = data.settings.half_width;
            Ok(Evidence {
                label: series.label.clone(),
                time: (0..samples).map(time).collect(),
                position: series.position.clone(),
                velocity: (0..samples)
                    .map(|sample| {
                        let inside = sample.max(half).min(samples - 1 - half);
                        let state = log.smoothed_state(inside, half, data.settings.resolution);
                        state.velocity.value()
                    })
                    .collect(),
                input: series.input.clone(),
                current: series.current.clone().unwrap_or_default(),
                before,
                after,
                torque_before: narrow(&torque_before.residual),
                torque_after: narrow(&torque_after.residual),
                torque_time: torque_before.sample.iter().map(|&s| time(s)).collect(),
                torque_velocity: narrow(&torque_before.velocity),
                torque_position: narrow(&torque_before.position),
                window_starts,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace;
    use model_core::gap::fit::variables;
    use model_core::gap::replay::{COLUMNS, Sums};

    /// A cogging of amplitude A whose two components have independent errors of standard deviation
    /// σ has σ of its amplitude and σ/A of its phase, wherever the phase lies.
    #[test]
    fn a_phase_is_as_certain_at_pi_as_elsewhere() {
        let file = workspace::root().join("host-tests/machines/emps.toml");
        let declared = model(&Machine::read(&file).unwrap()).unwrap();
        let mut model = declared.clone();
        let scope = Scope {
            friction: 20.0,
            torque: 30.0,
            speed: 0.1,
            stroke: 0.2,
            period: 1e-3,
            rotary: false,
        };
        // With unit sums, a variable's standard deviation is its scale: here the friction.
        let mut unit = [[0.0; COLUMNS]; COLUMNS];
        for index in 0..COLUMNS {
            unit[index][index] = 1.0;
        }
        let amplitude = 40.0_f32;
        for phase in [-3.139, -1.0, 0.0, 2.0, 3.139_f32] {
            model.effects = [Active {
                id: Id::Cogging,
                values: [amplitude * phase.cos(), amplitude * phase.sin(), 0.05],
            }]
            .into_iter()
            .collect();
            let fit = Fit {
                model: model.clone(),
                cost: 1.0,
                sums: Sums {
                    products: unit,
                    gradients: unit,
                    windows: 1_000_000,
                },
                simulated: 0,
            };
            let dimensions = [Dimension::Torque, Dimension::Phase, Dimension::Position];
            let report = |model: &Model| model.effects[0].report(&model.plant);
            let variables = variables(&declared, &model, &[], &scope);
            let [of_amplitude, of_phase, _] = propagate(&fit, &variables, &dimensions, report);
            assert!(
                (of_amplitude / 20.0 - 1.0).abs() < 0.02,
                "{phase}: {of_amplitude} N"
            );
            assert!(
                (of_phase / 0.5 - 1.0).abs() < 0.02,
                "{phase}: {of_phase} rad"
            );
        }
    }
}
