//! The answer for people: what was found, how much better the model is with it, how sure that is, and what to
//! do next. The terminal and the page begin with it; all numbers behind it come after, where they are asked
//! for.

mod found;
mod gain;
mod layout;
mod next;
mod settle;

use model_core::effect::Id;
use model_core::effect::twins::are_one_model;
use model_core::gap::criterion::UNEXPLAINED;
use model_core::gap::verdict::Verdict;

use self::found::{current_sensor, late_input, learned};
use self::gain::{gain, rises, shortest_gain};
pub use self::layout::LINES;
pub(super) use self::layout::lines;
pub use self::next::Step;
pub(super) use self::next::sentence as next_sentence;
use super::answer::listed;
use super::between_logs;
use super::disagreement::words::spoken;
use super::effect_words::{Workshop, sentence};
use super::experiment::any_of;
use super::outcome::{Candidate, FittedParameter, FoundEffect, Outcome, Report, ShortLogs};
use super::table::number_in_words;
use crate::quantity::{Scale, capitalised, significant};

/// Most effects that the first sentence names; of more it says the number.
const NAMED: usize = 3;

/// Most effects that a list of those which the logs cannot tell apart names; of more it names [`NAMED`].
const LISTED: usize = 6;

/// Share of the held-out error below which what a refused candidate leaves is no chance, most likely: the
/// reader is told of it.
const NEARLY: f64 = 0.5;

/// Least chance that is told as a number. A p-value takes the tail of a distribution from some dozens of blocks; that
/// far out nobody has checked it.
const LEAST_CHANCE: f64 = 1e-6;

/// What is said where nothing came near to being found.
const NOTHING_HELPS: &str =
    "Nothing that was tried lowers the error clearly on data left out of the fit.";

/// The answer in sentences.
#[derive(Debug, Clone, PartialEq)]
pub struct Headline {
    /// What was found; and which errors have risen, if any.
    pub finding: String,
    /// What that is, effect by effect, with its name in the catalogue.
    pub details: Vec<(String, String)>,
    /// How much better the model is, on unseen data where there is some.
    pub gain: String,
    /// The same of one error, where there is room for no more.
    pub(super) shortest_gain: String,
    /// How sure that is, and what else it could be.
    pub certainty: String,
    /// What to do next.
    pub next: Vec<Step>,
}

impl Headline {
    /// The sentences for a terminal.
    pub fn of(report: &Report) -> Self {
        let law = if report.has_page {
            "in the report"
        } else {
            "with --report DIR"
        };
        Self::with(report, law)
    }

    /// The sentences for the page, which shows what a terminal only refers to.
    pub fn on_page(report: &Report) -> Self {
        Self::with(report, "below")
    }

    /// The sentences; `law` says where a learned law is drawn.
    fn with(report: &Report, law: &str) -> Self {
        let outcome = &report.outcome;
        let workshop = Workshop::of(report);
        let mut finding = finding(outcome);
        let beside = [
            left(outcome),
            short_logs(outcome).map(|short| short.in_words()),
            at_limit(outcome),
            differs(report),
            lost(report),
        ]
        .into_iter();
        let beside = beside.flatten();
        for sentence in beside.chain(rises(report)) {
            finding += " ";
            finding += &sentence;
        }
        let details = outcome.effects.iter();
        let mut details: Vec<_> = details
            .map(|effect| (effect.id.clone(), sentence(effect, &workshop)))
            .collect();
        details.extend(learned(report));
        details.extend(late_input(report));
        details.extend(current_sensor(report));
        details.extend(found::between_logs(report));
        Self {
            finding,
            details,
            gain: gain(report),
            shortest_gain: shortest_gain(report),
            certainty: certainty(report),
            next: next::steps(report, law),
        }
    }
}

