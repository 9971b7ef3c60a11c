//! Whether an answer is right.

use rig::EffectKind;
use serde::Serialize;

use super::cases::{Case, Group, label};
use crate::gap::outcome::Outcome;

/// What was said of a log.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Answer {
    /// Each effect that was named: its id, then those that the log cannot tell from it.
    pub named: Vec<Vec<String>>,
    /// Those of the effects whose law was learned, in place of the catalogue's formula.
    pub learned: Vec<String>,
    /// Numbers of the machine file that are said to be wrong although `[fit]` leaves them out.
    pub freed: Vec<String>,
    /// The variable that carries what the catalogue does not explain.
    pub unknown: Option<String>,
    /// Whether it is proven, where there is one.
    pub proven: bool,
    /// Whether it says that more is left than the sensors leave, and nothing of it proven.
    pub nothing_proven: bool,
    /// Whether it says that log and machine file do not belong together.
    pub disagrees: bool,
}

impl Answer {
    /// The tracing's.
    pub fn of(outcome: &Outcome) -> Self {
        let named = outcome.effects.iter().map(|found| {
            let id = std::iter::once(found.id.clone());
            id.chain(found.equivalent.iter().cloned()).collect()
        });
        let learned = outcome.effects.iter().filter(|found| found.law.is_some());
        Self {
            named: named.collect(),
            learned: learned.map(|found| found.id.clone()).collect(),
            freed: outcome.freed().map(str::to_owned).collect(),
            unknown: outcome
                .unknown
                .as_ref()
                .map(|unknown| unknown.depends_on.clone()),
            proven: outcome.unknown.is_some(),
            nothing_proven: outcome.verdict.name() == "nothing_proven",
            disagrees: outcome.verdict.name() == "log_and_machine_disagree",
        }
    }
}

/// What is behind a log, as far as an answer can say it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Truth {
    /// What kind of truth it is.
    pub group: Group,
    /// Ids of the effects; of what the catalogue has not, a name that no effect has.
    pub ids: Vec<String>,
    /// Variables that carry what the catalogue has not.
    pub carriers: Vec<&'static str>,
    /// Effects of the catalogue that say fairly what it has not.
    pub fair: Vec<&'static str>,
    /// Effects of the catalogue of which it has another law: they say what it has not where their law was learned.
    pub other_law: Vec<&'static str>,
    /// Effects that the log has by the way, whose names say nothing wrong.
    pub tolerated: Vec<&'static str>,
    /// Numbers of the machine file that are wrong.
    pub wrong_numbers: Vec<String>,
    /// Whether one of them is outside `[fit]`, so that something is left which no fit takes up.
    pub outside_fit: bool,
}

impl Truth {
    /// Of a log of the benchmark's own machines.
    pub fn of(case: &Case) -> Self {
        let kinds = case.effects.iter().map(|effect| effect.kind());
        Self {
            group: case.group,
            ids: kinds.clone().map(label).collect(),
            carriers: kinds.filter_map(carrier).collect(),
            fair: Vec::new(),
            other_law: Vec::new(),
            tolerated: Vec::new(),
            wrong_numbers: NUMBERS
                .into_iter()
                .filter(|name| case.misdeclares(name))
                .map(str::to_owned)
                .collect(),
            outside_fit: false,
        }
    }

    /// Whether a class of effects holds one that is there, or stands for it. `learned`: effects whose law was learned.
    fn holds(&self, class: &[String], learned: &[String]) -> bool {
        class.iter().any(|id| {
            let is_of_other_law = self.other_law.contains(&id.as_str()) && learned.contains(id);
            self.ids.contains(id) || self.fair.contains(&id.as_str()) || is_of_other_law
        })
    }
}

/// Numbers of a machine file that may be wrong.
const NUMBERS: [&str; 6] = [
    "inertia",
    "viscous",
    "coulomb",
    "static",
    "resistance",
    "torque_constant",
];

/// Whether an answer is right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Judgement {
    /// It says what there is, and nothing else: each effect, or a class that it is in; of what the
    /// catalogue has not, the variable that carries it.
    Right,
    /// It says too little: nothing, something unknown, one effect of two, or that no variable is proven.
    Abstained,
    /// It names what is not there, or proves a variable that carries nothing, sees something where nothing is, or
    /// calls a right number wrong.
    Wrong,
}

