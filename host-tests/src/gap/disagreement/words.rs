//! A disagreement in words: what, the evidence, and a remedy to copy.

use std::f64::consts::TAU;

use super::Disagreement;
use super::channels::Column;
use super::factor;
use super::limits::LONGEST_PERIOD;
use super::measure::{Clue, Subject};
use super::reading::{Correction, Reading};
use super::units::LARGEST_SUPPLY;
use crate::gap::experiment::any_of;
use crate::import::call::{Call, out_beside};
use crate::log::{BRAKE, COLUMNS, ENABLED, LOAD_TORQUE, Log, rounded};
use crate::machine::{Coordinate, Machine, PARAMETERS};
use crate::quantity::{given, significant};

/// What the corrections say, one entry each and for each log. The remedy of a log is one command for all of them, that of
/// the machine file a line.
pub(super) fn corrections(
    logs: &[Log],
    declared: &Reading,
    steps: &[Vec<Correction>],
    best: &Reading,
) -> Vec<Disagreement> {
    // From the declared reading to the best one, correction by correction.
    let mut readings = vec![declared.clone()];
    for correction in &best.corrections {
        readings.extend(readings.last().map(|before| before.with(*correction, 0.0)));
    }
    let mut all: Vec<Disagreement> = Vec::new();
    for log in logs {
        for found in corrections_of(log, &readings, steps, best) {
            if !all.contains(&found) {
                all.push(found);
            }
        }
    }
    all
}

fn corrections_of(
    log: &Log,
    readings: &[Reading],
    steps: &[Vec<Correction>],
    best: &Reading,
) -> Vec<Disagreement> {
    let declared = &readings[0];
    // What volts a unit of the input is says the machine file.
    let is_of_gain = |correction: &Correction| {
        matches!(correction, Correction::Factor(Column::Input, _)) && declared.machine.gain != 1.0
    };
    let mut all = Vec::new();
    for (step, alike) in steps.iter().enumerate() {
        let mut known: Vec<String> = Vec::new();
        let mut remedies: Vec<String> = Vec::new();
        for &correction in alike {
            let said = what(declared, correction);
            if known.contains(&said) {
                continue;
            }
            // What is done about the others stays as it is in the best reading.
            let mut chosen = best.corrections.clone();
            chosen[step] = correction;
            remedies.push(match correction {
                Correction::Number(name, _, value) => line(&declared.machine, name, value),
                Correction::Factor(Column::Input, factor) if is_of_gain(&correction) => {
                    let gain = rounded(declared.machine.gain * factor, 6);
                    entry(&declared.machine, "input", "gain", gain)
                }
                Correction::Unsigned(Column::Input) => format!(
                    "record the direction of the drive, the bridge's direction pin, with {}, and import it as --input \
                     input@DIRECTION",
                    log.path.display()
                ),
                _ => {
                    chosen.retain(|correction| !is_of_gain(correction));
                    command(log, declared, &chosen)
                }
            });
            known.push(said);
        }
        remedies.dedup();
        all.push(Disagreement {
            what: whats(declared, alike),
            evidence: evidence(&readings[step], &readings[step + 1]),
            remedy: remedies.join("\n"),
        });
    }
    all
}

/// What each of several corrections says, once; of supplies all their voltages together.
fn whats(declared: &Reading, alike: &[Correction]) -> String {
    let mut all: Vec<String> = Vec::new();
    for correction in alike {
        let said = match correction {
            Correction::Duty(whole, _) => {
                let supplies = alike.iter().filter_map(|other| match other {
                    Correction::Duty(same, volts) if same == whole => Some(volts.to_string()),
                    _ => None,
                });
                duty(*whole, &any_of(&supplies.collect::<Vec<_>>()))
            }
            _ => what(declared, *correction),
        };
        if !all.contains(&said) {
            all.push(said);
        }
    }
    all.join(", or ")
}

/// An input that is a share of a supply's voltage.
fn duty(whole: f64, volts: &str) -> String {
    match whole {
        1.0 => format!("input is the duty, a share of a supply of about {volts} V, not in volts"),
        100.0 => format!("input is in per cent of a supply of about {volts} V, not in volts"),
        _ => format!(
            "input is in counts of a PWM, of which {whole} are a supply of about {volts} V, not in volts"
        ),
    }
}

