//! What was found beside the effects of the catalogue, in sentences.

use model_core::effect::Id;
use model_core::gap::criterion::GOOD_SENSOR;

use crate::data_sheet::WITHIN;
use crate::gap::answer::listed;
use crate::gap::between_logs;
use crate::gap::component::LEARNED;
use crate::gap::effect_words::as_inductance;
use crate::gap::outcome::{Estimate, LearnedLaw, NumberDifference, Report};
use crate::gap::table::number_in_words;
use crate::quantity::{Scale, capitalised, change, estimate, prefixed_estimate, significant};

/// What was found beside the effects of the catalogue: wrong numbers, and a learned law.
pub(super) fn learned(report: &Report) -> Vec<(String, String)> {
    let outcome = &report.outcome;
    let freed = outcome.fit.iter().filter(|parameter| parameter.freed);
    let mut found: Vec<(String, String)> = freed
        .map(|parameter| {
            let unit = &parameter.unit;
            let tolerance = parameter.tolerance.map_or(String::new(), |tolerance| {
                format!(" {WITHIN}{} %", significant(100.0 * tolerance, 2))
            });
            let change = change(parameter.declared, parameter.fitted);
            let sentence = format!(
                "The machine file has {} {unit}{tolerance}, the logs ask for {} {unit}{}.",
                significant(parameter.declared, 3),
                significant(parameter.fitted, 3),
                change.map_or(String::new(), |change| format!(" ({change})"))
            );
            (parameter.name.clone(), sentence)
        })
        .collect();
    let ends = report.shown(LEARNED).and_then(|(_, law)| law.ends());
    for effect in &outcome.effects {
        if let Some(law) = &effect.law {
            let sentence = format!(
                "The formula does not follow it closely; learned from the logs: {}.",
                law_in_words(law, ends)
            );
            found.push((format!("{} over {}", effect.id, law.over), sentence));
        }
    }
    if let Some(unknown) = &outcome.unknown {
        let sentence = format!(
            "{}, learned from the logs.",
            capitalised(&law_in_words(&unknown.map, ends))
        );
        found.push((
            format!("unknown effect of {}", unknown.depends_on),
            sentence,
        ));
    }
    found
}

/// A learned law: how large it is, over what, and where it is largest, between these ends of what the data have of its variable.
fn law_in_words(law: &LearnedLaw, ends: Option<(f64, f64)>) -> String {
    let (at, values) = match ends {
        Some(ends) => law.within(ends),
        None => (law.at.clone(), law.values.clone()),
    };
    let range = |values: &[f64], unit: &str| {
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let scale = Scale::of(unit, [low, high]);
        format!("{} to {}", scale.number(low), scale.quantity(high))
    };
    let knots = at.iter().zip(&values);
    let most = knots.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    let most = most.map_or(String::new(), |(&at, _)| {
        format!(", most at {}", Scale::of(&law.at_unit, [at]).quantity(at))
    });
    format!(
        "a {} that depends on the {}: it is {} where that is {}{most}",
        law.acts_as,
        law.laid_over(),
        range(&values, &law.unit),
        range(&at, &law.at_unit),
    )
}

/// What logs have otherwise than the training logs, log by log.
pub(super) fn between_logs(report: &Report) -> Vec<(String, String)> {
    let of_log = report.outcome.between_logs.iter().map(|log| {
        let each: Vec<String> = log.numbers.iter().map(difference_in_words).collect();
        let scale = Scale::of(&report.coordinate, [log.position_rms]);
        // The numbers that a training log is held against are fitted to it too.
        let others = if log.trained_on {
            "all training logs together"
        } else {
            "the training logs"
        };
        let mut sentence = format!(
            "Against {others} this log has {}: with that the position error on it is {} rms, not {}.",
            listed(&each),
            scale.quantity(log.position_rms_with),
            scale.quantity(log.position_rms),
        );
        if log.numbers.iter().any(|it| between_logs::stays(&it.name)) {
            sentence += " See that it is of the same machine, under the same load and supply.";
        }
        (log.log.clone(), sentence)
    });
    of_log.collect()
}

