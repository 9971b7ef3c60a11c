//! Units that a column looks like, where none was given for it; and units and names that contradict what it is
//! taken for.

use super::convert::Converted;
use super::guess::is_command;
use super::raw::Raw;
use super::recipe::FLAGS;
use super::share;
use super::source::Source;
use super::summary::is_linear;
use super::text::suffixed;
use super::unit::{Kind, Unit, kinds, unit_of_time};
use crate::gap::disagreement::channels::wrap_of;
use crate::log::{COLUMNS, COMMAND, CURRENT, Columns, INPUT, POSITION, TIME, VELOCITY, counted};
use crate::machine::{Coordinate, Machine};
use crate::page::series::extent;
use crate::quantity::significant;

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

/// What to look at again.
#[derive(Debug, PartialEq)]
pub(super) struct Suspicion {
    /// What is wrong and what would mend it, without a full stop.
    pub sentence: String,
    /// What would mend it, where that is known.
    pub remedy: Option<Remedy>,
}

/// What would mend a suspicion.
#[derive(Debug, PartialEq)]
pub(super) enum Remedy {
    /// To write the source of a column of the log, by its place among them, like this.
    Source(usize, String),
    /// To take out the jumps of a turn.
    Unwrap,
}

impl Suspicion {
    /// That a column of the log is to be read like this. `hint`: what to put in place of an example, or nothing.
    fn reading(why: &str, index: usize, text: String, hint: &str) -> Self {
        let hint = if hint.is_empty() {
            String::new()
        } else {
            format!(" ({hint})")
        };
        Self {
            sentence: format!("{why}: then {} \"{text}\"{hint}", FLAGS[index]),
            remedy: Some(Remedy::Source(index, text)),
        }
    }

    /// Something that only the user can mend.
    fn told(sentence: String) -> Self {
        Self {
            sentence,
            remedy: None,
        }
    }
}

/// What to look at again: the column and the option that would read it otherwise.
pub(super) fn suspicions(
    raw: &Raw,
    sources: &[(usize, Source)],
    columns: &Columns,
    machine: Option<&Machine>,
) -> Vec<Suspicion> {
    let mut said = Vec::new();
    let is_linear = is_linear(sources, machine);
    said.extend(other_velocity(sources, columns, raw));
    for (index, source) in sources {
        let Some(values) = &columns[*index] else {
            continue;
        };
        if *index == POSITION && wrap_of(&[values]).is_some() {
            said.push(Suspicion {
                sentence:
                    "`position` jumps by its whole range: if it starts again there, add --unwrap"
                        .into(),
                remedy: Some(Remedy::Unwrap),
            });
        }
        let of_machine = || other_motion(raw, *index, source, machine?);
        let of_share = || share_in_doubt(raw, *index, source, values, machine);
        let doubt = contradiction(raw, *index, source).or_else(of_machine);
        if let Some(doubt) = doubt.or_else(of_share) {
            said.push(doubt);
            continue;
        }
        let is_stamp = raw.columns[source.column].first_stamp.is_some();
        if source.unit.is_some() || !source.is_plain() || is_stamp || *index == INPUT {
            continue;
        }
        let name = raw.name(source.column);
        let own = raw.own_unit(source.column, COLUMNS[*index].0);
        let (why, unit) = match (
            own,
            looks(*index, values, columns, (is_linear, machine.is_some())),
        ) {
            (Some(unit), _) => ("the file says so".to_owned(), unit),
            (None, Some(found)) => found,
            (None, None) => continue,
        };
        let (size, hint) = size(unit);
        let why = format!("`{}` may be in {unit}, for {why}", COLUMNS[*index].0);
        let mut doubt = Suspicion::reading(&why, *index, format!("{name}:{unit}{size}"), hint);
        if (own, is_linear, *index) == (None, None, POSITION) {
            let unit = if unit == "deg" { "mm" } else { COUNTS_ALONG };
            let stroke = Suspicion::reading(
                "; of a stroke",
                *index,
                format!("{name}:{unit}"),
                self::size(unit).1,
            );
            doubt.sentence += &stroke.sentence.replacen(": then", "", 1);
        }
        said.push(doubt);
    }
    said
}

