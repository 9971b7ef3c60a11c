//! Panels of axes and marks, drawn as inline SVG. The drawing knows nothing of actuators.

use std::fmt::Write as _;
use std::io;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::series::Point;

/// Measured data.
pub(crate) const MEASURED: RGBColor = RGBColor(0x4A, 0x55, 0x63);
/// The model before effects.
pub(crate) const BEFORE: RGBColor = RGBColor(0xC4, 0x52, 0x2E);
/// The model with its effects.
pub(crate) const AFTER: RGBColor = RGBColor(0x1F, 0x6A, 0xA5);
/// A model of another kind.
pub(crate) const OTHER: RGBColor = RGBColor(0x4F, 0x83, 0x2F);
/// Bounds and restarts.
pub(crate) const GUIDE: RGBColor = RGBColor(0x8A, 0x94, 0xA3);
pub(super) const TITLE: RGBColor = RGBColor(0x1C, 0x23, 0x2E);
pub(super) const LABEL: RGBColor = RGBColor(0x5B, 0x66, 0x76);
const GRID: RGBColor = RGBColor(0xE4, 0xE8, 0xED);

/// Every colour of a drawing: its name in the style sheet, on white, on black.
const PALETTE: [(&str, RGBColor, &str); 8] = [
    ("measured", MEASURED, "#B8C0CC"),
    ("before", BEFORE, "#F08A62"),
    ("after", AFTER, "#62AEE8"),
    ("other", OTHER, "#93C572"),
    ("guide", GUIDE, "#7C8796"),
    ("title", TITLE, "#E8ECF1"),
    ("label", LABEL, "#A3ADBA"),
    ("grid", GRID, "#2C333D"),
];

/// Units of a drawing's width. The page shows it about half as wide: SVG by plotters has integer
/// coordinates, so this is a resolution of half a pixel.
pub(super) const WIDTH: u32 = 2000;
/// Columns that a curve over the whole width is thinned to.
pub(crate) const COLUMNS: usize = 900;
pub(super) const FONT: (&str, u32) = ("sans-serif", 26);
const LEFT: u32 = 110;
const TOP: u32 = 62;
const BOTTOM: u32 = 82;
const BOTTOM_UNTITLED: u32 = 50;

/// One set of axes.
pub(crate) struct Panel {
    /// What the vertical axis shows, with its unit.
    pub title: String,
    /// What the horizontal axis shows, with its unit; empty above a panel with the same axis.
    pub x_title: String,
    /// Ends of the horizontal axis.
    pub x: (f64, f64),
    /// Ends of the vertical axis.
    pub y: (f64, f64),
    /// Drawn in this order.
    pub layers: Vec<Layer>,
}

/// Marks of one kind and colour.
pub(crate) struct Layer {
    /// How the points become marks.
    pub mark: Mark,
    /// Their colour, one of the palette.
    pub colour: RGBColor,
    /// From 0, invisible, to 1.
    pub opacity: f64,
    /// In the units of the axes.
    pub points: Vec<Point>,
}

/// How points become marks.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mark {
    /// A curve of this width.
    Line(u32),
    /// A filled circle of this radius for each point.
    Dot(i32),
    /// A bar from zero to each point, of the width of the spacing of the points.
    Bar,
    /// A filled area, the points its outline.
    Area,
    /// A line across the panel at the height of each point.
    Across,
    /// A line over the panel's height at each point.
    Upright,
}

impl Panel {
    /// Ends of an axis that shows `range` with some air, also when it is a single value.
    pub fn padded((low, high): (f64, f64)) -> (f64, f64) {
        let margin = if high > low {
            0.06 * (high - low)
        } else {
            0.05 * low.abs().max(1e-3)
        };
        (low - margin, high + margin)
    }
}

/// A curve as a layer.
pub(crate) fn line(colour: RGBColor, width: u32, opacity: f64, points: Vec<Point>) -> Layer {
    Layer {
        mark: Mark::Line(width),
        colour,
        opacity,
        points,
    }
}