fn finding(outcome: &Outcome) -> String {
    let known = match outcome.effects.as_slice() {
        [] => String::new(),
        [one] if one.equivalent.is_empty() => format!("one effect was missing, {}.", one.id),
        [one] => {
            let all = [vec![one.id.clone()], equivalent(one)].concat();
            let who = if is_one_model(outcome, one) {
                "no log can"
            } else {
                "the logs cannot"
            };
            format!(
                "one effect was missing, either {}: {who} tell them apart.",
                any_of(&all)
            )
        }
        several if several.len() <= NAMED => {
            let each = several.iter().map(|effect| match effect.equivalent.len() {
                0 => effect.id.clone(),
                _ => {
                    let others = any_of(&equivalent(effect));
                    format!("{} (or {others}: the logs cannot tell)", effect.id)
                }
            });
            let each: Vec<String> = each.collect();
            format!("{} effects were missing, {}.", several.len(), listed(&each))
        }
        several => format!("{} effects were missing.", several.len()),
    };
    let off = off(outcome);
    let next = outcome.next_experiment.as_ref();
    let shown = if next.is_some_and(|next| !next.absorbed.is_empty()) {
        " that the logs can show"
    } else if nearest(outcome).is_some() {
        " that the logs can prove"
    } else {
        ""
    };
    match (outcome.verdict, &outcome.unknown) {
        (Verdict::LogAndMachineDisagree, _) => {
            let mut whats: Vec<&str> = outcome.disagreements();
            let more = whats.len().saturating_sub(NAMED);
            whats.truncate(NAMED);
            let more = match more {
                0 => String::new(),
                more => format!("; and {more} more, all listed below"),
            };
            format!(
                "the log and the machine file do not belong together: {}{more}.",
                whats.join("; ")
            )
        }
        (Verdict::NoMissingEffect, _) => match off {
            Some(off) => format!("no effect is missing{shown}; {off}."),
            None => format!("no effect is missing{shown}."),
        },
        (Verdict::EffectsFound, _) => match off {
            Some(off) => format!("{known} Besides, {off}."),
            None => known,
        },
        (Verdict::NothingProven, _) => format!("{}.", nothing_proven(outcome)),
        (Verdict::UnknownEffect, unknown) => {
            let subject = if known.is_empty() {
                "an effect is missing"
            } else {
                " A further effect is missing"
            };
            let variable = unknown.as_ref().map_or(String::new(), |unknown| {
                let variable = &unknown.depends_on;
                format!("; it depends on {variable}")
            });
            format!("{known}{subject} that the catalogue does not name{variable}.")
        }
    }
}

/// Whether the first sentence names all that the logs cannot tell from an effect.
fn is_in_finding(outcome: &Outcome, effect: &FoundEffect) -> bool {
    outcome.effects.len() <= NAMED && effect.equivalent.len() <= LISTED
}

/// Whether something is in doubt, and the first sentence says all of it.
fn is_doubt_in_finding(outcome: &Outcome) -> bool {
    let effects = &outcome.effects;
    let next = outcome.next_experiment.as_ref();
    effects.iter().any(|effect| !effect.equivalent.is_empty())
        && effects.iter().all(|effect| is_in_finding(outcome, effect))
        && next.is_none_or(|next| next.rivals().is_empty())
}

/// Whether an effect and the only other one that it may be are one model in every motion.
fn is_one_model(outcome: &Outcome, effect: &FoundEffect) -> bool {
    match &effect.equivalent[..] {
        [other] => is_same_law(outcome, effect, other),
        _ => false,
    }
}

/// Whether an effect and another one are one law of the motion, so that no log tells them apart.
fn is_same_law(outcome: &Outcome, effect: &FoundEffect, other: &str) -> bool {
    let ids = Id::from_id(&effect.id).zip(Id::from_id(other));
    let next = outcome.next_experiment.as_ref();
    ids.is_some_and(|(id, other)| are_one_model(id, other))
        || next.is_some_and(|next| {
            next.candidates.first() == Some(&effect.id)
                && next.same_law.iter().any(|same| same == other)
        })
}

/// What the logs cannot tell from an effect; of many their number.
fn equivalent(effect: &FoundEffect) -> Vec<String> {
    match effect.equivalent.len() {
        count if count > LISTED => vec![format!("one of {count} others")],
        _ => effect.equivalent.clone(),
    }
}

