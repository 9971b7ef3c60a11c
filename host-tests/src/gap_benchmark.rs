//! `cargo hil bench gap`: how often the tracing is right.
//!
//! Rigs in `f64` play machines with an effect that nobody declared, with two, with one that is not in
//! the catalogue, with none, or with a wrong number in their machine file. Each log is traced as a
//! user would do it, and the answer is held against the truth. The tracing itself knows nothing of
//! this; its limits were chosen on other motions, seeds and noise. The same logs are given to a
//! stepwise regression on accelerations, as SINDy and FROLS do it. With `--worlds`, machines, laws, loops,
//! sensors and loggers are drawn at random instead ([`worlds`]).

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Instant;

use indicatif::ProgressBar;
use rayon::prelude::*;
use serde::Serialize;

use self::cases::{Case, Extent, Group};
use self::judgement::{Answer, Judgement, Truth};
use crate::failure::Failure;
use crate::gap::engine::Found;
use crate::gap::outcome::Outcome;
use crate::gap::{declared, engine};
use crate::log::Log;
use crate::machine::Machine;
use crate::outputs::{Kind, Outputs, print, write_own};
use crate::workspace;

pub mod cases;
pub mod judgement;
mod report;
pub mod stepwise;
mod summary;
pub mod truth;
pub mod worlds;

/// What `cargo hil bench gap` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Write the result to this file as JSON
    #[arg(long, value_name = "F")]
    pub json: Option<PathBuf>,
    /// One seed instead of several: a first impression within a minute or two
    #[arg(long)]
    pub quick: bool,
    /// Seed of the first log; the others follow. Of another one, other motions, noise and wrong numbers.
    /// With --worlds: other worlds, 1 unless it is given
    #[arg(long, value_name = "S")]
    pub seed: Option<u64>,
    /// Judge on this many worlds drawn at random instead: other machines, laws, loops, sensors and loggers
    #[arg(long, value_name = "N", conflicts_with = "quick")]
    pub worlds: Option<u64>,
    /// Trace the world of this index alone, print what it is and leave its files in target/hil/worlds
    #[arg(long, value_name = "INDEX", requires = "worlds")]
    pub only: Option<u64>,
    /// Trace each world twice more, with other guesses for the fitted numbers (a third of to three times the truth),
    /// and count the answers that stay
    #[arg(long, requires = "worlds", conflicts_with = "only")]
    pub guesses: bool,
}

/// A fitted number beside the truth.
#[derive(Debug, Clone, Serialize)]
pub struct Deviation {
    /// Its name in the answer.
    pub name: String,
    /// (estimate − truth) / standard deviation.
    pub deviation: f64,
    /// The same over the truth.
    pub relative: f64,
}

/// One traced log.
#[derive(Debug, Clone, Serialize)]
pub struct Traced {
    /// What was traced.
    #[serde(flatten)]
    pub case: Case,
    /// What the tracing said.
    pub answer: Answer,
    /// Whether that is so.
    pub judgement: Judgement,
    /// What the regression said.
    pub stepwise: Answer,
    /// Whether that is so.
    pub stepwise_judgement: Judgement,
    /// Windowed position error after over before, where an effect was found.
    pub after_over_before: Option<f64>,
    /// Windowed position error after, over that of a fit that was told the true effect.
    pub after_over_oracle: Option<f64>,
    /// Fitted numbers of a right answer beside what they should be.
    pub deviations: Vec<Deviation>,
    /// p-values of all that was refitted where there is nothing to be found.
    pub chances: Vec<f64>,
    /// Wall-clock seconds of the tracing, beside others.
    pub seconds: f64,
}

