//! `cargo hil reproduce`: the results of a paper, ours beside them.

use std::path::PathBuf;

use clap::ValueEnum;
use serde::Serialize;

use crate::failure::Failure;

pub mod bench;
pub mod prognostics;
pub mod throttle;

/// What `cargo hil reproduce` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Whose results
    pub paper: Paper,
    /// Write the results to this file as JSON
    #[arg(long, value_name = "F")]
    pub json: Option<PathBuf>,
    /// Throttle only: repeat it on so many stands more, with other noise and other test signals
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub repeat: u64,
    /// Bench only: trace the two open residuals at the widest backlash alone, in a fifth of the time
    #[arg(long)]
    pub short: bool,
}

/// A paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Paper {
    /// A test bench with a synchronous motor, a brake and adjustable backlash: maps, stick-slip
    Bench,
    /// Friction of an electromechanical actuator by simulated annealing: campaign, alerts, methods
    Prognostics,
    /// A throttle for hardware-in-the-loop simulation: identification, PWA model, error tables
    Throttle,
}

/// One result. A number that there is none of is null in JSON.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Entry {
    /// What it is.
    pub what: String,
    /// In the paper.
    pub paper: Option<f64>,
    /// Here.
    pub ours: f64,
    /// What would be right, where that is known.
    pub truth: Option<f64>,
    /// Its unit; empty for a plain number.
    pub unit: String,
}

/// An entry of the JSON.
fn entry(what: &str, paper: Option<f64>, ours: f64, truth: Option<f64>, unit: &str) -> Entry {
    Entry {
        what: what.to_owned(),
        paper,
        ours,
        truth,
        unit: unit.to_owned(),
    }
}

/// Reproduces a paper, prints a table, writes what was asked for.
///
/// # Errors
/// What is missing on this machine, or what is not in order with the run.
pub fn run(args: &Args) -> Result<(), Failure> {
    if args.repeat > 0 && args.paper != Paper::Throttle {
        let message = "--repeat is for `reproduce throttle` alone; leave it out";
        return Err(Failure::Usage(message.to_owned()));
    }
    if args.short && args.paper != Paper::Bench {
        let message = "--short is for `reproduce bench` alone; leave it out";
        return Err(Failure::Usage(message.to_owned()));
    }
    match args.paper {
        Paper::Bench => bench::run(args.json.as_deref(), args.short),
        Paper::Prognostics => prognostics::run(args.json.as_deref()),
        Paper::Throttle => throttle::run(args.json.as_deref(), args.repeat),
    }
}
