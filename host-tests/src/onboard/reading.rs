//! From the board's log and counts to the answer.

use std::str::FromStr;

use firmware::app::check;
use firmware::app::demonstration::{BRAKE, UNDECLARED, WEAR};
use firmware::app::experiment::Experiment;
use firmware::app::verdicts::VERDICTS;

use super::outcome::{Deadlines, Gap, Image, Onboard, Parity, ParityOf, PerStep, Refit};
use crate::board_log::{BoardLog, Recording};
use crate::board_run::{BoardRun, VerdictsRun};
use crate::emulate::summary::Summary;
use crate::failure::Failure;
use crate::figures::Figures;
use crate::image::{RAM, flash};
use crate::quantity::decimal;

/// The images that are run as they are flashed, and their chip.
const TARGET: &str = "STM32F405; images: throttle and controller (chip, loop), stm32f405 (parity, refit, brake, gap, image, deadlines), verdicts (parity, verdicts), on_target (instructions_per_step)";

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

/// A value that the board tells at the end of its log.
fn at_the_end<T: FromStr>(log: &BoardLog, kind: &str, name: &str) -> Result<T, Failure> {
    let said = log.messages().find_map(|line| line.value(kind, name));
    said.and_then(|text| text.parse().ok())
        .ok_or_else(|| Failure::other("the board's log has no end"))
}

impl Onboard {
    /// From a run of the images as they are flashed, one of the demonstration, and one of each kind of verdict.
    ///
    /// # Errors
    /// A log without a result.
    pub fn read(
        summary: Summary,
        run: &BoardRun,
        verdicts: &VerdictsRun,
        counts: &Figures,
    ) -> Result<Self, Failure> {
        let compared = || run.comparisons.iter().chain(&verdicts.comparisons);
        let deadlines = |name: &str| at_the_end::<u32>(&run.log, "deadlines", name);
        let logs = [&run.log, &verdicts.log].into_iter();
        let stacks = logs.map(|log| at_the_end::<u64>(log, "stack", "used"));
        let stacks = stacks.collect::<Result<Vec<u64>, Failure>>()?;
        Ok(Self {
            target: TARGET,
            chip: summary.chip,
            r#loop: summary.r#loop,
            parity: Parity {
                samples: compared().map(|experiment| experiment.samples).sum(),
                differing_bits: compared().map(|experiment| experiment.differing_bits).sum(),
                experiments: compared()
                    .map(|experiment| ParityOf {
                        name: experiment.name,
                        samples: experiment.samples,
                        differing_bits: experiment.differing_bits,
                    })
                    .collect(),
                same_evaluations: compared().all(|experiment| experiment.lines.is_empty()),
            },
            refit: Refit::read(&run.log, &WEAR)?,
            brake: Refit::read(&run.log, &BRAKE)?,
            gap: Gap::read(&run.log, &UNDECLARED)?,
            verdicts: VERDICTS
                .iter()
                .map(|experiment| Gap::read(&verdicts.log, experiment))
                .collect::<Result<_, Failure>>()?,
            instructions_per_step: PerStep::read(counts)?,
            image: Image {
                flash_bytes: run.size.flash,
                ram_bytes: run.size.ram,
                flash_room_bytes: flash() - run.size.flash,
                ram_room_bytes: RAM - run.size.ram,
                stack_bytes: stacks.into_iter().max().unwrap_or_default(),
            },
            deadlines: Deadlines {
                ticks: deadlines("ticks")?,
                missed: deadlines("missed")?,
            },
        })
    }
}

impl Gap {
    fn read(log: &BoardLog, experiment: &Experiment) -> Result<Self, Failure> {
        let lines = Lines::of(log, experiment.name)?;
        let all = |kind: &'static str, name: &'static str| {
            let of_kind = lines.0.lines.iter();
            of_kind.filter_map(move |line| line.value(kind, name).map(str::to_owned))
        };
        let to_be_fitted = |name: &String| check::BASE.iter().any(|base| base.name() == name);
        let instructions = lines.value("cost", "cycles")?;
        Ok(Self {
            experiment: experiment.name,
            verdict: lines.value("check", "verdict")?,
            effects: all("effect", "id").collect(),
            unknown: all("unknown", "depends_on").next(),
            freed: all("fitted", "name")
                .filter(|name| !to_be_fitted(name))
                .collect(),
            position_rms_before: lines.value("check", "position_rms_before")?,
            position_rms_after: lines.value("check", "position_rms_after")?,
            samples: lines.value("check", "samples")?,
            instructions,
            seconds: seconds(instructions),
            ticks: lines.value("cost", "ticks")?,
            missed_ticks: lines.value("cost", "missed")?,
        })
    }

    /// What was found, in a few words.
    pub(super) fn names(&self) -> String {
        let freed = self.freed.iter().map(|name| format!("wrong {name}"));
        let unknown = self.unknown.iter().map(|variable| format!("by {variable}"));
        let names = self.effects.iter().cloned().chain(unknown).chain(freed);
        let names: Vec<String> = names.collect();
        if names.is_empty() {
            self.verdict.clone()
        } else {
            format!("{} ({})", self.verdict, names.join(", "))
        }
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
        let instructions = lines.value("cost", "cycles")?;
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
