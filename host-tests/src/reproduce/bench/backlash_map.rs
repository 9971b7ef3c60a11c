//! Backlash over the encoder's micro-mover: Table 5.2, the polynomial and the theory of ch. 6.2.

use serde::Deserialize;

use super::errors::{Errors, error_rows, errors, range, rmse_of_fit};
use super::gears::GearPair;
use super::polynomial::{Polynomial, coefficient_rows, coefficient_unit};
use super::section::{Part, Section};
use crate::cells::{Cells, row};
use crate::failure::Failure;
use crate::page::Figure;
use crate::page::plot::{self, AFTER, BEFORE, Layer, MEASURED, Mark, OTHER, line, panel};
use crate::reproduce::entry;

/// Table 5.2.
const TABLE: &str = include_str!("../../../traces/bench-backlash-map.csv");

/// The paper's p_bk, from the constant up, in degrees over mm.
pub const PRINTED: [f64; 4] = [4.774, -0.5448, -0.000_240_8, 0.001_141];

/// What the paper gives as the errors of its fit: RMSE, degrees, and NRMSE.
pub const PRINTED_ERRORS: Errors = Errors {
    rmse: 0.0239,
    nrmse: 0.0147,
};

/// What it gives as those of its theory (Table 6.1).
pub const PRINTED_THEORY: Errors = Errors {
    rmse: 0.6824,
    nrmse: 0.1159,
};

/// Pitch radius of the gear on the slow shaft, mm (ch. 6.2).
pub const PITCH_RADIUS_MM: f64 = 77.5;

/// Teeth of the gear on the slow shaft and of the encoder's (ch. 5.2).
pub const TEETH: [f64; 2] = [62.0, 15.0];

/// Pressure angle, degrees (ch. 6.2).
pub const PRESSURE_ANGLE_DEG: f64 = 20.0;

/// Distance of the axes across the micro-mover's guide, mm (ch. 2.1.6).
pub const VERTICAL_MM: f64 = 68.06;

/// The micro-mover's reading without play, mm (ch. 5.2).
pub const ZERO_MM: f64 = 13.0;

/// A row of Table 5.2.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Row {
    /// The micro-mover's reading, mm: 13 without play, 6 with the most.
    pub displacement_mm: f64,
    /// Backlash by Algorithm 1 at the slow shaft, degrees.
    pub backlash_deg: f64,
}

/// Table 5.2, in its order.
pub fn table() -> Vec<Row> {
    super::rows(TABLE)
}

fn columns(rows: &[Row]) -> (Vec<f64>, Vec<f64>) {
    let pairs = rows.iter();
    pairs
        .map(|row| (row.displacement_mm, row.backlash_deg))
        .unzip()
}

/// The bench's gears. The module follows from pitch radius and teeth: 2.5 mm.
pub fn gears() -> GearPair {
    GearPair {
        module: 2e-3 * PITCH_RADIUS_MM / TEETH[0],
        teeth: TEETH[0],
        other_teeth: TEETH[1],
        pressure_angle: PRESSURE_ANGLE_DEG.to_radians(),
    }
}

/// Distance of the axes along the micro-mover's guide at its zero, m. The paper does not print it;
/// it follows from the gears' own centre distance, 96.25 mm, and is 68.06 mm like the one across: the
/// encoder's gear stands at 45°.
pub fn horizontal_at_zero() -> f64 {
    let across = 1e-3 * VERTICAL_MM;
    (gears().reference_distance().powi(2) - across * across).sqrt()
}

/// Centre distance of the gears at a reading of the micro-mover in mm, m, with the axes so far apart
/// along its guide at its zero, m.
pub fn centre_distance(reading_mm: f64, horizontal_at_zero: f64) -> f64 {
    let along = horizontal_at_zero + 1e-3 * (ZERO_MM - reading_mm);
    along.hypot(1e-3 * VERTICAL_MM)
}

/// A reading of the paper's theory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// What is taken for what.
    pub name: &'static str,
    /// By the involute instead of the paper's line.
    pub involute: bool,
    /// What is compared with the measurement, as a share of the full play.
    pub share: f64,
}

/// The readings that the text allows, and the involute's.
pub const READINGS: [Reading; 4] = [
    Reading {
        name: "line, full play",
        involute: false,
        share: 1.0,
    },
    Reading {
        name: "line, half play",
        involute: false,
        share: 0.5,
    },
    Reading {
        name: "involute, full play",
        involute: true,
        share: 1.0,
    },
    Reading {
        name: "involute, half play",
        involute: true,
        share: 0.5,
    },
];