/// One of them, such as a friction 2.9 ± 0.1 % higher.
fn difference_in_words(difference: &NumberDifference) -> String {
    let name = number_in_words(&difference.name, &difference.unit);
    let (size, std) = (difference.difference.abs(), difference.std);
    let side = if difference.difference > 0.0 {
        "higher"
    } else {
        "lower"
    };
    if difference.name == Id::OffsetTorque.description().id {
        let size = prefixed_estimate(size, std, &difference.unit);
        return format!("{} that is {size} {side}", with_article(&name));
    }
    let share = 100.0 / difference.trained;
    let percent = estimate(share * size, share * std, "%");
    format!("{} that is {percent} {side}", with_article(&name))
}

/// A noun with the article that its first letter asks for.
fn with_article(noun: &str) -> String {
    let article = if noun.starts_with(['a', 'e', 'i', 'o', 'u']) {
        "an"
    } else {
        "a"
    };
    format!("{article} {noun}")
}

/// Whether the log has its input late, if that is sure and more than the timing of a good logger.
pub(super) fn late_input(report: &Report) -> Option<(String, String)> {
    let lead = report.outcome.input_lead.as_ref()?;
    let step = row_period(report)?;
    if lead.value <= (2.0 * lead.std).max(GOOD_SENSOR * step) {
        return None;
    }
    let late = Scale::of(&lead.unit, [lead.value]).quantity(lead.value);
    let rows = significant(lead.value / step, 2);
    let mut sentence = format!(
        "The log has each input {late} late, {rows} of a row: it acted before the row that holds it. The model is given it \
         that much earlier."
    );
    // No more than a row is looked for.
    if lead.value + 2.0 * lead.std >= step {
        sentence +=
            " It may be later still: see in which row your logger writes what the drive is told.";
    }
    Some(("input".to_owned(), sentence))
}

/// Seconds from one row to the next.
fn row_period(report: &Report) -> Option<f64> {
    let log = report.train.first()?;
    log.time.get(1).map(|&step| f64::from(step))
}

/// How the log's current errs, by those of its numbers that are surely not a good sensor's.
pub(super) fn current_sensor(report: &Report) -> Option<(String, String)> {
    let outcome = &report.outcome;
    let [gain, offset, lag] = &outcome.current_sensor[..] else {
        return None;
    };
    let is_sure = |number: &Estimate, good: f64| (number.value - good).abs() > 2.0 * number.std;
    let quantity = |value: f64, unit: &str| Scale::of(unit, [value]).quantity(value);
    let mut errs = Vec::new();
    let times = significant(gain.value, 3);
    // What rounds to 1 is nothing to tell, however sure it is.
    if is_sure(gain, 1.0) && times != significant(1.0, 3) {
        let mut said = format!("is {times} times what flows");
        if !outcome.fit.iter().any(|number| number.name == "resistance") {
            // The same voltage drops over both, and inertia and friction are fitted to the torque of either.
            said += &format!(
                " (or the resistance is the declared one over {times}, and inertia and friction are {times} times the \
                 fitted ones)"
            );
        }
        errs.push(said);
    }
    if is_sure(offset, 0.0) {
        let size = quantity(offset.value.abs(), &offset.unit);
        let side = if offset.value > 0.0 { "high" } else { "low" };
        errs.push(format!("reads {size} too {side}"));
    }
    // The input is held from row to row, so a current without inductance is that of half a row before when a row begins; one
    // with inductance is that much later anyhow.
    let winding = lag.value + 0.5 * row_period(report).unwrap_or(0.0);
    let is_late = is_sure(lag, 0.0);
    if is_late {
        errs.push(format!("comes {} late", quantity(lag.value, &lag.unit)));
    }
    let errs: Vec<&str> = errs.iter().map(String::as_str).collect();
    (!errs.is_empty()).then(|| {
        let mut sentence = format!("The current that the log holds {}.", listed(&errs));
        if let Some(resistance) = report.without_inductance.filter(|_| is_late) {
            sentence += &format!(
                " Most likely that is the winding's inductance, which the machine file neglects: {}.",
                as_inductance(winding, resistance)
            );
        }
        ("current sensor".to_owned(), sentence)
    })
}
