//! What an import has found and done, for the terminal.

use std::path::Path;
use std::slice;

use super::call::Calls;
use super::convert::Converted;
use super::raw::Raw;
use super::source::Source;
use super::suspect::Suspicion;
use super::unit::Kind;
use crate::cells::{self, Cells, row};
use crate::gap::disagreement::{self, Disagreement};
use crate::gap::outcome::Resampled;
use crate::gap::table::resampled_line;
use crate::log::{COLUMNS, COMMAND, FILLED, Log, POSITION, TIME, VELOCITY, counted};
use crate::machine::{Coordinate, MOTOR, Machine};
use crate::page::series::extent;
use crate::quantity::{Scale, given, significant};

/// Whether the log is one of a motion along a stroke, or else of one about an axis, by the units that were given or else by the
/// machine file; `None` where neither says.
pub(super) fn is_linear(sources: &[(usize, Source)], machine: Option<&Machine>) -> Option<bool> {
    let of_column = |index: usize| {
        let (_, source) = sources.iter().find(|(known, _)| *known == index)?;
        source.unit.as_ref()?.1.kind.is_linear()
    };
    let given = [POSITION, COMMAND, VELOCITY]
        .into_iter()
        .find_map(of_column);
    given.or_else(|| machine.map(|machine| machine.coordinate == Coordinate::Metre))
}

/// The unit of a column of the log, as far as it is known.
pub(super) fn unit_of(
    index: usize,
    sources: &[(usize, Source)],
    is_linear: Option<bool>,
) -> &'static str {
    let of_motion = |[angle, stroke, either]: [&'static str; 3]| match is_linear {
        Some(true) => stroke,
        Some(false) => angle,
        None => either,
    };
    match COLUMNS[index].0 {
        "time_s" => "s",
        "current_a" => "A",
        "position" | "command" => of_motion(["rad", "m", "rad or m"]),
        "velocity" => of_motion(["rad/s", "m/s", "rad/s or m/s"]),
        "brake" | "load_torque" => of_motion(["N·m", "N", "N·m or N"]),
        "input" => {
            let source = sources.iter().find(|(known, _)| *known == index);
            let unit = source.and_then(|(_, source)| source.unit.as_ref());
            match unit.map(|(_, unit)| unit.kind) {
                Some(Kind::Voltage) => "V",
                Some(Kind::Current) => "A",
                Some(Kind::Torque) => "N·m",
                Some(Kind::Force) => "N",
                _ => "",
            }
        }
        _ => "",
    }
}

/// The table and what follows it.
pub(super) fn render(
    name: &str,
    raw: &Raw,
    sources: &[(usize, Source)],
    converted: &Converted,
    is_linear: Option<bool>,
    out: &Path,
) -> String {
    let log = &converted.log;
    let mut text = format!(
        "{name}: {}, {}\n",
        raw.layout,
        counted(converted.rows, "row")
    );
    let seconds = (log.samples() - 1) as f64 * log.period_s;
    text += &format!(
        "{}: {} at {} Hz, {} s\n\n",
        out.display(),
        counted(log.samples(), "sample"),
        given(1.0 / log.period_s),
        significant(seconds, 4)
    );
    text += &cells::render(&table(raw, sources, converted, is_linear));
    text.push('\n');
    let first_stamp = sources.iter().find_map(|(_, source)| {
        let stamp = raw.columns[source.column].first_stamp.as_deref();
        Some(format!(
            "The time is counted from the file's first row, {}.",
            stamp?
        ))
    });
    let slow = converted.slow.iter().map(|column| {
        let (slow, log_column) = (&column.slow, COLUMNS[column.index].0);
        let unit = unit_of(column.index, sources, is_linear);
        let error = Scale::of(unit, [column.error]).quantity(column.error);
        format!(
            "{} has a number in every {} row or so, {} of {}: it was interpolated in the rows between, which puts an \
             error of some {error} rms into `{log_column}`.",
            raw.name(slow.column),
            ordinal(slow.every),
            slow.rows,
            converted.rows
        )
    });
    let lines = first_stamp.into_iter().chain(slow);
    for line in lines.chain(done(converted, is_linear)) {
        text += &line;
        text.push('\n');
    }
    let taken = |column: &usize| {
        let mut columns = sources.iter().flat_map(|(_, source)| source.columns());
        columns.any(|taken| taken == *column)
    };
    let others: Vec<String> = (0..raw.names.len())
        .filter(|column| !taken(column) && raw.names[*column] != FILLED)
        .map(|column| raw.name(column))
        .collect();
    if !others.is_empty() {
        text += &format!("Columns that were not asked for: {}.\n", others.join(", "));
    }
    text
}

