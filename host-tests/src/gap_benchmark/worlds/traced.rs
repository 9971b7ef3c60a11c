//! One world, traced and judged.

use std::time::Instant;

use model_core::gap::replay::Settings;
use rig::world::{Kind, Record, World};
use serde::Serialize;

use super::guesses::Guessed;
use super::told::{self, Told};
use super::{VISIBLE, directory, truth};
use crate::error::InputError;
use crate::failure::Failure;
use crate::gap::engine::{self, Found};
use crate::gap::outcome::Outcome;
use crate::gap_benchmark::Deviation;
use crate::gap_benchmark::judgement::{self, Answer, Judgement, Truth};
use crate::log::Log;
use crate::machine::Machine;

/// What came of one world.
#[derive(Debug, Clone, Serialize)]
pub struct Judged {
    /// Which world.
    pub index: u64,
    /// What kind of world it is.
    pub kind: &'static str,
    /// What is behind it: ids, names in parentheses of what the catalogue has not.
    pub truth: Vec<&'static str>,
    /// Numbers outside `[fit]` that are wrong.
    pub wrong_numbers: Vec<String>,
    /// The logger's sins.
    pub sins: Vec<&'static str>,
    /// Rows a second, Hz.
    pub rate: f64,
    /// Rows.
    pub rows: usize,
    /// Why it was not traced, where a reader or the tracing refused it.
    pub refused: Option<String>,
    /// What the tracing said; nothing of a world that was refused.
    pub answer: Answer,
    /// Its verdict.
    pub verdict: String,
    /// Whether that is so.
    pub judgement: Judgement,
    /// Whether there was anything to be seen; true where nothing is there.
    pub visible: bool,
    /// Error on the other log of a fit without what is told over that of one with it.
    pub told_ratio: Option<f64>,
    /// Windowed position error after over before, where something was named.
    pub after_over_before: Option<f64>,
    /// Windowed position error after, over that of the fit that is told the truth.
    pub after_over_told: Option<f64>,
    /// Fitted numbers of a right answer beside the truth.
    pub deviations: Vec<Deviation>,
    /// What is said with other guesses for what `[fit]` names; empty unless it was asked.
    pub guesses: Vec<Guessed>,
    /// Wall-clock seconds of the tracing, beside others.
    pub seconds: f64,
}

impl Judged {
    /// Whether it counts against the tracing: a wrong name anywhere, or too little where there was something
    /// to be seen.
    pub fn fails(&self) -> bool {
        match self.judgement {
            Judgement::Right => false,
            Judgement::Abstained => self.visible,
            Judgement::Wrong => true,
        }
    }

    /// What was said, in a few words.
    pub fn said(&self) -> String {
        let mut words: Vec<String> = self
            .answer
            .named
            .iter()
            .map(|class| class.join("|"))
            .collect();
        words.extend(
            self.answer
                .freed
                .iter()
                .map(|name| format!("{name} is wrong")),
        );
        if let Some(variable) = &self.answer.unknown {
            let proven = if self.answer.proven { "" } else { ", unproven" };
            words.push(format!("unknown by {variable}{proven}"));
        }
        match (&self.refused, words.is_empty()) {
            (Some(_), _) => "refused".to_owned(),
            (None, true) => self.verdict.clone(),
            (None, false) => words.join(" + "),
        }
    }
}

/// Traces and judges a world, and gives what the tracing found.
pub fn judge_world(world: &World, records: &[Record; 2]) -> (Judged, Option<Found>) {
    let truth = truth::of(world);
    let mut judged = Judged {
        index: world.index,
        kind: world.kind.name(),
        truth: world.laws.iter().map(|law| law.label()).collect(),
        wrong_numbers: if world.kind == Kind::Misdeclared {
            let fit = &world.declaration.fit;
            let outside = |name: &&String| !fit.contains(&name.as_str());
            truth
                .wrong_numbers
                .iter()
                .filter(outside)
                .cloned()
                .collect()
        } else {
            Vec::new()
        },
        sins: world.sins.names(),
        rate: world.rate,
        rows: world.rows,
        refused: None,
        answer: Answer::default(),
        verdict: "refused".to_owned(),
        judgement: Judgement::Abstained,
        visible: world.laws.is_empty(),
        told_ratio: None,
        after_over_before: None,
        after_over_told: None,
        deviations: Vec::new(),
        guesses: Vec::new(),
        seconds: 0.0,
    };
    let found = match trace(world, records, &mut judged) {
        Ok(found) => found,
        Err(failure) => {
            judged.refused = Some(failure.to_string());
            see_mended(world, records, &mut judged);
            return (judged, None);
        }
    };
    let found = match found {
        engine::Answer::Found(found) => *found,
        engine::Answer::Disagree(report) => {
            said(&truth, &report.outcome, &mut judged);
            return (judged, None);
        }
    };
    let outcome = &found.report.outcome;
    said(&truth, outcome, &mut judged);
    let errors = &outcome.errors.train;
    if !outcome.effects.is_empty() || outcome.unknown.is_some() {
        judged.after_over_before = Some(errors.remaining());
    }
    if judged.judgement == Judgement::Right {
        judged.deviations = deviations(world, &found);
    }
    (judged, Some(found))
}

