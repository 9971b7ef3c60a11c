//! The prognostics paper: *A New Prognostic Method based on Simulated Annealing Algorithm to deal with
//! the Effects of Dry Friction on Electromechanical Actuators*.
//!
//! Its one result, 0.7352 N·m found where a brake gives 0.779 N·m, becomes a campaign with error
//! statistics; then its alerts, the life that is left, and whether annealing was needed.

use std::fs;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::time::Instant;

use model_core::numeric::invalid_parameter::InvalidParameter;

use self::calibration::Calibration;
use self::campaign::Case;
use self::detection::{Detection, Life};
use self::estimate::{Estimate, Options};
use self::stand::{Friction, Input, Recorded, Stand};
use crate::failure::Failure;
use crate::{whole_file, workspace};

pub mod anti_windup;
pub mod calibration;
pub mod campaign;
pub mod command_file;
pub mod detection;
pub mod estimate;
pub mod methods;
pub mod presumptions;
mod report;
pub mod servo;
pub mod stand;
pub mod statistics;
mod tables;

/// The external file of the campaign: what a surface is asked for on an approach.
pub const COMMAND: &str = "host-tests/commands/approach.csv";

/// What the paper found, N·m.
pub const PAPER: f64 = 0.7352;

/// Where its brake gave this, N·m: a share 11/24 of 1.7, which is 0.779.
pub const PAPER_TRUTH: f64 = 0.779;

/// What it calls its accuracy.
pub const PAPER_ERROR: f64 = 0.056;

/// Seed of the calibration and of the paper's case.
const SEED: u64 = 1;

/// Benches of the campaign for each level and input.
const SEEDS: u64 = 10;

/// Healthy logs that the threshold is learnt from.
const HEALTHY: usize = 100;

/// Actuators that wear.
const LIVES: u64 = 8;

/// Benches on which the methods are compared, each at every level.
const COMPARED: u64 = 3;

/// The paper's case: a sweep, the brake at 11 V.
#[derive(Debug, Clone)]
pub struct PaperCase {
    /// The log.
    pub log: Recorded,
    /// Its friction.
    pub truth: Friction,
    /// One number, by annealing and golden section.
    pub estimate: Estimate,
    /// The same by the paper's objective, one free run over the log.
    pub free_run: Estimate,
}

/// The paper's case, on a bench of its own.
///
/// # Errors
/// What the core refuses.
pub fn paper_case(
    stand: &Stand,
    calibration: &Calibration,
    seed: u64,
) -> Result<PaperCase, InvalidParameter> {
    let truth = Friction::drawn(PAPER_TRUTH, seed);
    let log = stand.record(Input::Sweep, truth, seed)?;
    let find =
        |options: &Options| estimate::one(&calibration.after, &log.log(false), options, seed);
    let free_run = Options {
        window: None,
        ..Options::default()
    };
    Ok(PaperCase {
        truth,
        estimate: find(&Options::default())?,
        free_run: find(&free_run)?,
        log,
    })
}

/// Everything that is shown.
pub(crate) struct Results {
    calibration: Calibration,
    case: PaperCase,
    cases: Vec<Case>,
    methods: Vec<methods::Result>,
    detection: Detection,
    lives: Vec<Life>,
    seconds: f64,
}

/// Runs everything, prints the tables, leaves the report and the paper's case in
/// `target/hil/prognostics`.
///
/// # Errors
/// A file that cannot be read or written; a log from which nothing follows.
pub fn run(json: Option<&Path>) -> Result<(), Failure> {
    let directory = workspace::results().join("prognostics");
    fs::create_dir_all(&directory).map_err(|error| Failure::system(directory.display(), &error))?;
    let on_terminal = io::stderr().is_terminal();
    let announce = |step: &str| {
        if on_terminal {
            eprintln!("{step} ...");
        }
    };
    let refused = |error: InvalidParameter| Failure::other(error.to_string());
    let began = Instant::now();
    announce("calibrating the model on healthy logs");
    let stand = Stand::new(&workspace::root().join(COMMAND))?;
    let calibration = calibration::calibrate(&stand, SEED)?;
    let model = &calibration.after;
    let case = paper_case(&stand, &calibration, SEED).map_err(refused)?;
    let file = directory.join("sweep.csv");
    let log = case.log.file(&file);
    log.write(&file)
        .map_err(|error| Failure::system(file.display(), &error))?;
    announce("levels of friction by inputs by benches");
    let cases = campaign::run(&stand, model, &Input::ALL, 1..=SEEDS).map_err(refused)?;
    announce("methods on the same logs");
    let methods = methods::compare(&stand, model, 1..=COMPARED).map_err(refused)?;
    announce("threshold");
    let detection = detection::detect(&stand, model, HEALTHY, SEED).map_err(refused)?;
    announce("wear");
    let lives = (1..=LIVES)
        .map(|seed| detection::wear(&stand, model, detection.threshold, seed))
        .collect::<Result<_, _>>()
        .map_err(refused)?;
    let results = Results {
        case,
        cases,
        methods,
        detection,
        lives,
        seconds: began.elapsed().as_secs_f64(),
        calibration,
    };
    let page = report::page(&results)?;
    let index = directory.join("index.html");
    fs::write(&index, page).map_err(|error| Failure::system(index.display(), &error))?;
    if let Some(path) = json {
        whole_file::write_json(path, &tables::entries(&results))
            .map_err(|error| Failure::system(path.display(), &error))?;
    }
    let mut text = tables::text(&results);
    text += &format!("report   {}\n", workspace::shown(&index));
    io::stdout()
        .write_all(text.as_bytes())
        .map_err(|error| Failure::system("standard output", &error))
}
