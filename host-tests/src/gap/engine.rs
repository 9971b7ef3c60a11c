//! From files to the answer: the host's side of the tracing in `model_core::gap`.

use std::cmp::Reverse;
use std::path::Path;
use std::time::Instant;

use model_core::gap::lengths;
use model_core::gap::log::Log as CoreLog;
use model_core::gap::model::{Base, Model};
use model_core::gap::replay::{Data, Job, MARGIN, Schedule, Settings};
use model_core::gap::select::LEAST_WINDOWS;
use model_core::gap::verdict::{Consideration, Decision, Subject, Trace};
use model_core::gap::workbench::{Options, Workbench};
use model_core::plant::parameters::ParameterError;
use rayon::prelude::*;

use super::answer::{
    candidate, current_sensor, fitted, found, input_lead, mechanism, settle, unknown,
};
use super::between_logs;
use super::declared::{base_parameters, encoder_turn, model, resolution, unsure};
use super::demand::Demand;
use super::disagreement::{self, Look};
use super::evidence::evidence;
use super::metrics::{
    self, LEAST_ENTRIES, SETTLING, balance_entries, least_balanced_samples, torque_balance,
};
use super::outcome::{
    Candidate, Cost, Errors, FreeMotor, Outcome, Report, Resampled, Residual, ShortLogs, Stages,
    rises_clearly,
};
use super::series::Series;
use super::spread::{Known, Spread};
use super::whiteness::whiteness;
use crate::error::InputError;
use crate::failure::Failure;
use crate::log::{Log, counted};
use crate::machine::{Coordinate, MOTOR, Machine};
use crate::quantity::decimal;
use crate::vectors::Vectors;

/// Fewest windows that a model can be judged on.
const LEAST_VALIDATE_WINDOWS: usize = 1;

/// All cores, and on each sixteen windows at once where the vectors are wide; results are folded in the order of the
/// windows, so that the sums have the same bits as on one core and one by one.
#[derive(Debug, Clone, Copy, Default)]
pub struct AllCores;

impl Schedule for AllCores {
    fn at_once(&self) -> usize {
        LANES * rayon::current_num_threads()
    }

    fn run<R: Default + Send>(
        &self,
        count: usize,
        work: impl Fn(usize, &mut R) + Send + Sync,
        mut fold: impl FnMut(usize, &R),
    ) {
        let mut results: Vec<R> = Vec::new();
        results.resize_with(count, R::default);
        let each = results.par_iter_mut().enumerate();
        each.for_each(|(index, result)| work(index, result));
        for (index, result) in results.iter().enumerate() {
            fold(index, result);
        }
    }

    fn run_job<J: Job>(&self, count: usize, job: &J, mut fold: impl FnMut(usize, &J::Result)) {
        let vectors = Vectors::widest();
        // Of few windows, each core has some.
        let group = count.div_ceil(rayon::current_num_threads()).clamp(1, LANES);
        let numbers = side_by_side(count, group, job);
        let mut results: Vec<J::Result> = Vec::new();
        results.resize_with(count, Default::default);
        let groups = numbers.par_chunks(group);
        let groups = groups.zip(results.par_chunks_mut(group));
        // Some groups take far longer than others: each may go to another core.
        let groups = groups.with_max_len(1);
        groups.for_each(|(numbers, results)| match vectors {
            Vectors::Baseline => work_baseline(job, numbers, results),
            // SAFETY: only `Vectors` makes it, where the processor has it.
            #[cfg(target_arch = "x86_64")]
            Vectors::Avx2(_) => unsafe { work_avx2(job, numbers, results) },
            // SAFETY: as above, each feature of the function.
            #[cfg(target_arch = "x86_64")]
            Vectors::Avx512(_) => unsafe { work_avx512(job, numbers, results) },
        });
        let mut places = vec![0; count];
        for (place, &number) in numbers.iter().enumerate() {
            places[number] = place;
        }
        for (number, &place) in places.iter().enumerate() {
            fold(number, &results[place]);
        }
    }
}

/// The numbers of all windows, in groups of lanes with leads of about one length, the longest first: a
/// group takes as long as the longest of its leads.
fn side_by_side(count: usize, group: usize, job: &impl Job) -> Vec<usize> {
    let leads: Vec<usize> = (0..count)
        .into_par_iter()
        .map(|number| job.lead(number))
        .collect();
    let mut numbers: Vec<usize> = (0..count).collect();
    numbers.sort_by_key(|&number| Reverse(leads[number]));
    for group in numbers.chunks_mut(group) {
        group.sort_unstable();
    }
    numbers
}

