//! The result as a terminal shows it: plain text, at most [`WIDTH`] columns. The answer for people comes first;
//! the tables of errors, effects, fitted numbers and candidates where they are asked for.

use model_core::effect::{Bounds, Id};
use model_core::gap::verdict::Verdict;

use super::disagreement::words::spoken;
use super::effect_words::declared_by;
use super::headline;
use super::outcome::{
    Candidate, ErrorSet, Errors, Estimate, FittedParameter, FoundEffect, LearnedLaw, Outcome,
    Report, Resampled, Stages,
};
pub use super::terminal::WIDTH;
use super::terminal::{Page, Style, printable};
use crate::log::counted;
use crate::quantity::{
    Scale, change, estimate, given, prefixed_estimate, probability, significant,
};

/// Ratio of a fitted to a declared number from which on the reader is told that units may be wrong.
const FAR_OFF: f64 = 100.0;

/// What is said of a number that was fitted although `[fit]` leaves it out.
pub(super) const FREED: &str = "[fit] does not name it; it was fitted because no effect follows the logs better than this value";

/// What is said of a number whose fit stopped at the limit of what the machine file lets it be off.
pub(super) const AT_LIMIT: &str = "stopped at its limit";

/// Refused candidates that a round lists even though they were not refitted.
const RUNNERS_UP: usize = 5;

/// How much of the result is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detail<'h> {
    /// The answer for people, in at most [`LINES`](super::headline::LINES) lines; `hint` is the last of them.
    Brief {
        /// Where the numbers are, in one line; none where that is said elsewhere.
        hint: Option<&'h str>,
    },
    /// That, and every number.
    Verbose,
}

/// The result, ready to print; it ends with a line feed. `colour` adds ANSI escapes and belongs to
/// a terminal: a pipe gets the same text without.
pub fn render(report: &Report, colour: bool, detail: Detail<'_>) -> String {
    let mut page = Page {
        text: String::new(),
        colour,
    };
    let hint = match detail {
        Detail::Brief { hint } => hint,
        Detail::Verbose => None,
    };
    for (line, style) in headline::lines(report, hint.iter().count()) {
        page.line(&line, style);
    }
    if let Some(hint) = hint {
        page.line(hint, Style::Faint);
    }
    if detail == Detail::Verbose {
        numbers(&mut page, report);
    }
    page.text
}

/// Every number behind the answer.
fn numbers(page: &mut Page, report: &Report) {
    let outcome = &report.outcome;
    for log in &outcome.resampled {
        page.line("", Style::Plain);
        page.wrapped(&resampled_line(log, &report.coordinate), 0, Style::Warning);
    }
    if outcome.verdict == Verdict::LogAndMachineDisagree {
        disagreement(page, outcome);
        return;
    }
    errors(page, &outcome.errors, &report.coordinate);
    if let Some(costs) = free_run_costs(outcome, &report.coordinate) {
        page.wrapped(&costs, 0, Style::Faint);
    }
    effects(page, outcome);
    experiment(page, report);
    parameters(page, outcome);
    selection(page, &outcome.candidates);
    page.line("", Style::Plain);
    page.wrapped(&whiteness(outcome), 0, Style::Faint);
    page.wrapped(&cost(outcome), 0, Style::Faint);
}

/// What logs and machine file disagree in. A remedy is to be copied, and so is not broken into lines.
fn disagreement(page: &mut Page, outcome: &Outcome) {
    for found in &outcome.disagreement {
        page.line("", Style::Plain);
        for (place, line) in found.lines().iter().enumerate() {
            match place {
                0 => page.wrapped(&printable(line), 0, Style::Strong),
                1 => page.wrapped(&printable(line), 2, Style::Plain),
                _ => page.line(&printable(line), Style::Plain),
            }
        }
    }
}

/// What its values rest on.
pub(super) fn presumed(effect: &FoundEffect) -> Option<String> {
    (!effect.presumes.is_empty()).then(|| {
        format!(
            "The values hold for the declared {}; others explain less",
            effect.presumes.join(" or ")
        )
    })
}

