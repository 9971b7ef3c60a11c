//! The prognostics paper: *A New Prognostic Method based on Simulated Annealing Algorithm to deal with
//! the Effects of Dry Friction on Electromechanical Actuators*.
//!
//! Its one result, 0.7352 N·m found where a brake gives 0.779 N·m, becomes a campaign with error
//! statistics; then what they presume, alerts, the life that is left, and whether annealing was needed.
//!
//! The paper's number is its C_SJ, an equivalent *static* friction torque (section V); its dynamic
//! coefficient fell by 53 % at the same time (section VI). What is set beside it here is the Coulomb level:
//! the sliding friction that a brake adds, which is what the 0.779 N·m are.

use std::path::Path;
use std::time::Instant;

use model_core::numeric::invalid_parameter::InvalidParameter;

use self::calibration::Calibration;
use self::campaign::Case;
use self::detection::{Detection, Life};
use self::estimate::{Estimate, Options};
use self::stand::{Friction, Input, Recorded, Stand};
use super::Entry;
use crate::failure::Failure;
use crate::outputs::{Kind, Outputs, print, write_own};
use crate::progress::announce;
use crate::workspace;

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
pub mod settings;
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

/// How much is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plan {
    /// Benches of the campaign for each level and input.
    pub benches: u64,
    /// Benches on which the methods are compared, each at every level.
    pub compared: u64,
    /// Benches on which presumptions are dropped, each at every level.
    pub presumed: u64,
    /// Searches with each setting of the annealing.
    pub searches: u64,
    /// Healthy logs that the threshold is learnt from.
    pub healthy: usize,
    /// Actuators that wear.
    pub lives: u64,
}

impl Plan {
    /// What the command does.
    pub const FULL: Self = Self {
        benches: 10,
        compared: 3,
        presumed: 5,
        searches: 30,
        healthy: 100,
        lives: 8,
    };
}

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
    /// Two numbers.
    pub both: Estimate,
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
        both: estimate::two(
            &calibration.after,
            &log.log(false),
            &Options::default(),
            seed,
        )?,
        log,
    })
}

/// Everything that is shown.
#[derive(Debug, Clone)]
pub struct Results {
    /// The model.
    pub calibration: Calibration,
    /// The paper's case.
    pub case: PaperCase,
    /// A long search on the paper's case.
    pub reannealed: Estimate,
    /// Settings of the annealing on the paper's case.
    pub settings: Vec<settings::Row>,
    /// The campaign.
    pub cases: Vec<Case>,
    /// Its presumptions, dropped one by one.
    pub presumptions: Vec<presumptions::Row>,
    /// Methods on the same logs.
    pub methods: Vec<methods::Result>,
    /// The threshold.
    pub detection: Detection,
    /// Actuators on their way to failure.
    pub lives: Vec<Life>,
    /// Wall-clock time of all of it, s.
    pub seconds: f64,
}

impl Results {
    /// Works out everything.
    ///
    /// # Errors
    /// A file that cannot be read; a log from which nothing follows.
    pub fn of(plan: Plan, announce: impl Fn(&str)) -> Result<Self, Failure> {
        let refused = |error: InvalidParameter| Failure::other(error.to_string());
        let began = Instant::now();
        announce("calibrating the model on healthy logs");
        let stand = Stand::new(&workspace::root().join(COMMAND))?;
        let calibration = calibration::calibrate(&stand, SEED)?;
        let model = &calibration.after;
        let case = paper_case(&stand, &calibration, SEED).map_err(refused)?;
        announce("settings of the annealing");
        let log = case.log.log(false);
        let reannealed = settings::reannealed(model, &log, SEED).map_err(refused)?;
        let settings = settings::compare(model, &log, case.truth.coulomb, 1..=plan.searches)
            .map_err(refused)?;
        announce("levels of friction by inputs by benches");
        let cases = campaign::run(&stand, model, &Input::ALL, 1..=plan.benches).map_err(refused)?;
        announce("what the model presumes");
        let presumptions =
            presumptions::compare(&stand, model, 1..=plan.presumed).map_err(refused)?;
        announce("methods on the same logs");
        let methods = methods::compare(&stand, model, 1..=plan.compared).map_err(refused)?;
        announce("threshold");
        let detection = detection::detect(&stand, model, plan.healthy, SEED).map_err(refused)?;
        announce("wear");
        let lives = (1..=plan.lives)
            .map(|seed| detection::wear(&stand, model, detection.threshold, seed))
            .collect::<Result<_, _>>()
            .map_err(refused)?;
        Ok(Self {
            reannealed,
            settings,
            cases,
            presumptions,
            methods,
            detection,
            lives,
            seconds: began.elapsed().as_secs_f64(),
            case,
            calibration,
        })
    }

    /// The report.
    ///
    /// # Errors
    /// A plot that cannot be drawn.
    pub fn page(&self) -> Result<String, Failure> {
        report::page(self)
    }

    /// The JSON.
    pub fn entries(&self) -> Vec<Entry> {
        tables::entries(self)
    }

    /// The tables for a terminal.
    pub fn text(&self) -> String {
        tables::text(self)
    }
}

/// Runs everything, prints the tables, leaves the report and the paper's case in
/// `target/hil/prognostics`.
///
/// # Errors
/// A file that cannot be read or written; a log from which nothing follows.
pub fn run(json: Option<&Path>) -> Result<(), Failure> {
    let directory = workspace::results().join("prognostics");
    let mut outputs = Outputs::reading([]);
    outputs.fills(&directory);
    let json = outputs.file(json, Kind::Marked)?;
    let results = Results::of(Plan::FULL, announce())?;
    let file = directory.join("sweep.csv");
    let log = results.case.log.file(&file);
    write_own(&file, log.to_csv())?;
    let index = directory.join("index.html");
    write_own(&index, results.page()?)?;
    outputs.stage_json(json, &results.entries())?;
    outputs.commit()?;
    let mut text = results.text();
    text += &format!("report   {}\n", workspace::shown(&index));
    print(&text)
}