/// What is off though no unit explains it.
pub(super) fn unexplained(machine: &Machine, log: &Log, clue: &Clue) -> Disagreement {
    let what = match clue.subject {
        Subject::Number(name) => {
            format!(
                "the {} that the log asks for is {} the declared one",
                spoken(name),
                times(clue.ratio)
            )
        }
        Subject::Period(_) => "the sampling is too slow".to_owned(),
        Subject::Winding(_) => "inductance or resistance is not that of a motor".to_owned(),
        Subject::Supply(_) => {
            "input is not in the unit that the machine file takes it for".to_owned()
        }
        _ => "position is far beyond the declared stops".to_owned(),
    };
    let remedy = match clue.subject {
        Subject::Number(name) => {
            let value = machine.parameter(name).unwrap_or(0.0) * clue.ratio;
            format!(
                "{}, if that is what it is, or check the columns of {}",
                line(machine, name, value),
                log.path.display()
            )
        }
        Subject::Period(_) => slower(log),
        Subject::Winding(_) => line(
            machine,
            "inductance",
            1e-3 * machine.parameter("inductance").unwrap_or(0.0),
        ),
        Subject::Supply(_) => format!(
            "import {} again with the unit of its input, as in --input input:mV or \"input:%*24\", or set `gain` in {}, \
             [input], to the volts for one unit of it",
            log.path.display(),
            machine.path.display()
        ),
        _ => format!(
            "in {}: set `lower_stop` and `upper_stop` to where the stops are, in the coordinate of the log",
            machine.path.display()
        ),
    };
    Disagreement {
        what,
        evidence: sentence(clue),
        remedy,
    }
}

/// A motion that the samples do not show.
pub(super) fn too_slow(log: &Log, samples: f64) -> Disagreement {
    Disagreement {
        what: "the sampling is too slow for the motion".to_owned(),
        evidence: format!(
            "sampled every {} s, the speed has changed from one sample to the next as that of a sine with \
             fewer than {samples} samples a period",
            rounded(log.period_s, 6)
        ),
        remedy: slower(log),
    }
}

fn slower(log: &Log) -> String {
    format!(
        "record {} again at least ten times as fast ({} Hz), or move the machine more slowly",
        log.path.display(),
        significant((10.0 / log.period_s).max(10.0 / LONGEST_PERIOD), 2)
    )
}

fn what(declared: &Reading, correction: Correction) -> String {
    let coordinate = declared.machine.coordinate.unit();
    match correction {
        Correction::Unit(column, unit, ..) => format!("{} is in {unit}", column.name()),
        Correction::Counts(size) => format!(
            "position is in counts of the sensor, of {} {coordinate} each",
            significant(size, 4)
        ),
        Correction::Factor(Column::Input, factor)
            if (factor * declared.machine.gain.abs() - 1.0).abs() < 1e-9 =>
        {
            format!(
                "input is in V, and the machine file takes it for a share of {} V",
                given(declared.machine.gain.abs())
            )
        }
        Correction::Factor(column, factor) => scaled(column, factor),
        Correction::Duty(whole, volts) => duty(whole, &volts.to_string()),
        Correction::Taken(column, own, taken, factor) => format!(
            "{} is {} times too {}: the column is in {}, and was imported as {taken}",
            column.name(),
            rounded(factor.max(1.0 / factor), 4),
            if factor > 1.0 { "small" } else { "large" },
            own.unwrap_or_else(|| expected_unit(&declared.machine, column))
        ),
        Correction::Geared(Column::Position, ratio) => format!("position is {}", geared(ratio)),
        Correction::GearedSensor(ratio) => {
            format!("position and velocity are {}", geared(ratio))
        }
        Correction::Geared(column, ratio) => format!(
            "{} is that of the other side of a gear of about {}",
            column.name(),
            significant(ratio.abs().max(1.0 / ratio.abs()), 3)
        ),
        Correction::Negative(column) => format!("{} has the wrong sign", column.name()),
        Correction::Reversed => {
            "position and velocity have the wrong sign: the encoder counts the other way".to_owned()
        }
        Correction::Swapped(one, other) => {
            format!("{} and {} are swapped", one.name(), other.name())
        }
        Correction::Wrapped(turn) => format!(
            "position is wrapped: it starts again after {}",
            significant(turn, 6)
        ),
        Correction::Unsigned(Column::Input) => {
            "input has no sign: it is the size of a voltage or of a duty, whichever way it drives".to_owned()
        }
        Correction::Unsigned(_) => "current_a has no sign: it is the size of the motor's current, or the supply's current; \
                                 record the motor's own, or leave it out"
            .to_owned(),
        Correction::Number(name, unit, _) => {
            let expected = declared
                .machine
                .coordinate
                .parameter_unit(name)
                .unwrap_or("");
            format!("{name} is declared in {unit}, not in {expected}")
        }
    }
}