/// Which numbers of the machine file the logs have otherwise, although `[fit]` leaves them out, or by more than the tolerance
/// that the file gives them.
fn off(outcome: &Outcome) -> Option<String> {
    let freed = outcome.fit.iter().filter(|parameter| parameter.freed);
    let (near, far): (Vec<_>, Vec<_>) =
        freed.partition(|parameter| parameter.is_within_tolerance());
    let names = |parameters: &[&FittedParameter]| {
        let names: Vec<&str> = parameters.iter().map(|it| it.name.as_str()).collect();
        listed(&names)
    };
    let wrong = match far.len() {
        0 => None,
        1 => Some(format!("the declared {} is wrong", names(&far))),
        _ => Some(format!("the declared {} are wrong", names(&far))),
    };
    let within = match near.len() {
        0 => None,
        1 => Some(format!(
            "{} differs from the declared value, within its tolerance",
            names(&near)
        )),
        _ => Some(format!(
            "{} differ from the declared values, within their tolerances",
            names(&near)
        )),
    };
    let all = wrong.into_iter().chain(within).chain(beyond(&outcome.fit));
    let all: Vec<String> = all.collect();
    (!all.is_empty()).then(|| all.join("; "))
}

/// Which numbers of `[fit]` are surely farther off than the tolerance that the machine file gives them.
fn beyond(fit: &[FittedParameter]) -> Option<String> {
    let fitted = fit.iter().filter(|parameter| !parameter.freed);
    let beyond: Vec<&FittedParameter> = fitted
        .filter(|parameter| parameter.is_surely_beyond_tolerance())
        .collect();
    let share = |parameter: &FittedParameter| parameter.fitted / parameter.declared - 1.0;
    let named = beyond
        .iter()
        .map(|parameter| format!("{} ({:+.0} %)", parameter.name, 100.0 * share(parameter)));
    let named: Vec<String> = named.collect();
    let are = match named.len() {
        0 => return None,
        1 => "is farther from the declared value than its tolerance",
        _ => "are farther from the declared values than their tolerances",
    };
    Some(format!("{} {are}", listed(&named)))
}

/// Why nothing is said to be complete although nothing was found.
fn nothing_proven(outcome: &Outcome) -> String {
    let Some(residual) = &outcome.residual else {
        return "nothing is proven".to_owned();
    };
    if residual.unconfirmed {
        let window = outcome.errors.train.before.window_s;
        let time = |seconds: f64| Scale::of("s", [seconds]).quantity(seconds);
        return format!(
            "nothing is proven: something seems to be missing where the model predicts {} ahead, but not where it \
             predicts {} ahead",
            time(window),
            time(0.5 * window)
        );
    }
    match residual.implausible {
        Some(number) => format!(
            "nothing is proven: to follow the logs, `{number}` had to go farther than the machine file lets it be \
             off, and no effect was found that explains why"
        ),
        None if residual.times_floor() <= UNEXPLAINED => {
            "nothing is proven: the training data show no missing effect".to_owned()
        }
        None => format!(
            "nothing is proven: the model is off by {} times the sensor's noise, and nothing that was tried predicts the \
             rest of it",
            significant(residual.times_floor(), 2)
        ),
    }
}

/// The effects that the machine file declares, by their names.
fn declared(report: &Report) -> Vec<&str> {
    report.declared.iter().map(|effect| &*effect.id).collect()
}

/// What the machine file declares and no fit changes.
fn presumed(report: &Report) -> Option<String> {
    let declared = declared(report);
    (!declared.is_empty()).then(|| {
        format!(
            "No fit changes what the machine file declares of {}; what is not in `declared_effects` is looked for.",
            listed(&declared)
        )
    })
}

/// The declared numbers that the sizes of effects are proportional to and no fit has moved, and whether their intervals hold what
/// these may be off by.
fn scale_of_torques(report: &Report) -> Option<String> {
    let mut presumed = report.outcome.effects.iter().map(|effect| &effect.presumes);
    let presumed = presumed.find(|numbers| !numbers.is_empty())?;
    let is_within = |number: &String| report.held_within.contains(&number.as_str());
    let interval = if presumed.iter().all(is_within) {
        "; the intervals include their tolerances"
    } else {
        "; the intervals do not include that"
    };
    let words = presumed.iter().map(|number| number.replace('_', " "));
    Some(format!(
        "If the declared {} is wrong, each size is wrong by as much{interval}.",
        any_of(&words.collect::<Vec<_>>())
    ))
}

