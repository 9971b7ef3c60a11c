//! The input/output characteristic with its lines and points: the paper's Fig. 3.

use std::io;

use model_core::identify::characteristic::{Characteristic, Kind};
use plotters::prelude::*;

use super::{Series, table};

const SIZE: (u32, u32) = (1200, 800);
const MEASURED: RGBColor = RGBColor(0xB8, 0xC0, 0xCC);

fn colour(kind: Kind) -> RGBColor {
    match kind {
        Kind::Uniform => RGBColor(0x1F, 0x6A, 0xA5),
        Kind::Breakaway => RGBColor(0xC4, 0x52, 0x2E),
        Kind::Standstill => RGBColor(0x3C, 0x8D, 0x5A),
    }
}

/// The drawing as SVG: input over position, all samples grey, inliers filled, outliers hollow.
pub(crate) fn draw(slow: &Series, found: &Characteristic, unit: &str) -> io::Result<String> {
    let range = |values: &[f32]| {
        let low = values.iter().copied().fold(f32::INFINITY, f32::min);
        let high = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let margin = 0.05 * (high - low);
        (low - margin)..(high + margin)
    };
    let (x, y) = (range(&slow.position), range(&slow.input));
    let mut svg = String::new();
    paint(&mut svg, slow, found, unit, (x, y)).map_err(io::Error::other)?;
    Ok(svg)
}

fn paint(
    svg: &mut String,
    slow: &Series,
    found: &Characteristic,
    unit: &str,
    (x, y): (std::ops::Range<f32>, std::ops::Range<f32>),
) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let fault = |error: DrawingAreaErrorKind<_>| -> Box<dyn std::error::Error + Send + Sync> {
        format!("{error:?}").into()
    };
    let area = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    area.fill(&WHITE).map_err(fault)?;
    let mut chart = ChartBuilder::on(&area)
        .margin(20)
        .x_label_area_size(50)
        .y_label_area_size(70)
        .caption("Input/output characteristic", ("sans-serif", 24))
        .build_cartesian_2d(x.clone(), y)
        .map_err(fault)?;
    chart
        .configure_mesh()
        .x_desc(format!("position, {unit}"))
        .y_desc("input")
        .label_style(("sans-serif", 16))
        .draw()
        .map_err(fault)?;
    let every = (slow.input.len() / 4000).max(1);
    let track = slow
        .position
        .iter()
        .copied()
        .zip(slow.input.iter().copied());
    chart
        .draw_series([PathElement::new(
            track.step_by(every).collect::<Vec<_>>(),
            MEASURED,
        )])
        .map_err(fault)?;
    for kind in Kind::ALL {
        let marks = found
            .points(kind)
            .flat_map(|(_, _, points)| points)
            .map(|point| {
                let style = if point.inlier {
                    colour(kind).filled()
                } else {
                    colour(kind).stroke_width(1)
                };
                Circle::new((point.position, point.input), 3, style)
            });
        chart.draw_series(marks).map_err(fault)?;
    }
    for branch in &found.branches {
        let ends = [x.start, x.end].map(|x| (x, branch.line.at(f64::from(x)) as f32));
        let style = colour(branch.kind).stroke_width(1);
        chart
            .draw_series([PathElement::new(ends.to_vec(), style)])
            .map_err(fault)?
            .label(table::line_name(branch.kind, branch.direction))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], style));
    }
    chart
        .configure_series_labels()
        .background_style(WHITE.mix(0.8))
        .label_font(("sans-serif", 14))
        .draw()
        .map_err(fault)?;
    drop(chart);
    area.present().map_err(fault)
}
