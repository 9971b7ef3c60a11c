//! The command line of `cargo hil gap`.

use std::fs;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use super::engine::Answer;
use super::experiment::{self, Plan};
use super::outcome::Report;
use super::table::Detail;
use super::{engine, machine_out, report, table};
use crate::error::{InputError, one_line, warn};
use crate::failure::Failure;
use crate::log::Log;
use crate::machine::Machine;
use crate::outputs::{Kind, Output, Outputs};

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
    /// Write a report with plots to this directory; where the logs leave something in doubt, an input that would settle
    /// it is looked for too, as by --experiment
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Where the logs leave something in doubt, look for an input that would settle it, which may take minutes, and
    /// write it, if there is one, to this file, CSV with time_s,input; with --report, it goes into the report's
    /// directory too
    #[arg(long, value_name = "FILE")]
    pub experiment: Option<PathBuf>,
    /// Write the machine file with what was found to this file: your file with its comments, fitted numbers
    /// where it declares them, each with what it was and its 95 % interval, and found effects among
    /// declared_effects. Not written where nothing is proven, or log and machine file disagree
    #[arg(long, value_name = "M2.toml")]
    pub machine_out: Option<PathBuf>,
    /// Print every number too: errors, effects, fitted numbers, what was refused and why
    #[arg(long)]
    pub verbose: bool,
}

/// Where the numbers are that the answer for people leaves out.
fn hint(args: &Args) -> String {
    let plots = match &args.report {
        Some(directory) => {
            let page = directory.join("index.html");
            format!("Plots: {}.", one_line(&page.display().to_string()))
        }
        None => "With plots: --report DIR.".to_owned(),
    };
    let program = match &args.json {
        Some(_) => "",
        None => " To read by a program: --json FILE.",
    };
    format!("All numbers: --verbose. {plots}{program}")
}

/// The next experiment's input in the report's directory.
const NEXT_EXPERIMENT: &str = "next-experiment.csv";

/// Finds the effects that the declared machine lacks, prints the answer, writes what was asked for.
///
/// # Errors
/// A wrong file, before anything is written; or a result that cannot be written.
pub fn run(args: &Args) -> Result<(), Failure> {
    let logs = args.train.iter().chain(&args.validate);
    let mut outputs = Outputs::reading(logs.chain([&args.machine]));
    let places = Places::of(args, &mut outputs)?;
    let (machine, source) = Machine::read_with_text(&args.machine)?;
    let mut doubts = Vec::new();
    let train = read_train(&args.train, &mut doubts)?;
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
    progress.set_style(spinner());
    progress.set_message("fitting the numbers of [fit], then looking for effects");
    let result = engine::trace(
        &machine,
        &train,
        || Ok(read_validate(&args.validate, &train, &mut doubts)?),
        |message| progress.set_message(message.to_owned()),
    )
    .and_then(|answer| results(args, (&machine, &source), &train, answer, &progress));
    progress.finish_and_clear();
    let results = result?;
    warn(&doubts);
    let input = results.input.as_deref();
    places.stage(&mut outputs, &results)?;
    outputs.commit()?;
    let mut out = io::stdout();
    let hint = hint(args);
    let detail = if args.verbose {
        Detail::Verbose
    } else {
        Detail::Brief { hint: Some(&hint) }
    };
    let mut text = table::render(&results.report, out.is_terminal(), detail);
    if let Some(path) = &args.experiment
        && input.is_none()
    {
        text += &format!(
            "\nThere is no experiment to propose: {} was not written.\n",
            path.display()
        );
    }
    if let Some(path) = &args.machine_out
        && let Some(reason) = machine_out::refusal(results.report.outcome.verdict)
    {
        let earlier = if path.is_file() {
            "; what is there is of an earlier run"
        } else {
            ""
        };
        let path = path.display();
        text += &format!("\n{path} was not written: {reason}{earlier}.\n");
    }
    out.write_all(text.as_bytes())
        .map_err(|error| Failure::system("standard output", &error))
}

/// What is shown while it works: how long it has, and at what it is.
fn spinner() -> ProgressStyle {
    ProgressStyle::with_template("{spinner} {elapsed} {msg}")
        .unwrap_or_else(|_| ProgressStyle::default_spinner())
}

/// Where the results go, as far as they were asked for.
struct Places {
    json: Option<Output>,
    experiment: Option<Output>,
    machine_out: Option<Output>,
    report: Option<[Output; 2]>,
}