/// What to look at again, and the call that would mend all of it.
pub(super) fn doubts(suspicions: &[Suspicion], again: Option<&Calls>, out: &Path) -> String {
    if suspicions.is_empty() {
        return String::new();
    }
    let lines = suspicions
        .iter()
        .map(|suspicion| format!("Look again: {}.\n", suspicion.sentence));
    let lines: String = lines.collect();
    let out = out.display();
    let written = format!("{lines}{out} was written with the columns as they were given.");
    match again {
        // No import replaces a file.
        Some(calls) => format!("{written} With all of that changed it is:\n  {calls}\n"),
        None => format!(
            "{written} No import replaces a file: name another --out than {out} for the next one.\n"
        ),
    }
}

/// How many times its motor's speed without a load a machine may move at: a load that falls drives it faster, and the
/// torque constant is known to some tenths.
const FASTER: f64 = 5.0;

/// Share of the stroke from which on a step of one sample is none of the sensor's noise.
const STEP: f64 = 0.02;

/// So many such steps may be damaged samples.
const MOST_DAMAGED: usize = 10;

/// A position that moves faster than the motor can turn it, if it does.
fn too_fast(machine: &Machine, log: &Log) -> Option<String> {
    let constant = machine.motor.as_ref()?.torque_constant;
    let volts = |input: &f64| (input * machine.gain).abs();
    let most_volts = log.input.iter().map(volts).fold(0.0, f64::max);
    let motor = most_volts / constant;
    let (low, high) = extent(log.position.iter().copied())?;
    let least = (FASTER * motor * log.period_s).max(STEP * (high - low));
    let steps = log.position.windows(2);
    let jumps = steps.map(|pair| (pair[1] - pair[0]).abs());
    let jumps: Vec<f64> = jumps.filter(|step| *step > least).collect();
    if motor <= 0.0 || jumps.len() <= MOST_DAMAGED {
        return None;
    }
    let fastest = jumps.iter().copied().fold(0.0, f64::max) / log.period_s;
    let unit = machine.coordinate.unit();
    Some(format!(
        "`position` moves at up to {} {unit}/s, and with the {} V that the log has at most the motor of {} does {} \
         {unit}/s: check that it is the right column, in the right unit, and that `input` is what drives the motor. {} \
         was written as it is; remove it before you import again.",
        significant(fastest, 2),
        significant(most_volts, 3),
        machine.path.display(),
        significant(motor, 2),
        log.path.display()
    ))
}

/// A motor whose numbers are all to be fitted, to a log without the current that alone tells them from the mechanics'.
fn lacks_current(machine: &Machine, log: &Log) -> Option<String> {
    let is_fitted = MOTOR.iter().all(|name| machine.fits(name));
    (is_fitted && log.current.is_none()).then(|| {
        format!(
            "{} has {} fitted, and the log has no current that would tell these from inertia and friction: add --current, \
             or take them out of `parameters` in [fit].",
            machine.path.display(),
            MOTOR.join(" and ")
        )
    })
}

/// What the log says of a machine file. `counted`: what is to be said before a unit is named.
pub(super) fn compared(machine: &Machine, log: &Log, counted: Option<String>) -> String {
    let (file, path) = (machine.path.display(), log.path.display());
    let found = disagreement::look(machine, slice::from_ref(log));
    if found.is_empty() {
        return match too_fast(machine, log).or_else(|| lacks_current(machine, log)) {
            Some(sentence) => format!("Look again: {sentence}\n"),
            None => format!("Nothing in the log contradicts {file}.\n"),
        };
    }
    let lines = found.iter().flat_map(Disagreement::lines);
    let lines: Vec<String> = counted.into_iter().chain(lines).collect();
    format!(
        "\n{path} and {file} do not belong together:\n{}\n",
        lines.join("\n")
    )
}