/// A panel around its layers, from the first to the last second of them.
pub(crate) fn panel(title: &str, x_title: &str, layers: Vec<Layer>) -> Panel {
    let range = |pick: fn(&Point) -> f64| {
        let values = layers
            .iter()
            .flat_map(|layer| layer.points.iter().map(pick));
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        })
    };
    Panel {
        title: title.to_owned(),
        x_title: x_title.to_owned(),
        x: range(|point| point.0),
        y: Panel::padded(range(|point| point.1)),
        layers,
    }
}

/// The style sheet's share for drawings: the palette as custom properties, light and dark, and
/// rules that let it override the colours in the SVG.
pub(crate) fn theme() -> String {
    let (mut light, mut dark, mut rules) = (String::new(), String::new(), String::new());
    for (name, RGBColor(r, g, b), on_black) in PALETTE {
        let colour = format!("#{r:02X}{g:02X}{b:02X}");
        write!(light, "--{name}:{colour};").expect("a string takes all");
        write!(dark, "--{name}:{on_black};").expect("a string takes all");
        for attribute in ["fill", "stroke"] {
            writeln!(
                rules,
                "svg [{attribute}=\"{colour}\"]{{{attribute}:var(--{name})}}"
            )
            .expect("a string takes all");
        }
    }
    format!(
        ":root{{{light}}}\n@media (prefers-color-scheme:dark){{:root{{{dark}}}}}\n{rules}svg \
         text{{font-family:inherit}}\n"
    )
}

/// Rows of panels as one `<svg>` element. Each row comes with its height in drawing units;
/// `description` (already escaped) is for readers who cannot see it.
pub(crate) fn draw(rows: &[(u32, Vec<Panel>)], description: &str) -> io::Result<String> {
    let height = rows.iter().map(|(height, _)| height).sum();
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
        let mut rest = root.clone();
        for (height, panels) in rows {
            let (row, below) = rest.split_vertically(*height);
            rest = below;
            for (area, panel) in row.split_evenly((1, panels.len())).iter().zip(panels) {
                draw_panel(area, panel).map_err(io::Error::other)?;
            }
        }
        root.present().map_err(io::Error::other)?;
    }
    Ok(inlined(&svg, height, description))
}

/// A drawing of this height as an element of a page.
///
/// Inside a page an SVG takes its size from the style sheet and needs no name space.
pub(super) fn inlined(svg: &str, height: u32, description: &str) -> String {
    let body = svg.split_once('>').map_or("", |(_, body)| body);
    format!(
        "<svg viewBox=\"0 0 {WIDTH} {height}\" role=\"img\" aria-label=\"{description}\">{body}"
    )
}

