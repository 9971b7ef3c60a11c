//! The answer on the terminal.

use std::fmt::Write as _;

use model_core::identify::characteristic::{Direction, Kind, Side};

use super::{Identified, Model};
use crate::free_run::Errors;
use crate::machine::{Coordinate, Machine};

/// Names and units of the six numbers.
pub(super) const NUMBERS: [(&str, &str, &str); 6] = [
    ("a0/b0", "spring", "V/rad"),
    ("a1/b0", "damping", "V·s/rad"),
    ("c0/b0", "preload", "V"),
    ("c1/b0", "Coulomb friction", "V"),
    ("cH/b0", "static friction", "V"),
    ("b0", "acceleration gain", "rad/(V·s²)"),
];

/// Unit of a number in the machine's coordinate and of its input.
pub(super) fn unit(unit: &str, machine: &Machine) -> String {
    let input = if machine.motor.is_some() {
        "V"
    } else {
        machine.coordinate.load_unit()
    };
    let unit = unit.replace('V', input);
    unit.replace("rad", machine.coordinate.unit())
}

/// The name that the paper gives a line.
pub(super) fn line_name(kind: Kind, direction: Direction) -> &'static str {
    match (kind, direction) {
        (Kind::Uniform, Direction::Opening) => "L1 uniform opening",
        (Kind::Uniform, Direction::Closing) => "L2 uniform closing",
        (Kind::Breakaway, Direction::Opening) => "L3 stiction to sliding, opening",
        (Kind::Breakaway, Direction::Closing) => "L3 stiction to sliding, closing",
        (Kind::Standstill, Direction::Opening) => "L4 sliding to stiction, opening",
        (Kind::Standstill, Direction::Closing) => "L4 sliding to stiction, closing",
    }
}

/// The errors of every model on the validation log, in the order of [`models`].
pub(super) type Validation = Vec<Errors>;

/// The models with their names.
pub(super) fn models(identified: &Identified) -> Vec<(&'static str, &Model)> {
    let mut models = vec![
        ("lines and b0, reduced motor", &identified.reduced),
        ("lines and b0, full motor", &identified.full),
    ];
    if let Some(polished) = &identified.polished {
        models.push(("polished, full motor", polished));
    }
    models
}

/// The table.
pub(super) fn render(
    machine: &Machine,
    identified: &Identified,
    validation: Option<&Validation>,
) -> String {
    let mut text = format!(
        "{}: six numbers, of the lines and b0 with 95 % intervals\n",
        machine.name
    );
    let polished = identified.polished.as_ref();
    let _ = writeln!(
        text,
        "{:<8}{:<20}{:>26}{:>26}",
        "", "", "lines and b0, full motor", "polished"
    );
    for (index, (symbol, meaning, volts)) in NUMBERS.into_iter().enumerate() {
        let shown = |model: &Model| {
            let number = model.numbers.all()[index];
            if number.half_width.is_finite() {
                format!("{:.5} ± {:.5}", number.value, number.half_width)
            } else {
                format!("{:.5}", number.value)
            }
        };
        let _ = writeln!(
            text,
            "{symbol:<8}{meaning:<20}{:>26}{:>26} {}",
            shown(&identified.full),
            polished.map_or("-".to_owned(), shown),
            unit(volts, machine)
        );
    }
    text.push_str("\nLines of the characteristic, inliers of points\n");
    for branch in &identified.characteristic.branches {
        let side = match branch.side {
            Side::Below => "below rest",
            Side::Above => "above rest",
        };
        let line = branch.line;
        let _ = writeln!(
            text,
            "{:<34}{side:<12}{:>4} of {:<4} slope {:.4} ± {:.4}",
            line_name(branch.kind, branch.direction),
            line.inliers,
            line.points,
            line.slope,
            1.96 * line.slope_variance.sqrt(),
        );
    }
    let (scale, error_unit) = match machine.coordinate {
        Coordinate::Radian => (180.0 / std::f64::consts::PI, "°"),
        Coordinate::Metre => (1000.0, "mm"),
    };
    let shown = |errors: Errors| {
        format!(
            "{:.4} / {:.3} {error_unit}",
            errors.nrmse,
            scale * errors.max_abs
        )
    };
    let _ = writeln!(
        text,
        "\nFree run, NRMSE / largest error\n{:<30}{:>20}{:>20}{:>20}",
        "",
        "slow",
        "fast",
        if validation.is_some() {
            "validation"
        } else {
            ""
        }
    );
    for (index, (name, model)) in models(identified).into_iter().enumerate() {
        let validated = validation.map_or(String::new(), |errors| shown(errors[index]));
        let _ = writeln!(
            text,
            "{name:<30}{:>20}{:>20}{validated:>20}",
            shown(model.errors.slow),
            shown(model.errors.fast)
        );
    }
    for warning in &identified.warnings {
        let _ = writeln!(text, "note: {warning}");
    }
    text
}