/// Whether the model after the tracing differs from the one before.
pub(super) fn is_extended(outcome: &Outcome) -> bool {
    matches!(
        outcome.verdict,
        Verdict::EffectsFound | Verdict::UnknownEffect
    ) || outcome.freed().next().is_some()
}

/// One kind of error, in one unit, on both sets of logs.
pub(super) struct ErrorRow {
    /// What it measures.
    pub label: &'static str,
    /// The unit of all its numbers.
    pub unit: String,
    /// On the training logs.
    pub train: ErrorCells,
    /// On the validation logs.
    pub validate: Option<ErrorCells>,
}

/// One kind of error of the three models on one set of logs.
pub(super) struct ErrorCells {
    /// The machine file as it stands, its parameters refitted, with the effects.
    pub models: [String; 3],
    /// `after / before`
    pub ratio: String,
}

/// The error table, kind by kind. Current has a row where it was measured.
pub(super) fn error_rows(errors: &Errors, coordinate: &str) -> Vec<ErrorRow> {
    type Pick = fn(&ErrorSet) -> Option<f64>;
    let kinds: [(&str, Option<&str>, Pick); 6] = [
        ("position rms", Some(coordinate), |e| Some(e.position_rms)),
        ("position max", Some(coordinate), |e| Some(e.position_max)),
        ("position NRMSE", None, |e| Some(e.position_nrmse)),
        ("current rms", Some("A"), |e| e.current_rms),
        ("torque residual", None, |e| Some(e.torque_rel)),
        ("free run rms", Some(coordinate), |e| Some(e.free_run_rms)),
    ];
    let sets = || std::iter::once(&errors.train).chain(&errors.validate);
    kinds
        .into_iter()
        .filter_map(|(label, unit, pick)| {
            let values: Vec<f64> = sets().flat_map(models).filter_map(pick).collect();
            if values.is_empty() {
                return None;
            }
            let scale = unit.map_or_else(Scale::percent, |unit| Scale::of(unit, values));
            let cells = |stages: &Stages| {
                let [_, before, after] = models(stages).map(pick);
                ErrorCells {
                    models: models(stages)
                        .map(|set| pick(set).map_or("–".into(), |value| scale.number(value))),
                    ratio: before
                        .zip(after)
                        .map(|(before, after)| after / before)
                        .filter(|ratio| ratio.is_finite())
                        .map_or("–".into(), narrow_ratio),
                }
            };
            Some(ErrorRow {
                label,
                train: cells(&errors.train),
                validate: errors.validate.as_ref().map(cells),
                unit: scale.unit,
            })
        })
        .collect()
}

fn models(stages: &Stages) -> [&ErrorSet; 3] {
    [&stages.declared, &stages.before, &stages.after]
}