fn draw_panel(
    area: &DrawingArea<SVGBackend, Shift>,
    panel: &Panel,
) -> Result<(), DrawingAreaErrorKind<io::Error>> {
    let (left, right) = panel.x;
    let (bottom, top) = panel.y;
    let label = FONT.into_font().color(&LABEL);
    let title = FONT.into_font().color(&TITLE);
    area.draw(&Text::new(panel.title.as_str(), (LEFT as i32, 20), title))?;
    let below = if panel.x_title.is_empty() {
        BOTTOM_UNTITLED
    } else {
        BOTTOM
    };
    let mut chart = ChartBuilder::on(area)
        .margin_top(TOP)
        .margin_right(30)
        .set_label_area_size(LabelAreaPosition::Left, LEFT)
        .set_label_area_size(LabelAreaPosition::Bottom, below)
        .build_cartesian_2d(left..right, bottom..top)?;
    let (width, height) = area.dim_in_pixel();
    chart
        .configure_mesh()
        .x_labels((width / 160) as usize)
        .y_labels((height / 45).max(3) as usize)
        .x_label_formatter(&|value| tick(*value, right - left))
        .y_label_formatter(&|value| tick(*value, top - bottom))
        .label_style(label)
        .axis_desc_style(FONT.into_font().color(&LABEL))
        .x_desc(panel.x_title.as_str())
        .bold_line_style(GRID.stroke_width(2))
        .light_line_style(TRANSPARENT)
        .axis_style(GRID.stroke_width(2))
        .draw()?;
    for layer in &panel.layers {
        let colour = layer.colour.mix(layer.opacity);
        let points = &layer.points;
        match layer.mark {
            Mark::Line(width) => {
                let style = colour.stroke_width(width);
                chart.draw_series([PathElement::new(points.clone(), style)])?;
            }
            Mark::Dot(radius) => {
                chart.draw_series(
                    points
                        .iter()
                        .map(|&p| Circle::new(p, radius, colour.filled())),
                )?;
            }
            Mark::Bar => {
                let half = match points.as_slice() {
                    [first, second, ..] => 0.46 * (second.0 - first.0),
                    _ => 0.4,
                };
                chart.draw_series(points.iter().map(|&(x, y)| {
                    Rectangle::new([(x - half, 0.0), (x + half, y)], colour.filled())
                }))?;
            }
            Mark::Area => {
                chart.draw_series([Polygon::new(points.clone(), colour.filled())])?;
            }
            Mark::Across => {
                chart.draw_series(points.iter().map(|&(_, y)| {
                    PathElement::new(vec![(left, y), (right, y)], colour.stroke_width(2))
                }))?;
            }
            Mark::Upright => {
                chart.draw_series(points.iter().map(|&(x, _)| {
                    PathElement::new(vec![(x, bottom), (x, top)], colour.stroke_width(2))
                }))?;
            }
        }
    }
    Ok(())
}

/// An axis label: as many decimals as an axis of this length needs, no trailing zeros.
fn tick(value: f64, length: f64) -> String {
    let decimals = (2.0 - length.log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.')
    } else {
        &text
    };
    if text == "-0" {
        "0".into()
    } else {
        text.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_short() {
        assert_eq!(tick(0.30000000000000004, 1.0), "0.3");
        assert_eq!(tick(-1e-17, 1.0), "0");
        assert_eq!(tick(1200.0, 5000.0), "1200");
        assert_eq!(tick(10.0, 5.0), "10");
        assert_eq!(tick(2.5e-4, 1e-3), "0.00025");
    }

    #[test]
    fn an_axis_has_length_even_for_one_value() {
        for range in [(0.0, 0.0), (5.0, 5.0), (-2.0, -2.0), (0.0, 1.0)] {
            let (low, high) = Panel::padded(range);
            assert!(low < range.0 && high > range.1);
        }
    }

    #[test]
    fn every_colour_of_a_drawing_follows_the_theme() {
        let layer = |mark, colour| Layer {
            mark,
            colour,
            opacity: 1.0,
            points: vec![(0.2, 0.3), (0.6, 0.7)],
        };
        let panel = Panel {
            title: "a < b".into(),
            x_title: "time, s".into(),
            x: (0.0, 1.0),
            y: (0.0, 1.0),
            layers: vec![
                layer(Mark::Line(3), MEASURED),
                layer(Mark::Dot(3), BEFORE),
                layer(Mark::Dot(3), OTHER),
                layer(Mark::Bar, AFTER),
                layer(Mark::Area, AFTER),
                layer(Mark::Across, GUIDE),
                layer(Mark::Upright, GUIDE),
            ],
        };
        let svg = draw(&[(300, vec![panel])], "a drawing").unwrap();
        let theme = theme();
        let document = roxmltree::Document::parse(&svg).unwrap();
        let mut used = std::collections::BTreeSet::new();
        for node in document.descendants() {
            for attribute in ["fill", "stroke"] {
                match node.attribute(attribute) {
                    None | Some("none") => {}
                    Some(colour) => {
                        let rule = format!("svg [{attribute}=\"{colour}\"]");
                        assert!(theme.contains(&rule), "{colour} is not in the palette");
                        used.insert(colour.to_owned());
                    }
                }
            }
        }
        assert_eq!(used.len(), PALETTE.len());
        assert!(svg.contains("a &lt; b"));
    }
}