impl Reading {
    /// Backlash at a reading of the micro-mover in mm, degrees.
    pub fn at(&self, reading_mm: f64) -> f64 {
        let gears = gears();
        let distance = centre_distance(reading_mm, horizontal_at_zero());
        let play = if self.involute {
            gears.involute_play(distance)
        } else {
            gears.linear_play(distance)
        };
        (self.share * play).to_degrees()
    }

    /// Its errors on Table 5.2, and its own range in degrees.
    pub fn errors(&self) -> (Errors, f64) {
        let (x, y) = columns(&table());
        let theory: Vec<f64> = x.iter().map(|&x| self.at(x)).collect();
        (errors(&theory, &y), range(&theory))
    }
}

/// A third-order polynomial over rows of the map.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// In degrees over mm.
    pub polynomial: Polynomial,
    /// Its errors on these rows.
    pub errors: Errors,
    /// The RMSE with n − 4 below the sum, degrees.
    pub rmse_of_fit: f64,
}

/// Fits rows of the table.
///
/// # Errors
/// Rows that do not determine it.
pub fn fit(rows: &[Row]) -> Result<Fit, Failure> {
    let (x, y) = columns(rows);
    let polynomial = Polynomial::fit(&x, &y, PRINTED.len() - 1)
        .ok_or_else(|| Failure::other("the map of the backlash does not determine its fit"))?;
    let model = polynomial.over(&x);
    Ok(Fit {
        errors: errors(&model, &y),
        rmse_of_fit: rmse_of_fit(&model, &y, PRINTED.len()),
        polynomial,
    })
}

/// The printed polynomial on the table.
pub fn printed_errors() -> Errors {
    let (x, y) = columns(&table());
    errors(&Polynomial(PRINTED.to_vec()).over(&x), &y)
}

/// The rows at a whole number of millimetres: those that the text says the table is of.
pub fn integer_rows() -> Vec<Row> {
    let mut rows = table();
    rows.retain(|row| row.displacement_mm.fract() == 0.0);
    rows
}

