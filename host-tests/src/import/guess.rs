//! Which column of a file is most likely which column of a log, by its name.

use super::raw::Raw;
use super::recipe::Recipe;
use super::suspect::looks_unsized;
use super::unit::{Kind, Unit, unit_of_time};
use crate::log::{COLUMNS, COMMAND, CURRENT, INPUT, POSITION, REQUIRED, TIME, VELOCITY};

/// Names that loggers and papers give the columns of a log, without case, unit and punctuation. Of the times of an MCAP
/// the message's own comes first, which is that of the measurement; then that of the recorder, which is of one clock
/// in the whole file. The sender's may be of any clock, and many recorders write their own in its place
/// (<https://github.com/PlotJuggler/PlotJuggler/issues/1084>, <https://github.com/ros2/rosbag2/pull/1531>).
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
        "datetime",
        "uhrzeit",
        "headerstamp",
        "logtime",
        "publishtime",
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
        "cur",
        "curr",
        "motorcur",
        "ampere",
        "amperes",
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

/// What stands in a call for the rate of rows without a time, Hz, until the user puts theirs there.
pub(super) const SOME_RATE: f64 = 1000.0;

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

/// Whether a column is the position asked for by its name.
pub(super) fn is_command(name: &str) -> bool {
    NAMES[COMMAND].contains(&base(name).as_str())
}

/// Whether a column is the motor's current by its name.
pub(crate) fn is_current(name: &str) -> bool {
    NAMES[CURRENT].contains(&base(name).as_str())
}

/// What a name in a path ends with, without the number of an element: `current` of `/motor.current.0`.
pub(super) fn end_of_path(name: &str) -> &str {
    let is_number = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
    let mut parts = name.rsplit('.');
    parts.find(|part| !is_number(part)).unwrap_or(name)
}

/// The most likely recipe; of rows without a time with [`SOME_RATE`]. `None` where the file has too few columns.
pub(super) fn recipe(raw: &Raw) -> Option<Recipe> {
    let whole: Vec<String> = raw.names.iter().map(|name| base(name)).collect();
    let ends = raw.names.iter().map(|name| base(end_of_path(name)));
    let ends: Vec<String> = ends.collect();
    let good = |column: usize| {
        let values = raw.columns[column].values.iter().copied();
        values.filter(|value| !value.is_nan())
    };
    let has_numbers = |column: &usize| good(*column).next().is_some();
    // Of a stamp that nobody set every row has the same.
    let varies = |column: &usize| good(*column).any(|value| Some(value) != good(*column).next());
    let mut chosen: [Option<usize>; COLUMNS.len()] = [None; COLUMNS.len()];
    // Some files call a column by its unit alone.
    let mut named_by_unit = Vec::new();
    for index in 0..COLUMNS.len() {
        let fits = |column: &usize| match index {
            TIME => varies(column),
            _ => has_numbers(column),
        };
        // The log's own name first, then the usual ones in their order.
        let own = raw.names.iter().position(|name| name == COLUMNS[index].0);
        let usual = |bases: &[String]| {
            let free = |at: &usize| !chosen.contains(&Some(*at)) && fits(at);
            let named = |name: &&str| (0..bases.len()).find(|at| bases[*at] == *name && free(at));
            NAMES[index].iter().find_map(named)
        };
        let own = own.filter(fits);
        chosen[index] = own.or_else(|| usual(&whole)).or_else(|| usual(&ends));
        if chosen[index].is_none() {
            let is_free = |at: &usize| !chosen.contains(&Some(*at)) && fits(at);
            // A name of one small letter is a symbol, as v of a velocity and a of an acceleration.
            let is_symbol = |name: &str| matches!(name, "a" | "v");
            let is_of = |at: &usize| {
                let name = &raw.names[*at];
                !is_symbol(name) && Unit::find(name).is_some_and(|unit| tells(index, unit.kind))
            };
            chosen[index] = (0..raw.names.len()).find(|at| is_free(at) && is_of(at));
            named_by_unit.extend(chosen[index]);
        }
    }
    let is_stamps = |column: &usize| raw.columns[*column].first_stamp.is_some();
    let is_time = |column: &usize| {
        let named = |bases: &[String]| NAMES[TIME].contains(&bases[*column].as_str());
        is_stamps(column) || named(&whole) || named(&ends)
    };
    for index in 0..REQUIRED {
        if chosen[index].is_none() {
            let free = |column: &usize| !chosen.contains(&Some(*column)) && has_numbers(column);
            let mut free = (0..raw.columns.len()).filter(free);
            chosen[index] = match index {
                TIME => (0..raw.columns.len())
                    .find(is_stamps)
                    .or_else(|| free.find(|&column| rises(&raw.columns[column].values))),
                _ => free.find(|column| !is_time(column)),
            };
        }
    }
    let mut recipe = Recipe::default();
    for (index, column) in chosen.into_iter().enumerate() {
        let Some(column) = column else {
            match index {
                // Even rows, of a rate that the user knows.
                TIME => recipe.rate = Some(SOME_RATE),
                _ if index < REQUIRED => return None,
                _ => {}
            }
            continue;
        };
        let name = raw.name(column);
        let is_unit = named_by_unit.contains(&column);
        let unit = is_unit.then_some(name.as_str());
        let unit = unit.or_else(|| raw.own_unit(column, COLUMNS[index].0));
        // That the file says it is in SI units is worth seeing too; a time in seconds is the rule.
        let stated = || raw.stated_unit(column, COLUMNS[index].0);
        // What has the log's own name is in the log's unit.
        let is_own = name == COLUMNS[index].0;
        let unit = unit.or_else(|| stated().filter(|_| index != TIME && !is_own));
        // Seconds that the name says are believed; without any the steps tell.
        let told = index != TIME || raw.units[column].is_some();
        let steps = || unit_of_time(&raw.columns[column].values);
        let unit = unit.or_else(|| (!told).then(steps)?.map(|(_, unit)| unit));
        recipe.sources[index] = Some(match unit {
            // Of what it is a share, or how much a count is, the file does not say: as it stands, and to be seen.
            Some(unit) if Unit::find(unit).is_some_and(|unit| unit.needs_size()) => {
                format!("{name}:{unit}*1")
            }
            Some(unit) => format!("{name}:{unit}"),
            None => {
                let values: Vec<f64> = good(column).collect();
                let looks = looks_unsized(index, &name, &values);
                looks.map_or_else(|| name.clone(), |source| format!("{source}*1"))
            }
        });
    }
    Some(recipe)
}

