//! The command line of `cargo hil gap`.

use std::fs;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use indicatif::ProgressBar;

use super::engine::Answer;
use super::experiment::{self, NextExperiment};
use super::{engine, report, table};
use crate::error::InputError;
use crate::failure::Failure;
use crate::log::Log;
use crate::machine::Machine;
use crate::whole_file;

/// What `cargo hil gap` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Machine file: what you declare about the actuator, as in host-tests/machines/ema-24v.toml
    #[arg(long, value_name = "M.toml")]
    pub machine: PathBuf,
    /// Log to find the effects in, CSV with time_s,input,position and, where measured, command,
    /// current_a, velocity, brake, load_torque, enabled; may be given several times
    #[arg(long, value_name = "A.csv", required = true)]
    pub train: Vec<PathBuf>,
    /// A log to judge them on, opened once at the end; may be given several times
    #[arg(long, value_name = "B.csv")]
    pub validate: Vec<PathBuf>,
    /// Write the result to this file as JSON
    #[arg(long, value_name = "F")]
    pub json: Option<PathBuf>,
    /// Write a report with plots to this directory
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Where the logs leave something in doubt, look for an input that would settle it, and write it to
    /// this file, CSV with time_s,input; with --report, it goes into the report's directory too
    #[arg(long, value_name = "FILE")]
    pub experiment: Option<PathBuf>,
}

/// The next experiment's input in the report's directory.
const NEXT_EXPERIMENT: &str = "next-experiment.csv";

/// Finds the effects that the declared machine lacks, prints the table, writes what was asked for.
///
/// # Errors
/// A wrong file, before anything is written; or a result that cannot be written.
pub fn run(args: &Args) -> Result<(), Failure> {
    whole_file::check_place(args.json.as_deref())?;
    whole_file::check_place(args.experiment.as_deref())?;
    whole_file::check_directory(args.report.as_deref())?;
    let inputs = args.train.iter().chain(&args.validate);
    whole_file::check_apart(
        args.json.iter().chain(&args.experiment),
        inputs.chain([&args.machine]),
    )?;
    let machine = Machine::read(&args.machine)?;
    let train = read_train(&args.train)?;
    // A name that is wrong is better said now than after the fit; what is inside stays unread.
    for path in &args.validate {
        check_there(path)?;
    }
    let progress = if io::stderr().is_terminal() {
        ProgressBar::new_spinner()
    } else {
        ProgressBar::hidden()
    };
    progress.enable_steady_tick(Duration::from_millis(100));
    progress.set_message("tracing the residual");
    let result = engine::trace(
        &machine,
        &train,
        || Ok(read_validate(&args.validate, &train)?),
        |message| progress.set_message(message.to_owned()),
    )
    .and_then(|answer| {
        let found = match answer {
            Answer::Found(found) => found,
            Answer::Disagree(report) => return Ok((*report, None)),
        };
        let next = if args.experiment.is_some() || args.report.is_some() {
            progress.set_message("looking for the next experiment");
            experiment::next(&machine, &train, &found)?
        } else {
            experiment::doubt(&machine, &train, &found)?
        };
        Ok((found.report, next))
    });
    progress.finish_and_clear();
    let (mut found, next) = result?;
    found.outcome.next_experiment = write_input(args, next)?;

    if let Some(path) = &args.json {
        whole_file::write_json(path, &found.outcome)
            .map_err(|error| Failure::system(path.display(), &error))?;
    }
    if let Some(directory) = &args.report {
        report::write(&found, directory)
            .map_err(|error| Failure::system(directory.display(), &error))?;
    }
    let mut out = io::stdout();
    let mut text = table::render(&found, out.is_terminal());
    let next = found.outcome.next_experiment.as_ref();
    if let Some(path) = &args.experiment
        && next.is_none_or(|next| next.plan.is_none())
    {
        text += &format!(
            "\nThere is no experiment to propose: {} was not written.\n",
            path.display()
        );
    }
    out.write_all(text.as_bytes())
        .map_err(|error| Failure::system("standard output", &error))
}

/// Writes the next experiment's input into the report and where it was asked for. A report without one
/// keeps none from before.
fn write_input(
    args: &Args,
    mut next: Option<NextExperiment>,
) -> Result<Option<NextExperiment>, Failure> {
    let planned = next.as_mut().filter(|next| next.plan.is_some());
    let beside = args.report.as_ref();
    let beside = beside.map(|directory| directory.join(NEXT_EXPERIMENT));
    let failed = |path: &Path| {
        let name = path.display().to_string();
        move |error: io::Error| Failure::system(name, &error)
    };
    let Some(next_one) = planned else {
        if let Some(old) = beside.filter(|old| old.exists()) {
            fs::remove_file(&old).map_err(failed(&old))?;
        }
        return Ok(next);
    };
    if let Some(directory) = &args.report {
        fs::create_dir_all(directory).map_err(failed(directory))?;
    }
    for path in beside.iter().chain(&args.experiment) {
        next_one.write(path).map_err(failed(path))?;
    }
    Ok(next)
}

/// Refuses a path that leads to nothing, or to a directory.
fn check_there(path: &Path) -> Result<(), InputError> {
    let reason = match fs::metadata(path) {
        Ok(entry) if entry.is_dir() => "is a directory".to_owned(),
        Ok(_) => return Ok(()),
        Err(error) if error.kind() == io::ErrorKind::NotFound => "no such file".to_owned(),
        Err(error) => format!("cannot be read ({error})"),
    };
    let message =
        format!("{reason}; expected a log (CSV with the columns time_s, input, position)");
    Err(InputError::new(path, None, message))
}

/// Training logs, all at the longest of their sampling periods: what a slower one did between its samples
/// nobody knows.
///
/// # Errors
/// The first fault found in one of them.
pub fn read_train(paths: &[PathBuf]) -> Result<Vec<Log>, InputError> {
    let logs = paths
        .iter()
        .map(|path| Log::read(path))
        .collect::<Result<Vec<_>, _>>()?;
    let longest = logs.iter().map(|log| log.period_s).fold(0.0, f64::max);
    logs.into_iter().map(|log| log.at_period(longest)).collect()
}

/// Validation logs, at the sampling period of the training logs.
///
/// # Errors
/// The first fault found in one of them.
pub fn read_validate(paths: &[PathBuf], train: &[Log]) -> Result<Vec<Log>, InputError> {
    let period = train.first().map(|log| log.period_s);
    paths
        .iter()
        .map(|path| {
            let log = Log::read(path)?;
            period.map_or(Ok(log.clone()), |period| log.at_period(period))
        })
        .collect()
}
