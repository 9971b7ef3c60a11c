//! The answer: each log's numbers, the trend of each number, and the alarm.

use serde::Serialize;

use super::jump::Jump;
use super::trend::{Estimate, FALSE_ALARMS, Line, Reach, holm};
use crate::gap::disagreement::Disagreement;
use crate::gap::numbers::Numbers;
use crate::gap::outcome::FittedParameter;
use crate::machine::Machine;

/// Where no limit is given, it is this many times the line's value at the first log if the number rises, and one over that if
/// it falls.
pub const LIMIT_FACTOR: f64 = 2.0;

/// Numbers that have no zero of their own, so that a multiple of one means nothing.
pub(super) const PLACES: [&str; 4] = ["spring_rest", "gravity_rest", "lower_stop", "upper_stop"];

/// What the command answers; the JSON of `--json`.
#[derive(Debug, Clone, Serialize)]
pub struct Outcome {
    /// The machine's name.
    pub machine: String,
    /// One entry for each log, in the order of time.
    pub logs: Vec<LogNumbers>,
    /// One entry for each number of `[fit]`.
    pub trends: Vec<Trend>,
    /// The largest change from one log to the next that is surely more than scatter; null where there is none.
    pub jump: Option<Jump>,
    /// Whether any number changes for certain.
    pub alarm: bool,
}

/// The numbers of one log.
#[derive(Debug, Clone, Serialize)]
pub struct LogNumbers {
    /// As the user named it.
    pub log: String,
    /// Each number of `[fit]`; none where log and machine file disagree.
    pub fit: Vec<Value>,
    /// What the fitted model leaves; null where log and machine file disagree.
    pub errors: Option<Errors>,
    /// What log and machine file disagree in; left out of the JSON where they belong together.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub disagreement: Vec<Disagreement>,
}

/// A number with its standard deviation.
#[derive(Debug, Clone, Serialize)]
pub struct Value {
    /// As in the machine file.
    pub name: String,
    /// SI.
    pub value: f64,
    /// Null where the log does not determine it, as where the fit stopped at its limit.
    pub std: Option<f64>,
    /// Its unit.
    pub unit: String,
}

/// What a fitted model leaves of a log.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Errors {
    /// Windowed position error, rms, rad or m.
    pub position_rms: f64,
    /// What sensor and restarts leave to any model.
    pub floor: f64,
    /// Whether that is more than these leave.
    pub unexplained: bool,
}

/// How a number changes from log to log.
#[derive(Debug, Clone, Serialize)]
pub struct Trend {
    /// As in the machine file.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Logs that determine it.
    pub logs: usize,
    /// Value of the line at the first log; null, as all that follows, where fewer than three logs determine the number.
    pub first: Option<f64>,
    /// Value of the line at the last log.
    pub last: Option<f64>,
    /// Change a log.
    pub slope_per_log: Option<f64>,
    /// Its 95 % interval.
    pub interval: Option<(f64, f64)>,
    /// Standard deviation of the scatter from log to log, beyond the standard errors of the logs.
    pub scatter: Option<f64>,
    /// Chance of such a slope while nothing changes, of this number alone.
    pub p_value: Option<f64>,
    /// Whether it changes for certain, all numbers considered.
    pub alarm: bool,
    /// What the remaining logs are counted to.
    pub limit: Option<f64>,
    /// Whether the user has given that.
    pub limit_given: bool,
    /// Whether the line is there already.
    pub reached: bool,
    /// Logs after the last one until the line is there; null where it leads away.
    pub remaining_logs: Option<f64>,
    /// Their 95 % interval; its end is null where there is none. Null where the line surely leads away.
    pub remaining_interval: Option<(f64, Option<f64>)>,
    /// The line.
    #[serde(skip)]
    pub line: Option<Line>,
}

