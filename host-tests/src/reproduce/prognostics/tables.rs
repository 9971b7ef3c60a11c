//! The results as tables and as entries of the JSON.

use super::campaign::{Case, Spread};
use super::detection::{CONFIDENCE, CONTENT, FAILURE, Life, SCATTER};
use super::methods::{self, Method};
use super::stand::{Input, LEVELS};
use super::statistics::quantile;
use super::{PAPER, PAPER_ERROR, PAPER_TRUTH, Results};
use crate::cells::{Cells, render, row};
use crate::reproduce::{Entry, entry};

/// Shares of the time from alert to failure at which the prediction is judged.
const LIFE_SHARES: [f64; 3] = [0.25, 0.5, 0.75];

fn per_cent(share: f64) -> String {
    format!("{:.2} %", 100.0 * share)
}

fn spread(errors: &Spread) -> String {
    let [median, most, worst] =
        [errors.median, errors.most, errors.worst].map(|share| format!("{:.2}", 100.0 * share));
    format!("{median} / {most} / {worst} %")
}

/// The paper's case.
pub(super) fn paper_cells(results: &Results) -> Cells {
    let case = &results.case;
    let line = |name: &str, found: f64, evaluations: String| {
        vec![
            name.to_owned(),
            format!("{found:.4} N·m"),
            per_cent(found / PAPER_TRUTH - 1.0),
            evaluations,
        ]
    };
    let ours = |name: &str, it: &super::Estimate| {
        line(
            name,
            it.levels.coulomb.into(),
            format!("{} + {}", it.annealing_evaluations, it.polish_evaluations),
        )
    };
    vec![
        row(["friction of 0.779 N·m", "found", "error", "evaluations"]),
        line("paper", PAPER, "–".to_owned()),
        line(
            "annealing alone, in windows",
            case.estimate.annealed.coulomb.into(),
            case.estimate.annealing_evaluations.to_string(),
        ),
        ours("polished by golden section", &case.estimate),
        ours("the same in a free run, the paper's", &case.free_run),
    ]
}

/// The settings of the annealing.
pub(super) fn setting_cells(results: &Results) -> Cells {
    let mut rows = vec![row([
        "annealing alone, on the paper's case",
        "windows",
        "free run",
        "evaluations",
        "accepted",
        "re-annealed",
    ])];
    rows.extend(results.settings.iter().map(|it| {
        vec![
            it.name.to_owned(),
            spread(&it.windows),
            spread(&it.free_run),
            it.evaluations.to_string(),
            format!("{:.0}", it.accepted),
            format!("{:.1}", it.reannealings),
        ]
    }));
    rows
}

/// What the campaign presumes.
pub(super) fn presumption_cells(results: &Results) -> Cells {
    let mut rows = vec![row(["sweep, every level", "logs", "bias", "error"])];
    rows.extend(results.presumptions.iter().map(|it| {
        vec![
            it.condition.name().to_owned(),
            it.logs.to_string(),
            format!("{:+.2} %", 100.0 * it.bias),
            spread(&it.errors),
        ]
    }));
    rows
}

fn errors_of(cases: &[Case], of: impl Fn(&Case) -> bool) -> [Spread; 3] {
    let chosen: Vec<&Case> = cases.iter().filter(|case| of(case)).collect();
    [
        Spread::of(chosen.iter().map(|case| case.error())),
        Spread::of(chosen.iter().map(|case| case.separate_errors().0)),
        Spread::of(chosen.iter().map(|case| case.separate_errors().1)),
    ]
}

fn campaign_row(name: String, cases: &[Case], of: impl Fn(&Case) -> bool) -> Vec<String> {
    let [one, coulomb, breakaway] = errors_of(cases, of);
    vec![name, spread(&one), spread(&coulomb), spread(&breakaway)]
}

/// The campaign by inputs.
pub(super) fn input_cells(cases: &[Case]) -> Cells {
    let mut rows = vec![row([
        "input",
        "one number",
        "two: Coulomb",
        "two: breakaway",
    ])];
    rows.extend(
        Input::ALL
            .iter()
            .map(|&input| campaign_row(input.name().to_owned(), cases, |case| case.input == input)),
    );
    rows
}

/// The campaign by levels, sweeps alone.
pub(super) fn level_cells(cases: &[Case]) -> Cells {
    let mut rows = vec![row([
        "sweep, N·m",
        "one number",
        "two: Coulomb",
        "two: breakaway",
    ])];
    rows.extend(LEVELS.iter().enumerate().map(|(level, truth)| {
        campaign_row(format!("{truth:.3}"), cases, |case| {
            case.input == Input::Sweep && case.level == level
        })
    }));
    rows
}

/// What a method replays the log in.
fn replay(it: &methods::Result) -> &'static str {
    match (it.window, it.method) {
        (Some(_), _) => "windows",
        (None, Method::RecursiveLeastSquares) => "none",
        (None, _) => "free run",
    }
}

