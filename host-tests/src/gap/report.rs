//! The result as a page: one HTML file that needs nothing beside it, with the evidence drawn.

mod component_figure;
mod experiment;
mod figures;

use std::fmt::Write as _;
use std::io;

use super::component;
use super::effect_words::declared_by;
use super::headline::{Headline, next_sentence};
use super::outcome::{Candidate, ErrorSet, Evidence, FoundEffect, Outcome, Report};
use super::table::{
    ErrorCells, FREED, SELECTION_LEGEND, cost, effect_parameter, error_legend, error_rows, fitted,
    free_run_costs, is_extended, presumed, resampled_line, rounds, whiteness,
};
use crate::page::series::{difference, extent, rms};
use crate::page::{self, escape};
use crate::quantity::{Scale, capitalised, change, given, probability, significant};
use model_core::effect::Id;
use model_core::gap::verdict::Verdict;

/// The page, HTML. It holds its style and its drawings, and asks for no script, font or other file.
///
/// # Errors
/// Those of drawing.
pub fn page(report: &Report) -> io::Result<String> {
    let outcome = &report.outcome;
    let mut body = header(report);
    if outcome.verdict == Verdict::LogAndMachineDisagree {
        body += &disagreement(outcome);
        let title = format!("{}: log and machine file disagree", outcome.machine);
        return Ok(page::page(&title, &body, &[cost(outcome)]));
    }
    body += &errors(report);
    body += &effects(report)?;
    body += &experiment::section(report)?;
    body += &parameters(outcome);
    for (title, note, logs) in [
        (
            "validation",
            "Unseen data: nothing was chosen or fitted on it.",
            &report.validate,
        ),
        (
            "training",
            "The data that the model was fitted to.",
            &report.train,
        ),
    ] {
        if let Some((first, others)) = logs.split_first() {
            body += &log(report, title, note, first, others)?;
        }
    }
    body += &selection(&outcome.candidates);
    let title = format!("{}: missing effects", outcome.machine);
    let resampled = outcome.resampled.iter();
    let mut footer: Vec<String> = resampled
        .map(|log| resampled_line(log, &report.coordinate))
        .collect();
    footer.extend([whiteness(outcome), cost(outcome)]);
    Ok(page::page(&title, &body, &footer))
}

fn header(report: &Report) -> String {
    let outcome = &report.outcome;
    let headline = Headline::on_page(report);
    let (data, stages) = match &outcome.errors.validate {
        Some(validate) => ("unseen data", validate),
        None => ("training data", &outcome.errors.train),
    };
    let figure = |label: &str, unit: Option<&str>, pick: fn(&ErrorSet) -> f64| {
        let (before, after) = (pick(&stages.before), pick(&stages.after));
        let scale = unit.map_or_else(Scale::percent, |unit| Scale::of(unit, [before, after]));
        let numbers = if is_extended(outcome) {
            let change = change(before, after).map_or(String::new(), |c| format!("<em>{c}</em>"));
            format!(
                "<b><s>{}</s> → {} {}</b>{change}",
                scale.number(before),
                scale.number(after),
                scale.unit
            )
        } else {
            format!("<b>{}</b>", scale.quantity(after))
        };
        format!("<li><span>{label}, {data}</span>{numbers}</li>\n")
    };
    let mut text = format!(
        "<header>\n<p class=\"kind\">Missing effects</p>\n<h1>{}</h1>\n<p class=\"finding\">{}</p>\n\
         {}<ul class=\"numbers\">\n",
        escape(&outcome.machine),
        escape(&capitalised(&headline.finding)),
        sentences(&headline),
    );
    text += &figure("Position error rms", Some(&report.coordinate), |e| {
        e.position_rms
    });
    text += &figure("Torque residual", None, |e| e.torque_rel);
    text += &figure("Free run rms", Some(&report.coordinate), |e| e.free_run_rms);
    text + "</ul>\n</header>\n"
}

