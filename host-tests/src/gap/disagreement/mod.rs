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
pub(super) mod words;

pub(super) use answer::{failure, report};
use rayon::prelude::*;
use serde::Serialize;

use crate::log::Log;
use crate::machine::Machine;
use channels::{Channels, Column};
use limits::{
    ALIKE, CLEARLY_BETTER, FAR_OFF, IMPLAUSIBLE, IMPOSSIBLE, KEPT, LARGEST_UNIT, LEAST_SAVING,
    MOST_CORRECTIONS, SAMPLES_A_PERIOD,
};
use measure::{Clue, Subject};
use reading::{Correction, Reading, Tried};

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
    Look::at(machine, logs).found
}

/// A look at logs and their machine file.
pub(super) struct Look<'a> {
    /// What they disagree in, as [`look`].
    pub found: Vec<Disagreement>,
    machine: &'a Machine,
    explanation: Option<(Vec<Vec<Correction>>, Reading)>,
}

impl<'a> Look<'a> {
    /// At these logs, read as one log of one machine.
    pub fn at(machine: &'a Machine, logs: &[Log]) -> Self {
        Self::of(machine, logs, &declared(machine, logs))
    }

    /// At logs whose declared reading is known.
    fn of(machine: &'a Machine, logs: &[Log], declared: &Reading) -> Self {
        let explanation = explanation(declared);
        let found = match &explanation {
            Some((steps, best)) => words::corrections(logs, declared, steps, best),
            None => unexplained(logs, declared),
        };
        Self {
            found,
            machine,
            explanation,
        }
    }

    /// What other logs of the same logger disagree in. What mends the ones mends the others most likely: it is said of them if
    /// they agree better with it, though by themselves they may not show it.
    pub fn beside(&self, others: &[Log]) -> Vec<Disagreement> {
        let declared = declared(self.machine, others);
        if let Some((steps, best)) = &self.explanation {
            let best = Tried::of(best).reading(&declared);
            if best.cost < IMPLAUSIBLE && best.strained() + ALIKE < declared.strained() {
                return words::corrections(others, &declared, steps, &best);
            }
        }
        Self::of(self.machine, others, &declared).found
    }
}

fn declared(machine: &Machine, logs: &[Log]) -> Reading {
    Reading::declared(machine, logs.iter().map(Channels::of).collect())
}

/// The corrections that make log and machine file agree, each with those that do as well, and the reading that they lead to.
fn explanation(declared: &Reading) -> Option<(Vec<Vec<Correction>>, Reading)> {
    let (steps, explained) = if declared.cost < IMPLAUSIBLE {
        (Vec::new(), declared.clone())
    } else {
        explain(declared)
    };
    let mended = factor::readings(declared);
    // One other correction may agree still better: per cent of 24 V are about a quarter of them.
    let is_better = |best: &Reading| steps.len() == 1 && explained.strained() < best.strained();
    if let Some(best) = mended.first().filter(|best| !is_better(best)) {
        let alike = with_duties(declared, &mended, best.strained());
        let corrections = alike.iter().map(|reading| reading.corrections[0]).collect();
        return Some((vec![corrections], alike[0].clone()));
    }
    let is_explained = !is_absurd(declared) && !steps.is_empty();
    is_explained.then_some((steps, explained))
}

/// No unit is that far off: the number is none that a machine has, and its model says so.
fn is_absurd(declared: &Reading) -> bool {
    declared.clues.iter().any(|clue| clue.ratio > LARGEST_UNIT)
}

/// What is wrong with these logs though no correction explains it.
fn unexplained(logs: &[Log], declared: &Reading) -> Vec<Disagreement> {
    if declared.cost < IMPLAUSIBLE {
        return if is_too_slow(&declared.logs) {
            vec![words::too_slow(&logs[0], SAMPLES_A_PERIOD)]
        } else {
            Vec::new()
        };
    }
    if is_absurd(declared) {
        return Vec::new();
    }
    let is_clear = |clue: &&Clue| match clue.subject {
        Subject::Number(name) => {
            name != "viscous" && clue.ratio > 0.0 && clue.excess > FAR_OFF.ln()
        }
        _ => clue.cost >= IMPOSSIBLE,
    };
    let clue = declared.clues.iter().find(is_clear);
    clue.map(|clue| words::unexplained(&declared.machine, &logs[0], clue))
        .into_iter()
        .collect()
}

/// How implausible logs and machine file are as declared, nats: from [`limits::IMPLAUSIBLE`] on another
/// reading is looked for.
pub fn cost(machine: &Machine, logs: &[Log]) -> f64 {
    declared(machine, logs).cost
}

