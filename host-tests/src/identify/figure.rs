//! The input/output characteristic with its lines and points: the paper's Fig. 3.

use std::io;

use std::ops::Range;

use model_core::identify::characteristic::{Characteristic, Direction, Kind};
use model_core::identify::line::Line;
use plotters::prelude::*;

use super::{Series, table};

const SIZE: (u32, u32) = (1200, 800);
const MEASURED: RGBColor = RGBColor(0xB8, 0xC0, 0xCC);

/// A line that opens is lighter than the one of its kind that closes.
fn colour(kind: Kind, direction: Direction) -> RGBColor {
    match (kind, direction) {
        (Kind::Uniform, Direction::Opening) => RGBColor(0x3E, 0x8F, 0xCC),
        (Kind::Uniform, Direction::Closing) => RGBColor(0x12, 0x44, 0x6F),
        (Kind::Breakaway, Direction::Opening) => RGBColor(0xDE, 0x78, 0x4E),
        (Kind::Breakaway, Direction::Closing) => RGBColor(0x8C, 0x33, 0x17),
        (Kind::Standstill, Direction::Opening) => RGBColor(0x5C, 0xB3, 0x7C),
        (Kind::Standstill, Direction::Closing) => RGBColor(0x22, 0x5F, 0x39),
    }
}

/// Where a line enters and leaves the frame; `None` if it does not cross it.
fn clipped(line: &Line, x: &Range<f32>, y: &Range<f32>) -> Option<[(f32, f32); 2]> {
    let at = |x: f32| line.at(f64::from(x)) as f32;
    let (mut left, mut right) = (x.start, x.end);
    for level in [y.start, y.end] {
        let (low, high) = (at(left) - level, at(right) - level);
        if low * high < 0.0 {
            let crossing = left + (right - left) * low / (low - high);
            let outside = |x: f32| at(x) < y.start || at(x) > y.end;
            if outside(left) {
                left = crossing;
            } else {
                right = crossing;
            }
        }
    }
    // A hair of rounding beyond the frame is inside it.
    let slack = 1e-3 * (y.end - y.start);
    let inside = |x: f32| at(x) >= y.start - slack && at(x) <= y.end + slack;
    (inside(left) && inside(right)).then(|| [left, right].map(|x| (x, at(x).clamp(y.start, y.end))))
}

/// The drawing as SVG: input over position, all samples grey, inliers filled, outliers hollow. `units`:
/// of the position and of the input.
pub(crate) fn draw(slow: &Series, found: &Characteristic, units: [&str; 2]) -> io::Result<String> {
    let range = |values: &[f32]| {
        let low = values.iter().copied().fold(f32::INFINITY, f32::min);
        let high = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let margin = 0.05 * (high - low);
        (low - margin)..(high + margin)
    };
    let (x, y) = (range(&slow.position), range(&slow.input));
    let mut svg = String::new();
    paint(&mut svg, slow, found, units, (x, y)).map_err(io::Error::other)?;
    Ok(svg)
}

fn paint(
    svg: &mut String,
    slow: &Series,
    found: &Characteristic,
    units: [&str; 2],
    (x, y): (Range<f32>, Range<f32>),
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
        .caption(
            "Input/output characteristic: filled dots lie on their line, hollow ones do not",
            ("sans-serif", 22),
        )
        .build_cartesian_2d(x.clone(), y.clone())
        .map_err(fault)?;
    chart
        .configure_mesh()
        .x_desc(format!("position, {}", units[0]))
        .y_desc(format!("input, {}", units[1]))
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
            .flat_map(|(direction, _, points)| points.iter().map(move |point| (direction, point)))
            .map(|(direction, point)| {
                let style = if point.inlier {
                    colour(kind, direction).filled()
                } else {
                    colour(kind, direction).stroke_width(1)
                };
                Circle::new((point.position, point.input), 3, style)
            });
        chart.draw_series(marks).map_err(fault)?;
    }
    for branch in &found.branches {
        let Some(ends) = clipped(&branch.line, &x, &y) else {
            continue;
        };
        let style = colour(branch.kind, branch.direction).stroke_width(2);
        chart
            .draw_series([PathElement::new(ends.to_vec(), style)])
            .map_err(fault)?
            .label(table::line_name(branch.kind, branch.direction))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], style));
    }
    chart
        .configure_series_labels()
        // Input grows with position: this corner is free.
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.8))
        .label_font(("sans-serif", 14))
        .draw()
        .map_err(fault)?;
    drop(chart);
    area.present().map_err(fault)
}

#[cfg(test)]
mod tests {
    use super::{Line, clipped};

    #[test]
    fn a_line_ends_where_it_leaves_the_frame() {
        let line = Line {
            centre: 1.0,
            level: 2.0,
            slope: 3.0,
            level_variance: 0.0,
            slope_variance: 0.0,
            degrees_of_freedom: 1.0,
            deviation: 0.0,
            inliers: 2,
            points: 2,
        };
        // y = 3 x − 1 in a frame from −1 to 5 over 0 to 10.
        let near = |found: Option<[(f32, f32); 2]>, expected: [(f32, f32); 2]| {
            for (found, expected) in found.unwrap().into_iter().zip(expected) {
                assert!((found.0 - expected.0).abs() < 1e-5 && (found.1 - expected.1).abs() < 1e-4);
            }
        };
        near(
            clipped(&line, &(0.0..10.0), &(-1.5..5.0)),
            [(0.0, -1.0), (2.0, 5.0)],
        );
        near(
            clipped(&line, &(-10.0..1.0), &(-1.0..5.0)),
            [(0.0, -1.0), (1.0, 2.0)],
        );
        near(
            clipped(&line, &(0.0..1.0), &(-9.0..9.0)),
            [(0.0, -1.0), (1.0, 2.0)],
        );
        assert!(clipped(&line, &(5.0..10.0), &(-1.0..5.0)).is_none());
    }
}
