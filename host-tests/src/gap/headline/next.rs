//! What to do next: the line to declare, the log to record, the experiment to play, the call to run.

use std::borrow::Cow;

use model_core::gap::criterion::FARTHEST;
use model_core::gap::model::Base;
use model_core::gap::verdict::Verdict;

use super::gain::Reliance;
use super::settle::{changed, experiment, repeated};
use super::{declared, nearest, short_logs, times_left};
use crate::gap::answer::listed;
use crate::gap::between_logs;
use crate::gap::disagreement::Disagreement;
use crate::gap::outcome::{FittedParameter, FreeMotor, NUMBERS, Outcome, Report};
use crate::machine::{DeclaredEffect, MOTOR};
use crate::quantity::{Scale, given, significant};

/// How the machine file with what was found is written.
const AGAIN: &str = "run it again with --machine-out FILE";

/// The same as a step.
const KEEP: &str = "to keep it, run it again with --machine-out FILE";

/// Most remedies that the answer shows, so that it keeps to its lines.
const MOST_REMEDIES: usize = 5;

/// A part of what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Step {
    /// In words, as a part of a sentence.
    Do(String),
    /// What a file is for that has been written, likewise a part of a sentence: it is said however little room there is.
    Written(String),
    /// To keep an effect, by a command or by the line to copy that comes next.
    Keep,
    /// A line to copy as it stands: a command, or a line of the machine file.
    Copy(String),
}

impl Step {
    /// It in words, or the line to copy.
    pub fn text(&self) -> Cow<'_, str> {
        match self {
            Self::Do(text) | Self::Written(text) | Self::Copy(text) => text.into(),
            Self::Keep => format!("{KEEP}, or have `declared_effects` in [fit] as below").into(),
        }
    }

    /// These steps without the line to declare an effect by, where they have it: the command alone keeps the effect too.
    pub(super) fn without_line(steps: &[Self]) -> Option<Vec<Self>> {
        matches!(steps, [Self::Keep, Self::Copy(_)]).then(|| vec![said(KEEP)])
    }
}

/// What to do, the most useful first; `law` says where a learned law is drawn.
pub(super) fn steps(report: &Report, law: &str) -> Vec<Step> {
    let outcome = &report.outcome;
    let unit = report.coordinate.as_str();
    match outcome.verdict {
        Verdict::LogAndMachineDisagree => remedies(outcome),
        Verdict::EffectsFound | Verdict::NoMissingEffect => {
            let mut steps = Vec::new();
            let validate = outcome.errors.validate.as_ref();
            let reliance = Reliance::on(report);
            steps.extend(supply(&outcome.fit, has_current(report)));
            steps.extend(not_yet(reliance));
            steps.extend(apart(report));
            // A number that is said to be wrong may make up for one that is declared and no fit changes.
            if times_left(outcome).is_some() || outcome.freed().next().is_some() {
                steps.extend(without_declared(report));
            }
            let motor = free_motor(report);
            // Else the line that declares an effect is not yet the last word on it.
            let guessed = guessed(outcome);
            let is_final = motor.is_empty()
                && times_left(outcome).is_none()
                && guessed.is_none()
                && reliance == Reliance::Full;
            steps.extend(motor);
            if validate.is_none() {
                steps.push(said(
                    "record a second log, not for the fit, and give it with --validate",
                ));
            }
            if let Some(longer) = longer(outcome) {
                steps.push(longer);
            } else if outcome.verdict == Verdict::NoMissingEffect && nearest(outcome).is_some() {
                steps.push(said(
                    "to see whether that is chance, record a longer log with more varied motion and give it with another --train",
                ));
            }
            let next = outcome.next_experiment.as_ref();
            let experiment = experiment(next, unit);
            steps.extend(repeated(outcome));
            steps.extend(changed(outcome));
            // An input that settles what the logs do not tell apart comes before what is kept.
            let (found, offered) = match next.is_some_and(|next| next.excitation.is_some()) {
                true => (experiment, None),
                false => (None, experiment),
            };
            steps.extend(found);
            steps.extend(guessed);
            steps.extend(declare(report, reliance, is_final));
            steps.extend(offered);
            steps.extend(look_at_validation(outcome));
            if steps.is_empty() {
                steps.push(said(
                    "nothing; the machine file and these logs belong together",
                ));
            }
            steps
        }
        Verdict::UnknownEffect => {
            let variable = outcome.unknown.as_ref();
            let hint = hint(variable.map_or("", |unknown| unknown.depends_on.as_str()));
            let mut steps = Vec::from_iter(apart(report));
            steps.extend(without_declared(report));
            steps.push(said(&format!("see the learned law {law}; {hint}")));
            steps.extend(guessed(outcome));
            steps.extend(free_motor(report));
            steps.extend(experiment(outcome.next_experiment.as_ref(), unit));
            steps.extend(declare(report, Reliance::Full, true));
            steps
        }
        Verdict::NothingProven => {
            // The first step stays however little room there is.
            let mut steps = Vec::from_iter(look_at_validation(outcome));
            steps.extend(mounted(outcome).or_else(|| guessed(outcome)));
            steps.extend(longer(outcome));
            steps.extend(apart(report));
            steps.extend(without_declared(report));
            steps.extend(free_motor(report));
            if report.has_return_spring {
                steps.push(said(
                    "if this machine file does not come from `cargo hil identify`, record a slow triangle and fast \
                     steps as docs/throttle.md says, and let that make one: spring and friction are on it line by line",
                ));
            }
            steps.extend(experiment(outcome.next_experiment.as_ref(), unit));
            // A current that is there shows where an input is written late or early; one that is not is missed.
            steps.push(said(if has_current(report) {
                "check that your logger writes the input (voltage, duty) at the moment it is set, not a row later; record a \
                 longer log, slow and fast, both ways and with many reversals, and give it with another --train"
            } else {
                "record a longer log, slow and fast, both ways and with many reversals, with current_a if it can be \
                 measured, and give it with another --train"
            }));
            steps
        }
    }
}

