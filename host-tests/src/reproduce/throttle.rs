//! The throttle paper: *On Semi-Automated Modeling of Systems with Friction for HiL-Simulation and
//! Application to Electromechanical Actuators of Passenger Car*.
//!
//! From the logs of a test stand to both models, to their errors on data that they had not seen
//! (Table 1), and onto the chip (Table 2).

use std::path::{Path, PathBuf};
use std::time::Instant;

use firmware::app::tape::Driven;
use model_core::gap::model::Model;

use self::tables::{Column, Implementation, Implemented, Judged};
use super::Entry;
use crate::failure::Failure;
use crate::free_run::{self, Errors};
use crate::gap::{declared, engine};
use crate::identify::{self, Identified, Start, machine_file};
use crate::log::Log;
use crate::machine::Machine;
use crate::outputs::{Kind, Outputs, print, write_own};
use crate::progress::announce;
use crate::pwa;
use crate::replay_run::{self, OnBoard};
use crate::toolchain::Toolchain;
use crate::workspace;

pub mod implementations;
mod report;
pub mod stand;
pub mod tables;

/// The machine file that the identification starts from.
const MACHINE: &str = "host-tests/machines/intake-throttle-12v.toml";

/// Seed of the stand's noise and steps.
const SEED: u64 = 1;

/// From the seed of a stand to that of the next: a stand uses a few.
const SEEDS_APART: u64 = 10;

/// How far off the start is from the throttle, as factors of inertia, damping and friction: what the
/// identification gives must come out of the logs.
const START_OFF: f64 = 2.0;

/// Windows in which the model is refitted after the gap loop, s: a free run errs for as long as a level
/// of the steps is held, and on.
const REFIT_S: [f64; 2] = [1.0, 4.0];

/// What the logs gave.
pub struct Models {
    /// Six numbers, their intervals, lines.
    pub identified: Identified,
    /// The physical model by the paper's procedure.
    pub physical: Model,
    /// The same, all numbers fitted together; the first where that gained nothing.
    pub fitted: Model,
    /// With what the gap loop found.
    pub extended: Model,
    /// The piecewise affine model.
    pub piecewise_affine: pwa::Identified,
    /// The ids of what it found.
    pub effects: Vec<String>,
    /// Seconds from logs to models, without the gap loop.
    pub seconds: f64,
    /// Seconds of the gap loop.
    pub gap_seconds: f64,
}

impl Models {
    /// The piecewise affine model, to be driven.
    fn piecewise_affine(&self) -> Driven {
        Driven::PiecewiseAffine(self.piecewise_affine.model.parameters().clone())
    }
}

/// The start of the identification: the machine file with inertia, damping and friction that are wrong.
///
/// # Errors
/// A machine file that cannot be read.
pub fn start() -> Result<Start, Failure> {
    let mut machine = Machine::read(&workspace::root().join(MACHINE))?;
    machine.mechanics.inertia *= START_OFF;
    machine.mechanics.viscous *= START_OFF;
    machine.mechanics.spring /= START_OFF;
    machine.mechanics.spring_preload /= START_OFF;
    machine.friction.coulomb /= START_OFF;
    machine.friction.r#static /= START_OFF;
    Ok(Start::new(machine)?)
}

/// From the slow and the fast log to the models. `directory` takes the identified machine file.
///
/// # Errors
/// Logs from which no model follows, a file that cannot be written.
pub fn models(logs: &stand::Logs, directory: &Path) -> Result<Models, Failure> {
    let start = start()?;
    let began = Instant::now();
    let identified = identify::identify(&start, &logs.slow, &logs.fast)?;
    let piecewise_affine = pwa::identify(&[&logs.slow, &logs.fast], &pwa::Options::default())?;
    let seconds = began.elapsed().as_secs_f64();
    let file = directory.join("piecewise_affine.toml");
    pwa::write(&piecewise_affine.model, &file)?;
    let file = directory.join("identified.toml");
    let text = machine_file::text(
        &start.machine,
        &identified.best().parameters,
        "throttle of the test stand",
    );
    write_own(&file, text)?;
    let machine = Machine::read(&file)?;
    let fitted = declared::model(&machine)?;
    let physical = Model {
        plant: identified.full.parameters,
        ..fitted.clone()
    };
    let began = Instant::now();
    let train = [logs.slow.clone(), logs.fast.clone()];
    let found = engine::trace(&machine, &train, || Ok(Vec::new()), |_| ())?.found()?;
    let extended = engine::refit(&machine, &train, &found.model, &REFIT_S)?;
    Ok(Models {
        identified,
        physical,
        fitted,
        extended,
        piecewise_affine,
        effects: found
            .report
            .outcome
            .effects
            .into_iter()
            .map(|effect| effect.id)
            .collect(),
        seconds,
        gap_seconds: began.elapsed().as_secs_f64(),
    })
}

