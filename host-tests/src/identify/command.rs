//! The command line of `cargo hil identify`.

use std::path::PathBuf;

use model_core::identify::characteristic::{Direction, Kind, Side};
use serde_json::{Value, json};

use super::table::{self, Validation};
use super::{Identified, Series, Start, figure, identify, machine_file, page, verdict};
use crate::error::{InputError, warn};
use crate::failure::Failure;
use crate::free_run::Errors;
use crate::log::Log;
use crate::machine::Machine;
use crate::outputs::{self, MARK, Output, Outputs, print};

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
    /// Write a page with the answer and the plot of the characteristic (index.html), that plot alone, and a machine
    /// file of each model to this directory
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// Identifies the machine, prints the table, writes what was asked for.
///
/// # Errors
/// A wrong file, before anything is written; or a result that cannot be written.
pub fn run(args: &Args) -> Result<(), Failure> {
    let inputs = [&args.machine, &args.slow, &args.fast];
    let mut outputs = Outputs::reading(inputs.into_iter().chain(&args.validate));
    let machine_out = outputs.file(args.machine_out.as_deref(), outputs::Kind::Marked)?;
    let json = outputs.file(args.json.as_deref(), outputs::Kind::Marked)?;
    let files = REPORT.map(|name| (name, outputs::Kind::Marked));
    let files = outputs.directory(args.report.as_deref(), files)?;
    let start = Start::new(Machine::read(&args.machine)?)?;
    let mut doubts = Vec::new();
    let mut read = |path: &PathBuf| Log::read_with_doubts(path, &mut doubts);
    let (slow, fast) = (read(&args.slow)?, read(&args.fast)?);
    let identified = identify(&start, &slow, &fast)?;
    let validation = match &args.validate {
        Some(path) => Some(validate(&identified, &read(path)?)?),
        None => None,
    };
    warn(&doubts);
    let machine = &start.machine;
    if let Some(machine_out) = machine_out {
        let note = if identified.polished.is_some() {
            "six numbers polished on both logs"
        } else {
            "lines and b0"
        };
        let text = machine_file::text(machine, &identified.best().parameters, note);
        outputs.stage(machine_out, text)?;
    }
    outputs.stage_json(json, &outcome(machine, &identified, validation.as_ref()))?;
    let mut text = table::render(machine, &identified, validation.as_ref());
    text += &verdict::text(args, machine, &identified, validation.as_ref());
    if let Some(files) = files {
        report(&mut outputs, files, (machine, &text), &identified, &slow)?;
    }
    outputs.commit()?;
    print(&text)
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

/// What a report's directory holds: the page, the plot, and a machine file of each model.
const REPORT: [&str; 5] = [
    "index.html",
    "characteristic.svg",
    "reduced.toml",
    "full.toml",
    "polished.toml",
];

fn report(
    outputs: &mut Outputs,
    [index, plot, files @ ..]: [Output; REPORT.len()],
    (machine, text): (&Machine, &str),
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
    outputs.stage(plot, format!("<!-- {MARK} -->\n{svg}"))?;
    outputs.stage(index, page::html(machine, text, svg))?;
    let mut models = table::models(identified).into_iter();
    for file in files {
        match models.next() {
            Some((name, model)) => {
                outputs.stage(file, machine_file::text(machine, &model.parameters, name))?;
            }
            // A report without this model keeps none from before.
            None => outputs.stage_removal(file),
        }
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