impl Places {
    /// Those that the user named.
    ///
    /// # Errors
    /// What [`Outputs::file`] and [`Outputs::directory`] refuse.
    fn of(args: &Args, outputs: &mut Outputs) -> Result<Self, Failure> {
        Ok(Self {
            json: outputs.file(args.json.as_deref(), Kind::Marked)?,
            experiment: outputs.file(args.experiment.as_deref(), Kind::Input)?,
            machine_out: outputs.file(args.machine_out.as_deref(), Kind::Marked)?,
            report: outputs.directory(
                args.report.as_deref(),
                [("index.html", Kind::Marked), (NEXT_EXPERIMENT, Kind::Input)],
            )?,
        })
    }

    /// Prepares every result that has a place.
    ///
    /// # Errors
    /// What the file system reports; a report that cannot be drawn.
    fn stage(self, outputs: &mut Outputs, results: &Results) -> Result<(), Failure> {
        outputs.stage_json(self.json, &results.report.outcome)?;
        if let (Some(experiment), Some(input)) = (self.experiment, &results.input) {
            outputs.stage(experiment, input.as_str())?;
        }
        if let (Some(machine_out), Some(machine)) = (self.machine_out, &results.machine) {
            outputs.stage(machine_out, machine.as_str())?;
        }
        if let Some([page, next_experiment]) = self.report {
            match &results.input {
                Some(input) => outputs.stage(next_experiment, input.as_str())?,
                // A report without one keeps none from before.
                None => outputs.stage_removal(next_experiment),
            }
            let text = report::page(&results.report)
                .map_err(|error| Failure::system("the report", &error))?;
            outputs.stage(page, text)?;
        }
        Ok(())
    }
}

/// What is shown and written.
struct Results {
    report: Report,
    /// The next experiment's input, CSV.
    input: Option<String>,
    /// The machine file with what was found.
    machine: Option<String>,
}

/// What an answer gives. `declared`: the machine and the text of its file.
///
/// # Errors
/// What the next experiment or the machine file cannot be made of.
fn results(
    args: &Args,
    declared: (&Machine, &str),
    train: &[Log],
    answer: Answer,
    progress: &ProgressBar,
) -> Result<Results, Failure> {
    let found = match answer {
        Answer::Found(found) => found,
        Answer::Disagree(report) => {
            return Ok(Results {
                report: *report,
                input: None,
                machine: None,
            });
        }
    };
    let (machine, source) = declared;
    let mut next = if args.experiment.is_some() || args.report.is_some() {
        progress.set_message("looking for the next experiment, which may take minutes");
        experiment::next(machine, train, &found)?
    } else {
        experiment::doubt(machine, train, &found)?
    };
    let refitted = match &args.machine_out {
        Some(_) if machine_out::refusal(found.report.outcome.verdict).is_none() => {
            Some(machine_out::text(source, machine, &args.train, &found)?)
        }
        _ => None,
    };
    let input = next.as_ref().and_then(|next| next.plan.as_ref());
    let input = input.map(Plan::to_csv);
    if let (Some(next), Some(_)) = (&mut next, &input) {
        next.file = experiment_file(args);
    }
    let mut report = found.report;
    report.has_page = args.report.is_some();
    report.outcome.next_experiment = next;
    let written = refitted.as_ref().and(args.machine_out.as_ref());
    report.outcome.machine_out = written.map(|file| file.display().to_string());
    Ok(Results {
        report,
        input,
        machine: refitted,
    })
}

/// The file of the next experiment's input, as the user would name it.
fn experiment_file(args: &Args) -> Option<String> {
    let beside = args.report.as_ref();
    let beside = beside.map(|directory| directory.join(NEXT_EXPERIMENT));
    let file = args.experiment.as_ref().or(beside.as_ref())?;
    Some(file.display().to_string())
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
/// nobody knows. What can hardly be so in them is added to `doubts`.
///
/// # Errors
/// The first fault found in one of them.
pub fn read_train(paths: &[PathBuf], doubts: &mut Vec<InputError>) -> Result<Vec<Log>, InputError> {
    let logs = paths
        .iter()
        .map(|path| Log::read_with_doubts(path, doubts))
        .collect::<Result<Vec<_>, _>>()?;
    let longest = logs.iter().map(|log| log.period_s).fold(0.0, f64::max);
    logs.into_iter().map(|log| log.at_period(longest)).collect()
}

/// Validation logs, at the sampling period of the training logs; `doubts` as for [`read_train`].
///
/// # Errors
/// The first fault found in one of them.
pub fn read_validate(
    paths: &[PathBuf],
    train: &[Log],
    doubts: &mut Vec<InputError>,
) -> Result<Vec<Log>, InputError> {
    paths
        .iter()
        .map(|path| {
            let log = Log::read_with_doubts(path, doubts)?;
            match train.first() {
                Some(first) => log.at_period_of(first),
                None => Ok(log),
            }
        })
        .collect()
}