/// Takes down what was said, and whether it is so.
fn said(truth: &Truth, outcome: &Outcome, judged: &mut Judged) {
    judged.answer = Answer::of(outcome);
    outcome.verdict.name().clone_into(&mut judged.verdict);
    judged.judgement = judgement::judge(truth, &judged.answer);
}

/// The tracing, and what a fit that is told the truth makes of the same log.
fn trace(
    world: &World,
    records: &[Record; 2],
    judged: &mut Judged,
) -> Result<engine::Answer, Failure> {
    let machine = machine_of(world)?;
    let train = [log_of(world, &records[0], 0)?];
    let started = Instant::now();
    let found = engine::trace(&machine, &train, || Ok(Vec::new()), |_| ())?;
    judged.seconds = started.elapsed().as_secs_f64();
    let [train] = train;
    let settings = match &found {
        engine::Answer::Found(found) => found.settings,
        engine::Answer::Disagree(_) => {
            Settings::new(train.period_s as f32, world.machine.resolution as f32)
        }
    };
    if let Some(told) = told_of(world, train, &records[1], settings) {
        judged.told_ratio = Some(told.ratio);
        judged.visible = told.ratio >= VISIBLE;
        if let engine::Answer::Found(found) = &found {
            let after = found.report.outcome.errors.train.after.position_rms;
            judged.after_over_told = (told.train > 0.0).then_some(after / told.train);
        }
    }
    Ok(found)
}

/// What was to be seen in a log that was refused: as in one with every row in its place. What is refused all
/// the same shows nothing.
fn see_mended(world: &World, records: &[Record; 2], judged: &mut Judged) {
    if !world.laws.is_empty()
        && let Ok(train) = log_of(world, &world.mended_record(), 0)
    {
        let settings = Settings::new(train.period_s as f32, world.machine.resolution as f32);
        if let Some(told) = told_of(world, train, &records[1], settings) {
            judged.told_ratio = Some(told.ratio);
            judged.visible = told.ratio >= VISIBLE;
        }
    }
}

/// Told fits. Without the other log, or where such a fit fails, nobody knows what was to be seen: nothing,
/// then.
fn told_of(world: &World, train: Log, other: &Record, settings: Settings) -> Option<Told> {
    let other = log_of(world, other, 1).ok()?;
    told::told(world, &[train, other], settings).ok().flatten()
}

/// What the answer says and the world knows. Of a poor logger's log the numbers do not mean the same.
fn deviations(world: &World, found: &Found) -> Vec<Deviation> {
    if world.sins.any() || world.kind == Kind::Misdeclared {
        return Vec::new();
    }
    let outcome = &found.report.outcome;
    let truths = truth::numbers(world);
    let effects = outcome.effects.iter().flat_map(|found| &found.parameters);
    let base = outcome.fit.iter().filter_map(|fit| {
        let std = fit.std?;
        Some((fit.name.as_str(), fit.fitted, std))
    });
    effects
        .map(|estimate| (estimate.name.as_str(), estimate.value, estimate.std))
        .chain(base)
        .filter(|(_, _, std)| std.is_finite() && *std > 0.0)
        .filter_map(|(name, value, std)| {
            let (_, truth) = truths.iter().find(|(known, _)| *known == name)?;
            Some(Deviation {
                name: name.to_owned(),
                deviation: (value - truth) / std,
                relative: (value - truth) / truth,
            })
        })
        .collect()
}

/// The world's machine file, read as a user's.
///
/// # Errors
/// A file that is refused.
pub fn machine_of(world: &World) -> Result<Machine, Failure> {
    let path = directory().join(format!("{}.toml", name_of(world)));
    Ok(Machine::of_bytes(&path, world.to_toml().into_bytes())?)
}

/// One of its logs, read as a user's.
///
/// # Errors
/// A log that is refused.
pub fn log_of(world: &World, record: &Record, drive: usize) -> Result<Log, InputError> {
    let name = format!("{}-{}.csv", name_of(world), ["train", "other"][drive]);
    Log::of_bytes(name.as_ref(), record.to_csv().into_bytes())
}

/// Beginning of the names of its files.
pub fn name_of(world: &World) -> String {
    format!("world-{}-{}", world.seed, world.index)
}