/// To look at how the validation logs were recorded, where the model does not follow them.
fn look_at_validation(outcome: &Outcome) -> Option<Step> {
    outcome.is_lost().then(|| {
        said(
            "see what was different when the validation data were recorded (load, supply, units), or give them with \
             another --train",
        )
    })
}

/// What to do as one sentence, and the lines to copy behind it.
pub(in crate::gap) fn sentence(steps: &[Step]) -> (String, Vec<&str>) {
    let (mut words, mut copied) = (Vec::new(), Vec::new());
    for step in steps {
        match step {
            Step::Copy(line) => copied.push(line.as_str()),
            in_words => words.push(in_words.text()),
        }
    }
    let end = if copied.is_empty() { "." } else { ":" };
    (format!("Next: {}{end}", words.join("; ")), copied)
}

/// Whether the training logs have the motor's current.
fn has_current(report: &Report) -> bool {
    report.train.iter().all(|log| !log.current.is_empty())
}

pub(super) fn said(words: &str) -> Step {
    Step::Do(words.to_owned())
}

/// What to do where an error rose with what was found.
fn not_yet(reliance: Reliance) -> Option<Step> {
    let more = "record a longer log with more varied motion and give it with another --train";
    match reliance {
        Reliance::Full => None,
        Reliance::ShortPredictions => Some(said(&format!(
            "do not rely on it for long runs without restarts, whose error rose; for these {more}"
        ))),
        Reliance::None => Some(said(&format!("do not rely on it yet; {more}"))),
    }
}

/// What mends the files; a command that mends several things is said once.
fn remedies(outcome: &Outcome) -> Vec<Step> {
    let mut remedies = outcome.remedies();
    let more = remedies.len().saturating_sub(MOST_REMEDIES);
    remedies.truncate(MOST_REMEDIES);
    let is_choice = |found: &Disagreement| found.remedy.lines().count() > 1;
    let mend = match more {
        0 if outcome.disagreement.iter().any(is_choice) => {
            "mend each log by one of these, then run it again".to_owned()
        }
        0 => "mend this, then run it again".to_owned(),
        _ => format!("mend this, and {more} more that --verbose lists, then run it again"),
    };
    let copied = remedies
        .into_iter()
        .map(|remedy| Step::Copy(remedy.to_owned()));
    [Step::Do(mend)].into_iter().chain(copied).collect()
}

/// To record for longer, where nothing was found in short logs.
fn longer(outcome: &Outcome) -> Option<Step> {
    let least = short_logs(outcome)?.least();
    Some(said(&format!(
        "record a log of {least} or more, both ways and with many reversals, and give it with another --train"
    )))
}

/// What to do about logs that differ. One set of numbers is fitted to all training logs, so what was found may only make up for one
/// of them that has others.
fn apart(report: &Report) -> Option<Step> {
    let logs = &report.outcome.between_logs;
    let others = logs.iter().filter(|log| !log.trained_on);
    let others: Vec<&str> = others.map(|log| log.log.as_str()).collect();
    if !logs.iter().any(|log| log.trained_on) {
        return (!others.is_empty()).then(|| {
            said(&format!(
                "see why {} differs, as said above",
                listed(&others)
            ))
        });
    }
    let odd = between_logs::odd(logs, report.train.len());
    let alone = if odd.is_empty() {
        "run it again with each training log alone".to_owned()
    } else {
        format!("run it again without {}", listed(&odd))
    };
    Some(said(&format!(
        "{alone}, for one set of numbers does not suit them all; `cargo hil track` says how the numbers change from log to log"
    )))
}

