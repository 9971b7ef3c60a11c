//! `cargo hil bench real`: the tracing on logs that other people measured on their machines.
//!
//! The logs are no part of the project ([`manifest`] names them and says what is known of each device); the
//! machine files are, written as a user of the device would. Each row is read and traced as
//! `cargo hil gap` does it, and its answer is held against what is known.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use serde::Serialize;
use serde_json::Value;

use self::judgement::{Answer, Judgement, Named, REFUSED, judge};
use self::manifest::{ROWS, Row};
use crate::failure::Failure;
use crate::gap::command::{read_train, read_validate};
use crate::gap::engine;
use crate::gap::outcome::{ErrorSet, Outcome, Resampled, Stages};
use crate::machine::Machine;
use crate::outputs::{Kind, Outputs, print};
use crate::quantity::significant;
use crate::workspace;

pub mod judgement;
pub mod manifest;

/// Where the logs are unless the call says otherwise, from the project's root.
pub const LOGS: &str = "../shared/data/real";

/// Where the machine files are, from the project's root.
const MACHINES: &str = "host-tests/machines/measured";

/// What `cargo hil bench real` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Directory of the measured logs, one directory a device; ../shared/data/real beside the project unless
    /// given
    #[arg(value_name = "DIR")]
    pub directory: Option<PathBuf>,
    /// Write the result to this file as JSON
    #[arg(long, value_name = "F")]
    pub json: Option<PathBuf>,
}

/// What became of one row. Pairs are before and after the effects, on the validation logs where there are
/// some; none where the logs were refused.
#[derive(Debug, Clone, Serialize)]
pub struct Judged {
    /// The device.
    pub log: String,
    /// What is known of it.
    pub known: String,
    /// The verdict's name, or `refused`.
    pub verdict: String,
    /// Ids of the effects that were named.
    pub effects: Vec<String>,
    /// Whether that is so.
    pub judged: Judgement,
    /// Norm of the torque residual over the norm of the torque.
    pub torque_rel: Option<[f64; 2]>,
    /// Position error of one replay without restarts, rms, rad or m.
    pub free_run_rms: Option<[f64; 2]>,
    /// Position error in windows, rms, rad or m.
    pub position_rms: Option<[f64; 2]>,
    /// What the errors are of: `validate` or `train`.
    pub errors_on: &'static str,
    /// The same effects with those that the log cannot tell from them, and their periods.
    pub named: Vec<Named>,
    /// Logs that were resampled on reading.
    pub resampled: Vec<Resampled>,
    /// Why the logs were refused.
    pub reason: Option<String>,
    /// Wall-clock seconds, reading and all.
    pub seconds: f64,
}

/// Traces all rows, prints the table, writes what was asked for.
///
/// # Errors
/// No directory of logs; a machine file of the project that is refused; a result that cannot be written.
pub fn run(args: &Args) -> Result<(), Failure> {
    let directory = match &args.directory {
        Some(directory) => directory.clone(),
        None => workspace::root().join(LOGS),
    };
    let mut outputs = Outputs::reading([&directory]);
    let json = outputs.file(args.json.as_deref(), Kind::Marked)?;
    if !directory.is_dir() {
        return Err(Failure::Usage(format!(
            "{}: no such directory; expected the measured logs, one directory for each of {}. They are not \
             part of the project: host-tests/src/real_benchmark/manifest.rs names them",
            directory.display(),
            ROWS.map(|row| row.log).join(", ")
        )));
    }
    // Hidden by itself where standard error is no terminal.
    let progress = ProgressBar::new_spinner();
    progress.enable_steady_tick(Duration::from_millis(100));
    let mut judged = Vec::new();
    for row in &ROWS {
        progress.set_message(row.log);
        judged.push(trace(row, &directory)?);
    }
    progress.finish_and_clear();
    outputs.stage_json(json, &judged)?;
    outputs.commit()?;
    print(&table(&judged))
}

/// Reads and traces one row's logs.
fn trace(row: &Row, directory: &Path) -> Result<Judged, Failure> {
    let started = Instant::now();
    let machine = machine(row)?;
    let paths = |names: &[&str]| -> Vec<PathBuf> {
        let inside = names.iter().map(|name| directory.join(row.log).join(name));
        inside.collect()
    };
    let traced = read_train(&paths(row.train), &mut Vec::new())
        .map_err(Failure::from)
        .and_then(|train| {
            let validate = || {
                Ok(read_validate(
                    &paths(row.validate),
                    &train,
                    &mut Vec::new(),
                )?)
            };
            engine::run(&machine, &train, validate, |_| ())
        });
    let seconds = started.elapsed().as_secs_f64();
    match traced {
        Ok(report) => Ok(judged(row, &report.outcome, seconds)),
        Err(failure) => Ok(Judged {
            log: row.log.to_owned(),
            known: row.known.to_owned(),
            verdict: REFUSED.to_owned(),
            effects: Vec::new(),
            judged: judge(row, &Answer::refused()),
            torque_rel: None,
            free_run_rms: None,
            position_rms: None,
            errors_on: "train",
            named: Vec::new(),
            resampled: Vec::new(),
            reason: Some(failure.to_string()),
            seconds,
        }),
    }
}

