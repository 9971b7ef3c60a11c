//! Whether logs and machine file belong together, asked before anything is traced.
//!
//! Degrees, per cent, a sign, a wrapped angle, an inertia in g·cm²: the fit of a model swallows all of them
//! and gives physics for an answer. Each is here a *reading* of the files (`reading`), a transformation of
//! a column or of a declared number from one table of units (`units`), and all readings are judged by one
//! measure (`measure`): how far the balances of the log (`balance`) are from what the machine file allows
//! with a data sheet's tolerance. Logs and machine file disagree where the declared reading is implausible by
//! a large margin and another one explains it, or one number alone is off by orders of magnitude. What the
//! log does not determine decides nothing.

mod answer;
mod balance;
pub(crate) mod channels;
mod factor;
pub mod limits;
mod measure;
mod reading;
mod regression;
pub(crate) mod units;
mod words;

pub(super) use answer::{failure, report};
use serde::Serialize;

use crate::log::Log;
use crate::machine::Machine;
use channels::{Channels, Column};
use limits::{
    ALIKE, CLEARLY_BETTER, FAR_OFF, IMPLAUSIBLE, IMPOSSIBLE, LARGEST_UNIT, LEAST_SAVING,
    MOST_CORRECTIONS, SAMPLES_A_PERIOD,
};
use measure::{Clue, Subject};
use reading::{Correction, Reading};

/// One thing in which logs and machine file disagree.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Disagreement {
    /// What is wrong, in a few words.
    pub what: String,
    /// What shows it.
    pub evidence: String,
    /// The command to run, or the line of the machine file to change; a line for each, where one of several does.
    pub remedy: String,
}

impl Disagreement {
    /// A line that says what is wrong, one of evidence, and one for each remedy, which is to be copied and so is not to
    /// be broken.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![
            format!("{}.", self.what),
            format!("  Evidence: {}.", self.evidence),
        ];
        for (place, remedy) in self.remedy.lines().enumerate() {
            let head = if place == 0 { "Remedy:" } else { "or:" };
            lines.push(format!("  {head} {remedy}"));
        }
        lines
    }
}

/// What logs and machine file disagree in; nothing where they belong together, or where the logs do not
/// tell. The logs are read as one log of one machine.
pub fn look(machine: &Machine, logs: &[Log]) -> Vec<Disagreement> {
    let channels: Vec<Channels> = logs.iter().map(Channels::of).collect();
    let declared = Reading::declared(machine, channels);
    let (steps, explained) = explain(&declared);
    let mended = factor::readings(&declared);
    // One other correction may agree still better: per cent of 24 V are about a quarter of them.
    let is_better = |best: &Reading| steps.len() == 1 && explained.strained() < best.strained();
    if let Some(best) = mended.first().filter(|best| !is_better(best)) {
        let alike = with_duties(&declared, &mended, best.strained());
        return words::corrections(logs, &declared, std::slice::from_ref(&alike), &alike[0]);
    }
    if declared.cost < IMPLAUSIBLE {
        return if is_too_slow(&declared.logs) {
            vec![words::too_slow(&logs[0], SAMPLES_A_PERIOD)]
        } else {
            Vec::new()
        };
    }
    // No unit is that far off: the number is none that a machine has, and its model says so.
    if declared.clues.iter().any(|clue| clue.ratio > LARGEST_UNIT) {
        return Vec::new();
    }
    if !steps.is_empty() {
        return words::corrections(logs, &declared, &steps, &explained);
    }
    let unexplained = |clue: &&Clue| match clue.subject {
        Subject::Number(name) => {
            name != "viscous" && clue.ratio > 0.0 && clue.excess > FAR_OFF.ln()
        }
        _ => clue.cost >= IMPOSSIBLE,
    };
    let clue = declared.clues.iter().find(unexplained);
    clue.map(|clue| words::unexplained(machine, &logs[0], clue))
        .into_iter()
        .collect()
}

/// How implausible logs and machine file are as declared, nats: from [`limits::IMPLAUSIBLE`] on another
/// reading is looked for.
pub fn cost(machine: &Machine, logs: &[Log]) -> f64 {
    Reading::declared(machine, logs.iter().map(Channels::of).collect()).cost
}

/// Those that mend a column that is off as a whole, with the duties that do as well: per cent of 24 V are about a quarter
/// of them. No input beyond the largest supply is a voltage.
fn with_duties(declared: &Reading, mended: &[Reading], strained: f64) -> Vec<Reading> {
    let is_of_input = |reading: &&Reading| {
        let last = reading.corrections.last();
        matches!(last, Some(Correction::Factor(Column::Input, _)))
    };
    if !mended.iter().any(|reading| is_of_input(&reading)) {
        return mended.to_vec();
    }
    let is_voltage = !declared.is_beyond_supplies();
    let duties = declared.of_duty().into_iter();
    let duties = duties.map(|(correction, _)| declared.with(correction, 0.0));
    let mut duties: Vec<Reading> = duties
        .filter(|reading| reading.strained() <= strained + ALIKE)
        .collect();
    duties.sort_by(|a, b| a.strained().total_cmp(&b.strained()));
    let voltages = mended
        .iter()
        .filter(|reading| is_voltage || duties.is_empty() || !is_of_input(reading));
    let voltages: Vec<Reading> = voltages.cloned().collect();
    [voltages, duties].concat()
}

/// The corrections that explain the contradiction, one after the other, each with those that explain it
/// as well, and the reading that they lead to. None where no correction does.
fn explain(declared: &Reading) -> (Vec<Vec<Reading>>, Reading) {
    let mut best = declared.clone();
    let mut steps = Vec::new();
    while best.cost >= IMPLAUSIBLE && steps.len() < MOST_CORRECTIONS {
        let mut further = best.further();
        further.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let saving = (LEAST_SAVING * best.cost).max(CLEARLY_BETTER);
        let Some(least) = further.first().map(|reading| reading.cost) else {
            break;
        };
        let is_wrap = matches!(further[0].corrections.last(), Some(Correction::Wrapped(_)));
        if best.cost - least < saving && !is_wrap {
            break;
        }
        // Of those that explain it as well, the ones that the well-known numbers speak for.
        further.retain(|reading| reading.cost <= least + ALIKE);
        further.sort_by(|a, b| a.strained().total_cmp(&b.strained()));
        let least = further[0].strained();
        further.retain(|reading| reading.strained() <= least + ALIKE);
        best = further[0].clone();
        steps.push(further);
    }
    (steps, best)
}

/// Whether the motion's speed changes too much from one sample to the next: its autocorrelation is that
/// of a sine with too few samples a period. A sensor's noise is no motion: it makes the
/// neighbouring differences less alike than those two apart.
fn is_too_slow(logs: &[Channels]) -> bool {
    let mut products = [0.0; 3];
    for log in logs {
        let speeds: Vec<f64> = log
            .position
            .windows(2)
            .map(|pair| pair[1] - pair[0])
            .collect();
        for (lag, product) in products.iter_mut().enumerate() {
            let shifted = speeds.iter().skip(lag);
            *product += speeds.iter().zip(shifted).map(|(a, b)| a * b).sum::<f64>();
        }
    }
    let [none, one, two] = products;
    let corner = (std::f64::consts::TAU / SAMPLES_A_PERIOD).cos();
    one < corner * none && two < one
}
