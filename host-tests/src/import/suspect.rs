//! Units that a column looks like, where none was given for it; and units and names that contradict what it is
//! taken for.

use super::convert::Converted;
use super::guess::is_command;
use super::raw::Raw;
use super::source::Source;
use super::summary::is_linear;
use super::text::suffixed;
use super::unit::{Kind, Unit, kinds, unit_of_time};
use crate::gap::disagreement::channels::{largest, wrap_of};
use crate::gap::disagreement::units::full_scale;
use crate::log::{COLUMNS, COMMAND, CURRENT, Columns, INPUT, POSITION, TIME, VELOCITY, counted};
use crate::machine::{Coordinate, Machine};
use crate::page::series::extent;
use crate::quantity::{given, significant};

/// An angle beyond this, rad, is more than three turns either way: degrees, more likely.
const FAR: f64 = 20.0;
/// A current beyond this, A, is one in milliamperes of a small drive.
const STRONG: f64 = 200.0;
/// A stroke beyond this, m, is one in millimetres, more likely.
const LONG: f64 = 5.0;
/// Share of its rows from which on an angle that jumps there is not one that starts again: ten samples a turn show no motion.
const MOST_TURNS: f64 = 0.1;
/// What the velocity may differ from the slope of the position by, as a share.
const ALIKE: f64 = 0.1;

/// What to look at again, one sentence each: the column and the option that would read it otherwise.
pub(super) fn suspicions(
    raw: &Raw,
    sources: &[(usize, Source)],
    columns: &Columns,
    machine: Option<&Machine>,
) -> Vec<String> {
    let mut said = Vec::new();
    let is_linear = is_linear(sources, machine);
    // A machine file with a gain takes the input in its own unit: the comparison with it says whether that is it.
    let has_own_input = machine.is_some_and(|machine| machine.gain != 1.0);
    said.extend(other_velocity(sources, columns, raw));
    for (index, source) in sources {
        let Some(values) = &columns[*index] else {
            continue;
        };
        if *index == POSITION && wrap_of(&[values]).is_some() {
            said.push(
                "`position` jumps by its whole range: if it starts again there, add --unwrap"
                    .into(),
            );
        }
        let of_machine = || other_motion(raw, *index, source, machine?);
        if let Some(doubt) = contradiction(raw, *index, source).or_else(of_machine) {
            said.push(doubt);
            continue;
        }
        let is_stamp = raw.columns[source.column].first_stamp.is_some();
        let is_own = *index == INPUT && has_own_input;
        if source.unit.is_some() || !source.is_plain() || is_stamp || is_own {
            continue;
        }
        let name = raw.name(source.column);
        let most = extent(values.iter().copied()).map_or(0.0, |(low, high)| high.max(-low));
        if *index == INPUT
            && let Some(scale) = counter_of_duty(&name, values)
        {
            let most = given(most);
            said.push(format!(
                "`input` may be in counts of a PWM, for it is whole and reaches {most}: then --input \
                 \"{name}/{scale}:duty*12\" ({scale} being the most; put the volts of your supply in place of 12)"
            ));
            continue;
        }
        let own = raw.own_unit(source.column, COLUMNS[*index].0);
        let flag = super::recipe::FLAGS[*index];
        let (why, unit) = match (own, looks(*index, &name, values, columns, is_linear)) {
            (Some(unit), _) => ("the file says so".to_owned(), unit),
            (None, Some(found)) => found,
            (None, None) => continue,
        };
        let stroke = match (own, is_linear) {
            (None, None) if *index == POSITION => {
                let unit = if unit == "deg" { "mm" } else { COUNTS_ALONG };
                format!("; of a stroke {flag} \"{name}:{unit}{}", size(unit))
            }
            _ => String::new(),
        };
        said.push(format!(
            "`{}` may be in {unit}, for {why}: then {flag} \"{name}:{unit}{}{stroke}",
            COLUMNS[*index].0,
            size(unit)
        ));
    }
    said
}

/// A unit of another motion than the machine's: an angle's where the machine file has a stroke, or the other way round.
fn other_motion(raw: &Raw, index: usize, source: &Source, machine: &Machine) -> Option<String> {
    let is_stroke = machine.coordinate == Coordinate::Metre;
    let (given, unit) = source.unit.as_ref()?;
    if unit.kind.is_linear()? == is_stroke {
        return None;
    }
    let (is, machine) = if is_stroke {
        ("an angle's", "a stroke")
    } else {
        ("a stroke's", "an angle")
    };
    let (column, name) = (COLUMNS[index].0, raw.name(source.column));
    let counts = if is_stroke && given.starts_with("counts/") && index != VELOCITY {
        let flag = super::recipe::FLAGS[index];
        format!(
            ": then {flag} \"{name}:{COUNTS_ALONG}{}",
            size(COUNTS_ALONG)
        )
    } else {
        ": check the unit, or `coordinate` in the machine file".to_owned()
    };
    Some(format!(
        "`{column}` was given in {given}, which is {is} unit, and the coordinate of the machine file is {machine}{counts}"
    ))
}

