//! Which column of a file is most likely which column of a log, by its name.

use super::raw::Raw;
use super::recipe::Recipe;
use super::unit::{Unit, unit_of_time};
use crate::log::{COLUMNS, REQUIRED, TIME};

/// Names that loggers and papers give the columns of a log, without case, unit and punctuation.
const NAMES: [&[&str]; COLUMNS.len()] = [
    &[
        "times",
        "time",
        "t",
        "timestamp",
        "stamp",
        "zeit",
        "tid",
        "temps",
        "elapsed",
        "clock",
    ],
    &[
        "input",
        "u",
        "voltage",
        "volt",
        "duty",
        "pwm",
        "motorvoltage",
        "uin",
        "vin",
        "umot",
        "vir",
        "drive",
        "output",
        "control",
        "effort",
        "tau",
        "torque",
        "spannung",
        "stellgroesse",
    ],
    &[
        "position",
        "pos",
        "angle",
        "theta",
        "phi",
        "q",
        "qm",
        "x",
        "y",
        "encoder",
        "enc",
        "counts",
        "motorposition",
        "positionact",
        "actualposition",
        "actual",
        "feedback",
        "ist",
        "istwert",
        "istposition",
        "istwinkel",
        "winkel",
        "weg",
        "stroke",
        "displacement",
    ],
    &[
        "command",
        "cmd",
        "setpoint",
        "reference",
        "ref",
        "target",
        "desired",
        "goal",
        "qg",
        "soll",
        "sollwert",
        "sollposition",
        "sollwinkel",
        "demand",
    ],
    &[
        "currenta",
        "current",
        "i",
        "imot",
        "motorcurrent",
        "iq",
        "amps",
        "strom",
    ],
    &[
        "velocity",
        "vel",
        "speed",
        "omega",
        "w",
        "dq",
        "rpm",
        "drehzahl",
        "geschwindigkeit",
    ],
    &["brake", "bremse"],
    &["loadtorque", "load"],
    &["enabled", "enable"],
];

/// A name without its unit, its case and its punctuation.
fn base(name: &str) -> String {
    let end = name.find(['[', '(', '{']).unwrap_or(name.len());
    let name = &name[..end];
    let name = match name.rsplit_once(['_', ' ', '/']) {
        Some((rest, unit)) if !rest.is_empty() && Unit::find(unit).is_some() => rest,
        _ => name,
    };
    let letters = name.chars().filter(|c| c.is_alphanumeric());
    letters.flat_map(char::to_lowercase).collect()
}

/// The most likely recipe. `None` where the file has too few columns.
pub(super) fn recipe(raw: &Raw) -> Option<Recipe> {
    let bases: Vec<String> = raw.names.iter().map(|name| base(name)).collect();
    let has_numbers = |column: &usize| raw.columns[*column].values.iter().any(|v| !v.is_nan());
    let mut chosen: [Option<usize>; COLUMNS.len()] = [None; COLUMNS.len()];
    for index in 0..COLUMNS.len() {
        // The log's own name first, then the usual ones in their order.
        let own = raw.names.iter().position(|name| name == COLUMNS[index].0);
        let usual = || {
            let mut names = NAMES[index].iter();
            names.find_map(|name| {
                (0..bases.len()).find(|&at| bases[at] == *name && !chosen.contains(&Some(at)))
            })
        };
        chosen[index] = own.or_else(usual).filter(has_numbers);
    }
    for index in 0..REQUIRED {
        if chosen[index].is_none() {
            let free = |column: &usize| !chosen.contains(&Some(*column)) && has_numbers(column);
            let mut free = (0..raw.columns.len()).filter(free);
            chosen[index] = match index {
                TIME => free.find(|&column| rises(&raw.columns[column].values)),
                _ => free.next(),
            };
        }
    }
    let mut recipe = Recipe::default();
    for (index, column) in chosen.into_iter().enumerate() {
        let Some(column) = column else {
            if index < REQUIRED {
                return None;
            }
            continue;
        };
        let unit = raw.own_unit(column, COLUMNS[index].0);
        // Seconds that the name says are believed; without any the steps tell.
        let told = index != TIME || raw.units[column].is_some();
        let steps = || unit_of_time(&raw.columns[column].values);
        let unit = unit.or_else(|| (!told).then(steps)?.map(|(_, unit)| unit));
        let name = raw.name(column);
        recipe.sources[index] = Some(match unit {
            // Of what it is a share, or how much a count is, the file does not say: as it stands, and to be seen.
            Some(unit) if Unit::find(unit).is_some_and(|unit| unit.needs_size()) => {
                format!("{name}:{unit}*1")
            }
            Some(unit) => format!("{name}:{unit}"),
            None => name,
        });
    }
    Some(recipe)
}

/// Whether a column may be a time.
fn rises(values: &[f64]) -> bool {
    let good: Vec<f64> = values
        .iter()
        .copied()
        .filter(|value| !value.is_nan())
        .collect();
    let falls = good.windows(2).filter(|pair| pair[1] < pair[0]).count();
    good.first() < good.last() && 10 * falls <= good.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::raw::Column;

    fn guessed<const N: usize>(names: [&str; N], step: f64) -> Vec<String> {
        let mut raw = Raw::named(names);
        for (at, column) in raw.columns.iter_mut().enumerate() {
            // Only the first column never falls.
            *column = Column::of(
                (0..10_u32)
                    .map(|row| f64::from(row * row.pow(at as u32) % 7))
                    .collect(),
            );
        }
        raw.columns[0] = Column::of((0..10).map(|row| f64::from(row) * step).collect());
        let recipe = recipe(&raw).unwrap();
        recipe.sources.into_iter().flatten().collect()
    }

    #[test]
    fn usual_names_are_known() {
        // Steps of 1 are no seconds of a drive's log.
        assert_eq!(
            guessed(["t", "qg", "vir", "qm"], 1.0),
            ["t:ms", "vir", "qm", "qg"]
        );
        assert_eq!(
            guessed(["Time [ms]", "Pos_deg", "Duty (%)"], 1e-3),
            ["Time [ms]", "Duty (%)", "Pos_deg"]
        );
        // What is asked for stands before what came of it.
        assert_eq!(
            guessed(
                [
                    "Zeit [ms]",
                    "Sollwert [°]",
                    "Istwert [°]",
                    "PWM [%]",
                    "Strom [mA]"
                ],
                1e-3
            ),
            [
                "Zeit [ms]",
                "PWM [%]",
                "Istwert [°]",
                "Sollwert [°]",
                "Strom [mA]"
            ]
        );
        assert_eq!(guessed(["t,u,y", "b", "c"], 1e-3), ["t,u,y", "b", "c"]);
        assert_eq!(
            guessed(["time_s", "input", "position", "current"], 1e-3).len(),
            4
        );
        assert_eq!(guessed(["", "", ""], 1e-3), ["1", "2", "3"]);
    }
}
