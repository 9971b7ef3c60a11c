//! The page: each number over the logs, with its line and its limit.

use std::io;

use super::outcome::{Outcome, Trend, estimates};
use super::text::{log_cells, notes, sentences, trend_cells, words};
use super::trend::{Estimate, FALSE_ALARMS, Line};
use crate::machine::Machine;
use crate::page::plot::{self, AFTER, BEFORE, Layer, MEASURED, Mark, Panel, line};
use crate::page::{self, Figure, escape, table};
use crate::quantity::Scale;

/// Height of a panel, drawing units.
const HEIGHT: u32 = 560;

/// The line is drawn ahead to its limit, if it is there within so many times the logs that there are.
const AHEAD: f64 = 2.0;

/// Points of a curve.
const POINTS: usize = 100;

/// Standard errors of a 95 % interval of a single log; it has many degrees of freedom.
const DEVIATIONS: f64 = 1.96;

const KEYS: [(&str, &str); 3] = [
    ("measured", "logs, with their own 95 % intervals"),
    ("after", "line, with its 95 % interval"),
    ("before", "limit"),
];

/// The page.
pub(super) fn page(outcome: &Outcome, machine: &Machine) -> io::Result<String> {
    let said: String = sentences(outcome)
        .iter()
        .map(|sentence| format!("<p class=\"finding\">{}</p>\n", escape(sentence)))
        .collect();
    let notes: String = notes(outcome, machine)
        .iter()
        .map(|note| format!("<p>{}</p>\n", escape(note)))
        .collect();
    let mut body = format!(
        "<header>\n<p class=\"kind\">Numbers of a machine over its logs</p>\n<h1>{}</h1>\n{said}{notes}</header>\n",
        escape(&outcome.machine)
    );
    body += "<section>\n<h2>Trends</h2>\n";
    body += &table(&trend_cells(outcome));
    for trend in &outcome.trends {
        body += &figure(outcome, trend)?.html();
    }
    body += "</section>\n<section>\n<h2>Logs</h2>\n";
    body += &table(&log_cells(outcome, machine));
    body += "</section>\n";
    let foot = [format!(
        "The line is weighted least squares with a variance between the logs (R. C. Paule and J. Mandel, 1982), its intervals \
         those of G. Knapp and J. Hartung (2003), the remaining logs those of E. C. Fieller (1954). An alarm is Holm's (1979): \
         while nothing changes, at most {:.0} % of the calls raise one. The logs' scatter is taken for independent from log to \
         log, and the line for straight.",
        100.0 * FALSE_ALARMS
    )];
    let title = format!("{}, tracked", outcome.machine);
    Ok(page::page(&title, &body, &foot))
}

fn figure(outcome: &Outcome, trend: &Trend) -> io::Result<Figure> {
    let estimates = estimates(&outcome.logs, &trend.name);
    let scale = scale(trend, &estimates);
    let mut layers: Vec<Layer> = Vec::new();
    let last = outcome.logs.len() as f64;
    let to = match trend.remaining_logs {
        Some(logs) if trend.alarm && logs < AHEAD * last => last + logs,
        _ => last,
    };
    if let Some(fitted) = trend.line {
        layers.extend(line_layers(&fitted, to));
    }
    layers.extend(log_layers(&estimates));
    let near = trend.limit.filter(|_| trend.limit_given || trend.alarm);
    if let Some(limit) = near {
        layers.push(line(BEFORE, 3, 1.0, vec![(1.0, limit), (to, limit)]));
    }
    for point in layers.iter_mut().flat_map(|layer| &mut layer.points) {
        point.1 *= scale.factor;
    }
    let title = format!("{}, {}", words(&trend.name), scale.unit);
    let mut panel = plot::panel(&title, "log", layers);
    if estimates.is_empty() {
        panel.y = (0.0, 1.0);
    }
    panel.x = Panel::padded((1.0, to));
    let description = escape(&format!(
        "{} of each log, with its trend",
        words(&trend.name)
    ));
    let method = match trend.slope_per_log {
        Some(_) => format!("{} logs determine it.", trend.logs),
        None => format!("{} logs determine it, too few for a line.", trend.logs),
    };
    Ok(Figure {
        statement: format!("{}.", title),
        method,
        keys: KEYS.to_vec(),
        svg: plot::draw(&[(HEIGHT, vec![panel])], &description)?,
    })
}

/// What the axis is in: a unit with a prefix, or a power of a thousand of one that takes none.
fn scale(trend: &Trend, estimates: &[Estimate]) -> Scale {
    let values = || estimates.iter().map(|it| it.value.abs());
    let own = Scale::of(&trend.unit, values());
    let largest = own.factor * values().fold(0.0, f64::max);
    if largest == 0.0 || (0.1..1e4).contains(&largest) {
        return own;
    }
    let power = 3 * (largest.log10() / 3.0).floor() as i32;
    Scale {
        factor: own.factor * 10f64.powi(-power),
        unit: format!("1e{power} {}", own.unit),
    }
}

/// The line with its interval up to a log, counted from 1 as the axis is.
fn line_layers(fitted: &Line, to: f64) -> [Layer; 2] {
    let places = (0..=POINTS).map(|step| (to - 1.0) * step as f64 / POINTS as f64);
    let places: Vec<f64> = places.collect();
    let edge = |pick: fn((f64, f64)) -> f64| {
        let of = move |place: &f64| (place + 1.0, pick(fitted.interval_at(*place)));
        places.iter().map(of)
    };
    let band = edge(|it| it.0).chain(edge(|it| it.1).rev()).collect();
    let curve = places.iter().map(|&place| (place + 1.0, fitted.at(place)));
    [
        Layer {
            mark: Mark::Area,
            colour: AFTER,
            opacity: 0.15,
            points: band,
        },
        line(AFTER, 4, 1.0, curve.collect()),
    ]
}

/// The logs' estimates, each with its interval.
fn log_layers(estimates: &[Estimate]) -> Vec<Layer> {
    let bar = |it: &Estimate| {
        let half = DEVIATIONS * it.std;
        let place = it.place + 1.0;
        line(
            MEASURED,
            3,
            1.0,
            vec![(place, it.value - half), (place, it.value + half)],
        )
    };
    let mut layers: Vec<Layer> = estimates.iter().map(bar).collect();
    layers.push(Layer {
        mark: Mark::Dot(8),
        colour: MEASURED,
        opacity: 1.0,
        points: estimates
            .iter()
            .map(|it| (it.place + 1.0, it.value))
            .collect(),
    });
    layers
}
