//! The largest change of a number from one log to the next that stands out of its other changes.

use model_core::numeric::student::upper_tail;
use serde::Serialize;

use super::outcome::{LogNumbers, estimates};
use super::trend::{Estimate, FALSE_ALARMS};

/// Fewest changes beside the one that is judged: of two it is known how far they scatter.
const LEAST_OTHERS: usize = 2;

/// A number that changes at once, and not a little from log to log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Jump {
    /// As in the machine file.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// The log before it.
    pub from: String,
    /// The log behind it: the next one that determines the number.
    pub to: String,
    /// Value in the log before it.
    pub before: f64,
    /// How much the number changes.
    pub change: f64,
    /// Standard deviation of such a change while nothing jumps.
    pub std: f64,
    /// Chance of so large a change anywhere, of all changes of all numbers together, while nothing jumps.
    pub p_value: f64,
}

/// A change between two estimates that follow each other.
#[derive(Debug, Clone, Copy)]
struct Change {
    /// The first of the two.
    place: usize,
    /// How much more the second one is.
    change: f64,
    /// Standard deviation of such a change.
    std: f64,
    /// Chance of one as far from the others, while they all are alike.
    p_value: f64,
}

impl Jump {
    /// The surest one, if it is sure. `names`: the numbers that are looked at, with their units.
    pub fn find(logs: &[LogNumbers], names: &[(&str, &str)]) -> Option<Self> {
        let all = names.iter().flat_map(|&(name, unit)| {
            let read = estimates(logs, name);
            let changes = changes(&read);
            changes.into_iter().map(move |change| {
                let log = |place: usize| logs[read[place].place as usize].log.clone();
                Self {
                    name: name.to_owned(),
                    unit: unit.to_owned(),
                    from: log(change.place),
                    to: log(change.place + 1),
                    before: read[change.place].value,
                    change: change.change,
                    std: change.std,
                    p_value: change.p_value,
                }
            })
        });
        let all: Vec<Self> = all.collect();
        // C. E. Bonferroni: of so many changes each may be one by chance.
        let tried = all.len() as f64;
        let surest = all
            .into_iter()
            .min_by(|one, other| one.p_value.total_cmp(&other.p_value))?;
        let p_value = (tried * surest.p_value).min(1.0);
        (p_value <= FALSE_ALARMS).then_some(Self { p_value, ..surest })
    }
}

/// Each change, judged by all others: by their mean, so that a number which rises evenly does not jump, and by their scatter, or
/// by the standard errors of its two logs where these are larger. With the quantiles of Student's t for the
/// prediction of one more value. A log that is odd makes two changes, of which each hides the other.
fn changes(estimates: &[Estimate]) -> Vec<Change> {
    let pairs = || estimates.windows(2);
    let steps: Vec<f64> = pairs().map(|pair| pair[1].value - pair[0].value).collect();
    let others = steps.len().saturating_sub(1);
    if others < LEAST_OTHERS {
        return Vec::new();
    }
    let count = others as f64;
    let judged = pairs().enumerate().map(|(place, pair)| {
        let rest = || (0..steps.len()).filter(|other| *other != place);
        let mean = rest().map(|other| steps[other]).sum::<f64>() / count;
        let squares = rest()
            .map(|other| (steps[other] - mean).powi(2))
            .sum::<f64>();
        let own = pair[0].std.powi(2) + pair[1].std.powi(2);
        let std = ((squares / (count - 1.0)).max(own) * (1.0 + 1.0 / count)).sqrt();
        let away = (steps[place] - mean).abs() / std;
        Change {
            place,
            change: steps[place],
            std,
            p_value: if away.is_finite() {
                2.0 * upper_tail(away, count - 1.0)
            } else {
                1.0
            },
        }
    });
    judged.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::track::outcome::Value;
    use model_core::numeric::random::Random;

    fn logs(values: &[f64], std: f64) -> Vec<LogNumbers> {
        let each = values.iter().enumerate();
        each.map(|(place, &value)| LogNumbers {
            log: format!("{place}.csv"),
            fit: vec![Value {
                name: "coulomb".into(),
                value,
                std: Some(std),
                unit: "N·m".into(),
            }],
            errors: None,
            disagreement: Vec::new(),
        })
        .collect()
    }

    const NUMBERS: [(&str, &str); 1] = [("coulomb", "N·m")];

    #[test]
    fn a_step_is_found_where_it_is_and_a_slope_or_an_odd_log_is_none() {
        let step = [0.100, 0.101, 0.099, 0.100, 0.131, 0.130, 0.132, 0.131];
        let jump = Jump::find(&logs(&step, 1e-3), &NUMBERS).unwrap();
        assert_eq!((&*jump.from, &*jump.to), ("3.csv", "4.csv"));
        assert!((jump.change - 0.031).abs() < 1e-12 && jump.p_value < 1e-3);
        for values in [
            [0.100, 0.111, 0.119, 0.130, 0.141, 0.149, 0.160, 0.171],
            [0.100, 0.101, 0.099, 0.131, 0.100, 0.100, 0.101, 0.099],
        ] {
            assert_eq!(Jump::find(&logs(&values, 1e-3), &NUMBERS), None);
        }
        // Of three logs nobody knows how far they scatter, and what their own errors hide is no jump.
        assert_eq!(Jump::find(&logs(&step[2..5], 1e-3), &NUMBERS), None);
        assert_eq!(Jump::find(&logs(&step, 0.1), &NUMBERS), None);
    }

    /// Of logs that scatter and do not jump, no more than one call in twenty is wrong, but for what four standard deviations of
    /// chance in 2,000 calls add: 5 + 4 √(5 · 95 / 2000) = 7 %.
    #[test]
    fn chance_is_no_jump() {
        let mut random = Random::new(7, 0);
        for count in [4, 6, 10, 30] {
            let mut found = 0;
            for _ in 0..2_000 {
                let values: Vec<f64> = (0..count)
                    .map(|_| 1.0 + 0.1 * f64::from(random.normal()))
                    .collect();
                found += usize::from(Jump::find(&logs(&values, 0.01), &NUMBERS).is_some());
            }
            assert!(found <= 140, "{found} of 2000 with {count} logs");
        }
    }
}
