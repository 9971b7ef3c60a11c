//! The throttle's results as a page, with the paper's Figs. 3 to 6.

use std::io;

use plotters::style::RGBColor;

use super::tables::{self, Column, Implementation, Implemented, Judged};
use super::{Results, stand};
use crate::identify::{Series, figure};
use crate::log::Log;
use crate::page::plot::{
    self, AFTER, BEFORE, COLUMNS, Layer, MEASURED, Mark, OTHER, Panel, line, panel,
};
use crate::page::series::{Point, envelope, histogram};
use crate::page::{self, Figure, escape, table};
use crate::pwa;

/// Seconds of the excerpt that compares the implementations.
const EXCERPT: f64 = 8.0;
/// What the intervals of the six numbers are worth on this stand.
pub(super) const INTERVALS: &str = "The intervals hold for a machine without undeclared effects; here, \
     friction that differs by direction works as a weaker preload, and bristles yield before a \
     breakaway.";
/// Bars of a histogram.
const BARS: usize = 41;

/// The key and the colour of a model.
fn ink(column: Column) -> (&'static str, RGBColor) {
    match column {
        Column::Physical | Column::Fitted => ("before", BEFORE),
        Column::Extended => ("after", AFTER),
        Column::PiecewiseAffine => ("other", OTHER),
    }
}

fn seconds(log: &Log, row: usize) -> f64 {
    row as f64 * log.period_s
}

/// A curve in degrees over seconds, for the rows from a first up to a last one.
fn curve(log: &Log, series: &[f64], (from, to): (usize, usize)) -> Vec<Point> {
    let points: Vec<Point> = (from..to.min(series.len()))
        .map(|row| (seconds(log, row), series[row].to_degrees()))
        .collect();
    envelope(&points, COLUMNS)
}

fn difference(model: &[f64], measured: &[f64]) -> Vec<f64> {
    let pairs = model.iter().zip(measured);
    pairs.map(|(model, measured)| model - measured).collect()
}

/// The page.
pub(super) fn page(results: &Results) -> io::Result<String> {
    let logs = &results.logs;
    let mut body = header(results);
    body += "<section>\n<h2>Errors</h2>\n<p class=\"note\">Free run over steps of 40 s; in brackets \
             the paper's. NRMSE: eq. 23; the largest error: eq. 24, 5° at most.</p>\n";
    body += &table(&tables::cells_1(&results.judged));
    if !results.repeated.is_empty() {
        body += &format!(
            "<h3>Stands of other noise and steps</h3>\n<p class=\"note\">{} stands, validation: median, \
             worst; on how many the largest error is within {}°.</p>\n{}",
            results.repeated.len(),
            tables::LIMIT,
            table(&tables::cells_repeated(&results.repeated))
        );
    }
    body += "<h3>One model, three implementations</h3>\n<p class=\"note\">On validation data. \
             Time-continuous: double precision, 2 µs. Time-discrete: single precision, 50 µs, on the \
             host. Real-time: the same in the interrupt of the emulated microcontroller.</p>\n";
    body += &table(&transposed(&tables::cells_2(&results.implemented)));
    body += &validation(&logs.validate, &results.judged)?.html();
    body += &implementations(&logs.validate, &results.implemented)?.html();
    body += "</section>\n<section>\n<h2>Identification</h2>\n<p class=\"note\">The six numbers of \
             eq. 7 by the four lines of the characteristic and a fast log, with 95 % intervals; the rig's \
             without its effects. ";
    body += INTERVALS;
    for warning in &results.models.identified.warnings {
        body += &escape(&format!(" Note: {warning}."));
    }
    body += "</p>\n";
    body += &numbers(results);
    let svg = figure::draw(
        &Series::of(&logs.slow),
        &results.models.identified.characteristic,
        ["rad", "V"],
    )?;
    body += &drawing(
        "The input over the position lies on four kinds of lines.",
        "Slow triangles (the paper's Fig. 3).",
        &svg,
    );
    let piecewise_affine = &results.models.piecewise_affine;
    body += "</section>\n<section>\n<h2>Piecewise affine model</h2>\n<p class=\"note\">Numbers of \
             clusters by their errors on the fifth of the data that was held out: rms in free run, large \
             errors weighing more.</p>\n";
    body += &table(&trials(piecewise_affine));
    let svg =
        pwa::figure::draw(piecewise_affine, &[&logs.slow, &logs.fast]).map_err(io::Error::other)?;
    body += &drawing(
        "Friction parts the samples into rest, opening and closing.",
        "What the spring leaves of the input, over velocity (the paper's Fig. 4, there over the input).",
        &svg,
    );
    body += "</section>\n";
    let foot = [
        stand(),
        format!(
            "From logs to models {:.1} s, gap loop {:.1} s.",
            results.models.seconds, results.models.gap_seconds
        ),
    ];
    Ok(page::page("Throttle paper, reproduced", &body, &foot))
}

