//! `cargo hil onboard`: what the emulated board does by itself, beside this host and the truth.

use std::fmt::Write as _;
use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;
use std::str::FromStr;

use firmware::app::demonstration::DEMONSTRATION;
use firmware::app::experiment::{Evaluation, Experiment};
use serde::Serialize;

use crate::board_log::{BoardLog, Recording};
use crate::board_run::{self, BoardRun};
use crate::failure::Failure;
use crate::figures::Figures;
use crate::gap::metrics::decimal;
use crate::image::{FLASH, RAM};
use crate::on_target_run;
use crate::whole_file;

/// What the emulation is called.
const TARGET: &str = "QEMU netduinoplus2, Cortex-M4F";

/// Clock of the STM32F405, Hz.
const CLOCK: f64 = 168e6;

/// What `cargo hil onboard` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Write the result to this file as JSON
    #[arg(long, value_name = "F")]
    json: Option<PathBuf>,
}

/// The answer, serialised as it stands. Keys beyond the contract are additions.
#[derive(Debug, Clone, Serialize)]
pub struct Onboard {
    /// What ran it.
    pub target: &'static str,
    /// The board's samples beside this host's.
    pub parity: Parity,
    /// Friction estimated anew on the board.
    pub refit: Refit,
    /// What the board finds in its own log.
    pub gap: Gap,
    /// Instructions of one step: exact, of this compiler.
    pub instructions_per_step: PerStep,
    /// What the image occupies.
    pub image: Image,
    /// Deadlines missed in the whole run, and plant ticks in it.
    pub deadlines: Deadlines,
}

/// The board's samples beside this host's.
#[derive(Debug, Clone, Serialize)]
pub struct Parity {
    /// Samples compared: position, velocity, current, control output, and what the sensors read.
    pub samples: usize,
    /// Bits that differ.
    pub differing_bits: u32,
    /// Samples by experiment.
    pub experiments: Vec<ParityOf>,
    /// Whether the refit and the check came to the same numbers, to the last bit.
    pub same_evaluations: bool,
}

/// One experiment's samples beside this host's.
#[derive(Debug, Clone, Serialize)]
pub struct ParityOf {
    /// Its name.
    pub name: &'static str,
    /// Samples compared.
    pub samples: usize,
    /// Bits that differ.
    pub differing_bits: u32,
}

/// Friction estimated anew on the board.
#[derive(Debug, Clone, Serialize)]
pub struct Refit {
    /// What was estimated.
    pub parameter: String,
    /// What it was before, and where the search started, N·m.
    pub present: f64,
    /// What it really is, N·m.
    #[serde(rename = "true")]
    pub truth: f64,
    /// What the board says, N·m.
    pub estimate: f64,
    /// Replays of the log: by annealing and by golden section.
    pub evaluations: u32,
    /// Samples of the log.
    pub samples: u32,
    /// Without those of the interrupts.
    pub instructions: u64,
    /// At one instruction a cycle and 168 MHz, beside the interrupts.
    pub seconds: f64,
    /// Plant ticks meanwhile.
    pub ticks: u32,
    /// Deadlines missed meanwhile.
    pub missed_ticks: u32,
}

/// What the board finds in its own log.
#[derive(Debug, Clone, Serialize)]
pub struct Gap {
    /// As in the answer of `cargo hil gap`.
    pub verdict: String,
    /// Ids of the effects.
    pub effects: Vec<String>,
    /// Windowed position error, rms, of the machine with its parameters fitted, rad.
    pub position_rms_before: f64,
    /// With what was found, rad.
    pub position_rms_after: f64,
    /// Samples of the log.
    pub samples: u32,
    /// Without those of the interrupts.
    pub instructions: u64,
    /// At one instruction a cycle and 168 MHz, beside the interrupts.
    pub seconds: f64,
    /// Plant ticks meanwhile.
    pub ticks: u32,
    /// Deadlines missed meanwhile.
    pub missed_ticks: u32,
}

/// Instructions of one step.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct PerStep {
    /// The actuator, sliding forward.
    pub ema: u64,
    /// The throttle, sliding, with its spring and its stops.
    pub throttle: u64,
    /// The controller.
    pub pid: u64,
    /// The actuator in a step in which it turns round.
    pub ema_reversal: u64,
    /// A sample of the log in one evaluation of the refit.
    pub refit_sample: u64,
}

