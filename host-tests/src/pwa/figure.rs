//! The regression space with its cells: the paper's Fig. 4.

use std::io;
use std::ops::Range;

use plotters::prelude::*;

use super::model::{CHANGE, INPUT, POSITION};
use super::reading::Reading;
use super::search::Identified;
use super::series::Series;
use crate::failure::Failure;
use crate::log::Log;

const SIZE: (u32, u32) = (1200, 800);

/// Most points drawn.
const POINTS: usize = 4000;

/// A colour a cell, told apart by people who see few colours: P. Tol's bright and muted schemes.
const CELLS: [RGBColor; 10] = [
    RGBColor(0x44, 0x77, 0xAA),
    RGBColor(0xEE, 0x66, 0x77),
    RGBColor(0x22, 0x88, 0x33),
    RGBColor(0xCC, 0xBB, 0x44),
    RGBColor(0x66, 0xCC, 0xEE),
    RGBColor(0xAA, 0x33, 0x77),
    RGBColor(0x33, 0x22, 0x88),
    RGBColor(0x99, 0x99, 0x33),
    RGBColor(0x88, 0x22, 0x55),
    RGBColor(0xBB, 0xBB, 0xBB),
];

/// A sample in the plane: velocity, what is left of the input, cell.
type Dot = (f64, f64, usize);

/// The drawing as SVG: each sample of the logs by velocity and input, in the colour of its cell. In the
/// reading [`Reading::Balance`] the input is what the spring leaves of it.
///
/// # Errors
/// Logs whose period does not divide the model's, a drawing that fails.
pub fn draw(identified: &Identified, logs: &[&Log]) -> Result<String, Failure> {
    let period = f64::from(identified.model.parameters().period);
    let mut dots: Vec<Dot> = Vec::new();
    for log in logs {
        let series = Series::of(log, period)?;
        dots.extend((2..series.samples()).map(|sample| {
            let regressor = series.step(sample).regressor;
            let [position, change, input] = [POSITION, CHANGE, INPUT].map(|place| regressor[place]);
            let model = &identified.model;
            let cell = model.cell_at(position as f32, change as f32, input as f32);
            (change / period, input - identified.slope * position, cell)
        }));
    }
    let every = dots.len().div_ceil(POINTS).max(1);
    let dots: Vec<Dot> = dots.into_iter().step_by(every).collect();
    let mut svg = String::new();
    paint(&mut svg, &dots, identified)
        .map_err(|error| Failure::system("the partition's drawing", io::Error::other(error)))?;
    Ok(svg)
}

fn paint(
    svg: &mut String,
    dots: &[Dot],
    identified: &Identified,
) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let fault = |error: DrawingAreaErrorKind<_>| -> Box<dyn std::error::Error + Send + Sync> {
        format!("{error:?}").into()
    };
    let range = |pick: fn(&Dot) -> f64| -> Range<f64> {
        let low = dots.iter().map(pick).fold(f64::INFINITY, f64::min);
        let high = dots.iter().map(pick).fold(f64::NEG_INFINITY, f64::max);
        let margin = 0.05 * (high - low);
        low - margin..high + margin
    };
    let area = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    area.fill(&WHITE).map_err(fault)?;
    let mut chart = ChartBuilder::on(&area)
        .margin(20)
        .x_label_area_size(50)
        .y_label_area_size(70)
        .caption("Regression space by cell", ("sans-serif", 24))
        .build_cartesian_2d(range(|dot| dot.0), range(|dot| dot.1))
        .map_err(fault)?;
    let vertical = match identified.reading {
        Reading::Balance => "input that the spring leaves, V",
        _ => "input, V",
    };
    chart
        .configure_mesh()
        .x_desc("(y(k−1) − y(k−2)) / period, rad/s")
        .y_desc(vertical)
        .label_style(("sans-serif", 16))
        .draw()
        .map_err(fault)?;
    for (cell, colour) in CELLS.into_iter().enumerate() {
        let own: Vec<&Dot> = dots.iter().filter(|dot| dot.2 == cell).collect();
        if own.is_empty() {
            continue;
        }
        chart
            .draw_series(
                own.into_iter()
                    .map(|&(x, y, _)| Circle::new((x, y), 3, colour.filled())),
            )
            .map_err(fault)?
            .label(format!("cell {}", cell + 1))
            .legend(move |(x, y)| Circle::new((x + 10, y), 5, colour.filled()));
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
