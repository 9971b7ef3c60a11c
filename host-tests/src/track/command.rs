//! The command line of `cargo hil track`.

use std::io::{self, IsTerminal};
use std::path::PathBuf;

use indicatif::ProgressBar;

use super::outcome::{LogNumbers, Outcome};
use super::{figure, text};
use crate::error::{InputError, warn};
use crate::failure::Failure;
use crate::gap::numbers::Numbers;
use crate::log::Log;
use crate::machine::Machine;
use crate::outputs::{Kind, Outputs, print};

/// What `cargo hil track` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Machine file; the numbers that its `[fit]` names are fitted to each log, all others stay as they are
    #[arg(long, value_name = "M.toml")]
    pub machine: PathBuf,
    /// Logs of this machine in the order of time, CSV with time_s,input,position and, where measured, the other columns of `gap`
    #[arg(value_name = "LOG", required = true)]
    pub logs: Vec<PathBuf>,
    /// Say in how many logs a number reaches this value, SI; may be given several times. It is an upper limit if it is above the
    /// value of the first log, else a lower one. Without it: twice the first log where a number rises, half of it where it falls
    #[arg(long, value_name = "NAME=VALUE")]
    pub limit: Vec<String>,
    /// Write the result to this file as JSON
    #[arg(long, value_name = "F")]
    pub json: Option<PathBuf>,
    /// Write a page with a plot of each number to this directory
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// Fits the numbers to each log, lays a line through each of them, prints the answer, writes what was asked for.
///
/// # Errors
/// A wrong file or limit, before anything is written; or a result that cannot be written.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut outputs = Outputs::reading(args.logs.iter().chain([&args.machine]));
    let json = outputs.file(args.json.as_deref(), Kind::Marked)?;
    let page = outputs.directory(args.report.as_deref(), [("index.html", Kind::Marked)])?;
    let machine = Machine::read(&args.machine)?;
    if machine.fit.is_empty() {
        let message = "`[fit]` has no `parameters`, so there is nothing to track; name the numbers that may change, \
                       as parameters = [\"coulomb\", \"viscous\"]";
        return Err(InputError::new(&machine.path, None, message).into());
    }
    let limits = limits(&machine, &args.limit)?;
    let mut doubts = Vec::new();
    let logs = read(&args.logs, &mut doubts)?;
    let outcome = Outcome::new(&machine, numbers(&machine, &logs)?, &limits);
    check_any(&outcome, &machine)?;
    warn(&doubts);
    warn(&left_out(&outcome));
    outputs.stage_json(json, &outcome)?;
    if let Some([page]) = page {
        let drawn = figure::page(&outcome, &machine)
            .map_err(|error| Failure::system("the report", &error))?;
        outputs.stage(page, drawn)?;
    }
    outputs.commit()?;
    print(&text::render(&outcome, &machine))
}

/// The limits of `--limit`.
fn limits(machine: &Machine, given: &[String]) -> Result<Vec<(String, f64)>, Failure> {
    let mut limits: Vec<(String, f64)> = Vec::new();
    for limit in given {
        let number = limit.split_once('=').and_then(|(name, value)| {
            let value: f64 = value.trim().parse().ok()?;
            value.is_finite().then(|| (name.trim().to_owned(), value))
        });
        let Some((name, value)) = number else {
            return Err(Failure::Usage(format!(
                "--limit {limit}: expected a number's name and its value in SI units, as coulomb=0.2"
            )));
        };
        if !machine.fits(&name) {
            return Err(Failure::Usage(format!(
                "--limit {limit}: [fit] of the machine file does not name `{name}`; expected one of {}",
                machine.fit.join(", ")
            )));
        }
        if limits.iter().any(|(known, _)| *known == name) {
            return Err(Failure::Usage(format!(
                "--limit {limit}: `{name}` has a limit already; give one for each number"
            )));
        }
        limits.push((name, value));
    }
    Ok(limits)
}

/// The logs, each of them once.
fn read(paths: &[PathBuf], doubts: &mut Vec<InputError>) -> Result<Vec<Log>, InputError> {
    let mut logs: Vec<Log> = Vec::new();
    for path in paths {
        let log = Log::read_with_doubts(path, doubts)?;
        if let Some(seen) = logs.iter().find(|seen| seen.repeats(&log)) {
            let message = format!(
                "has the samples of the log {}; expected each log once",
                seen.path.display()
            );
            return Err(InputError::new(path, None, message));
        }
        logs.push(log);
    }
    Ok(logs)
}

/// Each log's numbers.
fn numbers(machine: &Machine, logs: &[Log]) -> Result<Vec<LogNumbers>, Failure> {
    let progress = if io::stderr().is_terminal() {
        ProgressBar::new(logs.len() as u64)
    } else {
        ProgressBar::hidden()
    };
    let of = |log: &Log| {
        progress.set_message(format!("{}", log.path.display()));
        let numbers = Numbers::of(machine, log)?;
        progress.inc(1);
        Ok(LogNumbers::new(log.path.display().to_string(), numbers))
    };
    let numbers = logs.iter().map(of).collect();
    progress.finish_and_clear();
    numbers
}

/// Refuses logs none of which belongs to the machine file.
fn check_any(outcome: &Outcome, machine: &Machine) -> Result<(), InputError> {
    if outcome.logs.iter().any(|log| log.disagreement.is_empty()) {
        return Ok(());
    }
    let first = outcome.logs.iter().flat_map(|log| &log.disagreement).next();
    let why = first.map_or(String::new(), |it| format!(": {}; {}", it.what, it.remedy));
    let message = format!("no log belongs to this machine file{why}");
    Err(InputError::new(&machine.path, None, message))
}

/// The logs that were left out, each with why.
fn left_out(outcome: &Outcome) -> Vec<InputError> {
    let of = |log: &LogNumbers| {
        let first = log.disagreement.first()?;
        let message = format!(
            "is left out, log and machine file do not belong together: {}; {}",
            first.what, first.remedy
        );
        Some(InputError::new(log.log.as_ref(), None, message))
    };
    outcome.logs.iter().filter_map(of).collect()
}
