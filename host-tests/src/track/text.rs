//! The answer on the terminal: sentences for people, then the numbers.

use super::jump::Jump;
use super::outcome::{LIMIT_FACTOR, Outcome, PLACES, Trend};
use super::trend::LEAST_LOGS;
use crate::cells::{self, Cells};
use crate::error::one_line;
use crate::gap::answer::listed;
use crate::gap::terminal::wrapped;
use crate::log::counted;
use crate::machine::Machine;
use crate::quantity::{Scale, capitalised, estimate, probability, significant};

/// From so many logs on nobody counts them: one a day for thirty years.
const MOST_LOGS: f64 = 10_000.0;

/// The words for a number of the machine file.
pub(super) fn words(name: &str) -> String {
    match name {
        "resistance" => "winding resistance".into(),
        "inductance" => "winding inductance".into(),
        "viscous" => "viscous friction".into(),
        "spring" => "spring stiffness".into(),
        "spring_rest" => "rest of the spring".into(),
        "gravity_rest" => "angle at which the load hangs".into(),
        "coulomb" => "Coulomb friction".into(),
        "static" => "static friction".into(),
        other => other.replace('_', " "),
    }
}

/// `3.1 % a log (95 %: 2.6 to 3.6)`, or with the unit where the number has no level to be a share of.
fn rate(trend: &Trend) -> Option<String> {
    let (slope, (low, high), first) = (trend.slope_per_log?, trend.interval?, trend.first?);
    let (low, high) = if slope < 0.0 {
        (-high, -low)
    } else {
        (low, high)
    };
    // A place, or a number that begins at nothing, has no level to be a share of.
    let is_share = !PLACES.contains(&trend.name.as_str()) && first > slope.abs();
    let scale = if is_share {
        let percent = Scale::percent();
        Scale {
            factor: percent.factor / first.abs(),
            ..percent
        }
    } else {
        Scale::of(&trend.unit, [slope])
    };
    let number = |value: f64| significant(value * scale.factor, 2);
    Some(format!(
        "{} {} a log (95 %: {} to {})",
        number(slope.abs()),
        scale.unit,
        number(low),
        number(high)
    ))
}

/// A count of logs that a person would say. A line that is all but level reaches its limit in the end, too.
fn about(logs: f64) -> String {
    if logs < 9.95 {
        significant(logs, 2)
    } else if logs < MOST_LOGS {
        format!("{logs:.0}")
    } else {
        format!("over {MOST_LOGS}")
    }
}

/// When a number is at its limit.
pub(super) fn reach(trend: &Trend) -> Option<String> {
    let (limit, first) = (trend.limit?, trend.first?);
    let value = Scale::of(&trend.unit, [limit]).quantity(limit);
    let limit = if trend.limit_given {
        value
    } else if limit >= first {
        format!("{value} ({LIMIT_FACTOR} times the first log)")
    } else {
        format!("{value} (1/{LIMIT_FACTOR} of the first log)")
    };
    if trend.reached {
        return Some(format!("it has reached {limit}"));
    }
    let Some((from, to)) = trend.remaining_interval else {
        return Some(format!("at this rate it never reaches {limit}"));
    };
    let interval = match to {
        Some(to) => format!("{} to {}", about(from), about(to)),
        None => format!("{} or more, without end", about(from)),
    };
    Some(match trend.remaining_logs {
        Some(logs) => format!(
            "it reaches {limit} in about {} logs (95 %: {interval})",
            about(logs)
        ),
        None => format!("the logs do not tell when it reaches {limit} (95 %: in {interval})"),
    })
}

/// The largest change from one log to the next, that is surely none of chance.
fn jumped(jump: &Jump) -> String {
    let scale = Scale::of(&jump.unit, [jump.change]);
    let is_share = !PLACES.contains(&jump.name.as_str()) && jump.before > 0.0;
    let share = if is_share {
        let percent = Scale::percent().quantity((jump.change / jump.before).abs());
        format!(" ({percent})")
    } else {
        String::new()
    };
    format!(
        "{} jumps {} by {}{share} from {} to {}, which is more than it changes between the other logs (p = {}).",
        capitalised(&words(&jump.name)),
        if jump.change < 0.0 { "down" } else { "up" },
        scale.quantity(jump.change.abs()),
        one_line(&jump.from),
        one_line(&jump.to),
        probability(jump.p_value)
    )
}

/// The sentences of the answer.
pub(super) fn sentences(outcome: &Outcome) -> Vec<String> {
    let mut sentences = Vec::new();
    let (alarms, others): (Vec<&Trend>, Vec<&Trend>) =
        outcome.trends.iter().partition(|trend| trend.alarm);
    for trend in alarms {
        let falls = trend.slope_per_log.is_some_and(|slope| slope < 0.0);
        let verb = if falls { "falls" } else { "rises" };
        let mut sentence = capitalised(&words(&trend.name));
        if let Some(rate) = rate(trend) {
            sentence += &format!(" {verb} by {rate}");
        }
        if let Some(reach) = reach(trend) {
            sentence += &format!("; {reach}");
        }
        sentences.push(sentence + ".");
    }
    sentences.extend(outcome.jump.as_ref().map(jumped));
    let (seen, unseen): (Vec<&Trend>, Vec<&Trend>) = others
        .into_iter()
        .partition(|trend| trend.p_value.is_some());
    let names = |trends: &[&Trend]| {
        let names: Vec<String> = trends.iter().map(|trend| words(&trend.name)).collect();
        listed(&names)
    };
    if !seen.is_empty() {
        sentences.push(format!("The logs prove no trend of {}.", names(&seen)));
    }
    for trend in seen.iter().filter(|trend| trend.limit_given) {
        if let Some(reach) = reach(trend) {
            let name = capitalised(&words(&trend.name));
            sentences.push(format!("{name}: {reach}."));
        }
    }
    if !unseen.is_empty() {
        let fitted = outcome
            .logs
            .iter()
            .filter(|log| log.errors.is_some())
            .count();
        sentences.push(if fitted < LEAST_LOGS {
            format!(
                "No trend can be proven from {}: it takes {LEAST_LOGS} at least.",
                counted(fitted, "log")
            )
        } else {
            format!("Fewer than {LEAST_LOGS} logs determine {}.", names(&unseen))
        });
    }
    sentences
}

