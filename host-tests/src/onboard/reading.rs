//! From the board's log and counts to the answer.

use std::str::FromStr;

use firmware::app::demonstration::{BRAKE, UNDECLARED, WEAR};
use firmware::app::experiment::Experiment;

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
        let check = Lines::of(&run.log, UNDECLARED.name)?;
        let check_instructions = check.value("cost", "instructions")?;
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
            refit: Refit::read(&run.log, &WEAR)?,
            brake: Refit::read(&run.log, &BRAKE)?,
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

impl Refit {
    fn read(log: &BoardLog, experiment: &Experiment) -> Result<Self, Failure> {
        let lines = Lines::of(log, experiment.name)?;
        let truth = experiment
            .wear
            .map_or(experiment.actuator.coulomb.forward, |wear| wear.coulomb);
        let annealed: u32 = lines.value("refit", "annealing_evaluations")?;
        let polished: u32 = lines.value("refit", "golden_section_evaluations")?;
        let instructions = lines.value("cost", "instructions")?;
        Ok(Self {
            parameter: lines.value("refit", "parameter")?,
            present: lines.value("refit", "present")?,
            truth: decimal(truth),
            estimate: lines.value("refit", "estimate")?,
            evaluations: annealed + polished,
            samples: lines.value("refit", "samples")?,
            instructions,
            seconds: seconds(instructions),
            ticks: lines.value("cost", "ticks")?,
            missed_ticks: lines.value("cost", "missed")?,
        })
    }
}

/// At one instruction a cycle.
fn seconds(instructions: u64) -> f64 {
    instructions as f64 / CLOCK
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
            bench: count("bench_averaged")?,
            bench_switching: count("bench_switching")?,
            ema_reversal: count("ema_reversal")?,
            refit_sample: count("refit_sample")?,
        })
    }
}