/// Windows that are simulated in lockstep: numbers in the widest vector.
const LANES: usize = 16;

/// The same with the vectors that the program is built for. Nearly every x86-64 has AVX2, and the code of sixteen
/// lanes for the narrow vectors of one that has not would be nine seconds of every build: there the windows are
/// simulated one by one. By `cargo hil bench gap --worlds 8 --seed 5` that takes 2.4 times as long as with AVX2;
/// sixteen at once in narrow vectors took 1.3 times as long.
const BASELINE_LANES: usize = if cfg!(target_arch = "x86_64") {
    1
} else {
    LANES
};

/// Not in line, where there would be a copy for each caller's `fold`: they take long to build.
#[inline(never)]
fn work_baseline<J: Job>(job: &J, numbers: &[usize], results: &mut [J::Result]) {
    let results = results.chunks_mut(BASELINE_LANES);
    for (numbers, results) in numbers.chunks(BASELINE_LANES).zip(results) {
        job.work::<BASELINE_LANES>(numbers, results);
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn work_avx2<J: Job>(job: &J, numbers: &[usize], results: &mut [J::Result]) {
    job.work::<LANES>(numbers, results);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw")]
fn work_avx512<J: Job>(job: &J, numbers: &[usize], results: &mut [J::Result]) {
    job.work::<LANES>(numbers, results);
}

/// What a tracing gives.
#[derive(Debug, Clone)]
pub struct Found {
    /// The answer and its evidence.
    pub report: Report,
    /// The model with the effects, everything refitted.
    pub model: Model,
    /// How the logs were cut and weighed for that.
    pub settings: Settings,
    /// What the selection took, and every look at a candidate, in their order.
    pub trace: Trace,
    pub(super) looks: Vec<Consideration>,
}

/// What logs and machine file give.
#[derive(Debug, Clone)]
pub enum Answer {
    /// They belong together: what a tracing found.
    Found(Box<Found>),
    /// They disagree: nothing was traced.
    Disagree(Box<Report>),
}

impl Answer {
    /// What the user is told.
    pub fn into_report(self) -> Report {
        match self {
            Self::Found(found) => found.report,
            Self::Disagree(report) => *report,
        }
    }

    /// What was found.
    ///
    /// # Errors
    /// Logs and machine file that disagree.
    pub fn found(self) -> Result<Found, Failure> {
        match self {
            Self::Found(found) => Ok(*found),
            Self::Disagree(report) => Err(disagreement::failure(&report)),
        }
    }
}

/// Traces the training logs, then opens the validation logs.
///
/// `validate` is called once, when nothing is left to be chosen or fitted: what these logs speak against is taken back.
///
/// # Errors
/// What [`model`] refuses; a machine whose replay diverges; logs too short, at rest or without force
/// throughout, or of different sampling periods; whatever `validate` returns.
pub fn run(
    machine: &Machine,
    train: &[Log],
    validate: impl FnOnce() -> Result<Vec<Log>, Failure>,
    progress: impl FnMut(&str) + Send,
) -> Result<Report, Failure> {
    trace(machine, train, validate, progress).map(Answer::into_report)
}

/// As [`run`], with the model that was found.
///
/// # Errors
/// As [`run`].
pub fn trace(
    machine: &Machine,
    train: &[Log],
    validate: impl FnOnce() -> Result<Vec<Log>, Failure>,
    mut progress: impl FnMut(&str) + Send,
) -> Result<Answer, Failure> {
    let started = Instant::now();
    let declared = model(machine)?;
    let base = base_parameters(machine);
    let unsure = unsure(machine);
    let rotary = machine.coordinate == Coordinate::Radian;
    let series = Series::of(train, machine);
    let logs: Vec<CoreLog> = series.iter().map(Series::log).collect();
    let period = same_period(train, None)?;
    let disagree = |found| {
        let report = disagreement::report(machine, &declared, train, found, started);
        Ok(Answer::Disagree(Box::new(report)))
    };
    let mut look = Look::at(machine, train);
    if !look.found.is_empty() {
        // They most likely need the same call. What else is wrong with them is said once this is mended.
        if let Ok(held_back) = validate()
            && !held_back.is_empty()
        {
            look.found.extend(look.beside(&held_back));
        }
        return disagree(look.found);
    }
    let refused = |error: ParameterError| InputError::new(&machine.path, None, error.to_string());
    declared.build(period as f32).map_err(refused)?;
    let resolution = resolution(machine, train);
    let data = Data::new(&logs, resolution).ok_or_else(|| Failure::other("no log to train on"))?;
    check_logs(&train[0].path, &data, &declared, LEAST_WINDOWS)?;
    let left_range = || {
        Failure::other(
            "the fit left the range in which the machine can be simulated; \
             name fewer `parameters` in [fit], end stops last",
        )
    };
    let options = options(machine, (&data, &declared), &base, &unsure).ok_or_else(left_range)?;
    let schedule = AllCores;
    let mut candidates: Vec<Candidate> = Vec::new();
    let mut looks: Vec<Consideration> = Vec::new();
    let mut observe = |look: &Consideration| {
        if look.subject == Subject::Input && look.decision == Decision::Accepted {
            // What was told of these rounds is void.
            looks.retain(|told| told.round < look.round);
            candidates.retain(|told| told.round < look.round);
        }
        looks.push(*look);
        let entry = candidate(look);
        // An effect or a map that was taken in an earlier round and is not any more: that look gets the
        // last word on it.
        let taken = |known: &&mut Candidate| known.accepted && known.id == entry.id;
        let is_number = matches!(look.subject, Subject::Numbers | Subject::Input);
        if !is_number
            && !entry.accepted
            && let Some(taken) = candidates.iter_mut().find(taken)
        {
            taken.accepted = false;
            taken.reason = entry.reason;
            return;
        }
        let decision = if entry.accepted {
            "accepted"
        } else {
            "refused"
        };
        progress(&format!(
            "looking for effects, round {}: {} {decision}",
            entry.round, entry.id
        ));
        candidates.push(entry);
    };
    // On a core that works on the windows too: from any other one, each replay would begin with waking two.
    let mut trace =
        rayon::scope(|_| lengths::trace(&data, &schedule, &declared, &options, &mut observe))
            .ok_or_else(left_range)?;
    let seconds = started.elapsed().as_secs_f64();
    progress("judging what was found");

    let judged = Data {
        settings: trace.settings,
        ..data
    };
    let models = [&declared, &trace.before.model, &trace.after.model];
    let mut train_errors = stages(&judged, &schedule, models)?;
    if !train_errors.before.position_rms.is_finite() {
        let message = "the replay of the training data diverges with these numbers, fitted or not; \
                       expected a machine in SI units that can move as the logs do";
        return Err(InputError::new(&machine.path, None, message).into());
    }
    let held_back = validate()?;
    let mut resampled = Resampled::among(train);
    resampled.extend(Resampled::among(&held_back));
    let unseen_series = Series::of(&held_back, machine);
    let unseen_logs: Vec<CoreLog> = unseen_series.iter().map(Series::log).collect();
    let unseen = Data {
        logs: &unseen_logs,
        ..judged
    };
    let mut validate_errors = None;
    if let Some(first) = held_back.first() {
        same_period(&held_back, Some(period))?;
        check_unseen(train, &held_back)?;
        let look = Look::at(machine, &held_back);
        if !look.found.is_empty() {
            return disagree([look.beside(train), look.found].concat());
        }
        check_logs(&first.path, &unseen, &declared, LEAST_VALIDATE_WINDOWS)?;
        let mut errors = stages(&unseen, &schedule, models)?;
        if let Some(reason) = does_not_carry_over(&errors) {
            for taken in candidates.iter_mut().filter(|taken| taken.accepted) {
                taken.accepted = false;
                taken.reason.clone_from(&reason);
            }
            trace.take_back();
            for errors in [&mut train_errors, &mut errors] {
                errors.after = errors.before.clone();
            }
            trace.residual.position_rms = train_errors.before.position_rms;
        }
        validate_errors = Some(errors);
    }
    settle(&mut candidates, &trace);
    let known = Known::of(machine, &options);
    let spread = Spread::new(&trace, &judged, &declared, &known).ok_or_else(left_range)?;
    let moved = (&trace.base[..], &trace.readings[..]);
    let named =
        mechanism(&trace).and_then(|it| Spread::of(&it.nearest, moved, &judged, &declared, &known));
    let train_evidence = evidence(&series, &judged, &declared, &trace)?;
    let demand = Demand::of(&judged, &trace.after.model).map_err(refused)?;
    let validate_evidence = if held_back.is_empty() {
        Vec::new()
    } else {
        evidence(&unseen_series, &unseen, &declared, &trace)?
    };

    let last = if held_back.is_empty() {
        &judged
    } else {
        &unseen
    };
    let numbers = between_logs::Numbers::of(&trace.after.model, &judged, &options.scope);
    let free_run_costs = numbers.free_run_costs(last).map_err(refused)?;
    // One log alone has nothing otherwise than itself.
    let trained = series.iter().filter(|_| series.len() > 1);
    let trained = trained.map(|log| (log, true));
    let others = trained.chain(unseen_series.iter().map(|log| (log, false)));
    let trained_rms = train_errors.after.position_rms;
    let between_logs = others
        .filter_map(|(log, trained_on)| {
            numbers.differences(log.log(), (&log.label, trained_on), trained_rms)
        })
        .collect();

    let mut outcome = Outcome {
        machine: machine.name.clone(),
        verdict: trace.verdict(),
        disagreement: Vec::new(),
        residual: Some(Residual {
            position_rms: trace.residual.position_rms,
            floor: trace.residual.floor,
            implausible: trace.farthest.map(Base::name),
            unconfirmed: trace.unconfirmed,
            short: ShortLogs::of(&data),
        }),
        effects: found(&trace, &spread, named.as_ref(), &declared, rotary),
        unknown: unknown(&trace, rotary),
        fit: fitted(
            (&trace.after.model, &trace.base),
            &spread,
            &declared,
            &options,
            machine,
        ),
        current_sensor: current_sensor(&trace, &spread),
        input_lead: input_lead(&trace, &spread),
        errors: Errors {
            train: train_errors,
            validate: validate_errors,
        },
        between_logs,
        free_run_costs,
        candidates,
        next_experiment: None,
        machine_out: None,
        whiteness: whiteness(&judged, &trace.before.model)?,
        resampled,
        cost: Cost {
            seconds,
            simulations: trace.simulated / judged.windows() as u64,
            samples: logs.iter().map(CoreLog::samples).sum(),
        },
    };
    outcome.heed_validation();
    let report = Report {
        outcome,
        coordinate: machine.coordinate.unit().to_owned(),
        load_unit: machine.coordinate.load_unit().to_owned(),
        demand,
        declared: machine.declared_effects.clone(),
        free_motor: free_motor(machine, train),
        has_return_spring: has_return_spring(machine),
        has_page: false,
        held_within: known.held(),
        without_inductance: machine
            .motor
            .as_ref()
            .filter(|motor| motor.inductance == 0.0)
            .map(|motor| motor.resistance),
        train: train_evidence,
        validate: validate_evidence,
    };
    Ok(Answer::Found(Box::new(Found {
        report,
        model: trace.after.model.clone(),
        settings: trace.settings,
        trace,
        looks,
    })))
}

/// Whether a machine has what `cargo hil identify` asks for: a spring between two stops, and neither weight nor effects.
fn has_return_spring(machine: &Machine) -> bool {
    let mechanics = &machine.mechanics;
    mechanics.spring > 0.0
        && mechanics.lower_stop.is_some()
        && mechanics.upper_stop.is_some()
        && mechanics.gravity_torque == 0.0
        && machine.declared_effects.is_empty()
}

/// Which of resistance and torque constant `[fit]` leaves out. None where it has both; nor where a log has no current,
/// for then the scale of all torques is theirs alone.
fn free_motor(machine: &Machine, train: &[Log]) -> Option<FreeMotor> {
    machine.motor.as_ref()?;
    let fixed = MOTOR.into_iter().filter(|name| !machine.fits(name));
    let fixed: Vec<&str> = fixed.collect();
    let with_current = train.iter().all(|log| log.current.is_some());
    (with_current && !fixed.is_empty()).then(|| {
        let fitted = machine.fit.iter().map(String::as_str);
        let all: Vec<&str> = fitted.chain(fixed.iter().copied()).collect();
        FreeMotor {
            line: format!("parameters = {all:?}"),
            fixed,
        }
    })
}

/// Windowed position error, rms, of a model that is refitted to the logs, cut and weighed as a tracing
/// did it.
///
/// # Errors
/// As [`refit`].
pub fn refitted_error(
    machine: &Machine,
    train: &[Log],
    settings: Settings,
    model: &Model,
) -> Result<f64, Failure> {
    Ok(refitted_errors(machine, train, &[], settings, model)?.0)
}

/// As [`refitted_error`], and the same error of the refitted model on logs that it was not fitted to; no
/// number where there are none.
///
/// # Errors
/// As [`refit`].
pub fn refitted_errors(
    machine: &Machine,
    train: &[Log],
    held_out: &[Log],
    settings: Settings,
    model: &Model,
) -> Result<(f64, f64), Failure> {
    let (model, train_error) = with_workbench(machine, train, |bench| {
        bench.data.settings = settings;
        let fit = bench.fit(model)?;
        let model = bench.multi_start(fit).model;
        let errors = metrics::errors(&bench.data, &AllCores, &model);
        Some((model, errors.ok()?.position_rms))
    })?;
    if held_out.is_empty() {
        return Ok((train_error, f64::NAN));
    }
    let series = Series::of(held_out, machine);
    let logs: Vec<CoreLog> = series.iter().map(Series::log).collect();
    let data = Data {
        logs: &logs,
        settings,
    };
    let errors = metrics::errors(&data, &AllCores, &model)
        .map_err(|error| Failure::other(error.to_string()))?;
    Ok((train_error, errors.position_rms))
}

/// Refits a model in longer windows than it was traced in, the shortest first: the longer a window,
/// the more the fit is one of free runs, and the nearer its start has to be.
///
/// # Errors
/// Logs of different sampling periods or shorter than a window; a model that leaves the range in
/// which it can be simulated.
pub fn refit(
    machine: &Machine,
    train: &[Log],
    model: &Model,
    windows_s: &[f64],
) -> Result<Model, Failure> {
    let period = same_period(train, None)?;
    with_workbench(machine, train, |bench| {
        let mut model = model.clone();
        for window_s in windows_s {
            let window = (window_s / period) as usize;
            model = bench.fit_windows(&model, window)?.model;
        }
        Some(model)
    })
}

/// Lays out the logs for fits of models of a machine. `None` of `work` is a fit without a window in
/// range.
pub(super) fn with_workbench<T>(
    machine: &Machine,
    train: &[Log],
    work: impl FnOnce(&mut Workbench<AllCores>) -> Option<T>,
) -> Result<T, Failure> {
    let declared = model(machine)?;
    let base = base_parameters(machine);
    let unsure = unsure(machine);
    same_period(train, None)?;
    let series = Series::of(train, machine);
    let logs: Vec<CoreLog> = series.iter().map(Series::log).collect();
    let resolution = resolution(machine, train);
    let data = Data::new(&logs, resolution).ok_or_else(|| Failure::other("no log to train on"))?;
    let failed = || Failure::other("no window of the refit is in range: record longer logs");
    let options = options(machine, (&data, &declared), &base, &unsure).ok_or_else(failed)?;
    let mut bench = Workbench::new(data, &AllCores, &declared, &options).ok_or_else(failed)?;
    work(&mut bench).ok_or_else(failed)
}

/// How the tracing runs on these logs; `None` where the declared model cannot be simulated.
fn options<'a>(
    machine: &Machine,
    (data, declared): (&Data, &Model),
    base: &'a [Base],
    unsure: &'a [(Base, f32)],
) -> Option<Options<'a>> {
    let rotary = machine.coordinate == Coordinate::Radian;
    let mut options = Options::new(data, declared, base, rotary)?;
    options.unsure = unsure;
    let scope = &mut options.scope;
    scope.encoder_turn = encoder_turn(machine).unwrap_or(scope.encoder_turn);
    Some(options)
}

/// The sampling period that all logs share.
fn same_period(logs: &[Log], expected: Option<f64>) -> Result<f64, InputError> {
    let period = expected.unwrap_or(logs[0].period_s);
    for log in logs {
        if (log.period_s - period).abs() > 0.01 * period {
            let unit = (log.period_s / period - 1000.0).abs() < 10.0;
            let remedy = if unit {
                "its `time_s` is in milliseconds, most likely: import it with --time time_s:ms"
            } else {
                "expected one sampling period"
            };
            let message = format!(
                "sampled every {} s where the other logs have {period} s: {remedy}",
                log.period_s
            );
            return Err(InputError::new(&log.path, None, message));
        }
    }
    Ok(period)
}

/// Refuses a validation log that was trained on.
fn check_unseen(train: &[Log], validate: &[Log]) -> Result<(), InputError> {
    for log in validate {
        if let Some(seen) = train.iter().find(|seen| seen.repeats(log)) {
            let message = format!(
                "has the samples of the training log {}; expected a log that nothing was fitted on",
                seen.path.display()
            );
            return Err(InputError::new(&log.path, None, message));
        }
    }
    Ok(())
}

/// Why what was found may not be said though the training logs prove it: the validation log is clearly worse
/// predicted with it, in windows or in torque.
fn does_not_carry_over(errors: &Stages) -> Option<String> {
    let (before, after) = (&errors.before, &errors.after);
    let measures = [
        ("position error", before.position_rms, after.position_rms),
        ("unexplained torque", before.torque_rel, after.torque_rel),
    ];
    let rises = |(_, before, after): &(&str, f64, f64)| rises_clearly(*before, *after);
    let most = |a: &(&str, f64, f64), b: &(&str, f64, f64)| (a.2 / a.1).total_cmp(&(b.2 / b.1));
    let (name, before, after) = measures.into_iter().filter(rises).max_by(most)?;
    Some(format!(
        "with it the {name} rises by {:.0} % on the validation log",
        100.0 * (after / before - 1.0)
    ))
}

/// Refuses logs in which there is too little to trace or to judge, or on which an error relative to
/// the motion or to the torque has no meaning. `path`: the file to blame.
pub(super) fn check_logs(
    path: &Path,
    data: &Data,
    model: &Model,
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
        let balanced = least_balanced_samples();
        let samples = replayed.max(balanced);
        let why = if replayed > balanced {
            format!(
                "{} of {} samples, and {MARGIN} on either side from which the model is started",
                counted(windows, "prediction"),
                settings.window
            )
        } else {
            format!(
                "{LEAST_ENTRIES} values of the torque balance, and {SETTLING} samples at either end over which its filters \
                 settle"
            )
        };
        return fail(format!(
            "too short; expected at least {samples} samples ({:.3} s) in one log, for {why}; record longer, or give several with \
             --train",
            samples as f64 * decimal(data.logs[0].period)
        ));
    }
    let still = |log: &CoreLog| log.position.iter().all(|p| p == log.position.at(0));
    if data.logs.iter().all(still) {
        return fail("`position` never changes; expected a log of the machine in motion".into());
    }
    let idle = |log: &CoreLog| {
        torque_balance(log, model, 0.0)
            .is_ok_and(|balance| balance.torque.iter().all(|torque| *torque == 0.0))
    };
    if data.logs.iter().all(idle) {
        let no_current = |log: &CoreLog| {
            let current = log.current;
            current.is_some_and(|current| (0..log.samples()).all(|at| current.at(at) == 0.0))
        };
        return fail(if data.logs.iter().all(no_current) {
            "`current_a` is 0 throughout; leave the column out, or see that its sensor is connected"
                .into()
        } else {
            "`input` is 0 throughout; expected a log of the machine being driven".into()
        });
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::outcome::ErrorSet;

    /// Why two effects' errors do not carry over: in windows, and in torque, beside 1 and 1 without.
    fn reason(position: f64, torque: f64) -> Option<String> {
        let errors = |position_rms, torque_rel| ErrorSet {
            window_s: 0.2,
            position_rms,
            position_max: position_rms,
            position_nrmse: position_rms,
            current_rms: None,
            torque_rel,
            free_run_rms: 1.0,
        };
        does_not_carry_over(&Stages {
            declared: errors(1.0, 1.0),
            before: errors(1.0, 1.0),
            after: errors(position, torque),
        })
    }

    #[test]
    fn what_the_validation_log_speaks_against_names_the_measure_that_rises_most() {
        // A ninth of the mean square is 5.4 % of the root mean square.
        assert_eq!(reason(1.05, 1.05), None);
        assert_eq!(reason(0.1, 1.05), None);
        let names = |position, torque, name: &str, percent: &str| {
            let reason = reason(position, torque).unwrap();
            assert!(
                reason.contains(name) && reason.contains(percent),
                "{reason}"
            );
        };
        names(0.1, 1.06, "unexplained torque", " 6 %");
        names(1.07, 3.0, "unexplained torque", " 200 %");
        names(1.5, 0.5, "position error", " 50 %");
        names(f64::INFINITY, 1.0, "position error", "inf %");
    }
}