/// Jumps in so many rows that no motion between them would be left, if each were a turn.
pub(super) fn many_turns(sources: &[(usize, Source)], converted: &Converted) -> Option<String> {
    let angles = sources
        .iter()
        .filter(|(index, _)| [POSITION, COMMAND].contains(index));
    let values = converted.rows * angles.count();
    (converted.turns as f64 > MOST_TURNS * values as f64).then(|| {
        format!(
            "--unwrap took {} jumps out of {}: no angle starts again so often, so the turn is another one: say at how many \
             of the file's numbers it starts again, as in --unwrap 65536, or give the position's unit",
            converted.turns,
            counted(values, "value")
        )
    })
}

/// What the file says of a column that is not what it is taken for: another unit, or another name.
fn contradiction(raw: &Raw, index: usize, source: &Source) -> Option<String> {
    let column = COLUMNS[index].0;
    let name = raw.name(source.column);
    if index == POSITION && is_command(&name) {
        return Some(format!(
            "`position` is to be {name}, which by its name is the position asked for: check that it is the \
             column of the measured one"
        ));
    }
    let own = raw.units[source.column].as_deref()?;
    let stated = Unit::find(own)?;
    let allowed = kinds(column);
    // What stands behind a name may be a part of it, as in theta_m and u_in.
    let is_suffix = suffixed(&name).is_some_and(|(_, unit)| unit == own);
    match &source.unit {
        Some((given, unit)) if unit.kind == stated.kind => {
            let flag = super::recipe::FLAGS[index];
            (unit.factor != stated.factor).then(|| {
                format!(
                    "`{column}` was given in {given}, and the file says that {name} is in {own}: then {flag} \
                     \"{name}:{own}{}",
                    size(own)
                )
            })
        }
        // Who multiplies has a unit of their own, and counts are of any size.
        _ if is_suffix || source.is_scaled() || stated.kind == Kind::Counts => None,
        Some((given, _)) => Some(format!(
            "`{column}` was given in {given}, and the file says that {name} is in {own}: check that it is the right column"
        )),
        None if allowed.is_empty() || allowed.contains(&stated.kind) => None,
        None => Some(format!(
            "`{column}` is to be {name}, which the file says is in {own}: check that it is the right column"
        )),
    }
}

/// Counts along a stroke, by example.
const COUNTS_ALONG: &str = "counts*0.005:mm";

/// What a unit needs beside its name, by example.
fn size(unit: &str) -> &'static str {
    match Unit::find(unit).map(|unit| unit.kind) {
        Some(Kind::Share) => "*12\" (put the volts of your supply in place of 12)",
        Some(Kind::Counts) => "*0.001\" (put the size of a count in place of 0.001)",
        _ if unit == COUNTS_ALONG => "\" (put the way of a count in place of 0.005)",
        _ if unit.starts_with("counts/") => {
            "\" (4096 being the counts of a turn; in front of a gear of 75, /75 behind it)"
        }
        _ => "\"",
    }
}

/// The unit that the values look like, and why.
fn looks(
    index: usize,
    name: &str,
    values: &[f64],
    columns: &Columns,
    is_linear: Option<bool>,
) -> Option<(String, &'static str)> {
    let (low, high) = extent(values.iter().copied())?;
    let largest = high.abs().max(low.abs());
    let whole = values.iter().all(|value| value.fract() == 0.0);
    let reaches = |unit| Some((format!("it reaches {}", significant(largest, 3)), unit));
    match index {
        TIME => {
            let (step, unit) = unit_of_time(values)?;
            Some((format!("it steps by {}", significant(step, 3)), unit))
        }
        INPUT if is_share(name) && largest > 1.5 && largest <= 100.5 => reaches("%"),
        INPUT if largest > 1e3 => reaches("mV"),
        INPUT if largest > 60.0 && largest <= 100.5 => reaches("%"),
        INPUT if largest <= 1.001 && largest > 0.05 => reaches("duty"),
        POSITION if whole && largest > FAR => {
            let counts = if is_linear == Some(true) {
                COUNTS_ALONG
            } else {
                "counts/4096"
            };
            Some(("its values are whole".into(), counts))
        }
        POSITION if is_linear == Some(true) => (high - low > LONG).then(|| reaches("mm"))?,
        POSITION if high - low > 2.0 * FAR => reaches("deg"),
        CURRENT if largest > STRONG => reaches("mA"),
        VELOCITY => unit_of_velocity(values, columns, 1.0, is_linear),
        _ => None,
    }
}

