//! Heat maps: a table of numbers, each on a cell as deep in colour as it is large, as inline SVG.

use std::io;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::plot::{AFTER, FONT, LABEL, TITLE, WIDTH, inlined};

/// Height of a cell, of a title and of the names under the columns, in drawing units.
const CELL: i32 = 84;
const HEAD: i32 = 64;
const FOOT: i32 = 100;
/// Width of the names of the rows.
const NAMES: i32 = 210;
/// Opacity of the deepest cell: its number stays readable.
const DEEPEST: f64 = 0.6;

/// One map.
pub(crate) struct HeatMap {
    /// What the numbers are, with their unit.
    pub title: String,
    /// Names of the columns, from the left.
    pub columns: Vec<String>,
    /// What the columns are.
    pub column_title: String,
    /// Rows from the top: a name, and a number for each column.
    pub rows: Vec<(String, Vec<f64>)>,
    /// The number of the deepest colour.
    pub deepest: f64,
    /// Decimals of the numbers.
    pub decimals: usize,
}

/// Maps side by side as one `<svg>` element; `description` (already escaped) is for readers who
/// cannot see it.
pub(crate) fn draw(maps: &[HeatMap], description: &str) -> io::Result<String> {
    let rows = maps.iter().map(|map| map.rows.len()).max().unwrap_or(0);
    let height = (HEAD + CELL * rows as i32 + FOOT) as u32;
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
        for (area, map) in root.split_evenly((1, maps.len())).iter().zip(maps) {
            draw_map(area, map).map_err(io::Error::other)?;
        }
        root.present().map_err(io::Error::other)?;
    }
    Ok(inlined(&svg, height, description))
}

fn draw_map(
    area: &DrawingArea<SVGBackend, Shift>,
    map: &HeatMap,
) -> Result<(), DrawingAreaErrorKind<io::Error>> {
    let title = FONT.into_font().color(&TITLE);
    let label = FONT.into_font().color(&LABEL);
    let middle = Pos::new(HPos::Center, VPos::Center);
    let (width, _) = area.dim_in_pixel();
    let cell = (width as i32 - NAMES - 30) / map.columns.len().max(1) as i32;
    area.draw(&Text::new(map.title.as_str(), (NAMES, 20), title.clone()))?;
    for (row, (name, values)) in map.rows.iter().enumerate() {
        let top = HEAD + CELL * row as i32;
        let right = Pos::new(HPos::Right, VPos::Center);
        area.draw(&Text::new(
            name.as_str(),
            (NAMES - 14, top + CELL / 2),
            label.pos(right),
        ))?;
        for (column, value) in values.iter().enumerate() {
            let left = NAMES + cell * column as i32;
            let depth = DEEPEST * (value / map.deepest).clamp(0.0, 1.0);
            let corners = [(left + 2, top + 2), (left + cell - 2, top + CELL - 2)];
            area.draw(&Rectangle::new(corners, AFTER.mix(depth).filled()))?;
            area.draw(&Text::new(
                format!("{value:.*}", map.decimals),
                (left + cell / 2, top + CELL / 2),
                title.pos(middle),
            ))?;
        }
    }
    let below = HEAD + CELL * map.rows.len() as i32;
    for (column, name) in map.columns.iter().enumerate() {
        let centre = NAMES + cell * column as i32 + cell / 2;
        area.draw(&Text::new(
            name.as_str(),
            (centre, below + 22),
            label.pos(middle),
        ))?;
    }
    let centre = NAMES + cell * map.columns.len() as i32 / 2;
    area.draw(&Text::new(
        map.column_title.as_str(),
        (centre, below + 62),
        label.pos(middle),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_stands_on_a_cell() {
        let map = HeatMap {
            title: "a < b, %".to_owned(),
            columns: vec!["x".to_owned(), "y".to_owned()],
            column_title: "column".to_owned(),
            rows: vec![
                ("low".to_owned(), vec![0.125, 0.5]),
                ("high".to_owned(), vec![1.0, 7.25]),
            ],
            deepest: 1.0,
            decimals: 2,
        };
        let svg = draw(&[map], "a map").unwrap();
        let document = roxmltree::Document::parse(&svg).unwrap();
        let cells = document
            .descendants()
            .filter(|node| node.has_tag_name("rect"))
            .count();
        assert_eq!(cells, 4);
        for number in ["0.12", "0.50", "1.00", "7.25"] {
            assert!(svg.contains(number), "{number}");
        }
        assert!(svg.contains("a &lt; b"));
    }
}