/// Errors in degrees.
fn degrees(predicted: &[f64], log: &Log) -> Errors {
    let errors = free_run::errors(predicted, &log.position);
    Errors {
        max_abs: errors.max_abs.to_degrees(),
        ..errors
    }
}

/// All models on both logs of steps, in the order of the tables.
///
/// # Errors
/// A model that the core does not take.
pub fn judge_all(models: &Models, logs: &stand::Logs) -> Result<Vec<Judged>, Failure> {
    let physical = |model: &Model| Driven::Physical(model.clone());
    let columns = [
        (Column::Physical, physical(&models.physical)),
        (Column::Fitted, physical(&models.fitted)),
        (Column::Extended, physical(&models.extended)),
        (Column::PiecewiseAffine, models.piecewise_affine()),
    ];
    columns
        .iter()
        .map(|(column, model)| judge(*column, model, logs))
        .collect()
}

/// A model on both logs of steps, as the core steps it.
///
/// # Errors
/// A model that the core does not take.
fn judge(column: Column, model: &Driven, logs: &stand::Logs) -> Result<Judged, Failure> {
    let run = |log: &Log| -> Result<Vec<f64>, Failure> {
        let tape = implementations::tape(model, log)?;
        Ok(implementations::positions(&replay_run::on_host(&tape)?))
    };
    Ok(Judged::new(
        column,
        run(&logs.fast)?,
        run(&logs.validate)?,
        logs,
    ))
}

/// The errors on stands of other seeds.
fn repeated(repeat: u64, mut announce: impl FnMut(&str)) -> Result<Vec<Vec<Judged>>, Failure> {
    (1..=repeat)
        .map(|number| {
            announce(&format!("stand {number} of {repeat}"));
            let directory = workspace::results().join(format!("throttle-{number}"));
            let logs = stand::record(&directory, SEED + SEEDS_APART * number)?;
            judge_all(&models(&logs, &directory)?, &logs)
        })
        .collect()
}

/// Runs everything, prints the tables, leaves logs, models and report in `target/hil/throttle`.
///
/// # Errors
/// What is missing on this machine, or what is not in order with the run.
pub fn run(json: Option<&Path>, repeat: u64) -> Result<(), Failure> {
    let directory = workspace::results().join("throttle");
    let mut outputs = Outputs::reading([]);
    outputs.fills(&directory);
    let json = outputs.file(json, Kind::Marked)?;
    let announce = announce();
    announce("recording the throttle on the stand");
    let logs = stand::record(&directory, SEED)?;
    announce("identification, gap loop");
    let models = models(&logs, &directory)?;
    let judged = judge_all(&models, &logs)?;
    let repeated = repeated(repeat, announce)?;
    announce("firmware");
    let toolchain = Toolchain::set_up()?;
    announce("three models on three emulated chips, in real time");
    let (implemented, boards) = implement(&toolchain, &models, &logs, &directory)?;
    let results = Results {
        logs,
        models,
        judged,
        repeated,
        implemented,
        differing_bits: boards.differing_bits,
        ticks: boards.ticks,
    };
    let page = report::page(&results).map_err(|error| Failure::system("the plots", &error))?;
    let index = directory.join("index.html");
    write_own(&index, page)?;
    outputs.stage_json(json, &results.entries())?;
    outputs.commit()?;
    let text = results.text(&directory);
    print(&text)
}

/// What the boards did.
struct Boards {
    differing_bits: u32,
    ticks: u64,
}

/// Table 2: the physical model, the extended one and the piecewise affine one.
fn implement(
    toolchain: &Toolchain,
    models: &Models,
    logs: &stand::Logs,
    directory: &Path,
) -> Result<(Vec<Implemented>, Boards), Failure> {
    let log = &logs.validate;
    let columns = [
        (
            Column::Physical,
            Driven::Physical(models.physical.clone()),
            "physical.tape",
        ),
        (
            Column::Extended,
            Driven::Physical(models.extended.clone()),
            "extended.tape",
        ),
        (
            Column::PiecewiseAffine,
            models.piecewise_affine(),
            "piecewise_affine.tape",
        ),
    ];
    let tapes: Vec<(Vec<u8>, PathBuf)> = columns
        .iter()
        .map(|(_, model, name)| Ok((implementations::tape(model, log)?, directory.join(name))))
        .collect::<Result<_, Failure>>()?;
    let places: Vec<(&[u8], &Path)> = tapes
        .iter()
        .map(|(tape, file)| (tape.as_slice(), file.as_path()))
        .collect();
    let boards: Vec<OnBoard> = implementations::on_boards(toolchain, &places)?;
    let mut implemented = Vec::new();
    let mut sums = Boards {
        differing_bits: 0,
        ticks: 0,
    };
    for (((column, ..), (tape, _)), board) in columns.iter().zip(&tapes).zip(&boards) {
        let host = replay_run::on_host(tape)?;
        sums.differing_bits += replay_run::differing_bits(&host, &board.rows);
        sums.ticks += board.ticks;
        let mut add = |implementation, positions: Vec<f64>| {
            implemented.push(Implemented {
                column: *column,
                implementation,
                errors: degrees(&positions, log),
                positions,
            });
        };
        if *column == Column::Physical {
            let continuous = implementations::continuous(&models.physical.plant, log);
            add(Implementation::Continuous, continuous);
        }
        add(Implementation::Discrete, implementations::positions(&host));
        add(
            Implementation::RealTime,
            implementations::positions(&board.rows),
        );
    }
    match sums.differing_bits {
        0 => Ok((implemented, sums)),
        bits => Err(Failure::Other(format!(
            "the models on the emulated chip differ from this host's in {bits} bits"
        ))),
    }
}

