//! Friction over the brake's micro-mover: Table 5.1 and the polynomial of ch. 6.1.

use serde::Deserialize;

use super::errors::{Errors, error_rows, errors, rmse_of_fit};
use super::polynomial::{Polynomial, coefficient_rows, coefficient_unit};
use super::section::{Part, Section};
use crate::cells::{Cells, row};
use crate::failure::Failure;
use crate::page::Figure;
use crate::page::plot::{self, AFTER, BEFORE, Layer, MEASURED, Mark, line, panel};
use crate::reproduce::entry;

/// Table 5.1.
const TABLE: &str = include_str!("../../../traces/bench-friction-map.csv");

/// From the axis of the rotating plate to the load cell, m (ch. 5.1).
pub const LEVER_ARM: f64 = 0.233;

/// The lever arm with which the fit of the table's forces has every printed coefficient, m.
pub const LEVER_ARM_OF_THE_FIT: f64 = 0.235;

/// Teeth of the brake shaft's sprocket over those of the motor's (Table 2.8).
pub const CHAIN_RATIO: f64 = 34.0 / 23.0;

/// Standard gravity as the table has it, m/s²; with 9.80665 its torques would be 0.03 % lower.
pub const GRAVITY: f64 = 9.81;

/// The paper's p_lc, from the constant up, in N·m over mm.
pub const PRINTED: [f64; 5] = [0.7155, -0.4094, 0.1082, -0.1714, 0.06521];

/// What the paper gives as its errors: RMSE, N·m, and NRMSE.
pub const PRINTED_ERRORS: Errors = Errors {
    rmse: 0.0105,
    nrmse: 0.0148,
};

/// A row of Table 5.1.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Row {
    /// The micro-mover's reading, mm: 2 without contact, 0 at most of it.
    pub displacement_mm: f64,
    /// Mean force on the load cell, gram-force.
    pub force_gram_force: f64,
    /// Friction torque at the motor's shaft, N·m.
    pub torque_nm: f64,
}

/// Table 5.1, in its order.
pub fn table() -> Vec<Row> {
    super::rows(TABLE)
}

/// Friction torque at the motor's shaft, N·m, from the load cell's force in gram-force and the lever
/// arm in m (ch. 5.1).
///
/// ```
/// use host_tests::reproduce::bench::friction_map::{LEVER_ARM, torque};
///
/// assert!((torque(453.3086, LEVER_ARM) - 0.70092).abs() < 5e-6);
/// ```
pub fn torque(force_gram_force: f64, lever_arm: f64) -> f64 {
    force_gram_force * lever_arm * GRAVITY / (1000.0 * CHAIN_RATIO)
}

/// A fourth-order polynomial over the map.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// In N·m over mm.
    pub polynomial: Polynomial,
    /// Its errors on the torques that it was fitted to.
    pub errors: Errors,
    /// The RMSE with n − 5 below the sum, N·m.
    pub rmse_of_fit: f64,
}

/// Fits the torques that the table's forces give with a lever arm, m.
///
/// # Errors
/// Points that do not determine it.
pub fn fit(lever_arm: f64) -> Result<Fit, Failure> {
    let (x, y) = points(lever_arm);
    let polynomial = Polynomial::fit(&x, &y, PRINTED.len() - 1)
        .ok_or_else(|| Failure::other("the map of the friction does not determine its fit"))?;
    let model = polynomial.over(&x);
    Ok(Fit {
        errors: errors(&model, &y),
        rmse_of_fit: rmse_of_fit(&model, &y, PRINTED.len()),
        polynomial,
    })
}

/// The printed polynomial on the table's torques.
pub fn printed_errors() -> Errors {
    let (x, y): (Vec<f64>, Vec<f64>) = table()
        .iter()
        .map(|row| (row.displacement_mm, row.torque_nm))
        .unzip();
    errors(&Polynomial(PRINTED.to_vec()).over(&x), &y)
}

fn points(lever_arm: f64) -> (Vec<f64>, Vec<f64>) {
    table()
        .iter()
        .map(|row| (row.displacement_mm, torque(row.force_gram_force, lever_arm)))
        .unzip()
}

/// The largest difference between the table's torques and those of its forces, N·m.
pub fn largest_difference() -> f64 {
    table()
        .iter()
        .map(|row| (torque(row.force_gram_force, LEVER_ARM) - row.torque_nm).abs())
        .fold(0.0, f64::max)
}