impl LogNumbers {
    /// Of one log.
    pub fn new(log: String, numbers: Numbers) -> Self {
        match numbers {
            Numbers::Fitted { fit, residual } => Self {
                log,
                fit: fit.into_iter().map(Value::from).collect(),
                errors: Some(Errors {
                    position_rms: residual.position_rms,
                    floor: residual.floor,
                    unexplained: residual.is_unexplained(),
                }),
                disagreement: Vec::new(),
            },
            Numbers::Disagree(disagreement) => Self {
                log,
                fit: Vec::new(),
                errors: None,
                disagreement,
            },
        }
    }
}

impl From<FittedParameter> for Value {
    fn from(fitted: FittedParameter) -> Self {
        Self {
            name: fitted.name,
            value: fitted.fitted,
            std: fitted.std.filter(|_| !fitted.at_limit),
            unit: fitted.unit,
        }
    }
}

impl Outcome {
    /// Of the logs. `limits`: those that the user has given, by name.
    pub fn new(machine: &Machine, logs: Vec<LogNumbers>, limits: &[(String, f64)]) -> Self {
        let first = logs.iter().find(|log| !log.fit.is_empty());
        let numbers = first.map_or(&[][..], |log| &log.fit);
        let mut trends: Vec<Trend> = numbers
            .iter()
            .map(|number| {
                let limit = limits.iter().find(|(name, _)| *name == number.name);
                Trend::of(
                    number,
                    &estimates(&logs, &number.name),
                    logs.len(),
                    limit.map(|it| it.1),
                )
            })
            .collect();
        let proven: Vec<usize> = (0..trends.len())
            .filter(|&place| trends[place].p_value.is_some())
            .collect();
        let p_values: Vec<f64> = proven
            .iter()
            .filter_map(|&place| trends[place].p_value)
            .collect();
        for (&place, alarm) in proven.iter().zip(holm(&p_values, FALSE_ALARMS)) {
            trends[place].alarm = alarm;
        }
        let names = numbers.iter().map(|number| (&*number.name, &*number.unit));
        let jump = Jump::find(&logs, &names.collect::<Vec<_>>());
        Self {
            machine: machine.name.clone(),
            jump,
            alarm: trends.iter().any(|trend| trend.alarm),
            logs,
            trends,
        }
    }
}

/// What the logs say of a number, as far as they determine it; the place is that of the log among all.
pub(super) fn estimates(logs: &[LogNumbers], name: &str) -> Vec<Estimate> {
    let of = |(place, log): (usize, &LogNumbers)| {
        let number = log.fit.iter().find(|number| number.name == name)?;
        Some(Estimate {
            place: place as f64,
            value: number.value,
            std: number.std?,
        })
    };
    logs.iter().enumerate().filter_map(of).collect()
}

impl Trend {
    fn of(number: &Value, estimates: &[Estimate], logs: usize, given: Option<f64>) -> Self {
        let last = logs.saturating_sub(1) as f64;
        let line = Line::through(estimates, last);
        let own = |line: Line| {
            let first = line.at(0.0);
            let factor = if line.slope < 0.0 {
                1.0 / LIMIT_FACTOR
            } else {
                LIMIT_FACTOR
            };
            let is_scaled = !PLACES.contains(&number.name.as_str()) && first > 0.0;
            is_scaled.then_some(factor * first)
        };
        let limit = given.or_else(|| line.and_then(own));
        let reach = line.zip(limit).map(|(line, limit)| line.reach(limit, 0.0));
        let (reached, remaining_logs, remaining_interval) = match reach {
            None | Some(Reach::Never) => (false, None, None),
            Some(Reach::Reached) => (true, Some(0.0), None),
            Some(Reach::In { logs, interval }) => (false, logs, Some(interval)),
        };
        Self {
            name: number.name.clone(),
            unit: number.unit.clone(),
            logs: estimates.len(),
            first: line.map(|line| line.at(0.0)),
            last: line.map(|line| line.level),
            slope_per_log: line.map(|line| line.slope),
            interval: line.map(|line| line.slope_interval()),
            scatter: line.map(|line| line.scatter),
            p_value: line.map(|line| line.p_value()),
            alarm: false,
            limit,
            limit_given: given.is_some(),
            reached,
            remaining_logs,
            remaining_interval,
            line,
        }
    }
}