/// What a sensor on the other side of the gear reads.
fn geared(ratio: f64) -> String {
    let (off, side) = if ratio > 1.0 {
        (format!("{} times too large", rounded(ratio, 4)), "motor")
    } else {
        (
            format!("{} times too small", rounded(1.0 / ratio, 4)),
            "load",
        )
    };
    format!("{off}, as of an encoder on the {side}'s side of the gear")
}

/// The unit of a column of a log.
fn expected_unit(machine: &Machine, column: Column) -> &'static str {
    match (column, machine.coordinate) {
        (Column::Time, _) => "s",
        (Column::Current, _) => "A",
        (Column::Input, _) if machine.motor.is_some() => "V",
        (Column::Input, coordinate) => coordinate.load_unit(),
        (Column::Velocity, Coordinate::Radian) => "rad/s",
        (Column::Velocity, Coordinate::Metre) => "m/s",
        (Column::Position | Column::Command, coordinate) => coordinate.unit(),
    }
}

/// `half` or `4 times`.
fn share(factor: f64) -> String {
    match factor {
        2.0 => "twice".to_owned(),
        0.5 => "half".to_owned(),
        0.25 => "a quarter of".to_owned(),
        _ => format!("{} times", rounded(factor, 3)),
    }
}

/// A column that is off as a whole, and what it may have been imported with.
fn scaled(column: Column, factor: f64) -> String {
    let off = if factor > 1.0 {
        format!("{} times too small", rounded(factor, 3))
    } else {
        format!("{} times too large", rounded(1.0 / factor, 3))
    };
    match column {
        // More counts a turn make less of each.
        Column::Position => format!(
            "position is {off}: the encoder has {} the counts a turn that it was taken to have (one of 500 lines \
             counts 500, 1000 or 2000)",
            share(1.0 / factor)
        ),
        _ if factor == factor::COUNTS_AS_PER_CENT => format!(
            "{} is {off}: it counts a PWM from 0 to 255, and was taken for per cent",
            column.name()
        ),
        _ => format!(
            "{} is {off}: the supply has {} the voltage that it was taken to have, or the drive's full scale is another",
            column.name(),
            share(factor)
        ),
    }
}

/// What speaks against the reading before, and what the correction leaves of it.
fn evidence(before: &Reading, after: &Reading) -> String {
    if let (Some(Correction::Factor(..)), Some([constant, resistance])) =
        (after.corrections.last(), factor::ratios(before))
    {
        let middle = |(low, high): (f64, f64)| significant(0.5 * (low + high), 2);
        return format!(
            "voltage, current and speed of the log ask for {} times the torque constant and {} times the resistance of \
             the machine file; corrected, for the declared ones",
            middle(constant),
            middle(resistance)
        );
    }
    let is_mended = |clue: &&Clue| {
        let same = |left: &&Clue| {
            std::mem::discriminant(&left.subject) == std::mem::discriminant(&clue.subject)
                && match (left.subject, clue.subject) {
                    (Subject::Number(one), Subject::Number(other)) => one == other,
                    _ => true,
                }
        };
        let left = after.clues.iter().find(same).map_or(0.0, |left| left.cost);
        left < 0.5 * clue.cost
    };
    let mut mended: Vec<&Clue> = before.clues.iter().filter(is_mended).collect();
    // Where one thing hides another, it is seen once both are mended.
    if mended.is_empty() {
        mended.extend(before.clues.first());
    }
    // What the sensor says of itself is the most direct.
    mended.sort_by_key(|clue| !matches!(clue.subject, Subject::Resolution(..)));
    let mut numbers = 0;
    mended.retain(|clue| {
        numbers += usize::from(matches!(clue.subject, Subject::Number(_)));
        numbers <= MOST_NUMBERS || !matches!(clue.subject, Subject::Number(_))
    });
    let mended = mended.into_iter().take(3).map(sentence);
    let mended: Vec<String> = mended.collect();
    format!("{}{}", mended.join("; "), agreement(after))
}