/// To take out what is declared and may not be so: no fit changes it, and other effects make up for it.
fn without_declared(report: &Report) -> Option<Step> {
    let declared = declared(report);
    (!declared.is_empty()).then(|| {
        said(&format!(
            "if {} in `declared_effects` {} from a data sheet, leave it out there and run it again: it is looked for \
             and fitted then",
            listed(&declared),
            if declared.len() == 1 { "comes" } else { "come" }
        ))
    })
}

/// To free the motor's numbers, where an effect or an error that is left may stand for one of them that is off: with one
/// that is 3 % off, a load that hangs was taken for a disc off its centre and a cogging. Where the tracing freed both itself,
/// it says their values.
fn free_motor(report: &Report) -> Vec<Step> {
    let outcome = &report.outcome;
    let is_complete = outcome.verdict == Verdict::NoMissingEffect
        && nearest(outcome).is_none_or(|nearest| nearest.id != NUMBERS);
    let are_freed = MOTOR
        .iter()
        .all(|name| outcome.freed().any(|freed| freed == *name));
    match &report.free_motor {
        Some(FreeMotor { fixed, line }) if !is_complete && !are_freed => {
            let fixed: Vec<String> = fixed.iter().map(|name| name.replace('_', " ")).collect();
            let comes = if fixed.len() == 1 { "comes" } else { "come" };
            vec![
                said(&format!(
                    "if {} {comes} from a data sheet, put `parameters` below into [fit] and run it again",
                    listed(&fixed)
                )),
                Step::Copy(line.clone()),
            ]
        }
        _ => Vec::new(),
    }
}

/// The supply to be looked at, where its voltage may be what is wrong and not the motor's numbers: in a log from a supply of s times the
/// voltage that the log has, torque constant and resistance seem to be 1/s times what they are. Without a current the resistance does
/// not show, and a position that is off does the same.
fn supply(fit: &[FittedParameter], with_current: bool) -> Option<Step> {
    let off = |base: Base| {
        let number = fit.iter().find(|number| number.name == base.name())?;
        let is_wrong = number.freed && !number.is_within_tolerance();
        (is_wrong || number.is_surely_beyond_tolerance()).then(|| number.fitted / number.declared)
    };
    let constant = off(Base::TorqueConstant)?;
    let sensor = if with_current {
        let resistance = off(Base::Resistance)?;
        if (resistance < 1.0) != (constant < 1.0) {
            return None;
        }
        ""
    } else {
        ", and the encoder the counts a turn,"
    };
    Some(said(&format!(
        "see that the supply has the voltage{sensor} that the log was imported with: were it {} times as high, the declared \
         torque constant would be right",
        significant(constant.recip(), 2)
    )))
}

/// What is mounted on the shaft, where the logs ask for more inertia than the data sheet of a motor would have.
fn mounted(outcome: &Outcome) -> Option<Step> {
    let implausible = outcome.residual.as_ref()?.implausible?;
    let mut numbers = outcome.fit.iter();
    let inertia = numbers.find(|number| number.name == "inertia" && implausible == "inertia")?;
    (inertia.fitted > inertia.declared).then(|| {
        said(&format!(
            "if anything is mounted on the shaft, put its inertia into the machine file (`cargo hil machine` takes \
             --load-inertia): it has {} {unit}, the logs ask for {} {unit}",
            significant(inertia.declared, 2),
            significant(inertia.fitted, 2),
            unit = inertia.unit
        ))
    })
}

/// What to do about a number that is farther from what the machine file says than that lets it be: it may be a guess, as the
/// friction of a gear that no data sheet gives.
fn guessed(outcome: &Outcome) -> Option<Step> {
    let implausible = outcome.residual.as_ref().and_then(|it| it.implausible);
    let mut numbers = outcome.fit.iter();
    let number = match implausible {
        Some(name) => numbers.find(|number| number.name == name)?,
        None => numbers.find(|number| number.at_limit)?,
    };
    let (name, unit) = (&number.name, &number.unit);
    let instead = match implausible {
        // It was fitted without a limit, to see where the logs have it.
        Some(_) => format!(
            "put {} {unit} there, which the logs ask for",
            significant(number.fitted, 2)
        ),
        None => {
            let off = (number.fitted / number.declared).max(number.declared / number.fitted);
            if off > 0.99 * f64::from(FARTHEST) {
                // Farther than that no factor lets it go: the next fit starts from there. A guess is too small, not so many times
                // too large: then something else is wrong.
                if number.fitted < number.declared {
                    return None;
                }
                format!("put {} {unit} there", significant(number.fitted, 2))
            } else {
                format!(
                    "give {name} a larger factor than {} in `unsure` of [fit]",
                    significant(off.cbrt(), 2)
                )
            }
        }
    };
    Some(said(&format!(
        "if what the machine file says of {} ({} {unit}) is a guess, {instead}, and run it again",
        name.replace('_', " "),
        significant(number.declared, 2),
    )))
}