/// What stands before the tables: warnings about the logs.
pub(super) fn notes(outcome: &Outcome, machine: &Machine) -> Vec<String> {
    let mut notes = Vec::new();
    let out = outcome
        .logs
        .iter()
        .filter(|log| log.errors.is_none())
        .count();
    if out > 0 {
        notes.push(format!(
            "{} left out, because log and machine file do not belong together.",
            counted(out, "log")
        ));
    }
    let unexplained = outcome
        .logs
        .iter()
        .filter(|log| log.errors.is_some_and(|it| it.unexplained));
    let unexplained: Vec<&str> = unexplained.map(|log| &*log.log).collect();
    if let Some(first) = unexplained.first() {
        notes.push(format!(
            "In {} of the logs the model's error is larger than the sensor's. An effect may be missing, which would change these \
             numbers. To look for it: cargo hil gap --machine {} --train {}",
            unexplained.len(),
            one_line(&machine.path.display().to_string()),
            one_line(first)
        ));
    }
    notes
}

/// The trends as a table.
pub(super) fn trend_cells(outcome: &Outcome) -> Cells {
    let mut rows = vec![cells::row([
        "number",
        "first log",
        "last log",
        "change a log",
        "95 %",
        "p",
        "alarm",
        "limit",
        "remaining logs",
        "95 %",
    ])];
    let shown = |value: Option<f64>| value.map_or("-".to_owned(), |value| significant(value, 3));
    for trend in &outcome.trends {
        let interval = |ends: Option<(String, String)>| {
            ends.map_or("-".to_owned(), |(low, high)| format!("{low} to {high}"))
        };
        let slope = trend
            .interval
            .map(|(low, high)| (significant(low, 2), significant(high, 2)));
        let remaining = trend.remaining_interval.map(|(from, to)| {
            let to = to.map_or("no end".to_owned(), about);
            (about(from), to)
        });
        rows.push(vec![
            format!("{}, {}", trend.name, trend.unit),
            shown(trend.first),
            shown(trend.last),
            trend
                .slope_per_log
                .map_or("-".to_owned(), |slope| significant(slope, 2)),
            interval(slope),
            trend.p_value.map_or("-".to_owned(), probability),
            if trend.alarm { "yes" } else { "no" }.to_owned(),
            shown(trend.limit),
            trend.remaining_logs.map_or("-".to_owned(), about),
            interval(remaining),
        ]);
    }
    rows
}

/// The logs as a table.
pub(super) fn log_cells(outcome: &Outcome, machine: &Machine) -> Cells {
    let unit = machine.coordinate.unit();
    let errors = outcome.logs.iter().filter_map(|log| log.errors);
    let scale = Scale::of(unit, errors.map(|errors| errors.position_rms));
    let mut head = vec!["log".to_owned()];
    let numbers = outcome.trends.iter();
    head.extend(numbers.map(|trend| format!("{}, {}", trend.name, trend.unit)));
    head.push(format!("position error, {}", scale.unit));
    head.push("sensor's".to_owned());
    let mut rows = vec![head];
    for log in &outcome.logs {
        let mut row = vec![one_line(&log.log)];
        row.extend(outcome.trends.iter().map(|trend| {
            let number = log.fit.iter().find(|number| number.name == trend.name);
            number.map_or("left out".to_owned(), |number| {
                estimate(number.value, number.std.unwrap_or(f64::NAN), "")
            })
        }));
        let error = |value: Option<f64>| value.map_or("-".to_owned(), |value| scale.number(value));
        row.push(error(log.errors.map(|errors| errors.position_rms)));
        row.push(error(log.errors.map(|errors| errors.floor)));
        rows.push(row);
    }
    rows
}

/// The answer.
pub(super) fn render(outcome: &Outcome, machine: &Machine) -> String {
    let head = format!(
        "{}: {}, {}",
        one_line(&outcome.machine),
        counted(outcome.logs.len(), "log"),
        if outcome.alarm { "alarm." } else { "no alarm." }
    );
    let mut text = String::new();
    let paragraphs = [vec![head], sentences(outcome), notes(outcome, machine)].concat();
    for line in paragraphs
        .iter()
        .flat_map(|paragraph| wrapped(paragraph, 2))
    {
        text += &line;
        text.push('\n');
    }
    format!(
        "{text}\n{}\n{}",
        cells::render(&trend_cells(outcome)),
        cells::render(&log_cells(outcome, machine))
    )
}