/// How well log and declared numbers agree where all is corrected.
fn agreement(after: &Reading) -> String {
    if after.cost >= super::IMPLAUSIBLE {
        return String::new();
    }
    let motor = after.motor();
    let off = motor.iter().filter(|stated| stated.off() != 1.0);
    let farthest = off.max_by(|a, b| a.off().ln().abs().total_cmp(&b.off().ln().abs()));
    match farthest {
        Some(stated) => format!(
            "; corrected, the log still asks for {} times the declared {}, which may be off by {:.0} %: another factor \
             may be the true one",
            significant(stated.off(), 3),
            spoken(stated.name),
            100.0 * (stated.tolerance - 1.0)
        ),
        None if after.agrees() => "; corrected, the log and the declared numbers agree".to_owned(),
        None => "; corrected, all agrees but the smallest step of `position` with the declared resolution".to_owned(),
    }
}

fn sentence(clue: &Clue) -> String {
    match clue.subject {
        Subject::Number(name) if clue.ratio < 0.0 => {
            format!(
                "taken as it is, the log fits only a {} with a negative {}",
                owner(name),
                spoken(name)
            )
        }
        Subject::Number(name) => {
            format!(
                "taken as it is, the log fits only a {} with {} the {} in the machine file",
                owner(name),
                times(clue.ratio),
                spoken(name)
            )
        }
        Subject::Losses => {
            "as declared, friction would drive the machine instead of braking it".to_owned()
        }
        Subject::Velocity => format!(
            "`velocity` is {} the rate at which `position` changes",
            times(clue.ratio)
        ),
        Subject::Command => format!("`position` follows {} `command`", times(clue.ratio)),
        Subject::Resolution(step, declared) => format!(
            "the smallest step of `position` is {}, the declared resolution {}",
            significant(step, 3),
            significant(declared, 3)
        ),
        Subject::Stops(farthest) => {
            format!(
                "`position` reaches {}, far beyond the declared stops",
                significant(farthest, 4)
            )
        }
        Subject::Wrap(wrap) => format!(
            "`position` jumps by about {} {} from one sample to the next, and else never by more than {}",
            significant(wrap.turn, 4),
            match wrap.jumps {
                1 => "once".to_owned(),
                jumps => format!("{jumps} times"),
            },
            significant(wrap.step, 2)
        ),
        Subject::InputSign([without, with]) => format!(
            "`input` has one sign though the machine moves both ways: with the sign of what drives it, {} % of the drive stays \
             unexplained, without it {} %",
            significant(100.0 * with, 2),
            significant(100.0 * without, 2)
        ),
        Subject::Sign([forward, backward]) => format!(
            "`current_a` is {} A in the mean where `input` and the speed drive the motor forward, and {} A where they drive it \
             backward",
            significant(forward, 2),
            significant(backward, 2)
        ),
        Subject::Winding(constant) => format!(
            "the declared winding takes inductance / resistance = {} s to follow a voltage, where motors take milliseconds",
            significant(constant, 2)
        ),
        Subject::Supply(volts) => format!(
            "`input` would be {} V, and no usual supply has more than {LARGEST_SUPPLY} V",
            significant(volts, 3)
        ),
        Subject::Period(period) => format!(
            "sampled every {} s, where a drive is sampled at least every {LONGEST_PERIOD} s",
            rounded(period, 6)
        ),
    }
}

/// `12 times` or `1/12 of`.
fn times(ratio: f64) -> String {
    if ratio.abs() >= 1.0 {
        format!("{} times", significant(ratio, 2))
    } else if ratio < 0.0 {
        format!("-1/{} of", significant(-1.0 / ratio, 2))
    } else {
        format!("1/{} of", significant(1.0 / ratio, 2))
    }
}

/// Most numbers of the machine file that an evidence tells: one that is off takes the others with it.
const MOST_NUMBERS: usize = 2;

/// What a number of a machine file is one of.
fn owner(name: &str) -> &'static str {
    match name {
        "resistance" | "inductance" | "torque_constant" => "motor",
        _ => "machine",
    }
}

/// A number of a machine file as a sentence has it.
pub(in crate::gap) fn spoken(name: &str) -> String {
    match name {
        "coulomb" => "Coulomb friction".to_owned(),
        "viscous" => "viscous friction".to_owned(),
        _ => name.replace('_', " "),
    }
}

/// The line of the machine file to change.
fn line(machine: &Machine, name: &str, value: f64) -> String {
    let section = PARAMETERS
        .iter()
        .find(|known| known.name == name)
        .map_or("", |known| known.section);
    entry(machine, section, name, rounded(value, 3))
}