impl PerStep {
    fn read(counts: &Figures) -> Result<Self, Failure> {
        let count = |name: &str| {
            let missing = || Failure::Other(format!("the board counts no instructions of {name}"));
            counts.get(name).copied().ok_or_else(missing)
        };
        Ok(Self {
            ema: count("ema_forward")?,
            throttle: count("throttle_sliding")?,
            pid: count("pid")?,
            ema_reversal: count("ema_reversal")?,
            refit_sample: count("refit_sample")?,
        })
    }
}

/// What the image occupies, bytes.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Image {
    /// Of the flash.
    pub flash_bytes: u64,
    /// Of the RAM.
    pub ram_bytes: u64,
    /// What is left of the flash.
    pub flash_room_bytes: u64,
    /// What is left of the RAM: the stack's.
    pub ram_room_bytes: u64,
}

/// Deadlines of the whole run.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Deadlines {
    /// Plant ticks.
    pub ticks: u32,
    /// Deadlines missed.
    pub missed: u32,
}

/// Runs the board, prints a table, writes what was asked for.
///
/// # Errors
/// What is missing on this machine; a board that differs from this host, once that is reported; a
/// result that cannot be written.
pub fn run(args: &Args) -> Result<(), Failure> {
    let on_terminal = io::stderr().is_terminal();
    let mut announce = |step: &str| {
        if on_terminal {
            eprintln!("{step} ...");
        }
    };
    let run = board_run::run(&mut announce)?;
    announce("instruction counts");
    let counts = on_target_run::run(&run.toolchain)?.counts;
    let onboard = Onboard::read(&run, &counts)?;
    if let Some(path) = &args.json {
        whole_file::write_json(path, &onboard)
            .map_err(|error| Failure::system(path.display(), &error))?;
    }
    io::stdout()
        .write_all(onboard.table().as_bytes())
        .map_err(|error| Failure::system("standard output", &error))?;
    run.require_parity()
}

fn experiment(evaluation: Evaluation) -> &'static Experiment {
    DEMONSTRATION
        .iter()
        .find(|experiment| experiment.evaluation == evaluation)
        .expect("one of each is demonstrated")
}

/// Reads values out of an experiment's lines.
struct Lines<'a>(Recording<'a>);

impl<'a> Lines<'a> {
    fn of(log: &'a BoardLog, name: &str) -> Result<Self, Failure> {
        let recordings = log.recordings();
        let recording = recordings
            .into_iter()
            .find(|recording| recording.name == name);
        let missing = || Failure::Other(format!("the board ran no experiment {name:?}"));
        recording.map(Lines).ok_or_else(missing)
    }

    fn value<T: FromStr>(&self, kind: &str, name: &str) -> Result<T, Failure> {
        let value = self.0.value(kind, name).and_then(|text| text.parse().ok());
        value.ok_or_else(|| {
            let said: String = self
                .0
                .lines
                .iter()
                .filter(|line| line.sample.is_none())
                .map(|line| format!("\n  {line}"))
                .collect();
            Failure::Other(format!(
                "the board says nothing of `{kind} {name}` in experiment {:?}{said}",
                self.0.name
            ))
        })
    }
}