fn table(
    raw: &Raw,
    sources: &[(usize, Source)],
    converted: &Converted,
    is_linear: Option<bool>,
) -> Cells {
    let mut cells = vec![row([
        "column",
        "from",
        "unit given",
        "smallest",
        "largest",
        "in",
    ])];
    let timed = sources.iter().any(|(index, _)| *index == TIME);
    if !timed {
        cells.push(row(["time_s", "the rate", "", "", "", "s"]));
    }
    for (index, source) in sources {
        let values = converted.columns[*index].as_deref().unwrap_or_default();
        let (low, high) = extent(values.iter().copied()).unwrap_or((0.0, 0.0));
        let unit = source
            .unit
            .as_ref()
            .map_or("none", |(name, _)| name.as_str());
        let from: Vec<String> = source.columns().map(|column| raw.name(column)).collect();
        cells.push(vec![
            COLUMNS[*index].0.to_owned(),
            from.join(", its sign from "),
            unit.to_owned(),
            significant(low, 4),
            significant(high, 4),
            unit_of(*index, sources, is_linear).to_owned(),
        ]);
    }
    cells
}

/// `2nd`, `5th`, `21st`.
fn ordinal(number: usize) -> String {
    let ending = match (number % 10, number % 100) {
        (_, 11..=13) => "th",
        (1, _) => "st",
        (2, _) => "nd",
        (3, _) => "rd",
        _ => "th",
    };
    format!("{number}{ending}")
}

/// What was done to the rows, one sentence each.
fn done(converted: &Converted, is_linear: Option<bool>) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(zero) = converted.zero {
        lines.push(format!(
            "The time starts at zero: the first stamp was {zero:?} s."
        ));
    }
    if converted.left_out > 0 {
        let rows = counted(converted.left_out, "row");
        lines.push(format!("{rows} without a usable number left out."));
    }
    if converted.sorted > 0 {
        let rows = counted(converted.sorted, "row");
        lines.push(format!(
            "{rows} earlier than one before moved to their time."
        ));
    }
    if converted.turns > 0 {
        lines.push(format!(
            "{} taken out (--unwrap).",
            counted(converted.turns, "jump")
        ));
    }
    match converted.log.resampling {
        Some(change) => {
            let resampled = Resampled {
                log: "The log".into(),
                period_s: converted.log.period_s,
                change,
            };
            lines.push(resampled_line(
                &resampled,
                unit_of(POSITION, &[], is_linear),
            ));
            lines.push(
                "The input is held from row to row and averaged over each sample, position and velocity \
                 are interpolated, a current is averaged where the rate falls."
                    .into(),
            );
        }
        None => {
            let period = Scale::of("s", [converted.log.period_s]).quantity(converted.log.period_s);
            lines.push(format!(
                "The rows are even, a sample every {period}: none was resampled."
            ));
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(position: impl Fn(f64) -> f64) -> Log {
        let rows = (0..2_000).map(|row| {
            let time = f64::from(row) * 1e-3;
            format!("{time:.3},{},{}\n", time.sin(), position(time))
        });
        let text = format!("time_s,input,position\n{}", rows.collect::<String>());
        Log::of_bytes(Path::new("a.csv"), text.into_bytes()).unwrap()
    }

    #[test]
    fn a_motor_to_be_fitted_without_a_current_is_pointed_out() {
        let machines = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines");
        let mut machine = Machine::read(&machines.join("ema-24v.toml")).unwrap();
        let mut log = log(f64::sin);
        assert_eq!(lacks_current(&machine, &log), None);
        machine.fit.extend(MOTOR.map(str::to_owned));
        let said = lacks_current(&machine, &log).unwrap();
        assert!(said.contains("the log has no current"), "{said}");
        log.current = Some(log.input.clone());
        assert_eq!(lacks_current(&machine, &log), None);
    }

    /// A motor of 0.06 V·s/rad turns at 17 rad/s on 1 V.
    #[test]
    fn a_position_that_its_motor_cannot_follow_is_pointed_out() {
        let machines = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines");
        let machine = Machine::read(&machines.join("ema-24v.toml")).unwrap();
        assert_eq!(
            too_fast(&machine, &log(|time| 4.0 * (4.0 * time).sin())),
            None
        );
        // A voltage that is switched every 50 ms: 20 in a millisecond.
        let switched = |time: f64| 10.0 * (1.0 - 2.0 * ((20.0 * time + 1e-6).floor() % 2.0));
        let said = too_fast(&machine, &log(switched)).unwrap();
        let hint = "`position` moves at up to 20000 rad/s";
        assert!(said.contains(hint), "{said}");
    }
}
