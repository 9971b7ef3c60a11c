//! Whether an answer about a measured log is right.

use std::f64::consts::TAU;

use serde::Serialize;

use super::manifest::Row;
use crate::gap::outcome::{FoundEffect, Outcome};

/// How far a ripple's period may be from the true one, relative.
const PERIOD: f64 = 0.03;

/// An effect that was named.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Named {
    /// Its id, then those that the log cannot tell from it.
    pub ids: Vec<String>,
    /// Periods in a turn, of an effect that has a period.
    pub per_turn: Option<f64>,
}

impl Named {
    fn of(found: &FoundEffect) -> Self {
        let id = std::iter::once(found.id.clone());
        let mut numbers = found.parameters.iter();
        let period = numbers.find(|number| number.name == "period" && number.unit == "rad");
        Self {
            ids: id.chain(found.equivalent.iter().cloned()).collect(),
            per_turn: period.map(|period| TAU / period.value),
        }
    }
}

/// What was said of a device.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answer {
    /// The verdict's name, or `refused`.
    pub verdict: String,
    /// The effects that were named.
    pub named: Vec<Named>,
    /// Whether a variable was proven to carry what the catalogue does not explain.
    pub proven: bool,
}

impl Answer {
    /// The tracing's, under its verdict's name.
    pub fn of(verdict: String, outcome: &Outcome) -> Self {
        Self {
            verdict,
            named: outcome.effects.iter().map(Named::of).collect(),
            proven: outcome.unknown.is_some(),
        }
    }

    /// Of logs that were refused.
    pub fn refused() -> Self {
        Self {
            verdict: REFUSED.to_owned(),
            named: Vec::new(),
            proven: false,
        }
    }
}

/// The verdict on logs that were refused.
pub const REFUSED: &str = "refused";

/// Verdicts that accuse the logs or the machine file. The files are the project's own and in SI units.
const ACCUSING: [&str; 2] = [REFUSED, "log_and_machine_disagree"];

/// Whether an answer is right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Judgement {
    /// It names what is known, and nothing that is not.
    Right,
    /// It names too little of it, or something unknown, or refuses.
    TooLittle,
    /// It names what is not there, or proves a structure where there is none.
    Wrong,
}

impl Judgement {
    /// As in the JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::TooLittle => "too_little",
            Self::Wrong => "wrong",
        }
    }
}

/// Holds an answer against what is known.
///
/// - An effect that is neither needed nor tolerated, with all that the log cannot tell from it, is wrong; so
///   is a cogging of another period.
/// - Where something is needed and missing the answer is too little, whatever the verdict.
/// - Where nothing is needed, a proven unknown effect is wrong, and a refusal too little.
pub fn judge(row: &Row, answer: &Answer) -> Judgement {
    if !answer.named.iter().all(|named| is_there(row, named)) {
        return Judgement::Wrong;
    }
    let says = |set: &&[&str]| {
        let mut named = answer.named.iter();
        named.any(|named| named.ids.iter().any(|id| set.contains(&id.as_str())))
    };
    let all = row.needed.iter().all(says);
    if row.needed.is_empty() && answer.proven {
        return Judgement::Wrong;
    }
    let unknown = answer.verdict == "unknown_effect";
    if all && !unknown && !ACCUSING.contains(&answer.verdict.as_str()) {
        Judgement::Right
    } else {
        Judgement::TooLittle
    }
}

/// Whether one of a class is really there.
fn is_there(row: &Row, named: &Named) -> bool {
    let known = row.needed.iter().copied().flatten().chain(row.tolerated);
    let known: Vec<&str> = known.copied().collect();
    let period_fits = |id: &str| {
        let near = |of: &f64, it: f64| (it / of - 1.0).abs() <= PERIOD;
        id != "cogging"
            || (named.per_turn).is_none_or(|it| row.per_turn.iter().any(|of| near(of, it)))
    };
    let mut ids = named.ids.iter().map(String::as_str);
    ids.any(|id| known.contains(&id) && period_fits(id))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROW: Row = Row {
        log: "arm",
        train: &["train.csv"],
        validate: &[],
        machine: "arm.toml",
        known: "cogging of 200 a turn, and friction by direction",
        needed: &[&["cogging"], &["asymmetric_coulomb", "offset_torque"]],
        tolerated: &["stribeck"],
        per_turn: &[200.0],
    };

    fn class(ids: &[&str], per_turn: Option<f64>) -> Named {
        Named {
            ids: ids.iter().map(|id| (*id).to_owned()).collect(),
            per_turn,
        }
    }

    fn answer(verdict: &str, named: &[Named]) -> Answer {
        Answer {
            verdict: verdict.to_owned(),
            named: named.to_vec(),
            proven: verdict == "unknown_effect",
        }
    }

    #[test]
    fn what_is_known_is_right_and_anything_else_is_wrong() {
        let cogging = class(&["cogging"], Some(200.4));
        let side = class(&["spring", "offset_torque"], None);
        let stribeck = class(&["stribeck"], None);
        for (named, expected) in [
            (&[cogging.clone(), side.clone()][..], Judgement::Right),
            (
                &[side.clone(), cogging.clone(), stribeck.clone()],
                Judgement::Right,
            ),
            (std::slice::from_ref(&cogging), Judgement::TooLittle),
            (std::slice::from_ref(&stribeck), Judgement::TooLittle),
            (&[cogging.clone(), cogging.clone()], Judgement::TooLittle),
            (
                &[cogging.clone(), class(&["compliance"], None)],
                Judgement::Wrong,
            ),
            (
                &[class(&["cogging"], Some(37.0)), side.clone()],
                Judgement::Wrong,
            ),
        ] {
            let answer = answer("effects_found", named);
            assert_eq!(judge(&ROW, &answer), expected, "{named:?}");
        }
    }

    #[test]
    fn a_verdict_without_a_name_is_too_little_where_an_effect_is_known() {
        for verdict in [
            "no_missing_effect",
            "unknown_effect",
            "nothing_proven",
            "log_and_machine_disagree",
            REFUSED,
        ] {
            assert_eq!(
                judge(&ROW, &answer(verdict, &[])),
                Judgement::TooLittle,
                "{verdict}"
            );
        }
        let both = [class(&["cogging"], None), class(&["offset_torque"], None)];
        let more = answer("unknown_effect", &both);
        assert_eq!(judge(&ROW, &more), Judgement::TooLittle);
    }

    #[test]
    fn where_nothing_is_plain_no_finding_is_right() {
        let clean = Row { needed: &[], ..ROW };
        for (verdict, named, expected) in [
            ("no_missing_effect", &[][..], Judgement::Right),
            ("nothing_proven", &[], Judgement::Right),
            (
                "effects_found",
                &[class(&["stribeck"], None)],
                Judgement::Right,
            ),
            (
                "effects_found",
                &[class(&["external_load"], None)],
                Judgement::Wrong,
            ),
            ("unknown_effect", &[], Judgement::Wrong),
            (REFUSED, &[], Judgement::TooLittle),
            ("log_and_machine_disagree", &[], Judgement::TooLittle),
        ] {
            assert_eq!(
                judge(&clean, &answer(verdict, named)),
                expected,
                "{verdict}"
            );
        }
    }
}