/// What is shown of the map.
pub(super) fn section() -> Result<Section, Failure> {
    let ours = fit(LEVER_ARM)?;
    let theirs = fit(LEVER_ARM_OF_THE_FIT)?;
    let printed = printed_errors();
    let mut entries = vec![
        entry(
            "friction map, largest difference between a torque of Table 5.1 and that of its force",
            None,
            largest_difference(),
            Some(0.0),
            "N·m",
        ),
        entry(
            "friction map, fourth-order fit, RMSE",
            Some(PRINTED_ERRORS.rmse),
            ours.errors.rmse,
            None,
            "N·m",
        ),
        entry(
            "friction map, fourth-order fit, NRMSE",
            Some(100.0 * PRINTED_ERRORS.nrmse),
            100.0 * ours.errors.nrmse,
            None,
            "%",
        ),
        entry(
            "friction map, fourth-order fit with a lever arm of 0.235 m, RMSE",
            Some(PRINTED_ERRORS.rmse),
            theirs.errors.rmse,
            None,
            "N·m",
        ),
        entry(
            "friction map, printed polynomial on Table 5.1, RMSE",
            Some(PRINTED_ERRORS.rmse),
            printed.rmse,
            None,
            "N·m",
        ),
        entry(
            "friction map, printed polynomial on Table 5.1, NRMSE",
            Some(100.0 * PRINTED_ERRORS.nrmse),
            100.0 * printed.nrmse,
            None,
            "%",
        ),
    ];
    for (power, (paper, found)) in PRINTED.iter().zip(&ours.polynomial.0).enumerate() {
        entries.push(entry(
            &format!("friction map, fourth-order fit, coefficient of the power {power}"),
            Some(*paper),
            *found,
            None,
            &coefficient_unit("N·m", power),
        ));
    }
    let notes = [
        format!(
            "Every torque of Table 5.1 follows from its force with {LEVER_ARM} m, 34/23 and {GRAVITY} m/s², \
             to within {:.0e} N·m, half of its last digit. The paper's unit gN is gram-force.",
            largest_difference()
        ),
        format!(
            "The printed polynomial is not the fit of the printed torques: it lies {:.2} % above it at full \
             contact, and on them its RMSE is {:.4} N·m and its NRMSE {:.2} %. Fitted to the same forces with \
             a lever arm of {LEVER_ARM_OF_THE_FIT} m instead of {LEVER_ARM} m, all five coefficients, RMSE and \
             NRMSE come out as printed. So the fit seems to have been made with another lever arm than the \
             table.",
            100.0 * (PRINTED[0] / ours.polynomial.0[0] - 1.0),
            printed.rmse,
            100.0 * printed.nrmse
        ),
        format!(
            "The paper's RMSE has n below the sum, as it defines it; with n less the five coefficients it \
             would be {:.4} N·m.",
            theirs.rmse_of_fit
        ),
    ];
    let mut parts = vec![Part::Table(
        "Fourth-order fit of the friction".to_owned(),
        fit_cells(&ours, &theirs, printed),
    )];
    parts.extend(notes.map(Part::Note));
    parts.push(Part::Figure(figure(&ours)?));
    Ok(Section {
        title: "Map of the friction",
        finding: format!(
            "The fit of Table 5.1 has an RMSE of {:.4} N·m, {:.2} % of the range; the paper's {} N·m and {} % are \
             those of the same forces with a lever arm of {LEVER_ARM_OF_THE_FIT} m instead of {LEVER_ARM} m.",
            ours.errors.rmse,
            100.0 * ours.errors.nrmse,
            PRINTED_ERRORS.rmse,
            100.0 * PRINTED_ERRORS.nrmse
        ),
        parts,
        entries,
    })
}

fn fit_cells(ours: &Fit, theirs: &Fit, printed: Errors) -> Cells {
    let mut cells = vec![row([
        "",
        "printed",
        "fit, 0.233 m",
        "fit, 0.235 m",
        "printed, on Table 5.1",
    ])];
    cells.extend(coefficient_rows(
        &PRINTED,
        [&ours.polynomial, &theirs.polynomial],
        "N·m",
        5,
    ));
    cells.extend(error_rows(
        &[PRINTED_ERRORS, ours.errors, theirs.errors, printed],
        "N·m",
    ));
    cells
}

/// The paper's Fig. 6.1.
fn figure(ours: &Fit) -> Result<Figure, Failure> {
    let measured: Vec<_> = table()
        .iter()
        .map(|row| (row.displacement_mm, row.torque_nm))
        .collect();
    let paper = Polynomial(PRINTED.to_vec());
    let curve = |polynomial: &Polynomial| -> Vec<_> {
        let steps = (0..=200).map(|step| 2.0 * f64::from(step) / 200.0);
        steps.map(|x| (x, polynomial.at(x))).collect()
    };
    let off = |polynomial: &Polynomial, colour| Layer {
        mark: Mark::Dot(6),
        colour,
        opacity: 0.9,
        points: measured
            .iter()
            .map(|&(x, y)| (x, 1e3 * (polynomial.at(x) - y)))
            .collect(),
    };
    let dots = Layer {
        mark: Mark::Dot(7),
        colour: MEASURED,
        opacity: 0.8,
        points: measured.clone(),
    };
    let x = "micro-mover, mm";
    let zero = line(plot::GUIDE, 2, 0.8, vec![(0.0, 0.0), (2.0, 0.0)]);
    let rows = [(
        440,
        vec![
            panel(
                "friction torque, N·m",
                x,
                vec![
                    dots,
                    line(BEFORE, 3, 0.9, curve(&paper)),
                    line(AFTER, 3, 0.9, curve(&ours.polynomial)),
                ],
            ),
            panel(
                "fit less measurement, mN·m",
                x,
                vec![zero, off(&paper, BEFORE), off(&ours.polynomial, AFTER)],
            ),
        ],
    )];
    Ok(Figure {
        statement: "Friction over the brake's micro-mover.".to_owned(),
        method: "The paper's Fig. 6.1, and what the fourth-order polynomials leave.".to_owned(),
        keys: vec![
            ("measured", "Table 5.1"),
            ("before", "printed polynomial"),
            ("after", "our fit of the table"),
        ],
        svg: plot::draw(
            &rows,
            "Friction torque over the displacement, measured and fitted",
        )
        .map_err(|error| Failure::system("the plots", &error))?,
    })
}
