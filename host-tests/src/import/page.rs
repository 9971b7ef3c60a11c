//! The columns of an imported log, drawn.

use std::io;

use super::source::Source;
use super::summary::unit_of;
use crate::log::{COLUMNS, Log, TIME};
use crate::page::plot::{self, MEASURED};
use crate::page::series::{Point, envelope};
use crate::page::{self, Figure, escape};

/// Height of a column's panel, drawing units.
const HEIGHT: u32 = 260;

/// A page with every column over the time. `summary` is what the terminal shows.
///
/// # Errors
/// A drawing that fails.
pub(super) fn html(
    name: &str,
    log: &Log,
    sources: &[(usize, Source)],
    is_linear: Option<bool>,
    summary: &str,
) -> io::Result<String> {
    let columns: Vec<(usize, &Vec<f64>)> = log
        .series()
        .into_iter()
        .enumerate()
        .filter_map(|(place, values)| Some((TIME + 1 + place, values?)))
        .collect();
    let last = columns.len() - 1;
    let panels = columns.iter().enumerate().map(|(place, (index, values))| {
        let points: Vec<Point> = values
            .iter()
            .enumerate()
            .map(|(sample, value)| (log.time_s(sample), *value))
            .collect();
        let unit = unit_of(*index, sources, is_linear);
        let title = match unit {
            "" => COLUMNS[*index].0.to_owned(),
            unit => format!("{}, {unit}", COLUMNS[*index].0),
        };
        let below = if place == last { "time, s" } else { "" };
        let curve = plot::line(MEASURED, 3, 1.0, envelope(&points, plot::COLUMNS));
        (HEIGHT, vec![plot::panel(&title, below, vec![curve])])
    });
    let rows: Vec<_> = panels.collect();
    let svg = plot::draw(&rows, "every column of the log over the time")?;
    let figure = Figure {
        statement: "The columns of the log.".into(),
        method: "Of each stretch the lowest and the highest value.".into(),
        keys: Vec::new(),
        svg,
    };
    let body = format!(
        "<header><p class=\"kind\">imported log</p><h1>{}</h1></header>\n<section><pre>{}</pre></section>\n\
         <section>{}</section>\n",
        escape(name),
        escape(summary),
        figure.html()
    );
    Ok(page::page(name, &body, &[]))
}