/// The distance along the guide at the zero, m, with which the paper's line for the full play has the
/// RMSE of Table 6.1; by bisection.
pub fn horizontal_of_the_printed_rmse() -> f64 {
    let (x, y) = columns(&table());
    let gears = gears();
    let rmse = |horizontal: f64| {
        let start = centre_distance(ZERO_MM, horizontal);
        let model = x.iter().map(|&x| {
            let growth = centre_distance(x, horizontal) - start;
            gears
                .linear_play(gears.reference_distance() + growth)
                .to_degrees()
        });
        errors(&model.collect::<Vec<_>>(), &y).rmse
    };
    // Between these it grows with the distance.
    let (mut low, mut high) = (0.05, horizontal_at_zero());
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if rmse(middle) < PRINTED_THEORY.rmse {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// What is shown of the map.
pub(super) fn section() -> Result<Section, Failure> {
    let ours = fit(&table())?;
    let integers = fit(&integer_rows())?;
    let printed = printed_errors();
    let mut entries = vec![
        entry(
            "backlash map, third-order fit, RMSE",
            Some(PRINTED_ERRORS.rmse),
            ours.errors.rmse,
            None,
            "°",
        ),
        entry(
            "backlash map, third-order fit, NRMSE",
            Some(100.0 * PRINTED_ERRORS.nrmse),
            100.0 * ours.errors.nrmse,
            None,
            "%",
        ),
        entry(
            "backlash map, printed polynomial on Table 5.2, RMSE",
            Some(PRINTED_ERRORS.rmse),
            printed.rmse,
            None,
            "°",
        ),
        entry(
            "backlash map, printed polynomial on Table 5.2, NRMSE",
            Some(100.0 * PRINTED_ERRORS.nrmse),
            100.0 * printed.nrmse,
            None,
            "%",
        ),
    ];
    for (power, (paper, found)) in PRINTED.iter().zip(&ours.polynomial.0).enumerate() {
        entries.push(entry(
            &format!("backlash map, third-order fit, coefficient of the power {power}"),
            Some(*paper),
            *found,
            None,
            &coefficient_unit("°", power),
        ));
    }
    for reading in READINGS {
        let (found, own) = reading.errors();
        let paper = |value| (!reading.involute).then_some(value);
        entries.push(entry(
            &format!("backlash map, theory, {}, RMSE", reading.name),
            paper(PRINTED_THEORY.rmse),
            found.rmse,
            None,
            "°",
        ));
        for (of, value) in [
            ("measurement's", found.nrmse),
            ("theory's", found.rmse / own),
        ] {
            entries.push(entry(
                &format!(
                    "backlash map, theory, {}, RMSE over the {of} range",
                    reading.name
                ),
                paper(100.0 * PRINTED_THEORY.nrmse),
                100.0 * value,
                None,
                "%",
            ));
        }
    }
    let mut parts = vec![Part::Table(
        "Third-order fit of the backlash".to_owned(),
        fit_cells(&ours, &integers, printed),
    )];
    parts.extend(fit_notes(&ours, &integers).map(Part::Note));
    parts.push(Part::Table(
        "Theory of the backlash against Table 5.2".to_owned(),
        theory_cells(),
    ));
    parts.extend(theory_notes().map(Part::Note));
    parts.push(Part::Figure(figure(&ours)?));
    Ok(Section {
        title: "Map of the backlash",
        finding: format!(
            "The fit of Table 5.2 has an RMSE of {:.4}°, {:.2} % of the range, as printed ({}° and {:.2} %). \
             The printed errors of the theory, {}° and {} %, do not belong to one theory.",
            ours.errors.rmse,
            100.0 * ours.errors.nrmse,
            PRINTED_ERRORS.rmse,
            100.0 * PRINTED_ERRORS.nrmse,
            PRINTED_THEORY.rmse,
            100.0 * PRINTED_THEORY.nrmse
        ),
        parts,
        entries,
    })
}

fn fit_cells(ours: &Fit, integers: &Fit, printed: Errors) -> Cells {
    let mut cells = vec![row([
        "",
        "printed",
        "fit, all 15",
        "fit, 8 integers",
        "printed, on Table 5.2",
    ])];
    cells.extend(coefficient_rows(
        &PRINTED,
        [&ours.polynomial, &integers.polynomial],
        "°",
        7,
    ));
    cells.extend(error_rows(
        &[PRINTED_ERRORS, ours.errors, integers.errors, printed],
        "°",
    ));
    cells
}

fn fit_notes(ours: &Fit, integers: &Fit) -> [String; 2] {
    [
        format!(
            "The text says that Table 5.2 lists integer displacements alone; it lists all 15, half \
             millimetres too, and the printed polynomial is the fit of all 15 (of the 8 integer ones the \
             RMSE would be {:.4}°).",
            integers.errors.rmse
        ),
        format!(
            "The RMSE has n below the sum; with n less the four coefficients it would be {:.4}°.",
            ours.rmse_of_fit
        ),
    ]
}

fn theory_cells() -> Cells {
    let mut cells = vec![row([
        "theory",
        "at 6 mm, °",
        "RMSE, °",
        "over the measurement's range, %",
        "over its own range, %",
    ])];
    cells.push(vec![
        "printed (Table 6.1)".to_owned(),
        String::new(),
        PRINTED_THEORY.rmse.to_string(),
        format!("{:.2}", 100.0 * PRINTED_THEORY.nrmse),
        String::new(),
    ]);
    cells.extend(READINGS.iter().map(|reading| {
        let (found, own) = reading.errors();
        vec![
            reading.name.to_owned(),
            format!("{:.3}", reading.at(6.0)),
            format!("{:.4}", found.rmse),
            format!("{:.2}", 100.0 * found.nrmse),
            format!("{:.2}", 100.0 * found.rmse / own),
        ]
    }));
    cells
}

fn theory_notes() -> [String; 5] {
    let gears = gears();
    let (_, measured) = columns(&table());
    let own = 1e3 * gears.reference_distance();
    let travel = ZERO_MM - 6.0;
    let bound = (2e-3 * travel * gears.pressure_angle.tan() / gears.pitch_radius()).to_degrees();
    let [_, half, _, involute] = READINGS;
    let ((half, half_range), (involute, _)) = (half.errors(), involute.errors());
    let at = |reading: Reading| reading.at(6.0);
    [
        format!(
            "Geometry: 62 teeth on a radius of {PITCH_RADIUS_MM} mm are a module of {:.1} mm, and with 15 \
             teeth a centre distance of {own:.2} mm without play. Were {PITCH_RADIUS_MM} mm the diameter, it \
             would be {:.2} mm, less than y_c = {VERTICAL_MM} mm alone: it is the radius. x_c is not printed; \
             at the zero it is √({own:.2}² − {VERTICAL_MM}²) = {:.2} mm, so the encoder's gear stands at 45°. \
             The printed j = 2a tan α / r must mean Δa for a.",
            1e3 * gears.module,
            0.5 * own,
            1e3 * horizontal_at_zero()
        ),
        format!(
            "An RMSE of {} over an NRMSE of {:.2} % is a range of {:.2}°. The measurement's is {:.2}°, and \
             no x_c gives the line more than {bound:.2}° over {travel} mm. So the two numbers of Table 6.1 \
             do not belong to the same curves in the same unit.",
            PRINTED_THEORY.rmse,
            100.0 * PRINTED_THEORY.nrmse,
            PRINTED_THEORY.rmse / PRINTED_THEORY.nrmse,
            range(&measured)
        ),
        format!(
            "Each number alone is near a reading: {}° would be the full play with x_c = {:.1} mm at the \
             zero; {:.2} % is near the half play's RMSE over the theory's own range, {:.2} %.",
            PRINTED_THEORY.rmse,
            1e3 * horizontal_of_the_printed_rmse(),
            100.0 * PRINTED_THEORY.nrmse,
            100.0 * half.rmse / half_range
        ),
        format!(
            "Algorithm 1 measures half of the play, and only beside the half play is the measurement \
             higher at large distances ({:.2}° against {:.2}° at 6 mm; the full play is {:.2}°), as the \
             paper says of it. Taken as the full width of a dead band, Table 5.2 gives half of the play that \
             it was measured on.",
            measured[measured.len() - 1],
            at(READINGS[1]),
            at(READINGS[0])
        ),
        format!(
            "The line is the first term of the involute's play. At 6 mm the involute itself is {:.0} % higher, \
             and it is curved upwards like the measurement: RMSE {:.3}° instead of {:.3}°. There the centre \
             distance has grown by {:.2} mm, more than the two modules by which teeth of standard height \
             overlap: by this geometry they would just have lost touch.",
            100.0 * (at(READINGS[3]) / at(READINGS[1]) - 1.0),
            involute.rmse,
            half.rmse,
            1e3 * centre_distance(6.0, horizontal_at_zero()) - own
        ),
    ]
}

/// The paper's Figs. 6.2 and 6.3.
fn figure(ours: &Fit) -> Result<Figure, Failure> {
    let rows = table();
    let over_reading: Vec<_> = rows
        .iter()
        .map(|row| (row.displacement_mm, row.backlash_deg))
        .collect();
    let distance = |reading: f64| 1e3 * centre_distance(reading, horizontal_at_zero());
    let over_distance: Vec<_> = rows
        .iter()
        .map(|row| (distance(row.displacement_mm), row.backlash_deg))
        .collect();
    let dots = |points| Layer {
        mark: Mark::Dot(7),
        colour: MEASURED,
        opacity: 0.8,
        points,
    };
    let readings: Vec<f64> = (0..=140).map(|step| 6.0 + f64::from(step) / 20.0).collect();
    let theory = |reading: &Reading| -> Vec<_> {
        let points = readings.iter().map(|&x| (distance(x), reading.at(x)));
        points.collect()
    };
    let fitted = readings.iter().map(|&x| (x, ours.polynomial.at(x)));
    let [full, half, _, involute] = &READINGS;
    let rows = [(
        460,
        vec![
            panel(
                "backlash, °",
                "micro-mover, mm",
                vec![dots(over_reading), line(AFTER, 3, 0.9, fitted.collect())],
            ),
            panel(
                "backlash, °",
                "centre distance, mm",
                vec![
                    dots(over_distance),
                    line(plot::GUIDE, 3, 0.9, theory(full)),
                    line(BEFORE, 3, 0.9, theory(half)),
                    line(OTHER, 3, 0.9, theory(involute)),
                ],
            ),
        ],
    )];
    Ok(Figure {
        statement: "Backlash over the encoder's micro-mover and over the centre distance."
            .to_owned(),
        method: "The paper's Figs. 6.2 and 6.3. Grey: the paper's line for the full play."
            .to_owned(),
        keys: vec![
            ("measured", "Table 5.2"),
            ("after", "our fit, third order"),
            ("before", "the paper's line, half play"),
            ("other", "involute, half play"),
        ],
        svg: plot::draw(&rows, "Backlash over displacement and centre distance")
            .map_err(|error| Failure::system("the plots", &error))?,
    })
}