fn entry(machine: &Machine, section: &str, name: &str, value: f64) -> String {
    let path = machine.path.display();
    format!("in {path}, [{section}]: {name} = {value:e}")
}

/// The import that mends a log.
fn command(log: &Log, declared: &Reading, corrections: &[Correction]) -> String {
    // In the unit that a gain makes volts of the values stand as they are.
    let is_in_volts = declared.machine.motor.is_some() && declared.machine.gain == 1.0;
    let mut call = Call::new(&log.path);
    let columns = [
        Column::Time,
        Column::Position,
        Column::Input,
        Column::Current,
        Column::Velocity,
        Column::Command,
    ];
    for column in columns {
        let unit = match column {
            Column::Input if !is_in_volts => "",
            _ => expected_unit(&declared.machine, column),
        };
        let is_there = column == Column::Time || declared.has(column);
        let is_left_out =
            column == Column::Current && corrections.contains(&Correction::Unsigned(column));
        if is_there && !is_left_out {
            let source = source(column, unit, corrections, declared.machine.gain);
            call.source(column.index(), &source);
        }
    }
    for (column, index) in [
        (&log.brake, BRAKE),
        (&log.load_torque, LOAD_TORQUE),
        (&log.enabled, ENABLED),
    ] {
        if column.is_some() {
            call.source(index, COLUMNS[index].0);
        }
    }
    let wrapped = corrections.iter().find_map(|correction| match correction {
        Correction::Wrapped(turn) => Some(*turn),
        _ => None,
    });
    match wrapped {
        None => {}
        // A turn of the unit that the column is given in says itself.
        Some(turn) if [TAU, 360.0].iter().any(|known| (turn - known).abs() < 1e-6) => {
            call.flag("--unwrap");
        }
        Some(turn) => call.option("--unwrap", &rounded(turn, 9).to_string()),
    }
    call.option("--out", &out_beside(&log.path));
    call.to_string()
}

/// A column of the new log as `cargo hil import` takes it: name, unit, factor.
fn source(column: Column, unit: &str, corrections: &[Correction], gain: f64) -> String {
    let (mut name, mut unit, mut factor) = (column.name(), unit, 1.0);
    let mut counts = String::new();
    for correction in corrections {
        match *correction {
            Correction::Unit(changed, _, import, size) if changed == column => {
                if import.is_empty() {
                    factor *= size;
                } else {
                    unit = import;
                }
            }
            Correction::Factor(changed, size) | Correction::Taken(changed, .., size)
                if changed == column =>
            {
                factor *= size;
            }
            Correction::Counts(size) if column == Column::Position => factor *= size,
            Correction::Duty(whole, volts) if column == Column::Input => {
                match whole {
                    1.0 => unit = "",
                    100.0 => unit = "%",
                    _ => {
                        unit = "duty";
                        counts = format!("/{whole}");
                    }
                }
                factor *= volts / gain.abs();
            }
            Correction::Geared(changed, ratio) if changed == column => factor /= ratio,
            Correction::GearedSensor(ratio)
                if matches!(column, Column::Position | Column::Velocity) =>
            {
                factor /= ratio;
            }
            Correction::Negative(changed) if changed == column => factor = -factor,
            Correction::Reversed if matches!(column, Column::Position | Column::Velocity) => {
                factor = -factor;
            }
            Correction::Swapped(one, other) if one == column => name = other.name(),
            Correction::Swapped(one, other) if other == column => name = one.name(),
            Correction::Wrapped(turn) if column == Column::Position && unit != "deg" => {
                // A turn says by itself what the unit is.
                if (turn - 360.0).abs() < 1e-6 {
                    unit = "deg";
                } else if (turn - TAU).abs() < 1e-6 {
                    unit = "rad";
                }
            }
            _ => {}
        }
    }
    // A share needs its supply, whatever that comes to.
    let is_share = matches!(unit, "%" | "duty");
    let unit = if unit.is_empty() {
        String::new()
    } else {
        format!(":{unit}")
    };
    // A gear, or a thousand.
    let divisor = rounded(1.0 / factor, 6);
    let source = format!("{name}{counts}{unit}");
    if factor == 1.0 && !is_share {
        source
    } else if divisor > 1.0 && divisor.fract() == 0.0 {
        format!("{source}/{divisor}")
    } else {
        format!("{source}*{}", rounded(factor, 6))
    }
}