/// How the machine file takes what was found; the line to copy only where that is final.
fn declare(report: &Report, reliance: Reliance, is_final: bool) -> Vec<Step> {
    let outcome = &report.outcome;
    if let Some(file) = &outcome.machine_out {
        return vec![written(outcome, file, reliance, is_final)];
    }
    let mut steps = Vec::new();
    if reliance == Reliance::None {
        return steps;
    }
    let freed = outcome.fit.iter().filter(|parameter| parameter.freed);
    let freed: Vec<String> = freed
        .map(|parameter| format!("`{} = {}`", parameter.name, given(parameter.fitted)))
        .collect();
    match (outcome.effects.as_slice(), freed.len()) {
        ([], 0) => {}
        ([], count) if count <= MOTOR.len() => steps.push(said(&format!(
            "{AGAIN}, or set {} in the machine file",
            listed(&freed)
        ))),
        ([one], 0) if is_final && one.law.is_none() => {
            // The whole line: a second one of its name would be an error.
            let known = report.declared.iter().map(DeclaredEffect::to_toml);
            let all: Vec<String> = known.chain([one.declare.clone()]).collect();
            steps.push(Step::Keep);
            steps.push(Step::Copy(format!(
                "declared_effects = [{}]",
                all.join(", ")
            )));
        }
        (effects, count) => {
            let it = if outcome.with_law().is_some() {
                "the catalogue's formula for it, which is near to what the logs show"
            } else if effects.len() + count == 1 {
                "it"
            } else {
                "all of that"
            };
            steps.push(said(&format!("to keep {it}, {AGAIN}")));
        }
    }
    steps
}

/// What the machine file is for that has been written.
fn written(outcome: &Outcome, file: &str, reliance: Reliance, is_final: bool) -> Step {
    let what = "the machine file with what was found";
    if let Some(effect) = outcome.with_law() {
        return Step::Written(format!(
            "{file} was written with the formula of {} that comes nearest, but not the learned law: no machine file can \
             hold one",
            effect.id
        ));
    }
    Step::Written(match (&outcome.unknown, reliance) {
        (Some(_), _) => format!(
            "{file} was written with the fitted numbers, but not the learned law: no machine file can hold one"
        ),
        (None, Reliance::None) => format!("until then use {file}, {what}, for trials only"),
        (None, Reliance::ShortPredictions) => {
            let window = outcome.errors.train.after.window_s;
            let window = Scale::of("s", [window]).quantity(window);
            format!("for now use {file}, {what}, for predictions of {window} or so")
        }
        (None, Reliance::Full) if is_final => format!("use {file} from now on, {what}"),
        (None, Reliance::Full) => format!("for now use {file}, {what}"),
    })
}

/// Where to look on the machine for a law of this variable.
fn hint(variable: &str) -> &'static str {
    match variable {
        "position" => "look along the stroke for a rough spot, a bent screw, a cable that pulls",
        "velocity" => "look for what changes with speed: grease, a fan, a seal",
        "current" => "look at motor, bridge and supply under load",
        "load" => "look at gear, screw and bearings under load",
        "time" => "look for what came, went or warmed up while the log was recorded",
        _ => "look for what changes with it",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A supply of s times the declared voltage makes R and k of the fit 1/s times what they are.
    #[test]
    fn only_what_a_supply_does_points_to_the_supply() {
        let fitted = |base: Base, share: f64| FittedParameter {
            name: base.name().to_owned(),
            declared: 2.0,
            fitted: 2.0 * (1.0 + share),
            std: Some(0.002),
            unit: String::new(),
            freed: false,
            tolerance: Some(0.1),
            at_limit: false,
        };
        let [resistance, constant] = [Base::Resistance, Base::TorqueConstant];
        let both = |r: f64, k: f64| [fitted(resistance, r), fitted(constant, k)];
        let points = |r, k| supply(&both(r, k), true).is_some();
        assert!(points(0.17, 0.16) && points(-0.15, -0.14));
        assert!(!points(0.17, -0.12) && !points(0.17, 0.01) && !points(0.05, -0.05));
        assert!(supply(&[fitted(constant, -0.5)], false).is_some());
        assert!(supply(&[fitted(constant, 0.05)], false).is_none());
    }
}
