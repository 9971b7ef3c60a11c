//! The command line of `cargo hil identify`.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use model_core::identify::characteristic::{Direction, Kind, Side};
use serde_json::{Value, json};

use super::table::{self, Validation};
use super::{Identified, Series, Start, figure, identify, machine_file};
use crate::error::InputError;
use crate::failure::Failure;
use crate::free_run::Errors;
use crate::log::Log;
use crate::machine::Machine;
use crate::whole_file;

/// What `cargo hil identify` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Machine file to start from: the winding, the stops and the spring's rest are believed, inertia
    /// and damping need their order of magnitude
    #[arg(long, value_name = "START.toml")]
    pub machine: PathBuf,
    /// Log of a slow triangle that reverses at several places of the stroke
    #[arg(long, value_name = "TRIANGLE.csv")]
    pub slow: PathBuf,
    /// Log of a fast multi-step signal
    #[arg(long, value_name = "APRTS.csv")]
    pub fast: PathBuf,
    /// A log to judge the models on, opened once at the end
    #[arg(long, value_name = "V.csv")]
    pub validate: Option<PathBuf>,
    /// Write the best model, with the full motor, to this machine file
    #[arg(long, value_name = "M.toml")]
    pub machine_out: Option<PathBuf>,
    /// Write the result to this file as JSON
    #[arg(long, value_name = "F")]
    pub json: Option<PathBuf>,
    /// Write the plot of the characteristic and a machine file of each model to this directory
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// Identifies the machine, prints the table, writes what was asked for.
///
/// # Errors
/// A wrong file, before anything is written; or a result that cannot be written.
pub fn run(args: &Args) -> Result<(), Failure> {
    whole_file::check_place(args.json.as_deref())?;
    whole_file::check_directory(args.report.as_deref())?;
    let inputs = [&args.machine, &args.slow, &args.fast];
    whole_file::check_apart(
        args.json.iter().chain(&args.machine_out),
        inputs.into_iter().chain(&args.validate),
    )?;
    let start = Start::new(Machine::read(&args.machine)?)?;
    let (slow, fast) = (Log::read(&args.slow)?, Log::read(&args.fast)?);
    let identified = identify(&start, &slow, &fast)?;
    let validation = match &args.validate {
        Some(path) => Some(validate(&identified, &Log::read(path)?)?),
        None => None,
    };
    let machine = &start.machine;
    if let Some(path) = &args.machine_out {
        let note = if identified.polished.is_some() {
            "six numbers polished on both logs"
        } else {
            "lines and b0"
        };
        let text = machine_file::text(machine, &identified.best().parameters, note);
        write(path, &text)?;
    }
    if let Some(path) = &args.json {
        let value = outcome(machine, &identified, validation.as_ref());
        whole_file::write_json(path, &value)
            .map_err(|error| Failure::system(path.display(), &error))?;
    }
    if let Some(directory) = &args.report {
        report(directory, machine, &identified, &slow)?;
    }
    let text = table::render(machine, &identified, validation.as_ref());
    io::stdout()
        .write_all(text.as_bytes())
        .map_err(|error| Failure::system("standard output", &error))
}

/// Free runs of every model over the validation log.
fn validate(identified: &Identified, log: &Log) -> Result<Validation, InputError> {
    let series = Series::of(log);
    table::models(identified)
        .into_iter()
        .map(|(_, model)| series.free_run(&model.parameters))
        .collect::<Result<_, _>>()
        .map_err(|message| InputError::new(&log.path, None, message))
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    whole_file::write(path, |partial| fs::write(partial, text))
        .map_err(|error| Failure::system(path.display(), &error))
}

fn report(
    directory: &Path,
    machine: &Machine,
    identified: &Identified,
    slow: &Log,
) -> Result<(), Failure> {
    let mut slow = Series::of(slow);
    // The lines are those of a machine that a positive input opens.
    for input in &mut slow.input {
        *input *= machine.gain.signum() as f32;
    }
    let units = [machine.coordinate.unit(), "V"];
    let svg = figure::draw(&slow, &identified.characteristic, units)
        .map_err(|error| Failure::system("the plot", &error))?;
    fs::create_dir_all(directory).map_err(|error| Failure::system(directory.display(), &error))?;
    write(&directory.join("characteristic.svg"), &svg)?;
    let files = ["reduced.toml", "full.toml", "polished.toml"];
    for (file, (name, model)) in files.iter().zip(table::models(identified)) {
        let text = machine_file::text(machine, &model.parameters, name);
        write(&directory.join(file), &text)?;
    }
    Ok(())
}

/// The JSON: the numbers in the order of the table, each model's errors, the lines.
fn outcome(machine: &Machine, identified: &Identified, validation: Option<&Validation>) -> Value {
    let models: Vec<Value> = table::models(identified)
        .into_iter()
        .enumerate()
        .map(|(index, (name, model))| {
            let numbers: Vec<Value> = table::NUMBERS
                .into_iter()
                .zip(model.numbers.all())
                .map(|((symbol, _, unit), number)| {
                    json!({"name": symbol, "value": number.value,
                           "half_width_95": number.half_width,
                           "unit": table::unit(unit, machine)})
                })
                .collect();
            let validated: Option<Errors> = validation.map(|errors| errors[index]);
            json!({"model": name, "numbers": numbers, "errors":
                   {"slow": model.errors.slow, "fast": model.errors.fast, "validate": validated}})
        })
        .collect();
    let lines: Vec<Value> = identified
        .characteristic
        .branches
        .iter()
        .map(|branch| {
            let kind = match branch.kind {
                Kind::Uniform => "uniform",
                Kind::Breakaway => "breakaway",
                Kind::Standstill => "standstill",
            };
            let direction = match branch.direction {
                Direction::Opening => "opening",
                Direction::Closing => "closing",
            };
            let side = match branch.side {
                Side::Below => "below_rest",
                Side::Above => "above_rest",
            };
            json!({"kind": kind, "direction": direction, "side": side,
                   "slope": branch.line.slope, "input_at_centre": branch.line.level,
                   "centre": branch.line.centre, "inliers": branch.line.inliers,
                   "points": branch.line.points})
        })
        .collect();
    json!({"machine": machine.name, "models": models, "lines": lines,
           "simulations": identified.simulations, "warnings": identified.warnings})
}