/// The methods.
pub(super) fn method_cells(results: &Results) -> Cells {
    let mut rows = vec![row([
        "method",
        "replay",
        "numbers",
        "Coulomb",
        "breakaway",
        "failed",
        "impossible",
        "evaluations",
    ])];
    rows.extend(results.methods.iter().map(|it| {
        vec![
            it.method.name().to_owned(),
            replay(it).to_owned(),
            it.numbers.to_string(),
            spread(&it.coulomb),
            it.breakaway.as_ref().map_or("–".to_owned(), spread),
            format!("{:.0} %", 100.0 * it.failed),
            format!("{:.0} %", 100.0 * it.impossible),
            format!("{:.0}", it.evaluations),
        ]
    }));
    rows
}

/// The errors of the threshold.
pub(super) fn detection_cells(results: &Results) -> Cells {
    let it = &results.detection;
    let mut rows = vec![
        row(["threshold", "logs", "rate"]),
        vec![
            "false alarms".to_owned(),
            it.healthy.to_string(),
            per_cent(it.false_alarms),
        ],
    ];
    rows.extend(it.missed.iter().map(|(growth, logs, missed)| {
        vec![
            format!("missed, friction {:.0} % up", 100.0 * growth),
            logs.to_string(),
            per_cent(*missed),
        ]
    }));
    let worn = |case: &&Case| case.level > 0;
    let all = results.cases.iter().filter(worn).count();
    let missed = results
        .cases
        .iter()
        .filter(worn)
        .filter(|case| case.coulomb <= it.threshold)
        .count();
    rows.push(vec![
        "missed, campaign from 0.2 N·m up".to_owned(),
        all.to_string(),
        per_cent(missed as f64 / all as f64),
    ]);
    rows
}

/// Lead times and errors of the predicted failures.
pub(super) fn life_cells(lives: &[Life]) -> Cells {
    let mut rows = vec![row(["wear, in logs", "least", "median", "largest"])];
    let mut add = |name: &str, values: Vec<f64>| {
        let quantiles = [0.0, 0.5, 1.0].map(|share| format!("{:.1}", quantile(&values, share)));
        let mut cells = vec![name.to_owned()];
        cells.extend(quantiles);
        rows.push(cells);
    };
    add(
        "from onset to alert",
        collect(lives, |life| {
            life.alert.map(|alert| alert as f64 - life.onset as f64)
        }),
    );
    add("from alert to failure", collect(lives, Life::lead));
    for share in LIFE_SHARES {
        add(
            &format!("error of the prediction at {:.0} % of that", 100.0 * share),
            collect(lives, |life| life.error_at(share)),
        );
    }
    rows
}

fn collect(lives: &[Life], of: impl Fn(&Life) -> Option<f64>) -> Vec<f64> {
    lives.iter().filter_map(of).collect()
}

/// How the threshold came about.
pub(super) fn threshold_sentence(results: &Results) -> String {
    let it = &results.detection;
    format!(
        "Threshold {:.4} N·m, learnt from {} healthy logs whose friction scatters by {:.0} %: with {:.0} % \
         confidence it leaves {:.0} % of the healthy below. Failure at {FAILURE} N·m.",
        it.threshold,
        it.learnt_from,
        100.0 * SCATTER,
        100.0 * CONFIDENCE,
        100.0 * CONTENT,
    )
}

/// Means over the campaign: evaluations by annealing and golden section for one number and for two,
/// seconds.
fn means(cases: &[Case]) -> [f64; 5] {
    let count = cases.len() as f64;
    let mean = |of: fn(&Case) -> f64| cases.iter().map(of).sum::<f64>() / count;
    [
        mean(|case| case.evaluations.0.into()),
        mean(|case| case.evaluations.1.into()),
        mean(|case| case.separate_evaluations.0.into()),
        mean(|case| case.separate_evaluations.1.into()),
        mean(|case| case.seconds),
    ]
}

/// The work of the campaign.
pub(super) fn work_sentence(results: &Results) -> String {
    let [annealing, polish, two_annealing, two_polish, seconds] = means(&results.cases);
    format!(
        "{} logs of 10 s. One number: {annealing:.0} + {polish:.0} replays (annealing + golden \
         section), {:.0} ms; two numbers: {two_annealing:.0} + {two_polish:.0}. Everything: {:.0} s.",
        results.cases.len(),
        1e3 * seconds,
        results.seconds
    )
}