/// What follows the finding: what it is, how much better, how sure, what next.
fn sentences(headline: &Headline) -> String {
    let mut text = String::new();
    // A string takes everything.
    if !headline.details.is_empty() {
        text += "<ul>\n";
        for (id, sentence) in &headline.details {
            let _ = writeln!(
                text,
                "<li><code>{}</code> {}</li>",
                escape(id),
                escape(sentence)
            );
        }
        text += "</ul>\n";
    }
    for words in [&headline.gain, &headline.certainty] {
        if !words.is_empty() {
            let _ = writeln!(text, "<p>{}</p>", escape(words));
        }
    }
    let (next, copied) = next_sentence(&headline.next);
    let _ = write!(text, "<p>{}", escape(&next));
    for line in copied {
        let _ = write!(text, "<br/><code>{}</code>", escape(line));
    }
    text + "</p>\n"
}

fn disagreement(outcome: &Outcome) -> String {
    let mut text = String::from("<section>\n<h2>What does not fit</h2>\n");
    for found in &outcome.disagreement {
        let _ = write!(
            text,
            "<article class=\"unknown\">\n<h3>{}</h3>\n<p>{}.</p>\n<p><code>{}</code></p>\n</article>\n",
            escape(&found.what),
            escape(&capitalised(&found.evidence)),
            escape(&found.remedy).replace('\n', "<br>"),
        );
    }
    text + "</section>\n"
}

fn errors(report: &Report) -> String {
    let errors = &report.outcome.errors;
    let rows = error_rows(errors, &report.coordinate);
    let sets = if errors.validate.is_some() { 2 } else { 1 };
    let mut text = String::from(
        "<section>\n<h2>Errors</h2>\n<div class=\"wide\"><table>\n<thead>\n<tr><td \
         colspan=\"2\"></td><th colspan=\"4\" class=\"group\">training data</th>",
    );
    if sets == 2 {
        text += "<th colspan=\"4\" class=\"group\">validation data</th>";
    }
    text += "</tr>\n<tr><th>error</th><th>unit</th>";
    text += &"<th class=\"n first\">declared</th><th class=\"n\">before</th><th \
              class=\"n\">after</th><th class=\"n\">ratio</th>"
        .repeat(sets);
    text += "</tr>\n</thead>\n<tbody>\n";
    let cells = |cells: &ErrorCells| {
        let [declared, before, after] = &cells.models;
        format!(
            "<td class=\"n first\">{declared}</td><td class=\"n\">{before}</td><td \
             class=\"n strong\">{after}</td><td class=\"n\">{}</td>",
            cells.ratio
        )
    };
    for row in &rows {
        let _ = write!(
            text,
            "<tr><td>{}</td><td>{}</td>",
            row.label,
            escape(&row.unit)
        );
        text += &cells(&row.train);
        text += &row.validate.as_ref().map(cells).unwrap_or_default();
        text += "</tr>\n";
    }
    text += "</tbody>\n</table></div>\n<p class=\"note\">";
    for (term, meaning) in error_legend(errors) {
        let _ = writeln!(text, "<b>{term}</b>: {}.", escape(&meaning));
    }
    if let Some(costs) = free_run_costs(&report.outcome, &report.coordinate) {
        text += &escape(&costs);
    }
    text + "</p>\n</section>\n"
}

fn effects(report: &Report) -> io::Result<String> {
    let outcome = &report.outcome;
    if outcome.effects.is_empty() && outcome.unknown.is_none() {
        return Ok(String::new());
    }
    let mut text = String::from("<section>\n<h2>What was missing</h2>\n");
    let figure = |id: &str| -> io::Result<String> {
        let Some((log, component)) = report.shown(id) else {
            return Ok(String::new());
        };
        let figure = component_figure::of_effect(report, log, component)?;
        Ok(figure.map_or(String::new(), |figure| figure.html()))
    };
    for effect in &outcome.effects {
        text += &found(effect);
        text += &figure(&effect.id)?;
        if let Some(law) = &effect.law {
            let _ = writeln!(
                text,
                "<p>This formula does not follow it closely. What does was learned from the logs, over the {}:</p>",
                escape(law.laid_over())
            );
            text += &figure(component::LEARNED)?;
        }
    }
    if let Some(unknown) = &outcome.unknown {
        let _ = write!(
            text,
            "<article class=\"unknown\">\n<h3>unknown effect of {}</h3>\n<p>No entry of the \
             catalogue explains it. A {} was learned over this variable.</p>\n</article>\n",
            escape(&unknown.depends_on),
            escape(&unknown.map.acts_as)
        );
        text += &figure(component::LEARNED)?;
    }
    Ok(text + "</section>\n")
}