/// What the columns and rows of the error table mean.
pub(super) fn error_legend(errors: &Errors) -> [(&'static str, String); 7] {
    let window = errors.train.before.window_s;
    let window = Scale::of("s", [window]).quantity(window);
    [
        ("declared", "the machine file as it stands".into()),
        (
            "before",
            "its fit parameters re-estimated on the training data".into(),
        ),
        ("after", "with what was found, everything refitted".into()),
        ("ratio", "after / before".into()),
        (
            "position and current",
            format!(
                "the model runs for {window}, again and again, each time started from what was measured; NRMSE is the error \
                 divided by the standard deviation of the position"
            ),
        ),
        (
            "torque residual",
            "the share of the torque that the model does not explain".into(),
        ),
        (
            "free run",
            "the model runs through the whole log from one start".into(),
        ),
    ]
}

/// A number of a machine file, or the offset, as a sentence has it.
pub(super) fn number_in_words(name: &str, unit: &str) -> String {
    match (name, unit) {
        ("offset_torque", "N") => "offset force".to_owned(),
        (name, _) => spoken(name),
    }
}

/// What little changes move a free run by: where that is as much as its error, the error says nothing of the model.
pub(super) fn free_run_costs(outcome: &Outcome, coordinate: &str) -> Option<String> {
    let costs = outcome.free_run_costs.iter();
    let costs = costs.map(|cost| {
        let change = Scale::of(&cost.unit, [cost.change]).quantity(cost.change);
        let moved = Scale::of(coordinate, [cost.position_rms]).quantity(cost.position_rms);
        let name = number_in_words(&cost.name, &cost.unit);
        format!("{change} more {name} by {moved} rms")
    });
    let costs: Vec<String> = costs.collect();
    (!costs.is_empty()).then(|| {
        format!(
            "How far a small change moves a free run: {}.",
            costs.join(", ")
        )
    })
}

/// What the test for whiteness says.
pub(super) fn whiteness(outcome: &Outcome) -> String {
    let whiteness = &outcome.whiteness;
    format!(
        "Whether the error before effects is mere noise: Ljung–Box {} per degree of freedom over {} lags (noise: about 1; \
         more says that something is missing), p {}. Correlation of that error with the input {:+.2}, with the velocity \
         {:+.2}, with the direction of motion {:+.2}, with the input squared {:+.2}.",
        significant(whiteness.ljung_box, 3),
        whiteness.lags,
        probability(whiteness.p_value),
        whiteness.correlations.input,
        whiteness.correlations.velocity,
        whiteness.correlations.direction,
        whiteness.correlations.input_squared
    )
}

/// What putting a log on a grid has changed.
pub(crate) fn resampled_line(log: &Resampled, coordinate: &str) -> String {
    let change = &log.change;
    let period = Scale::of("s", [log.period_s]).quantity(log.period_s);
    let percent = Scale::percent();
    let error = Scale::of(coordinate, [change.position_error]).quantity(change.position_error);
    format!(
        "{} was resampled: its {} rows were up to {} and rms {} of a period of {period} away from the \
         samples; filled in where rows are missing: {}; merged: {}. That puts an error of some {error} rms into the \
         position.",
        printable(&log.log),
        change.rows,
        percent.quantity(change.displacement_max),
        percent.quantity(change.displacement_rms),
        counted(change.filled, "sample"),
        counted(change.merged, "row"),
    )
}

/// A parameter of an effect with its deviation. One that cannot be negative and whose deviation is as large as it is has
/// any value from nothing on for the log.
pub(super) fn effect_parameter(effect: &FoundEffect, parameter: &Estimate) -> String {
    let known = Id::from_id(&effect.id).map(|id| id.description().parameters);
    let mut known = known.into_iter().flatten();
    let is_size =
        known.any(|known| known.name == parameter.name && matches!(known.bounds, Bounds::Positive));
    if is_size && parameter.std >= parameter.value {
        return "not determined by the log".to_owned();
    }
    prefixed_estimate(parameter.value, parameter.std, &parameter.unit)
}

/// What the run cost.
pub(super) fn cost(outcome: &Outcome) -> String {
    let cost = &outcome.cost;
    format!(
        "Cost: {} s, {} simulations of the training data ({} samples).",
        significant(cost.seconds, 3),
        cost.simulations,
        cost.samples
    )
}

/// The candidates round by round. In a round: what was taken, what was refitted and refused, the
/// rest; each by falling score.
pub(super) fn rounds(candidates: &[Candidate]) -> Vec<(usize, Vec<&Candidate>)> {
    let mut numbers: Vec<usize> = candidates.iter().map(|c| c.round).collect();
    numbers.sort_unstable();
    numbers.dedup();
    numbers
        .into_iter()
        .map(|number| {
            let mut round: Vec<_> = candidates.iter().filter(|c| c.round == number).collect();
            let class = |c: &Candidate| (!c.accepted, c.held_out_ratio.is_none());
            round.sort_by(|a, b| class(a).cmp(&class(b)).then(b.score.total_cmp(&a.score)));
            (number, round)
        })
        .collect()
}

fn errors(page: &mut Page, errors: &Errors, coordinate: &str) {
    let group = |cells: [&str; 4]| {
        let [declared, before, after, ratio] = cells;
        format!("{declared:>11}{before:>9}{after:>9}{ratio:>8}")
    };
    let heads = group(["declared", "before", "after", "ratio"]);
    let sets = if errors.validate.is_some() { 2 } else { 1 };
    page.section("Errors");
    let mut titles = format!("{:22}{:>37}", "", "on the training data");
    if sets == 2 {
        titles += &format!("{:>37}", "on the validation data");
    }
    page.line(&titles, Style::Faint);
    page.line(&format!("{:22}{}", "", heads.repeat(sets)), Style::Faint);
    for row in error_rows(errors, coordinate) {
        let mut line = format!("{:16}{:6}", row.label, row.unit);
        for cells in std::iter::once(&row.train).chain(&row.validate) {
            let [declared, before, after] = &cells.models;
            line += &group([declared, before, after, &cells.ratio]);
        }
        page.line(&line, Style::Plain);
    }
    let legend = error_legend(errors).map(|(term, meaning)| format!("{term}: {meaning}."));
    page.wrapped(&legend.join(" "), 0, Style::Faint);
}

fn effects(page: &mut Page, outcome: &Outcome) {
    if !outcome.effects.is_empty() {
        page.section("Effects");
    }
    for effect in &outcome.effects {
        page.line(
            &format!(
                "{:30} score {}   identifiability {}   p {}",
                effect.id,
                significant(effect.score, 3),
                significant(effect.identifiability, 3),
                probability(effect.p_value)
            ),
            Style::Good,
        );
        for parameter in &effect.parameters {
            let value = effect_parameter(effect, parameter);
            page.line(&format!("  {:28} {value}", parameter.name), Style::Plain);
        }
        if let Some(law) = &effect.law {
            let words = format!(
                "  the machine's law instead of this formula, a {} over {}:",
                law.acts_as,
                law.laid_over()
            );
            page.line(&words, Style::Plain);
            learned(page, law);
        }
        if !effect.equivalent.is_empty() {
            let others = effect.equivalent.join(", ");
            page.wrapped(
                &format!("  this log cannot tell it from: {others}"),
                4,
                Style::Plain,
            );
        }
        if let Some(presumed) = presumed(effect) {
            page.wrapped(&format!("  {presumed}"), 4, Style::Plain);
        }
        // In one line, to be copied, however long it is.
        page.line(
            &format!("  {:28} {}", "to declare it", effect.declare),
            Style::Plain,
        );
        if let Some(words) = Id::from_id(&effect.id).and_then(declared_by) {
            page.wrapped(&format!("  {:28} where {words}", ""), 31, Style::Faint);
        }
    }
    if let Some(unknown) = &outcome.unknown {
        page.section("Unknown effect");
        page.wrapped(
            &format!(
                "depends on {}: a {} was learned over it",
                unknown.depends_on, unknown.map.acts_as
            ),
            0,
            Style::Warning,
        );
        learned(page, &unknown.map);
    }
}

/// What was learned, point by point.
fn learned(page: &mut Page, map: &LearnedLaw) {
    for (name, unit, values) in [
        (map.laid_over(), &map.at_unit, &map.at),
        (map.acts_as.as_str(), &map.unit, &map.values),
    ] {
        let largest = values
            .iter()
            .fold(0.0, |most: f64, value| most.max(value.abs()));
        let scale = Scale::of(unit, [largest]);
        let mut line = format!("{:20}", format!("{name}, {}", scale.unit));
        for value in values {
            line += &format!(" {:>7}", scale.number(*value));
        }
        page.line(&line, Style::Plain);
    }
}

fn experiment(page: &mut Page, report: &Report) {
    let Some(next) = &report.outcome.next_experiment else {
        return;
    };
    page.section("Next experiment");
    page.wrapped(&next.sentences(&report.coordinate), 0, Style::Plain);
    if let Some(file) = &next.file {
        page.line(&format!("input        {}", printable(file)), Style::Plain);
    }
}

/// A fitted number with its deviation, or why it has none.
pub(super) fn fitted(parameter: &FittedParameter) -> String {
    let (value, unit) = (parameter.fitted, &parameter.unit);
    match parameter.std {
        _ if parameter.at_limit => format!("{} {unit} ({AT_LIMIT})", significant(value, 3)),
        Some(std) => estimate(value, std, unit),
        None => format!("{} {unit} (the logs do not determine it)", given(value)),
    }
}

fn parameters(page: &mut Page, outcome: &Outcome) {
    if outcome.fit.is_empty() {
        return;
    }
    page.section("Fitted parameters");
    for parameter in &outcome.fit {
        let fitted = fitted(parameter);
        let change = change(parameter.declared, parameter.fitted).unwrap_or_default();
        page.line(
            &format!(
                "{:30} {:>12} → {fitted:40} {change:>9}",
                parameter.name,
                given(parameter.declared)
            ),
            Style::Plain,
        );
        if parameter.freed {
            page.wrapped(&format!("  {FREED}"), 4, Style::Warning);
        }
    }
    let far = outcome.fit.iter().filter(|parameter| {
        let ratio = (parameter.fitted / parameter.declared).abs();
        parameter.declared != 0.0 && !(1.0 / FAR_OFF..=FAR_OFF).contains(&ratio) && ratio != 0.0
    });
    for parameter in far {
        page.wrapped(
            &format!(
                "note: the declared and the fitted {} are {:.0} times apart; if the declared one is about right, log and \
                 machine file are in different units (s, rad or m, V or A)",
                parameter.name,
                (parameter.fitted / parameter.declared)
                    .abs()
                    .max((parameter.declared / parameter.fitted).abs())
            ),
            0,
            Style::Plain,
        );
    }
}

/// What the columns of the candidates mean.
pub(super) const SELECTION_LEGEND: &str = "Score: an estimate, made before any fit, of the share of the error that the effect \
    explains and that no fitted number explains; effects with a high score are tried first. Identifiability: the share of what the \
    effect does that no fitted number can do. Held-out ratio: the mean square error with the effect divided by that without it, on \
    data left out of the fit.";

fn selection(page: &mut Page, candidates: &[Candidate]) {
    for (number, round) in rounds(candidates) {
        page.section(&format!("Round {number} of the selection"));
        page.line(
            &format!(
                "{:30} {:>8} {:>16} {:>15} {:>10}",
                "candidate", "score", "identifiability", "held-out ratio", "p"
            ),
            Style::Faint,
        );
        let listed = round
            .iter()
            .filter(|c| c.accepted || c.held_out_ratio.is_some())
            .count()
            .max(RUNNERS_UP)
            .min(round.len());
        let (shown, others) = round.split_at(listed);
        for candidate in shown {
            let ratio = candidate
                .held_out_ratio
                .map_or("–".into(), |r| significant(r, 3));
            let p = candidate.p_value.map_or("–".into(), probability);
            page.line(
                &format!(
                    "{:30} {:>8} {:>16} {ratio:>15} {p:>10}",
                    candidate.id,
                    significant(candidate.score, 3),
                    significant(candidate.identifiability, 3),
                ),
                if candidate.accepted {
                    Style::Good
                } else {
                    Style::Plain
                },
            );
            let decision = if candidate.accepted {
                "taken"
            } else {
                "refused"
            };
            page.wrapped(
                &format!("    {decision}: {}", printable(&candidate.reason)),
                6,
                Style::Faint,
            );
        }
        if let Some(best) = others.first() {
            page.line(
                &format!(
                    "and {} more, none with a score above {}",
                    others.len(),
                    significant(best.score, 3)
                ),
                Style::Faint,
            );
        }
    }
    if !candidates.is_empty() {
        page.wrapped(SELECTION_LEGEND, 0, Style::Faint);
    }
}

/// A ratio in the seven characters that its column has.
fn narrow_ratio(ratio: f64) -> String {
    if ratio < 1e-3 {
        format!("{ratio:.1e}")
    } else {
        significant(ratio, 3)
    }
}
