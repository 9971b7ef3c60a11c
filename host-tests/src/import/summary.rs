//! What an import has found and done, for the terminal.

use std::path::Path;
use std::slice;

use super::convert::Converted;
use super::raw::Raw;
use super::source::Source;
use super::unit::Kind;
use crate::cells::{self, Cells, row};
use crate::gap::disagreement::{self, Disagreement};
use crate::gap::outcome::Resampled;
use crate::gap::table::resampled_line;
use crate::log::{COLUMNS, Log, POSITION, TIME, counted};
use crate::machine::Machine;
use crate::page::series::extent;
use crate::quantity::{Scale, given, significant};

/// The unit of a column of the log, as far as it is known.
pub(super) fn unit_of(index: usize, sources: &[(usize, Source)]) -> &'static str {
    let kind = |index: usize| {
        let source = sources.iter().find(|(known, _)| *known == index);
        source
            .and_then(|(_, source)| source.unit.as_ref())
            .map(|(_, unit)| unit.kind)
    };
    let linear = kind(POSITION) == Some(Kind::Length);
    match COLUMNS[index].0 {
        "time_s" => "s",
        "current_a" => "A",
        "position" | "command" if linear => "m",
        "velocity" if linear => "m/s",
        "brake" | "load_torque" if linear => "N",
        "position" | "command" => "rad",
        "velocity" => "rad/s",
        "brake" | "load_torque" => "N·m",
        "input" => match kind(index) {
            Some(Kind::Voltage) => "V",
            Some(Kind::Current) => "A",
            Some(Kind::Torque) => "N·m",
            Some(Kind::Force) => "N",
            _ => "",
        },
        _ => "",
    }
}

/// The table and what follows it.
pub(super) fn render(
    name: &str,
    raw: &Raw,
    sources: &[(usize, Source)],
    converted: &Converted,
    suspicions: &[String],
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
    text += &cells::render(&table(raw, sources, converted));
    text.push('\n');
    let first_stamp = sources.iter().find_map(|(_, source)| {
        let stamp = raw.columns[source.column].first_stamp.as_deref();
        Some(format!(
            "The time is counted from the file's first row, {}.",
            stamp?
        ))
    });
    for line in first_stamp.into_iter().chain(done(sources, converted)) {
        text += &line;
        text.push('\n');
    }
    let taken = |column: &usize| {
        let mut columns = sources.iter().flat_map(|(_, source)| source.columns());
        columns.any(|taken| taken == *column)
    };
    let others: Vec<String> = (0..raw.names.len())
        .filter(|column| !taken(column))
        .map(|column| raw.name(column))
        .collect();
    if !others.is_empty() {
        text += &format!("Columns that were not asked for: {}.\n", others.join(", "));
    }
    for suspicion in suspicions {
        text += &format!("Look again: {suspicion}.\n");
    }
    if !suspicions.is_empty() {
        // No import replaces a file.
        text += &format!(
            "{} was written with the columns as they were given. Remove it, or give another --out, before you import \
             again.\n",
            out.display()
        );
    }
    text
}

/// How many times its motor's speed without a load a machine may move at: a load that falls drives it faster, and the
/// torque constant is known to some tenths.
const FASTER: f64 = 5.0;

/// Share of a log's speeds that may be beyond that: a sample that jumps is no speed.
const JUMPS: f64 = 0.01;

/// Time over which a speed is taken, s: over a shorter one noise of the sensor moves.
const OVER_S: f64 = 0.01;

/// A position that moves faster than the motor can turn it, if it does.
fn too_fast(machine: &Machine, log: &Log) -> Option<String> {
    let constant = machine.motor.as_ref()?.torque_constant;
    let volts = |input: &f64| (input * machine.gain).abs();
    let most_volts = log.input.iter().map(volts).fold(0.0, f64::max);
    let motor = most_volts / constant;
    let rows = (OVER_S / log.period_s).ceil().max(1.0);
    let ahead = log.position.iter().skip(rows as usize);
    let elapsed = rows * log.period_s;
    let speeds = log.position.iter().zip(ahead);
    let mut speeds: Vec<f64> = speeds.map(|(a, b)| (b - a).abs() / elapsed).collect();
    speeds.sort_by(f64::total_cmp);
    let fastest = *speeds.get((speeds.len() as f64 * (1.0 - JUMPS)) as usize)?;
    let unit = machine.coordinate.unit();
    (motor > 0.0 && fastest > FASTER * motor).then(|| {
        format!(
            "`position` moves at {} {unit}/s, and with the {} V that the log has at most the motor of {} does {} \
             {unit}/s: is it the right column, in the right unit, and is `input` what drives the motor? {} was written \
             as it is; remove it before you import again.",
            significant(fastest, 2),
            significant(most_volts, 3),
            machine.path.display(),
            significant(motor, 2),
            log.path.display()
        )
    })
}

/// What the log says of a machine file.
pub(super) fn compared(machine: &Machine, log: &Log) -> String {
    let (file, path) = (machine.path.display(), log.path.display());
    let found = disagreement::look(machine, slice::from_ref(log));
    if found.is_empty() {
        return match too_fast(machine, log) {
            Some(sentence) => format!("Look again: {sentence}\n"),
            None => format!("Nothing in the log contradicts {file}.\n"),
        };
    }
    let lines: Vec<String> = found.iter().flat_map(Disagreement::lines).collect();
    format!(
        "\n{path} and {file} do not belong together:\n{}\n",
        lines.join("\n")
    )
}

fn table(raw: &Raw, sources: &[(usize, Source)], converted: &Converted) -> Cells {
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
            unit_of(*index, sources).to_owned(),
        ]);
    }
    cells
}

/// What was done to the rows, one sentence each.
fn done(sources: &[(usize, Source)], converted: &Converted) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(zero) = converted.zero {
        lines.push(format!(
            "The time starts at zero: the first stamp was {zero:?} s."
        ));
    }
    if converted.left_out > 0 {
        let rows = counted(converted.left_out, "row");
        lines.push(format!("{rows} without a number left out."));
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
            lines.push(resampled_line(&resampled, unit_of(POSITION, sources)));
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