/// Those that mend a column that is off as a whole, with the duties that do as well: per cent of 24 V are about a quarter
/// of them. No input beyond the largest supply is a voltage, and none whose unit the machine file has is a duty.
fn with_duties(declared: &Reading, mended: &[Reading], strained: f64) -> Vec<Reading> {
    let is_of_input = |reading: &&Reading| {
        let last = reading.corrections.last();
        matches!(last, Some(Correction::Factor(Column::Input, _)))
    };
    let is_in_own_unit = declared.machine.gain != 1.0;
    if is_in_own_unit || !mended.iter().any(|reading| is_of_input(&reading)) {
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

/// The corrections that explain the contradiction, each with those that explain it as well, and the reading that they
/// lead to. None where no corrections do.
///
/// One wrong thing can hide another: a wrong sign is least wrong where a wrong unit makes it small. So several corrections
/// are sought together, and one more only where it saves enough, with what it leaves of the numbers that are known well.
fn explain(declared: &Reading) -> (Vec<Vec<Correction>>, Reading) {
    let mut best = declared.clone();
    let mut kept = vec![Tried::of(declared)];
    for round in 0..MOST_CORRECTIONS {
        let further = |tried: &Tried| tried.reading(declared).further();
        let mut further: Vec<Tried> = kept.par_iter().flat_map_iter(further).collect();
        if round == 1 {
            further.extend(of_both_scales(declared));
        }
        let alike = alike(&further);
        let Some(least) = alike.first() else {
            break;
        };
        let more = (least.corrections.len() - best.corrections.len()) as i32;
        let strained = best.strained();
        let saves = strained - least.strained >= CLEARLY_BETTER * f64::from(more)
            && least.strained <= (1.0 - LEAST_SAVING).powi(more) * strained;
        let is_wrap = matches!(least.last(), Some(Correction::Wrapped(_)));
        if saves || is_wrap {
            best = least.reading(declared);
        }
        if best.strained() < IMPLAUSIBLE {
            break;
        }
        kept = least_of_each(further);
        kept.truncate(KEPT);
    }
    alternatives(declared, best)
}

/// Every scale of the input with every one of the position. A balance says what the one is over the other: what is the best for
/// one of them alone is seldom the best beside another of the other.
fn of_both_scales(declared: &Reading) -> Vec<Tried> {
    let of = |column| move |correction: &Correction| correction.scales() == Some(column);
    let positions = declared.further_by(of(Column::Position));
    let both = |tried: &Tried| tried.reading(declared).further_by(of(Column::Input));
    positions.par_iter().flat_map_iter(both).collect()
}

/// Of those that correct the same things the one that costs least; the least first.
fn least_of_each(mut all: Vec<Tried>) -> Vec<Tried> {
    all.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut least: Vec<Tried> = Vec::new();
    for tried in all {
        if !least.iter().any(|known| known.corrects_as(&tried)) {
            least.push(tried);
        }
    }
    least
}

/// Each correction of a reading chosen anew beside the others, with those that explain as much, and the reading that
/// they lead to.
fn alternatives(declared: &Reading, mut best: Reading) -> (Vec<Vec<Correction>>, Reading) {
    let mut steps = Vec::new();
    for place in 0..best.corrections.len() {
        // What is exchanged or unwrapped comes before what is multiplied.
        if best.corrections[place].comes_first() {
            steps.push(vec![best.corrections[place]]);
            continue;
        }
        let further = Tried::of(&best).but(place).reading(declared).further();
        let alike = alike(&further);
        let last = alike.iter().filter_map(|tried| tried.last());
        steps.push(last.collect());
        if let Some(chosen) = alike.first() {
            best = chosen.with_last_at(place).reading(declared);
        }
    }
    (steps, best)
}

/// Those that explain as much as the best one, and for which the numbers that are known well speak as much; the best first.
fn alike(all: &[Tried]) -> Vec<&Tried> {
    let least = all
        .iter()
        .map(|tried| tried.cost)
        .fold(f64::INFINITY, f64::min);
    let mut alike: Vec<&Tried> = all
        .iter()
        .filter(|tried| tried.cost <= least + ALIKE)
        .collect();
    alike.sort_by(|a, b| a.strained.total_cmp(&b.strained));
    let least = alike.first().map_or(0.0, |tried| tried.strained);
    alike.retain(|tried| tried.strained <= least + ALIKE);
    alike
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