/// Holds an answer against what is behind the log.
pub fn judge(truth: &Truth, answer: &Answer) -> Judgement {
    if answer.disagrees {
        return match truth.group {
            Group::WrongNumbers => Judgement::Right,
            _ => Judgement::Wrong,
        };
    }
    let holds = |class: &[String]| truth.holds(class, &answer.learned);
    let tolerated = |class: &[String]| {
        let by_the_way = |id: &String| truth.tolerated.contains(&id.as_str());
        !holds(class) && class.iter().any(by_the_way)
    };
    let named: Vec<&Vec<String>> = answer
        .named
        .iter()
        .filter(|class| !tolerated(class))
        .collect();
    let true_ones = named.iter().filter(|class| holds(class)).count();
    let is_right = |name: &String| !truth.wrong_numbers.contains(name);
    // One number that is wrong may go by the name of an effect that is there for it.
    let most = truth.ids.len().max(usize::from(truth.outside_fit));
    if true_ones < named.len() || named.len() > most || answer.freed.iter().any(is_right) {
        return Judgement::Wrong;
    }
    let said_unknown = answer.unknown.is_some();
    match truth.group {
        // What a wrong number leaves is unknown; no physics is named.
        Group::WrongNumbers if said_unknown && truth.outside_fit => Judgement::Abstained,
        Group::Clean | Group::WrongNumbers if said_unknown => Judgement::Wrong,
        Group::Clean if answer.nothing_proven => Judgement::Abstained,
        Group::Clean | Group::WrongNumbers => Judgement::Right,
        Group::Outside => match &answer.unknown {
            Some(variable) if truth.carriers.contains(&variable.as_str()) => Judgement::Right,
            Some(_) if answer.proven => Judgement::Wrong,
            None if true_ones > 0 => Judgement::Right,
            _ => Judgement::Abstained,
        },
        Group::Named | Group::Two if said_unknown => Judgement::Abstained,
        Group::Named | Group::Two => {
            let all = truth
                .ids
                .iter()
                .all(|id| named.iter().any(|class| class.contains(id)));
            if all && named.len() == truth.ids.len() {
                Judgement::Right
            } else {
                Judgement::Abstained
            }
        }
    }
}