/// Runs the benchmark, prints the tables, leaves a report, writes what was asked for.
///
/// # Errors
/// A result that cannot be written; a rig's machine or log that is refused.
pub fn run(args: &Args) -> Result<(), Failure> {
    if let Some(count) = args.worlds {
        return worlds::run(&worlds::Args {
            count,
            seed: args.seed.unwrap_or(worlds::FIRST_SEED),
            only: args.only,
            guesses: args.guesses,
            json: args.json.clone(),
        });
    }
    let directory = workspace::results().join("bench-gap");
    let mut outputs = Outputs::reading([]);
    outputs.fills(&directory);
    let json = outputs.file(args.json.as_deref(), Kind::Marked)?;
    let started = Instant::now();
    let extent = if args.quick {
        Extent::Quick
    } else {
        Extent::Full
    };
    let cases = cases::all(extent, args.seed.unwrap_or(cases::FIRST_SEED));
    // Hidden by itself where standard error is no terminal.
    let progress = ProgressBar::new(cases.len() as u64);
    let traced = trace_all(&cases, &directory, || progress.inc(1));
    progress.finish_and_clear();
    let traced = traced?;
    let summary = summary::Summary::of(&traced);
    let page = directory.join("index.html");
    let html = report::html(&summary).map_err(|error| Failure::system("the report", &error))?;
    write_own(&page, html)?;
    let value = serde_json::json!({"summary": summary, "logs": traced});
    outputs.stage_json(json, &value)?;
    outputs.commit()?;
    let mut text = summary.text();
    text += &format!(
        "\n{} logs in {:.0} s\nreport   {}\n",
        traced.len(),
        started.elapsed().as_secs_f64(),
        workspace::shown(&page)
    );
    print(&text)
}

/// Traces every case, several at once. Machine files are left in `directory`.
///
/// # Errors
/// A machine file that cannot be written; a machine or a log that is refused.
pub fn trace_all(
    cases: &[Case],
    directory: &Path,
    done: impl Fn() + Sync,
) -> Result<Vec<Traced>, Failure> {
    // Equal files are written once, so that no reader meets half of one.
    let machines = Mutex::new(());
    cases
        .par_iter()
        .map(|case| {
            let machine = {
                let _one_at_a_time = machines.lock().unwrap_or_else(|held| held.into_inner());
                case.machine_file(directory)?
            };
            let traced = trace(case, &machine)?;
            done();
            Ok(traced)
        })
        .collect()
}

fn trace(case: &Case, machine: &Machine) -> Result<Traced, Failure> {
    let log = case.log();
    let train = [log];
    let started = Instant::now();
    let found = engine::trace(machine, &train, || Ok(Vec::new()), |_| ())?.found()?;
    let seconds = started.elapsed().as_secs_f64();
    let outcome = &found.report.outcome;
    let answer = Answer::of(outcome);
    let stepwise = stepwise::answer(machine, &train[0]);
    let errors = &outcome.errors.train;
    let says_something = !outcome.effects.is_empty() || outcome.unknown.is_some();
    let truth = Truth::of(case);
    let judgement = judgement::judge(&truth, &answer);
    Ok(Traced {
        stepwise_judgement: judgement::judge(&truth, &stepwise),
        after_over_before: says_something.then(|| errors.remaining()),
        after_over_oracle: oracle(case, machine, &train, &found)?,
        deviations: if judgement == Judgement::Right {
            deviations(case, outcome)
        } else {
            Vec::new()
        },
        chances: if case.group == Group::Clean {
            let refitted = outcome.candidates.iter();
            refitted.filter_map(|look| look.p_value).collect()
        } else {
            Vec::new()
        },
        case: case.clone(),
        answer,
        judgement,
        stepwise,
        seconds,
    })
}

/// The error over that of the declared model with the true effects, everything refitted from the
/// truth. `None` where the catalogue cannot say the truth.
fn oracle(
    case: &Case,
    machine: &Machine,
    train: &[Log],
    found: &Found,
) -> Result<Option<f64>, Failure> {
    let mut model = declared::model(machine)?;
    for effect in &case.effects {
        let Some(active) = truth::active(effect, &case.rig) else {
            return Ok(None);
        };
        if model.effects.push(active).is_err() {
            return Ok(None);
        }
    }
    let error = engine::refitted_error(machine, train, found.settings, &model)?;
    let after = found.report.outcome.errors.train.after.position_rms;
    Ok((error > 0.0).then_some(after / error))
}

/// What the answer says and the rig knows.
fn deviations(case: &Case, outcome: &Outcome) -> Vec<Deviation> {
    let effects = outcome.effects.iter().flat_map(|found| &found.parameters);
    let estimates = effects
        .map(|estimate| (estimate.name.as_str(), estimate.value, Some(estimate.std)))
        .chain(
            outcome
                .fit
                .iter()
                .map(|fit| (fit.name.as_str(), fit.fitted, fit.std)),
        );
    let truths = truth::numbers(case);
    estimates
        .filter_map(|(name, value, std)| {
            let (_, truth) = truths.iter().find(|(known, _)| *known == name)?;
            let std = std.filter(|std| std.is_finite() && *std > 0.0)?;
            Some(Deviation {
                name: name.to_owned(),
                deviation: (value - truth) / std,
                relative: (value - truth) / truth,
            })
        })
        .collect()
}