fn found(effect: &FoundEffect) -> String {
    let mut text = format!(
        "<article>\n<h3>{}</h3>\n<table class=\"narrow\">\n<tbody>\n",
        escape(&effect.id)
    );
    for parameter in &effect.parameters {
        let _ = writeln!(
            text,
            "<tr><td>{}</td><td class=\"strong\">{}</td></tr>",
            escape(&parameter.name),
            escape(&effect_parameter(effect, parameter))
        );
    }
    let _ = write!(
        text,
        "</tbody>\n</table>\n<p>On data left out of the fit the error falls. If the effect took one percent of it or less, \
         chance would make it fall so with p {} (one-sided; ranks by Wilcoxon, and of few stretches their mean by Student). Score \
         {} and identifiability {} were estimated before the fit and say what is tried first; they are explained below.</p>\n",
        escape(&probability(effect.p_value)),
        significant(effect.score, 3),
        significant(effect.identifiability, 3)
    );
    if !effect.equivalent.is_empty() {
        let _ = writeln!(
            text,
            "<p>This log cannot tell it from: <b>{}</b>.</p>",
            escape(&effect.equivalent.join(", "))
        );
    }
    if let Some(presumed) = presumed(effect) {
        let _ = writeln!(text, "<p>{}.</p>", escape(&presumed));
    }
    let _ = writeln!(
        text,
        "<p>To declare it: <code>{}</code></p>",
        escape(&effect.declare)
    );
    if let Some(words) = Id::from_id(&effect.id).and_then(declared_by) {
        let _ = writeln!(text, "<p class=\"note\">Where {}.</p>", escape(words));
    }
    text + "</article>\n"
}

fn parameters(outcome: &Outcome) -> String {
    if outcome.fit.is_empty() {
        return String::new();
    }
    let mut text = String::from(
        "<section>\n<h2>Fitted parameters</h2>\n<div class=\"wide\"><table class=\"short\">\n<thead>\n<tr>\
         <th>parameter</th><th class=\"n\">declared</th><th class=\"n\">fitted ± standard \
         deviation</th><th class=\"n\">change</th></tr>\n</thead>\n<tbody>\n",
    );
    for parameter in &outcome.fit {
        let fitted = fitted(parameter);
        let _ = writeln!(
            text,
            "<tr><td>{}</td><td class=\"n\">{} {}</td><td class=\"n strong\">{}</td><td \
             class=\"n\">{}</td></tr>",
            escape(&parameter.name),
            given(parameter.declared),
            escape(&parameter.unit),
            escape(&fitted),
            change(parameter.declared, parameter.fitted).unwrap_or("–".into())
        );
        if parameter.freed {
            let _ = writeln!(text, "<tr><td></td><td colspan=\"3\">{FREED}</td></tr>");
        }
    }
    text + "</tbody>\n</table></div>\n</section>\n"
}

fn log(
    report: &Report,
    title: &str,
    note: &str,
    first: &Evidence,
    others: &[Evidence],
) -> io::Result<String> {
    let mut text = format!(
        "<section>\n<h2>{} log</h2>\n<p class=\"note\"><code>{}</code> {note}</p>\n",
        capitalised(title),
        escape(&first.label)
    );
    let figures = figures::of_log(report, first)?;
    if figures.is_empty() {
        text += "<p>The log is too short to draw.</p>\n";
    }
    for figure in &figures {
        text += &figure.html();
    }
    if !others.is_empty() {
        text += &all_logs(report, title, std::iter::once(first).chain(others));
    }
    Ok(text + "</section>\n")
}