/// A drawing of its own in a page.
fn drawing(statement: &str, method: &str, svg: &str) -> String {
    // Inside a page an SVG needs no declaration of its kind.
    let svg = svg.find("<svg").map_or("", |start| &svg[start..]);
    format!(
        "<figure>\n<figcaption><b>{}</b> {}</figcaption>\n{svg}</figure>\n",
        escape(statement),
        escape(method)
    )
}

/// What came of each number of clusters.
fn trials(found: &pwa::Identified) -> Vec<Vec<String>> {
    let cells = found.model.parameters().cells.len();
    let mut rows = vec![
        ["clusters", "least squares", "parallel", "borders moved", ""]
            .map(str::to_owned)
            .to_vec(),
    ];
    let degrees = |radians: f64| format!("{:.2}°", radians.to_degrees());
    rows.extend(found.candidates.iter().map(|trial| {
        vec![
            trial.clusters.to_string(),
            degrees(trial.series_parallel),
            degrees(trial.parallel),
            trial.moved.map_or_else(String::new, degrees),
            if trial.clusters == cells {
                "chosen"
            } else {
                ""
            }
            .to_owned(),
        ]
    }));
    rows
}

fn header(results: &Results) -> String {
    let best = results
        .judged
        .iter()
        .find(|model| model.column == Column::Extended);
    let finding = best.map_or(String::new(), |model| {
        format!(
            "With what the gap loop found ({}), the physical model is off by {} at most on data that it \
             had not seen; the paper's by 4.93°.",
            results.models.effects.join(", "),
            tables::largest(&model.validation)
        )
    });
    let parity = match results.differing_bits {
        0 => "On the emulated microcontroller every position has the bits that it has on the host; in \
              the paper the port raised the largest error from 5.09° to 12.08°."
            .to_owned(),
        bits => format!("On the emulated microcontroller {bits} bits differ from the host's."),
    };
    format!(
        "<header>\n<p class=\"kind\">A paper reproduced</p>\n<h1>Throttle for \
         hardware-in-the-loop simulation</h1>\n<p class=\"finding\">{}</p>\n<p>{}</p>\n<p \
         class=\"note\">{}</p>\n</header>\n",
        escape(&finding),
        escape(&parity),
        escape(&stand())
    )
}

fn numbers(results: &Results) -> String {
    let mut rows = vec![
        ["number", "value", "95 % interval", "rig", "unit"]
            .map(str::to_owned)
            .to_vec(),
    ];
    rows.extend(results.numbers().map(|(name, unit, number, truth)| {
        vec![
            name.to_owned(),
            format!("{:.4}", number.value),
            format!("± {:.4}", number.half_width),
            format!("{truth:.4}"),
            unit.to_owned(),
        ]
    }));
    table(&rows)
}