impl Onboard {
    /// From a run of the board.
    ///
    /// # Errors
    /// A log without a result.
    pub fn read(run: &BoardRun, counts: &Figures) -> Result<Self, Failure> {
        let wear = experiment(Evaluation::Refit);
        let refit = Lines::of(&run.log, wear.name)?;
        let check = Lines::of(&run.log, experiment(Evaluation::Check).name)?;
        let seconds = |instructions: u64| instructions as f64 / CLOCK;
        let refit_instructions = refit.value("cost", "instructions")?;
        let check_instructions = check.value("cost", "instructions")?;
        let annealed: u32 = refit.value("refit", "annealing_evaluations")?;
        let polished: u32 = refit.value("refit", "golden_section_evaluations")?;
        let truth = wear
            .wear
            .map_or(wear.actuator.coulomb.forward, |wear| wear.coulomb);
        let effects = check
            .0
            .lines
            .iter()
            .filter_map(|line| line.value("effect", "id"));
        let last = |name: &str| {
            let said = run
                .log
                .messages()
                .find_map(|line| line.value("deadlines", name));
            said.and_then(|text| text.parse().ok())
                .ok_or_else(|| Failure::other("the board's log has no end"))
        };
        Ok(Self {
            target: TARGET,
            parity: Parity {
                samples: run.samples(),
                differing_bits: run.differing_bits(),
                experiments: run
                    .comparisons
                    .iter()
                    .map(|experiment| ParityOf {
                        name: experiment.name,
                        samples: experiment.samples,
                        differing_bits: experiment.differing_bits,
                    })
                    .collect(),
                same_evaluations: run
                    .comparisons
                    .iter()
                    .all(|experiment| experiment.lines.is_empty()),
            },
            refit: Refit {
                parameter: refit.value("refit", "parameter")?,
                present: refit.value("refit", "present")?,
                truth: decimal(truth),
                estimate: refit.value("refit", "estimate")?,
                evaluations: annealed + polished,
                samples: refit.value("refit", "samples")?,
                instructions: refit_instructions,
                seconds: seconds(refit_instructions),
                ticks: refit.value("cost", "ticks")?,
                missed_ticks: refit.value("cost", "missed")?,
            },
            gap: Gap {
                verdict: check.value("check", "verdict")?,
                effects: effects.map(str::to_owned).collect(),
                position_rms_before: check.value("check", "position_rms_before")?,
                position_rms_after: check.value("check", "position_rms_after")?,
                samples: check.value("check", "samples")?,
                instructions: check_instructions,
                seconds: seconds(check_instructions),
                ticks: check.value("cost", "ticks")?,
                missed_ticks: check.value("cost", "missed")?,
            },
            instructions_per_step: PerStep::read(counts)?,
            image: Image {
                flash_bytes: run.size.flash,
                ram_bytes: run.size.ram,
                flash_room_bytes: FLASH - run.size.flash,
                ram_room_bytes: RAM - run.size.ram,
            },
            deadlines: Deadlines {
                ticks: last("ticks")?,
                missed: last("missed")?,
            },
        })
    }

    /// For people.
    pub fn table(&self) -> String {
        let Self {
            parity,
            refit,
            gap,
            instructions_per_step: steps,
            image,
            ..
        } = self;
        let experiments: Vec<String> = parity
            .experiments
            .iter()
            .map(|experiment| format!("{} of {}", experiment.samples, experiment.name))
            .collect();
        let cost = |instructions: u64, seconds: f64, ticks: u32, missed: u32| {
            format!(
                "{:.3e} instructions, {seconds:.2} s at 168 MHz and one a cycle; {ticks} plant ticks \
                 meanwhile, {missed} missed",
                instructions as f64
            )
        };
        let rows = [
            (
                "parity",
                format!(
                    "{} samples ({}), {} bits differ from this host",
                    parity.samples,
                    experiments.join(", "),
                    parity.differing_bits
                ),
            ),
            (
                "refit",
                format!(
                    "{} {} -> {:.5} N·m, really {} ({:+.2} %), {} evaluations of {} samples",
                    refit.parameter,
                    refit.present,
                    refit.estimate,
                    refit.truth,
                    100.0 * (refit.estimate / refit.truth - 1.0),
                    refit.evaluations,
                    refit.samples
                ),
            ),
            (
                "",
                cost(
                    refit.instructions,
                    refit.seconds,
                    refit.ticks,
                    refit.missed_ticks,
                ),
            ),
            (
                "check",
                format!(
                    "{} ({}): position {:.3} -> {:.3} mrad rms over {} samples",
                    gap.verdict,
                    gap.effects.join(", "),
                    1e3 * gap.position_rms_before,
                    1e3 * gap.position_rms_after,
                    gap.samples
                ),
            ),
            (
                "",
                cost(gap.instructions, gap.seconds, gap.ticks, gap.missed_ticks),
            ),
            (
                "evaluations",
                if parity.same_evaluations {
                    "the same numbers as on this host, bit for bit".to_owned()
                } else {
                    "other numbers than on this host".to_owned()
                },
            ),
            (
                "instructions",
                format!(
                    "a step of the actuator {}, of the throttle {}, of the PID {}; a sample of the \
                     refit {}",
                    steps.ema, steps.throttle, steps.pid, steps.refit_sample
                ),
            ),
            (
                "image",
                format!(
                    "{:.1} of {} KB flash, {:.1} of {} KB RAM ({:.1} KB for the stack)",
                    kilobytes(image.flash_bytes),
                    FLASH / 1024,
                    kilobytes(image.ram_bytes),
                    RAM / 1024,
                    kilobytes(image.ram_room_bytes)
                ),
            ),
        ];
        let width = rows.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
        rows.iter().fold(String::new(), |mut text, (name, value)| {
            // A string takes everything.
            let _ = writeln!(text, "{name:width$}  {value}");
            text
        })
    }
}

fn kilobytes(bytes: u64) -> f64 {
    bytes as f64 / 1024.0
}