/// Everything that is shown.
pub(crate) struct Results {
    logs: stand::Logs,
    models: Models,
    judged: Vec<Judged>,
    repeated: Vec<Vec<Judged>>,
    implemented: Vec<Implemented>,
    differing_bits: u32,
    ticks: u64,
}

impl Results {
    /// The JSON.
    fn entries(&self) -> Vec<Entry> {
        let mut entries = tables::table_1(&self.judged);
        entries.extend(tables::table_2(&self.implemented));
        entries.extend(tables::table_repeated(&self.repeated));
        let plain = |what: &str, paper, ours, truth, unit: &str| Entry {
            what: what.to_owned(),
            paper,
            ours,
            truth,
            unit: unit.to_owned(),
        };
        entries.push(plain(
            "bits in which real-time and time-discrete model differ",
            None,
            self.differing_bits.into(),
            Some(0.0),
            "",
        ));
        entries.push(plain(
            "from logs to models",
            Some(300.0),
            self.models.seconds,
            None,
            "s",
        ));
        entries.extend(self.numbers().map(|(name, unit, number, truth)| {
            plain(
                &format!("{name} by the four lines"),
                None,
                number.value,
                Some(truth),
                unit,
            )
        }));
        entries
    }

    /// The six numbers by the paper's procedure: name, unit, value, the rig's.
    fn numbers(&self) -> impl Iterator<Item = (&'static str, &'static str, identify::Number, f64)> {
        let found = self.models.identified.full.numbers.all();
        let names = [
            ("a0/b0", "V/rad"),
            ("a1/b0", "V·s/rad"),
            ("c0/b0", "V"),
            ("c1/b0", "V"),
            ("cH/b0", "V"),
            ("b0", "rad/(V·s²)"),
        ];
        names
            .into_iter()
            .zip(found)
            .zip(stand::numbers())
            .map(|(((name, unit), number), truth)| (name, unit, number, truth))
    }

    /// The tables for a terminal.
    fn text(&self, directory: &Path) -> String {
        let mut text = format!(
            "{}\n\nTable 1: free run, ours (the paper's)\n{}\n",
            report::stand(),
            tables::render(&tables::cells_1(&self.judged))
        );
        text += &format!(
            "Table 2: validation, one model in three implementations\n{}\n",
            tables::render(&tables::cells_2(&self.implemented))
        );
        if !self.repeated.is_empty() {
            text += &format!(
                "{} stands of other noise and steps, validation: median, worst; within {}°\n{}\n",
                self.repeated.len(),
                tables::LIMIT,
                tables::render(&tables::cells_repeated(&self.repeated))
            );
        }
        text += "Six numbers by the four lines, 95 % interval, and the rig's\n";
        for (name, unit, number, truth) in self.numbers() {
            text += &format!(
                "{name:<8}{:>12.4} ± {:<10.4}{truth:>12.4} {unit}\n",
                number.value, number.half_width
            );
        }
        text += report::INTERVALS;
        text.push('\n');
        for warning in &self.models.identified.warnings {
            text += &format!("note: {warning}\n");
        }
        text += &format!(
            "\nreal-time against time-discrete   {} bits differ in {} ticks, none missed\n\
             gap loop                          {} in {:.1} s\n\
             from logs to models               {:.1} s (the paper: 300 s)\n\
             report                            {}\n",
            self.differing_bits,
            self.ticks,
            match self.models.effects.as_slice() {
                [] => "nothing found".to_owned(),
                effects => effects.join(", "),
            },
            self.models.gap_seconds,
            self.models.seconds,
            workspace::shown(&directory.join("index.html"))
        );
        text
    }
}