/// The models on the validation log: position, error, histograms of the error (the paper's Fig. 5).
fn validation(log: &Log, models: &[Judged]) -> io::Result<Figure> {
    let shown: Vec<&Judged> = models
        .iter()
        .filter(|model| model.column != Column::Fitted)
        .collect();
    let rows = (0, log.position.len());
    let mut positions = vec![line(MEASURED, 4, 0.55, curve(log, &log.position, rows))];
    let mut errors = Vec::new();
    for model in &shown {
        let (_, colour) = ink(model.column);
        positions.push(line(colour, 2, 0.9, curve(log, &model.validate, rows)));
        let error = difference(&model.validate, &log.position);
        errors.push(line(colour, 2, 0.9, curve(log, &error, rows)));
    }
    let histograms = shown.iter().map(|model| {
        let error: Vec<f64> = difference(&model.validate, &log.position)
            .iter()
            .map(|error| error.to_degrees())
            .collect();
        let ends = (-tables::LIMIT, tables::LIMIT);
        let width = (ends.1 - ends.0) / BARS as f64;
        let bars: Vec<Point> = histogram(&error, ends, BARS)
            .into_iter()
            .enumerate()
            .map(|(bar, share)| (ends.0 + (bar as f64 + 0.5) * width, 100.0 * share))
            .collect();
        let highest = bars.iter().map(|bar| bar.1).fold(1.0, f64::max);
        Panel {
            title: format!("share of the samples, %: {}", model.column.head()),
            x_title: "error, °".to_owned(),
            x: ends,
            y: (0.0, 1.06 * highest),
            layers: vec![Layer {
                mark: Mark::Bar,
                colour: ink(model.column).1,
                opacity: 0.9,
                points: bars,
            }],
        }
    });
    let drawn = vec![
        (400, vec![panel("position, °", "", positions)]),
        (400, vec![panel("error, °", "time, s", errors)]),
        (360, histograms.collect()),
    ];
    let mut keys = vec![("measured", "measured")];
    keys.extend(
        shown
            .iter()
            .map(|model| (ink(model.column).0, model.column.name())),
    );
    Ok(Figure {
        statement: "Steps that no model had seen.".to_owned(),
        method: "Free run of 40 s; the error is model minus measurement. Below, its histograms \
                 (the paper's Fig. 5)."
            .to_owned(),
        keys,
        svg: plot::draw(
            &drawn,
            "Position, error and its histograms on the validation log",
        )?,
    })
}

/// One model, three implementations, where they err most (the paper's Fig. 6).
fn implementations(log: &Log, implemented: &[Implemented]) -> io::Result<Figure> {
    let physical: Vec<&Implemented> = implemented
        .iter()
        .filter(|it| it.column == Column::Physical)
        .collect();
    let length = ((EXCERPT / log.period_s) as usize).min(log.position.len());
    let error = physical
        .first()
        .map(|it| difference(&it.positions, &log.position))
        .unwrap_or_default();
    let worst = (0..error.len())
        .max_by(|&a, &b| error[a].abs().total_cmp(&error[b].abs()))
        .unwrap_or(0);
    let from = worst
        .saturating_sub(length / 2)
        .min(log.position.len() - length);
    let rows = (from, from + length);
    let mut layers = vec![line(MEASURED, 6, 0.5, curve(log, &log.position, rows))];
    let mut keys = vec![("measured", "measured")];
    for it in physical {
        let (key, colour, width) = match it.implementation {
            Implementation::Continuous => ("other", OTHER, 8),
            Implementation::Discrete => ("after", AFTER, 5),
            Implementation::RealTime => ("before", BEFORE, 2),
        };
        layers.push(line(colour, width, 0.9, curve(log, &it.positions, rows)));
        keys.push((key, it.implementation.name()));
    }
    Ok(Figure {
        statement: "The model loses nothing on its way to the chip.".to_owned(),
        method: format!(
            "Physical model by the paper's procedure, {EXCERPT} s around its largest error; the \
             three curves lie on each other (the paper's Fig. 6, where they do not)."
        ),
        keys,
        svg: plot::draw(
            &[(500, vec![panel("position, °", "time, s", layers)])],
            "Measured position and three implementations of one model",
        )?,
    })
}

/// The same cells with columns as rows: many of them fit below each other.
fn transposed(cells: &[Vec<String>]) -> Vec<Vec<String>> {
    let columns = cells.first().map_or(0, Vec::len);
    (0..columns)
        .map(|column| cells.iter().map(|row| row[column].clone()).collect())
        .collect()
}

/// The sentence on the stand.
pub(super) fn stand() -> String {
    let effects: Vec<&str> = stand::effects()
        .iter()
        .filter_map(|effect| effect.kind().id())
        .collect();
    format!(
        "The measured throttle is a rig in double precision that shares no code with the models. It \
         has {}, a noisy potentiometer and a 12-bit converter.",
        effects.join(", ")
    )
}