/// The unit in which a velocity is the slope of the position, and why; none where it is that as it was read, at this factor.
fn unit_of_velocity(
    values: &[f64],
    columns: &Columns,
    factor: f64,
    is_linear: Option<bool>,
) -> Option<(String, &'static str)> {
    const UNITS: [&str; 8] = [
        "rpm", "deg/s", "rev/s", "mm/s", "cm/s", "m/min", "rad/s", "m/s",
    ];
    let slope = slope_of(values, columns[TIME].as_ref()?, columns[POSITION].as_ref()?)?;
    let is_one = |ratio: f64| (ratio - 1.0).abs() < ALIKE;
    let is_it = |name: &&str| {
        Unit::find(name).is_some_and(|unit| {
            let is_of_machine = is_linear.is_none() || unit.kind.is_linear() == is_linear;
            is_of_machine && is_one(slope * unit.factor / factor)
        })
    };
    let unit = UNITS.into_iter().find(is_it).filter(|_| !is_one(slope))?;
    let why = format!(
        "it is {} times the slope of `position`",
        significant(slope, 3)
    );
    Some((why, unit))
}

/// A velocity that is in another unit than the one that was given, beside a position whose unit is known.
fn other_velocity(sources: &[(usize, Source)], columns: &Columns, raw: &Raw) -> Option<String> {
    let of = |wanted: usize| sources.iter().find(|(index, _)| *index == wanted);
    let (_, position) = of(POSITION)?;
    let (_, velocity) = of(VELOCITY)?;
    position.unit.as_ref()?;
    let (given, unit) = velocity.unit.as_ref().filter(|_| !velocity.is_scaled())?;
    let values = columns[VELOCITY].as_deref()?;
    let is_linear = unit.kind.is_linear();
    let (why, found) = unit_of_velocity(values, columns, unit.factor, is_linear)?;
    let (flag, name) = (super::recipe::FLAGS[VELOCITY], raw.name(velocity.column));
    Some(format!(
        "`velocity` was given in {given}, and may be in {found}, for {why}: then {flag} \"{name}:{found}\""
    ))
}

/// The full scale of the counter that a duty is in, if it looks like one.
fn counter_of_duty(name: &str, values: &[f64]) -> Option<f64> {
    let largest = largest(values);
    let whole = values.iter().all(|value| value.fract() == 0.0);
    full_scale(largest).filter(|_| whole && largest > 100.5 && is_share(name))
}

/// Whether what looks like per cent may as well be counts of a PWM that stayed small: whole numbers of no stated unit.
pub(super) fn may_be_counted(raw: &Raw, column: usize) -> bool {
    let mut values = raw.columns[column].values.iter();
    let is_whole = |value: &f64| value.is_nan() || value.fract() == 0.0;
    is_share(&raw.name(column)) && raw.units[column].is_none() && values.all(is_whole)
}

/// How a column that names no unit is written with one of a size that the file does not say, if its values and its name
/// look like that: a counter's numbers, or a share of the supply.
pub(super) fn looks_unsized(index: usize, name: &str, values: &[f64]) -> Option<String> {
    match index {
        INPUT if is_share(name) => {
            if let Some(scale) = counter_of_duty(name, values) {
                return Some(format!("{name}/{scale}:duty"));
            }
            let (_, unit) = looks(index, name, values, &Columns::default(), None)?;
            ["%", "duty"]
                .contains(&unit)
                .then(|| format!("{name}:{unit}"))
        }
        POSITION => {
            let (_, unit) = looks(index, name, values, &Columns::default(), None)?;
            unit.starts_with("counts").then(|| format!("{name}:counts"))
        }
        _ => None,
    }
}

/// Whether the name is that of a part of the supply.
fn is_share(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    ["duty", "pwm", "percent"]
        .iter()
        .any(|word| name.contains(word))
}

/// How many times the slope of the position the velocity is, by least squares.
fn slope_of(velocity: &[f64], time: &[f64], position: &[f64]) -> Option<f64> {
    let (mut product, mut square) = (0.0, 0.0);
    for row in 1..time.len() - 1 {
        let step = time[row + 1] - time[row - 1];
        if step > 0.0 {
            let slope = (position[row + 1] - position[row - 1]) / step;
            product += slope * velocity[row];
            square += slope * slope;
        }
    }
    (square > 0.0).then_some(product / square)
}