/// What is to be said before a comparison with a machine file names a unit of the position: one whose column is a counter's, and
/// that was multiplied without a unit, may have any size of a count, which by chance is near to some unit.
pub(super) fn counted_position(
    raw: &Raw,
    sources: &[(usize, Source)],
    machine: &Machine,
) -> Option<String> {
    let (_, source) = sources.iter().find(|(index, _)| *index == POSITION)?;
    let is_length = |unit: &Unit| unit.kind.is_linear().is_some();
    let has_unit = source
        .unit
        .as_ref()
        .is_some_and(|(_, unit)| is_length(unit));
    let values = raw.columns[source.column].values.iter();
    let is_whole = |value: &f64| value.is_nan() || value.fract() == 0.0;
    if has_unit || !source.is_scaled() || !values.clone().all(is_whole) {
        return None;
    }
    let counts = match machine.coordinate {
        Coordinate::Metre => COUNTS_ALONG,
        Coordinate::Radian => COUNTS_A_TURN,
    };
    let name = raw.name(source.column);
    let text = format!("{name}:{counts}");
    let why = format!(
        "{name} is whole, as the numbers of a counter are, and was multiplied without a unit. Where a unit is named below, the \
         size of a count may be wrong instead"
    );
    let doubt = Suspicion::reading(&why, POSITION, text, size(counts).1);
    Some(format!("{}.", doubt.sentence))
}

/// An input that looks like a share of the supply, or goes beyond the share that it was given as.
fn share_in_doubt(
    raw: &Raw,
    index: usize,
    source: &Source,
    values: &[f64],
    machine: Option<&Machine>,
) -> Option<Suspicion> {
    if index != INPUT {
        return None;
    }
    let name = raw.name(source.column);
    let reading = |found: share::Reading| {
        let text = source.written_with(raw, &found.spec);
        Suspicion::reading(&format!("`input` {}", found.why), index, text, &found.hint)
    };
    if let Some(found) = share::beyond_whole(source, raw) {
        return Some(reading(found));
    }
    // A machine file with a gain takes the input in its own unit: the comparison with it says whether that is it.
    if source.is_scaled() || machine.is_some_and(|machine| machine.gain != 1.0) {
        return None;
    }
    let is_given = match &source.unit {
        None => false,
        Some((_, unit)) if unit.kind == Kind::Voltage && unit.factor == 1.0 => true,
        Some(_) => return None,
    };
    match raw.own_unit(source.column, COLUMNS[INPUT].0) {
        Some(own) if !is_given => {
            let (size, hint) = size(own);
            let why = format!("`input` may be in {own}, for the file says so");
            Some(Suspicion::reading(
                &why,
                index,
                source.written_with(raw, &format!(":{own}{size}")),
                hint,
            ))
        }
        _ => share::of_volts(&name, values, is_given).map(reading),
    }
}

/// A unit of another motion than the machine's: an angle's where the machine file has a stroke, or the other way round.
fn other_motion(raw: &Raw, index: usize, source: &Source, machine: &Machine) -> Option<Suspicion> {
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
    let why = format!(
        "`{column}` was given in {given}, which is {is} unit, and the coordinate of the machine file is {machine}"
    );
    if is_stroke && given.starts_with("counts/") && index != VELOCITY {
        let text = format!("{name}:{COUNTS_ALONG}");
        return Some(Suspicion::reading(&why, index, text, size(COUNTS_ALONG).1));
    }
    Some(Suspicion::told(format!(
        "{why}: check the unit, or `coordinate` in the machine file"
    )))
}

/// Jumps in so many rows that no motion between them would be left, if each were a turn.
pub(super) fn many_turns(sources: &[(usize, Source)], converted: &Converted) -> Option<Suspicion> {
    let angles = sources
        .iter()
        .filter(|(index, _)| [POSITION, COMMAND].contains(index));
    let values = converted.rows * angles.count();
    (converted.turns as f64 > MOST_TURNS * values as f64).then(|| {
        Suspicion::told(format!(
            "--unwrap took {} jumps out of {}: no angle starts again so often, so the turn is another one: say at how many \
             of the file's numbers it starts again, as in --unwrap 65536, or give the position's unit",
            converted.turns,
            counted(values, "value")
        ))
    })
}