/// How sure it is, and what else it could be.
fn certainty(report: &Report) -> String {
    let outcome = &report.outcome;
    match outcome.verdict {
        Verdict::LogAndMachineDisagree => {
            let first = outcome.disagreement.first();
            first.map_or(String::new(), |found| {
                format!("Evidence: {}.", found.evidence)
            })
        }
        Verdict::NoMissingEffect | Verdict::NothingProven => {
            let next = outcome.next_experiment.as_ref();
            let doubt = next
                .map(|next| next.doubt())
                .filter(|doubt| !doubt.is_empty());
            let mut sentences = Vec::from_iter(presumed(report));
            // Where there is room for one sentence the last one stays.
            match nearest(outcome) {
                Some(nearest) => sentences.extend(doubt.into_iter().chain([refused(nearest)])),
                None => sentences.extend([NOTHING_HELPS.to_owned()].into_iter().chain(doubt)),
            }
            sentences.join(" ")
        }
        Verdict::EffectsFound | Verdict::UnknownEffect => {
            let mut sentences = Vec::from_iter(presumed(report));
            sentences.extend(scale_of_torques(report));
            sentences.extend(chance(&outcome.effects));
            sentences.extend(alternatives(outcome, &report.coordinate));
            if outcome.verdict == Verdict::UnknownEffect {
                sentences.push(
                    "No effect of the catalogue follows the logs as well as the learned law."
                        .to_owned(),
                );
            }
            sentences.join(" ")
        }
    }
}

/// How many times what a sensor leaves what was found does, where that is more than a sensor makes.
fn times_left(outcome: &Outcome) -> Option<f64> {
    let times = outcome.residual.as_ref()?.times_floor();
    let found = matches!(
        outcome.verdict,
        Verdict::EffectsFound | Verdict::UnknownEffect
    );
    (found && times > UNEXPLAINED).then_some(times)
}

/// The same in words.
fn left(outcome: &Outcome) -> Option<String> {
    let times = significant(times_left(outcome)?, 2);
    Some(format!(
        "With that the model is still off by {times} times the sensor's noise: something more is missing, or something else than this."
    ))
}

/// The logs' length, where nothing was found in them and they are short.
fn short_logs(outcome: &Outcome) -> Option<ShortLogs> {
    let found_nothing = matches!(
        outcome.verdict,
        Verdict::NoMissingEffect | Verdict::NothingProven
    );
    outcome.residual?.short.filter(|_| found_nothing)
}

/// That logs differ, and in which numbers: what was found is of all training logs together, and may only make up for that.
fn differs(report: &Report) -> Option<String> {
    let logs = &report.outcome.between_logs;
    let mut numbers: Vec<String> = Vec::new();
    for number in logs.iter().flat_map(|log| &log.numbers) {
        let words = number_in_words(&number.name, &number.unit);
        if !numbers.contains(&words) {
            numbers.push(words);
        }
    }
    let who = between_logs::who_differs(logs, report.train.len());
    (!who.is_empty()).then(|| capitalised(&format!("{} in {}.", listed(&who), listed(&numbers))))
}

/// That the model does not follow the validation logs as it does the training logs, where no number in which they differ says why.
fn lost(report: &Report) -> Option<String> {
    let outcome = &report.outcome;
    let there = outcome.errors.validate.as_ref()?.after.position_rms;
    let here = outcome.errors.train.after.position_rms;
    if !outcome.is_lost() {
        return None;
    }
    let quantity = |error: f64| Scale::of(report.coordinate.as_str(), [error]).quantity(error);
    Some(format!(
        "But the model does not follow the validation data: it is off by {} rms there, and by {} on the training data.",
        quantity(there),
        quantity(here)
    ))
}