/// Whether a column that is called by a unit of this kind alone is that column of the log.
fn tells(index: usize, kind: Kind) -> bool {
    match index {
        TIME => kind == Kind::Time,
        INPUT => matches!(
            kind,
            Kind::Voltage | Kind::Share | Kind::Torque | Kind::Force
        ),
        POSITION => matches!(kind, Kind::Angle | Kind::Length),
        CURRENT => kind == Kind::Current,
        VELOCITY => matches!(kind, Kind::AngularVelocity | Kind::LinearVelocity),
        _ => false,
    }
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
        // As the reader of MCAP gives them.
        for (at, name) in names.iter().enumerate() {
            let is_time = name.ends_with("_time") || name.ends_with("stamp");
            raw.units[at] = is_time.then(|| "s".to_owned());
        }
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
            ["Time [ms]", "Duty (%):%*1", "Pos_deg"]
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
                "PWM [%]:%*1",
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
        // Called by their units alone.
        assert_eq!(
            guessed(["t", "deg", "pct", "mA"], 1.0),
            ["t:ms", "pct:pct*1", "deg:deg", "mA:mA"]
        );
        // The message's own time, then the recorder's; neither is an input or a position.
        assert_eq!(
            guessed(
                [
                    "log_time",
                    "publish_time",
                    "header.stamp",
                    "position.0",
                    "mode",
                    "current.0"
                ],
                1e-3
            ),
            ["header.stamp", "mode", "position.0", "current.0"]
        );
        assert_eq!(
            guessed(
                ["log_time", "publish_time", "drive.duty", "drive.pos"],
                1e-3
            ),
            ["log_time", "drive.duty:%*1", "drive.pos"]
        );
        assert_eq!(
            guessed(["/a.publish_time", "/a.log_time", "/a.u", "/a.x"], 1e-3),
            ["/a.log_time", "/a.u", "/a.x"]
        );
    }
}