/// The variable that carries an effect which the catalogue has not.
fn carrier(kind: EffectKind) -> Option<&'static str> {
    match kind {
        EffectKind::SpeedBand => Some("velocity"),
        EffectKind::RoughSpot => Some("position"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap_benchmark::cases::Motion;
    use rig::Effect;

    fn judge(case: &Case, answer: &Answer) -> Judgement {
        super::judge(&Truth::of(case), answer)
    }

    fn case(group: Group, kinds: &[EffectKind]) -> Case {
        let rig = rig::Machine::rotary_ema();
        Case {
            group,
            declared: None,
            effects: kinds
                .iter()
                .map(|&kind| Effect::nominal(kind, &rig))
                .collect(),
            rig,
            strength: 1.0,
            motion: Motion::Sines,
            seed: 1,
        }
    }

    fn answer(named: &[&[&str]], unknown: Option<&str>) -> Answer {
        Answer {
            named: named
                .iter()
                .map(|class| class.iter().map(|id| (*id).to_owned()).collect())
                .collect(),
            unknown: unknown.map(str::to_owned),
            proven: unknown.is_some(),
            ..Answer::default()
        }
    }

    #[test]
    fn an_effect_or_its_class_is_right_and_one_more_is_wrong() {
        let case = case(Group::Named, &[EffectKind::Cogging]);
        for (named, unknown, judgement) in [
            (&[&["cogging"][..]][..], None, Judgement::Right),
            (&[&["spring", "cogging"]], None, Judgement::Right),
            (&[&["cogging"], &["spring"]], None, Judgement::Wrong),
            (&[&["spring"]], None, Judgement::Wrong),
            (&[], None, Judgement::Abstained),
            (&[], Some("position"), Judgement::Abstained),
        ] {
            assert_eq!(
                judge(&case, &answer(named, unknown)),
                judgement,
                "{named:?}"
            );
        }
    }

    #[test]
    fn half_of_two_is_too_little() {
        let case = case(Group::Two, &[EffectKind::Cogging, EffectKind::Spring]);
        for (named, judgement) in [
            (&[&["cogging"][..], &["spring"]][..], Judgement::Right),
            (&[&["cogging"]], Judgement::Abstained),
            (&[&["cogging"], &["stribeck"]], Judgement::Wrong),
            // One class twice does not say both.
            (
                &[&["cogging"], &["cogging", "gravity"]],
                Judgement::Abstained,
            ),
        ] {
            assert_eq!(judge(&case, &answer(named, None)), judgement, "{named:?}");
        }
    }

    #[test]
    fn a_right_number_that_is_called_wrong_is_wrong() {
        let mut case = case(Group::WrongNumbers, &[]);
        let mut declared = case.rig.clone();
        declared.inertia *= 1.2;
        case.declared = Some(declared);
        for (number, judgement) in [("inertia", Judgement::Right), ("viscous", Judgement::Wrong)] {
            let freed = Answer {
                freed: vec![number.to_owned()],
                ..answer(&[], None)
            };
            assert_eq!(judge(&case, &freed), judgement, "{number}");
        }
    }

    #[test]
    fn a_name_where_there_is_none_is_wrong() {
        let outside = case(Group::Outside, &[EffectKind::RoughSpot]);
        assert_eq!(
            judge(&outside, &answer(&[], Some("position"))),
            Judgement::Right
        );
        assert_eq!(
            judge(&outside, &answer(&[], Some("velocity"))),
            Judgement::Wrong
        );
        let unproven = Answer {
            proven: false,
            ..answer(&[], Some("velocity"))
        };
        assert_eq!(judge(&outside, &unproven), Judgement::Abstained);
        assert_eq!(judge(&outside, &answer(&[], None)), Judgement::Abstained);
        assert_eq!(
            judge(&outside, &answer(&[&["cogging"]], None)),
            Judgement::Wrong
        );
        for group in [Group::Clean, Group::WrongNumbers] {
            let clean = case(group, &[]);
            assert_eq!(judge(&clean, &answer(&[], None)), Judgement::Right);
            assert_eq!(judge(&clean, &answer(&[], Some("time"))), Judgement::Wrong);
            assert_eq!(
                judge(&clean, &answer(&[&["spring"]], None)),
                Judgement::Wrong
            );
        }
    }

    #[test]
    fn a_fair_name_is_right_and_a_tolerated_one_says_nothing() {
        let truth = Truth {
            group: Group::Outside,
            ids: vec!["(warm_up)".to_owned()],
            carriers: vec!["time"],
            fair: vec!["friction_drift"],
            other_law: Vec::new(),
            tolerated: vec!["sensor_delay"],
            wrong_numbers: Vec::new(),
            outside_fit: false,
        };
        for (named, unknown, judgement) in [
            (&[&["friction_drift"][..]][..], None, Judgement::Right),
            (
                &[&["friction_drift"], &["sensor_delay"]],
                None,
                Judgement::Right,
            ),
            (&[&["sensor_delay"]], None, Judgement::Abstained),
            (&[&["friction_drift"], &["spring"]], None, Judgement::Wrong),
            (&[], Some("time"), Judgement::Right),
        ] {
            assert_eq!(
                super::judge(&truth, &answer(named, unknown)),
                judgement,
                "{named:?}"
            );
        }
    }

    /// An effect is a mechanism over a variable: a spring that stiffens is a spring whose law was learned, and no straight one.
    #[test]
    fn another_law_of_an_effect_is_right_where_it_was_learned() {
        let truth = Truth {
            group: Group::Outside,
            ids: vec!["(cubic_spring)".to_owned()],
            carriers: vec!["position"],
            fair: Vec::new(),
            other_law: vec!["spring"],
            tolerated: Vec::new(),
            wrong_numbers: Vec::new(),
            outside_fit: false,
        };
        for (named, learned, judgement) in [
            (&[&["spring"][..]][..], &["spring"][..], Judgement::Right),
            (&[&["spring"]], &[], Judgement::Wrong),
            (&[&["gravity"]], &["gravity"], Judgement::Wrong),
            (&[&["spring"], &["stribeck"]], &["spring"], Judgement::Wrong),
        ] {
            let answer = Answer {
                learned: learned.iter().map(|id| (*id).to_owned()).collect(),
                ..answer(named, None)
            };
            assert_eq!(super::judge(&truth, &answer), judgement, "{named:?}");
        }
    }

    #[test]
    fn that_log_and_machine_disagree_is_right_of_a_wrong_number_alone() {
        let disagrees = Answer {
            disagrees: true,
            ..answer(&[], None)
        };
        let clean = case(Group::Clean, &[]);
        let wrong = case(Group::WrongNumbers, &[]);
        assert_eq!(judge(&clean, &disagrees), Judgement::Wrong);
        assert_eq!(judge(&wrong, &disagrees), Judgement::Right);
        let nothing = Answer {
            nothing_proven: true,
            ..answer(&[], None)
        };
        assert_eq!(judge(&clean, &nothing), Judgement::Abstained);
        assert_eq!(judge(&wrong, &nothing), Judgement::Right);
    }

    #[test]
    fn a_wrong_number_outside_fit_may_be_freed_or_named_or_left_unknown() {
        let truth = Truth {
            group: Group::WrongNumbers,
            ids: Vec::new(),
            carriers: Vec::new(),
            fair: vec!["spring"],
            other_law: Vec::new(),
            tolerated: Vec::new(),
            wrong_numbers: vec!["spring".to_owned()],
            outside_fit: true,
        };
        for (named, unknown, judgement) in [
            (&[][..], None, Judgement::Right),
            (&[&["spring"][..]], None, Judgement::Right),
            (&[&["spring"], &["cogging"]], None, Judgement::Wrong),
            (&[&["cogging"]], None, Judgement::Wrong),
            (&[], Some("position"), Judgement::Abstained),
        ] {
            assert_eq!(
                super::judge(&truth, &answer(named, unknown)),
                judgement,
                "{named:?}"
            );
        }
    }
}