/// What the file says of a column that is not what it is taken for: another unit, or another name.
fn contradiction(raw: &Raw, index: usize, source: &Source) -> Option<Suspicion> {
    let column = COLUMNS[index].0;
    let name = raw.name(source.column);
    if index == POSITION && is_command(&name) {
        return Some(Suspicion::told(format!(
            "`position` is read from {name}, which by its name is the position asked for: check that it is the \
             column of the measured one"
        )));
    }
    let own = raw.units[source.column].as_deref()?;
    let stated = Unit::find(own)?;
    let allowed = kinds(column);
    // What stands behind a name may be a part of it, as in theta_m and u_in.
    let is_suffix = suffixed(&name).is_some_and(|(_, unit)| unit == own);
    let is_other = match &source.unit {
        Some((given, unit)) if unit.kind == stated.kind => {
            let why = format!(
                "`{column}` was given in {given}, and the file says that {name} is in {own}"
            );
            let (size, hint) = size(own);
            return (unit.factor != stated.factor)
                .then(|| Suspicion::reading(&why, index, format!("{name}:{own}{size}"), hint));
        }
        // Who multiplies has a unit of their own, and counts are of any size.
        _ if is_suffix || source.is_scaled() || stated.kind == Kind::Counts => return None,
        Some((given, _)) => {
            format!("`{column}` was given in {given}, and the file says that {name} is in {own}")
        }
        None if allowed.is_empty() || allowed.contains(&stated.kind) => return None,
        None => format!("`{column}` is read from {name}, which the file says is in {own}"),
    };
    Some(Suspicion::told(format!(
        "{is_other}: check that it is the right column"
    )))
}

/// Counts along a stroke, by example.
const COUNTS_ALONG: &str = "counts*0.005:mm";

/// Counts a turn, by example.
const COUNTS_A_TURN: &str = "counts/4096";

/// What a unit needs behind its name, by example, and what of the example to replace.
fn size(unit: &str) -> (&'static str, &'static str) {
    match Unit::find(unit).map(|unit| unit.kind) {
        Some(Kind::Share) => share::SUPPLY,
        Some(Kind::Counts) => ("*0.001", "put the size of a count in place of 0.001"),
        _ if unit == COUNTS_ALONG => ("", "put the way of a count in place of 0.005"),
        _ if unit.starts_with("counts/") => (
            "",
            "4096 being the counts of a turn; in front of a gear of 75, /75 behind it",
        ),
        _ => ("", ""),
    }
}

/// The unit that the values look like, and why. Of a position's unit its range alone says little: where there is a machine file,
/// the comparison with that tells it by how the motor moves.
fn looks(
    index: usize,
    values: &[f64],
    columns: &Columns,
    (is_linear, has_machine): (Option<bool>, bool),
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
        POSITION if whole && largest > FAR => {
            let counts = if is_linear == Some(true) {
                COUNTS_ALONG
            } else {
                COUNTS_A_TURN
            };
            Some(("its values are whole".into(), counts))
        }
        POSITION if has_machine => None,
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
fn other_velocity(sources: &[(usize, Source)], columns: &Columns, raw: &Raw) -> Option<Suspicion> {
    let of = |wanted: usize| sources.iter().find(|(index, _)| *index == wanted);
    let (_, position) = of(POSITION)?;
    let (_, velocity) = of(VELOCITY)?;
    position.unit.as_ref()?;
    let (given, unit) = velocity.unit.as_ref().filter(|_| !velocity.is_scaled())?;
    let values = columns[VELOCITY].as_deref()?;
    let is_linear = unit.kind.is_linear();
    let (why, found) = unit_of_velocity(values, columns, unit.factor, is_linear)?;
    let text = format!("{}:{found}", raw.name(velocity.column));
    let why = format!("`velocity` was given in {given}, and may be in {found}, for {why}");
    Some(Suspicion::reading(&why, VELOCITY, text, ""))
}

/// How a column that names no unit is written with one of a size that the file does not say, if its values and its name
/// look like that: a counter's numbers, or a share of the supply.
pub(super) fn looks_unsized(index: usize, name: &str, values: &[f64]) -> Option<String> {
    match index {
        INPUT => share::unsized_share(name, values),
        POSITION => {
            let (_, unit) = looks(index, values, &Columns::default(), (None, false))?;
            unit.starts_with("counts").then(|| format!("{name}:counts"))
        }
        _ => None,
    }
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