/// The row's machine file.
///
/// # Errors
/// A file that is refused: a fault of the project.
pub fn machine(row: &Row) -> Result<Machine, Failure> {
    Ok(Machine::read(
        &workspace::root().join(MACHINES).join(row.machine),
    )?)
}

fn judged(row: &Row, outcome: &Outcome, seconds: f64) -> Judged {
    let answer = Answer::of(verdict_name(outcome), outcome);
    let (errors_on, stages) = match &outcome.errors.validate {
        Some(validate) => ("validate", validate),
        None => ("train", &outcome.errors.train),
    };
    Judged {
        log: row.log.to_owned(),
        known: row.known.to_owned(),
        effects: outcome
            .effects
            .iter()
            .map(|effect| effect.id.clone())
            .collect(),
        judged: judge(row, &answer),
        torque_rel: Some(pair(stages, |set| set.torque_rel)),
        free_run_rms: Some(pair(stages, |set| set.free_run_rms)),
        position_rms: Some(pair(stages, |set| set.position_rms)),
        errors_on,
        verdict: answer.verdict,
        named: answer.named,
        resampled: outcome.resampled.clone(),
        reason: None,
        seconds,
    }
}

fn pair(stages: &Stages, pick: impl Fn(&ErrorSet) -> f64) -> [f64; 2] {
    [pick(&stages.before), pick(&stages.after)]
}

/// The verdict as the answer's JSON has it, so that one which is added there needs no word here.
fn verdict_name(outcome: &Outcome) -> String {
    let json = serde_json::to_value(outcome).unwrap_or_default();
    let verdict = json.get("verdict").and_then(Value::as_str);
    verdict.unwrap_or_default().to_owned()
}

fn table(rows: &[Judged]) -> String {
    let count = |judgement| rows.iter().filter(|row| row.judged == judgement).count();
    let mut text = format!(
        "Measured logs of {} machines: {} right, {} too little, {} wrong. Errors before and after the \
         effects.\n\n{:8} {:11} {:24} {:>19} {:>17} {:>19} {:>6}\n",
        rows.len(),
        count(Judgement::Right),
        count(Judgement::TooLittle),
        count(Judgement::Wrong),
        "log",
        "judged",
        "verdict",
        "position rms, mrad",
        "torque, %",
        "free run rms, rad",
        "s"
    );
    let both = |pair: Option<[f64; 2]>, factor: f64| {
        pair.map_or("–".to_owned(), |pair| {
            let [before, after] = pair.map(|value| significant(factor * value, 3));
            format!("{before} → {after}")
        })
    };
    for row in rows {
        // A String has no fault to report.
        let _ = writeln!(
            text,
            "{:8} {:11} {:24} {:>19} {:>17} {:>19} {:>6.1}",
            row.log,
            row.judged.name(),
            row.verdict,
            both(row.position_rms, 1e3),
            both(row.torque_rel, 100.0),
            both(row.free_run_rms, 1.0),
            row.seconds
        );
        let _ = writeln!(text, "         known: {}", row.known);
        let said: Vec<String> = row.named.iter().map(describe).collect();
        if !said.is_empty() {
            let _ = writeln!(text, "         said:  {}", said.join(", "));
        }
        if let Some(reason) = &row.reason {
            let _ = writeln!(text, "         {reason}");
        }
    }
    text
}

/// `cogging (7.0 a turn; or encoder_eccentricity)`
fn describe(named: &Named) -> String {
    let Some((id, equivalent)) = named.ids.split_first() else {
        return String::new();
    };
    let period = named
        .per_turn
        .map(|per_turn| format!("{} a turn", significant(per_turn, 3)));
    let others = (!equivalent.is_empty()).then(|| format!("or {}", equivalent.join(", ")));
    let notes: Vec<String> = period.into_iter().chain(others).collect();
    if notes.is_empty() {
        id.clone()
    } else {
        format!("{id} ({})", notes.join("; "))
    }
}
