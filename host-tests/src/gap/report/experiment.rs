//! The next experiment: its input, and what each candidate makes of it.

use std::io;

use plotters::style::RGBColor;

use crate::gap::experiment::{NextExperiment, Plan};
use crate::gap::outcome::Report;
use crate::page::plot::{self, AFTER, BEFORE, COLUMNS, Layer, MEASURED, OTHER, Panel, line, panel};
use crate::page::series::{Point, envelope};
use crate::page::{Figure, escape};
use crate::quantity::Scale;

/// Colours of the candidates, with their classes in the style sheet; the named one first.
const COLOURS: [(&str, RGBColor); 4] = [
    ("after", AFTER),
    ("before", BEFORE),
    ("other", OTHER),
    ("measured", MEASURED),
];

/// The section, where there is something to say.
pub(super) fn section(report: &Report) -> io::Result<String> {
    let Some(next) = &report.outcome.next_experiment else {
        return Ok(String::new());
    };
    let mut text = format!(
        "<section>\n<h2>Next experiment</h2>\n<p>{}</p>\n",
        escape(&next.sentences(&report.coordinate))
    );
    if let Some(plan) = &next.plan {
        if let Some(file) = &next.file {
            text += &format!("<p>Its input: <code>{}</code></p>\n", escape(file));
        }
        let keys = COLOURS.iter().zip(&plan.predicted);
        let keys: String = keys
            .map(|((class, _), (name, _))| {
                format!("<span class=\"{class}\">{}</span>", escape(name))
            })
            .collect();
        text += &figure(report, next, plan)?.html();
        text += &format!("<div class=\"keys\">{keys}</div>\n");
    }
    Ok(text + "</section>\n")
}

fn figure(report: &Report, next: &NextExperiment, plan: &Plan) -> io::Result<Figure> {
    let time = |sample: usize| sample as f64 * plan.period_s;
    let curve = |values: &mut dyn Iterator<Item = f64>| -> Vec<Point> {
        let points: Vec<Point> = values
            .enumerate()
            .map(|(sample, value)| (time(sample), value))
            .collect();
        envelope(&points, COLUMNS)
    };
    let (_, named) = &plan.predicted[0];
    let positions = named.iter().map(|&it| f64::from(it));
    let position = Scale::of(&report.coordinate, positions);
    let offs = plan.predicted.iter().flat_map(|(_, predicted)| {
        let pairs = predicted.iter().zip(named);
        pairs.map(|(a, b)| f64::from(a - b))
    });
    let off = Scale::of(&report.coordinate, offs);
    let input = vec![line(
        MEASURED,
        3,
        0.9,
        curve(&mut plan.input.iter().map(|&it| f64::from(it))),
    )];
    let layers = |value: &dyn Fn(f32, f32) -> f64| -> Vec<Layer> {
        let candidates = plan.predicted.iter().zip(COLOURS);
        candidates
            .map(|((_, predicted), (_, colour))| {
                let pairs = predicted.iter().zip(named);
                let values = &mut pairs.map(|(&own, &other)| value(own, other));
                line(colour, 3, 0.9, curve(values))
            })
            .collect()
    };
    let positions = layers(&|own, _| f64::from(own) * position.factor);
    let differences = layers(&|own, other| f64::from(own - other) * off.factor);
    let first = if next.absorbed.is_empty() {
        "the named candidate"
    } else {
        "the model without any"
    };
    let titled = |what: &str, scale: &Scale| format!("{what}, {}", scale.unit);
    let rows: Vec<(u32, Vec<Panel>)> = vec![
        (300, vec![panel("input", "", input)]),
        (
            360,
            vec![panel(
                &titled("predicted position", &position),
                "",
                positions,
            )],
        ),
        (
            360,
            vec![panel(
                &titled(&format!("less that of {first}"), &off),
                "time, s",
                differences,
            )],
        ),
    ];
    let start = next.start_position.unwrap_or(0.0);
    Ok(Figure {
        statement: "What the candidates predict of it.".into(),
        method: format!(
            "Free run of each candidate as it is fitted, from rest at {}.",
            Scale::of(&report.coordinate, [start]).quantity(start),
        ),
        keys: Vec::new(),
        svg: plot::draw(
            &rows,
            "Input of the next experiment and what the candidates predict",
        )?,
    })
}