/// The JSON.
pub(super) fn entries(results: &Results) -> Vec<Entry> {
    let found = f64::from(results.case.estimate.levels.coulomb);
    let case = &results.case;
    // Without the digits that a share of 0.056 has behind its 5.6 %.
    let per_cent = |share: f64| (1e10 * share).round() / 1e8;
    let mut entries = vec![
        entry(
            "friction torque found by annealing and golden section (the paper's is its static coefficient, ours the Coulomb level)",
            Some(PAPER),
            found,
            Some(PAPER_TRUTH),
            "N·m",
        ),
        entry(
            "friction torque found by annealing alone",
            Some(PAPER),
            case.estimate.annealed.coulomb.into(),
            Some(PAPER_TRUTH),
            "N·m",
        ),
        entry(
            "breakaway torque, both levels searched",
            Some(PAPER),
            case.both.levels.breakaway.into(),
            Some(case.truth.breakaway),
            "N·m",
        ),
        entry(
            "Coulomb torque, both levels searched",
            None,
            case.both.levels.coulomb.into(),
            Some(case.truth.coulomb),
            "N·m",
        ),
        entry(
            "error of the friction torque",
            Some(per_cent(PAPER_ERROR)),
            per_cent((found / PAPER_TRUTH - 1.0).abs()),
            None,
            "%",
        ),
        entry(
            "friction torque found by annealing and golden section, free run",
            Some(PAPER),
            case.free_run.levels.coulomb.into(),
            Some(PAPER_TRUTH),
            "N·m",
        ),
    ];
    for it in &results.settings {
        let what = format!("annealing alone, {}", it.name);
        let values = [
            ("median error in windows", per_cent(it.windows.median), "%"),
            ("worst error in windows", per_cent(it.windows.worst), "%"),
            (
                "median error in a free run",
                per_cent(it.free_run.median),
                "%",
            ),
            (
                "worst error in a free run",
                per_cent(it.free_run.worst),
                "%",
            ),
            ("evaluations", it.evaluations.into(), ""),
            ("re-annealings", it.reannealings, ""),
        ];
        for (name, value, unit) in values {
            entries.push(entry(&format!("{what}: {name}"), None, value, None, unit));
        }
    }
    for it in &results.presumptions {
        let values = [
            ("bias", it.bias),
            ("median error", it.errors.median),
            ("worst error", it.errors.worst),
        ];
        for (name, value) in values {
            let what = format!("sweep, {}: {name}", it.condition.name());
            entries.push(entry(&what, None, per_cent(value), None, "%"));
        }
    }
    for input in Input::ALL {
        let [one, coulomb, breakaway] = errors_of(&results.cases, |case| case.input == input);
        let kinds = [
            ("friction", one),
            ("Coulomb level apart", coulomb),
            ("breakaway level apart", breakaway),
        ];
        for (kind, errors) in kinds {
            let values = [
                ("median", errors.median),
                ("95 %", errors.most),
                ("worst", errors.worst),
            ];
            for (name, value) in values {
                let what = format!("campaign, {}, {kind}, error: {name}", input.name());
                entries.push(entry(&what, None, per_cent(value), None, "%"));
            }
        }
    }
    let [annealing, polish, .., seconds] = means(&results.cases);
    entries.push(entry("evaluations by annealing", None, annealing, None, ""));
    entries.push(entry(
        "evaluations by golden section",
        None,
        polish,
        None,
        "",
    ));
    // "A few minutes" in the paper.
    entries.push(entry("time of an estimate", None, seconds, None, "s"));
    for it in &results.methods {
        let plural = if it.numbers == 1 { "" } else { "s" };
        let replay = match replay(it) {
            "none" => "no replay",
            replay => replay,
        };
        let what = format!(
            "{}, {} number{plural}, {replay}",
            it.method.name(),
            it.numbers
        );
        let values = [
            ("worst error", per_cent(it.coulomb.worst), "%"),
            ("failed", per_cent(it.failed), "%"),
            ("evaluations", it.evaluations, ""),
        ];
        for (name, value, unit) in values {
            entries.push(entry(&format!("{what}: {name}"), None, value, None, unit));
        }
    }
    let detection = &results.detection;
    entries.push(entry("threshold", None, detection.threshold, None, "N·m"));
    entries.push(entry(
        "false alarms",
        None,
        per_cent(detection.false_alarms),
        None,
        "%",
    ));
    for (growth, _, missed) in &detection.missed {
        let what = format!("missed detections, friction {:.0} % up", per_cent(*growth));
        entries.push(entry(&what, None, per_cent(*missed), None, "%"));
    }
    let lead = collect(&results.lives, Life::lead);
    entries.push(entry(
        "logs from alert to failure, median",
        None,
        quantile(&lead, 0.5),
        None,
        "",
    ));
    entries.push(entry(
        "logs from alert to failure, least",
        None,
        quantile(&lead, 0.0),
        None,
        "",
    ));
    for share in LIFE_SHARES {
        let errors = collect(&results.lives, |life| life.error_at(share));
        let magnitudes = Spread::of(errors.into_iter());
        let values = [("median", magnitudes.median), ("worst", magnitudes.worst)];
        for (name, value) in values {
            let what = format!(
                "error of the predicted failure at {:.0} % of the time from alert to failure, in logs: {name}",
                100.0 * share
            );
            entries.push(entry(&what, None, value, None, ""));
        }
    }
    entries
}

/// The tables for a terminal.
pub(super) fn text(results: &Results) -> String {
    format!(
        "{}\n{}\nErrors of the campaign: median / 95 % / worst\n{}\n{}\n{}\n\nWhat it presumes\n{}\nMethods on the same sweeps, \
         all levels\n{}\n{}\n{}\n{}\n",
        render(&paper_cells(results)),
        render(&setting_cells(results)),
        render(&input_cells(&results.cases)),
        render(&level_cells(&results.cases)),
        work_sentence(results),
        render(&presumption_cells(results)),
        render(&method_cells(results)),
        threshold_sentence(results),
        render(&detection_cells(results)),
        render(&life_cells(&results.lives)),
    )
}