/// Which fitted numbers stopped at the limit of what the machine file lets them be off: they are no estimates.
fn at_limit(outcome: &Outcome) -> Option<String> {
    let at_limit = outcome.fit.iter().filter(|number| number.at_limit);
    let (names, limits): (Vec<String>, Vec<String>) = at_limit
        .map(|number| {
            let limit = format!("{} {}", significant(number.fitted, 2), number.unit);
            (spoken(&number.name), limit)
        })
        .unzip();
    let (verb, is_limit) = match names.len() {
        0 => return None,
        1 => ("is", "is only the limit"),
        _ => ("are", "are only the limits"),
    };
    Some(format!(
        "The logs do not show how large {} {verb}: {} {is_limit} that the fit was allowed to reach.",
        listed(&names),
        listed(&limits)
    ))
}

/// What the sentence begins with that says how sure it is; it stays however little room there is for others.
const CHANCE: &str = "Chance alone would show";

/// How often chance alone would show what was found, of the effect that is the least sure.
fn chance(effects: &[FoundEffect]) -> Option<String> {
    let least = effects
        .iter()
        .max_by(|a, b| a.p_value.total_cmp(&b.p_value))?;
    let what = if effects.len() > 1 {
        format!("{}, the least sure of them,", least.id)
    } else {
        "this".to_owned()
    };
    Some(format!("{CHANCE} {what} {}.", once_in(least.p_value)))
}

/// A probability as a frequency.
fn once_in(p: f64) -> String {
    if p < LEAST_CHANCE {
        return "less than once in a million logs".to_owned();
    }
    let times = 1.0 / p;
    // Two digits are as many as a p-value has.
    let step = 10f64.powf(times.log10().floor() - 1.0).max(1.0);
    let digits = format!("{:.0}", (times / step).round() * step);
    let mut grouped = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    format!("once in {grouped} logs")
}

/// What else may be true.
fn alternatives(outcome: &Outcome, coordinate: &str) -> Option<String> {
    let summary = |id: Id| id.description().summary.of(coordinate == "rad");
    let mut sentences: Vec<String> = outcome
        .effects
        .iter()
        // One is said in words too.
        .filter(|effect| match effect.equivalent.len() {
            0 => false,
            1 => true,
            _ => !is_in_finding(outcome, effect),
        })
        .map(|effect| {
            // One can be said in words too; of several the names are enough.
            let others = match effect.equivalent.as_slice() {
                [one] => match Id::from_id(one) {
                    Some(id) => format!("{one} ({})", summary(id)),
                    None => one.clone(),
                },
                several if several.len() <= LISTED => listed(several),
                several => format!(
                    "{} and {} more",
                    several[..NAMED].join(", "),
                    several.len() - NAMED
                ),
            };
            format!("The logs cannot tell {} from {others}.", effect.id)
        })
        .collect();
    if let Some(next) = &outcome.next_experiment {
        sentences.extend(next.rivals());
    }
    (!sentences.is_empty()).then(|| sentences.join(" "))
}

/// The refused candidate that came nearest to being found, if any came near.
fn nearest(outcome: &Outcome) -> Option<&Candidate> {
    let ratio = |candidate: &&Candidate| candidate.held_out_ratio.unwrap_or(f64::INFINITY);
    let refused = outcome.candidates.iter();
    let refused = refused.filter(|candidate| !candidate.accepted);
    let best = refused.min_by(|a, b| ratio(a).total_cmp(&ratio(b)));
    best.filter(|best| ratio(best) < NEARLY)
}

/// What came nearest to being found, and why it was refused.
fn refused(nearest: &Candidate) -> String {
    format!(
        "Of all that was tried and not taken, {} helps most: the error on data left out of the fit is {:.0} % smaller with it, but {}.",
        nearest.words,
        100.0 * (1.0 - nearest.held_out_ratio.unwrap_or(f64::NAN)),
        nearest.reason
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_probability_is_said_as_a_frequency() {
        assert_eq!(once_in(0.0042), "once in 240 logs");
        assert_eq!(once_in(0.04), "once in 25 logs");
        assert_eq!(once_in(2.5e-6), "once in 400,000 logs");
        assert_eq!(once_in(9e-7), "less than once in a million logs");
    }
}