/// The logs of one kind in numbers.
fn all_logs<'a>(
    report: &Report,
    title: &str,
    logs: impl Iterator<Item = &'a Evidence> + Clone,
) -> String {
    let window_s = report.outcome.errors.train.after.window_s;
    let error = |model: &[f32], log: &Evidence| {
        let errors = difference(model, &log.position);
        let predicted = log.predicted(window_s).into_iter();
        rms(predicted
            .filter_map(|at| errors.get(at).copied())
            .map(f64::from))
    };
    let torque = |residual: &[f32]| rms(residual.iter().map(|&value| f64::from(value)));
    let position = Scale::of(
        &report.coordinate,
        logs.clone().map(|log| error(&log.before, log)),
    );
    let load = Scale::of(
        &report.load_unit,
        logs.clone().map(|log| torque(&log.torque_before)),
    );
    let mut text = format!(
        "<h3>All {title} logs</h3>\n<div class=\"wide\"><table>\n<thead>\n<tr><td \
         colspan=\"3\"></td><th colspan=\"2\" class=\"group\">position error rms, {}</th><th \
         colspan=\"2\" class=\"group\">torque residual rms, {}</th></tr>\n<tr><th>log</th><th \
         class=\"n\">samples</th><th class=\"n\">length, s</th><th class=\"n first\">before</th>\
         <th class=\"n\">after</th><th class=\"n first\">before</th><th class=\"n\">after</th>\
         </tr>\n</thead>\n<tbody>\n",
        escape(&position.unit),
        escape(&load.unit)
    );
    for log in logs {
        let length = extent(log.time.iter().map(|&time| f64::from(time)))
            .map_or(0.0, |(start, end)| end - start);
        let _ = write!(
            text,
            "<tr><td><code>{}</code></td><td class=\"n\">{}</td><td class=\"n\">{}</td>",
            escape(&log.label),
            log.time.len(),
            significant(length, 3)
        );
        for (scale, before, after) in [
            (&position, error(&log.before, log), error(&log.after, log)),
            (&load, torque(&log.torque_before), torque(&log.torque_after)),
        ] {
            let _ = write!(
                text,
                "<td class=\"n first\">{}</td><td class=\"n strong\">{}</td>",
                scale.number(before),
                scale.number(after)
            );
        }
        text += "</tr>\n";
    }
    text + "</tbody>\n</table></div>\n"
}

fn selection(candidates: &[Candidate]) -> String {
    if candidates.is_empty() {
        return String::new();
    }
    let mut text = format!(
        "<section>\n<h2>How it was chosen</h2>\n<p class=\"note\">{SELECTION_LEGEND}</p>\n"
    );
    let scores = candidates.iter().map(|candidate| candidate.score);
    let best = scores.fold(f64::MIN_POSITIVE, f64::max);
    for (number, round) in rounds(candidates) {
        let _ = write!(
            text,
            "<h3>Round {number}</h3>\n<div class=\"wide\"><table class=\"candidates\">\n<thead>\n\
             <tr><th>candidate</th><th>score</th><th class=\"n\">identifiability</th><th \
             class=\"n\">held-out ratio</th><th class=\"n\">p</th><th>decision</th></tr>\n\
             </thead>\n<tbody>\n"
        );
        for candidate in round {
            text += &considered(candidate, best);
        }
        text += "</tbody>\n</table></div>\n";
    }
    text + "</section>\n"
}

/// A row of a round; the bar of its score is relative to the best of all rounds.
fn considered(candidate: &Candidate, best: f64) -> String {
    let class = if candidate.accepted {
        " class=\"taken\""
    } else {
        ""
    };
    let decision = if candidate.accepted {
        "taken"
    } else {
        "refused"
    };
    format!(
        "<tr{class}><td>{}</td><td class=\"score\"><i style=\"width:{:.1}%\"></i>\
         <span>{}</span></td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>\
         <td><b>{decision}</b> {}</td></tr>\n",
        escape(&candidate.id),
        60.0 * (candidate.score / best).clamp(0.0, 1.0),
        significant(candidate.score, 3),
        significant(candidate.identifiability, 3),
        candidate
            .held_out_ratio
            .map_or("–".into(), |r| significant(r, 3)),
        escape(&candidate.p_value.map_or("–".into(), probability)),
        escape(&candidate.reason),
    )
}
