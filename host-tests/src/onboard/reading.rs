//! From the board's log and counts to the answer.

use std::str::FromStr;

use firmware::app::demonstration::DEMONSTRATION;
use firmware::app::experiment::{Evaluation, Experiment};

use super::outcome::{Deadlines, Gap, Image, Onboard, Parity, ParityOf, PerStep, Refit};
use crate::board_log::{BoardLog, Recording};
use crate::board_run::BoardRun;
use crate::failure::Failure;
use crate::figures::Figures;
use crate::gap::metrics::decimal;
use crate::image::{FLASH, RAM};

/// What the emulation is called.
const TARGET: &str = "QEMU netduinoplus2, Cortex-M4F";

/// Clock of the STM32F405, Hz.
const CLOCK: f64 = 168e6;

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
