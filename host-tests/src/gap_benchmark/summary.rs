//! What the answers come to: rates, confusion, calibration.

use serde::Serialize;

use super::Traced;
use super::cases::{Group, Motion, STRENGTHS, label};
use super::judgement::{Answer, Judgement};
use crate::cells::{self, Cells};
use crate::reproduce::prognostics::statistics::quantile;

/// Where an answer names nothing.
pub(super) const NOTHING: &str = "nothing";
/// Where it names a variable.
pub(super) const UNKNOWN: &str = "unknown effect";
/// What an answer says that calls right numbers wrong.
const NUMBERS: &str = "wrong numbers";
/// What is behind a log whose machine file has wrong numbers.
const WRONG_NUMBERS: &str = "no effect, wrong numbers";

/// Standard deviations that hold 95 % of a normal population.
const HOLDS_95: f64 = 1.96;

/// Errors that p-values are held against.
const LEVELS: [f64; 2] = [0.05, 0.01];

/// Shares of a group's answers.
#[derive(Debug, Clone, Serialize)]
pub struct Rates {
    /// Which logs.
    pub of: String,
    /// How many.
    pub logs: usize,
    /// Share that is right.
    pub right: f64,
    /// Share that says too little.
    pub abstained: f64,
    /// Share that is wrong.
    pub wrong: f64,
    /// The regression's share that is right.
    pub stepwise_right: f64,
    /// The regression's share that is wrong.
    pub stepwise_wrong: f64,
}

/// How often the answers on logs of one kind were what.
#[derive(Debug, Clone, Serialize)]
pub struct Confusion {
    /// What there is, then the strength.
    pub truths: Vec<String>,
    /// What was said.
    pub answers: Vec<String>,
    /// Logs, a row a truth.
    pub counts: Vec<Vec<usize>>,
}

/// Everything that the tables show.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    /// By groups.
    pub groups: Vec<Rates>,
    /// By effects and strengths.
    pub effects: Vec<Rates>,
    /// By machines, single effects at both strengths.
    pub machines: Vec<Rates>,
    /// By other motions, of which all else here knows nothing.
    pub motions: Vec<Rates>,
    /// Truth against answer.
    pub confusion: Confusion,
    /// Windowed position error after over before where an effect at nominal strength was found: median.
    pub after_over_before: f64,
    /// The same over that of a fit that was told the truth, of right answers that name an effect: median
    /// and 90 %.
    pub after_over_oracle: [f64; 2],
    /// The same of answers that say too little.
    pub abstained_over_oracle: [f64; 2],
    /// Share of true numbers within the 95 % interval of right answers.
    pub coverage: f64,
    /// How many numbers that are.
    pub numbers: usize,
    /// The same share on other motions, and of how many numbers.
    pub coverage_on_others: f64,
    /// How many these are.
    pub numbers_on_others: usize,
    /// Candidates that were refitted on logs without an effect, whatever the motion.
    pub chances: usize,
    /// Share of these with a p-value below each of [`LEVELS`]: at most the level, if p is honest.
    pub below: [f64; 2],
    /// Wall-clock seconds of a tracing beside another one: median and longest.
    pub seconds: [f64; 2],
}

impl Summary {
    pub(super) fn of(all: &[Traced]) -> Self {
        let (traced, others): (Vec<Traced>, Vec<Traced>) = all
            .iter()
            .cloned()
            .partition(|traced| traced.case.motion == Motion::Sines);
        let traced = &traced[..];
        let (coverage, numbers) = coverage_of(traced);
        let (coverage_on_others, numbers_on_others) = coverage_of(&others);
        let single = |traced: &Traced| traced.case.group == Group::Named;
        let mut effects = Vec::new();
        for kind in rig::EffectKind::ALL {
            for strength in STRENGTHS {
                let of = |traced: &Traced| {
                    single(traced)
                        && traced.case.effects[0].kind() == kind
                        && traced.case.strength == strength
                };
                effects.extend(rates(format!("{} × {strength}", label(kind)), traced, of));
            }
        }
        let machines = super::cases::machines();
        let machines = machines.iter().filter_map(|machine| {
            let of = |traced: &Traced| single(traced) && traced.case.rig.name == machine.name;
            rates(machine.name.to_owned(), traced, of)
        });
        let found: Vec<f64> = traced
            .iter()
            .filter(|traced| single(traced) && traced.case.strength == 1.0)
            .filter_map(|traced| traced.after_over_before)
            .collect();
        let over_oracle = |judgement: Judgement| {
            let of =
                |traced: &&Traced| traced.judgement == judgement && !traced.case.effects.is_empty();
            let ratios = traced.iter().filter(of);
            let ratios: Vec<f64> = ratios.filter_map(|it| it.after_over_oracle).collect();
            [quantile(&ratios, 0.5), quantile(&ratios, 0.9)]
        };
        let chances: Vec<f64> = all
            .iter()
            .flat_map(|traced| traced.chances.iter().copied())
            .collect();
        let below = LEVELS.map(|level| {
            let below = chances.iter().filter(|p| **p < level).count();
            below as f64 / chances.len() as f64
        });
        let seconds: Vec<f64> = all.iter().map(|traced| traced.seconds).collect();
        Self {
            groups: groups(traced),
            effects,
            machines: machines.collect(),
            motions: motions(&others),
            confusion: confusion(traced),
            after_over_before: quantile(&found, 0.5),
            after_over_oracle: over_oracle(Judgement::Right),
            abstained_over_oracle: over_oracle(Judgement::Abstained),
            coverage,
            numbers,
            coverage_on_others,
            numbers_on_others,
            chances: chances.len(),
            below,
            seconds: [quantile(&seconds, 0.5), quantile(&seconds, 1.0)],
        }
    }

    pub(super) fn text(&self) -> String {
        let mut text = cells::render(&rate_cells("", &self.groups));
        text.push('\n');
        text += &cells::render(&rate_cells("one effect", &self.effects));
        text.push('\n');
        text += &cells::render(&rate_cells("one effect", &self.machines));
        text.push('\n');
        text += &cells::render(&rate_cells("other motions", &self.motions));
        text.push('\n');
        text += &cells::render(&self.figure_cells());
        text
    }

    pub(super) fn figure_cells(&self) -> Cells {
        let line = |what: &str, value: String| vec![what.to_owned(), value];
        let over_oracle = |[median, most]: [f64; 2]| format!("{median:.3} ({most:.2})");
        let [median, longest] = self.seconds;
        vec![
            line("", "measured".to_owned()),
            line(
                "position error after / before, nominal strength, median",
                format!("{:.3}", self.after_over_before),
            ),
            line(
                "position error after / with the true effect, right answers, median (90 %)",
                over_oracle(self.after_over_oracle),
            ),
            line(
                "the same, abstentions",
                over_oracle(self.abstained_over_oracle),
            ),
            line(
                &format!("of {} true numbers, in their 95 % interval", self.numbers),
                per_cent(self.coverage),
            ),
            line(
                &format!(
                    "of {} on other motions, in their 95 % interval",
                    self.numbers_on_others
                ),
                per_cent(self.coverage_on_others),
            ),
            line(
                &format!(
                    "of {} refits on logs without an effect, p below {} ({})",
                    self.chances, LEVELS[0], LEVELS[1]
                ),
                format!("{} ({})", per_cent(self.below[0]), per_cent(self.below[1])),
            ),
            line(
                "a log of 12,000 samples beside another, median (longest)",
                format!("{median:.2} s ({longest:.1} s)"),
            ),
        ]
    }
}

fn per_cent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

pub(super) fn rate_cells(name: &str, rates: &[Rates]) -> Cells {
    let mut rows = vec![cells::row([
        name,
        "logs",
        "right",
        "too little",
        "wrong",
        "stepwise: right",
        "wrong",
    ])];
    rows.extend(rates.iter().map(|rates| {
        vec![
            rates.of.clone(),
            rates.logs.to_string(),
            per_cent(rates.right),
            per_cent(rates.abstained),
            per_cent(rates.wrong),
            per_cent(rates.stepwise_right),
            per_cent(rates.stepwise_wrong),
        ]
    }));
    rows
}

/// Share of true numbers in their 95 % interval, and how many there are.
fn coverage_of(traced: &[Traced]) -> (f64, usize) {
    let deviations = || traced.iter().flat_map(|traced| &traced.deviations);
    let held = deviations().filter(|it| it.deviation.abs() <= HOLDS_95);
    let numbers = deviations().count();
    (held.count() as f64 / numbers as f64, numbers)
}

fn motions(traced: &[Traced]) -> Vec<Rates> {
    let kinds = [(Group::Named, "one effect"), (Group::Clean, "no effect")];
    let rows = Motion::OTHERS.iter().flat_map(|motion| {
        kinds.iter().filter_map(move |(group, name)| {
            let of = |traced: &Traced| traced.case.motion == *motion && traced.case.group == *group;
            rates(format!("{name}, {}", motion.name()), traced, of)
        })
    });
    rows.collect()
}

fn groups(traced: &[Traced]) -> Vec<Rates> {
    let group = |group: Group| move |traced: &Traced| traced.case.group == group;
    let strength = |strength: f64| {
        move |traced: &Traced| traced.case.group == Group::Named && traced.case.strength == strength
    };
    [
        rates("one effect, nominal".into(), traced, strength(STRENGTHS[0])),
        rates(
            format!("one effect, {} of it", STRENGTHS[1]),
            traced,
            strength(STRENGTHS[1]),
        ),
        rates("two effects".into(), traced, group(Group::Two)),
        rates(
            "none of the catalogue's".into(),
            traced,
            group(Group::Outside),
        ),
        rates("no effect".into(), traced, group(Group::Clean)),
        rates(
            "wrong numbers only".into(),
            traced,
            group(Group::WrongNumbers),
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn rates(of: String, traced: &[Traced], chosen: impl Fn(&Traced) -> bool) -> Option<Rates> {
    let chosen: Vec<&Traced> = traced.iter().filter(|traced| chosen(traced)).collect();
    if chosen.is_empty() {
        return None;
    }
    let share = |of: fn(&Traced) -> Judgement, judgement: Judgement| {
        let count = chosen
            .iter()
            .filter(|traced| of(traced) == judgement)
            .count();
        count as f64 / chosen.len() as f64
    };
    let ours: fn(&Traced) -> Judgement = |traced| traced.judgement;
    let theirs: fn(&Traced) -> Judgement = |traced| traced.stepwise_judgement;
    Some(Rates {
        of,
        logs: chosen.len(),
        right: share(ours, Judgement::Right),
        abstained: share(ours, Judgement::Abstained),
        wrong: share(ours, Judgement::Wrong),
        stepwise_right: share(theirs, Judgement::Right),
        stepwise_wrong: share(theirs, Judgement::Wrong),
    })
}

/// What an answer says in one word, in favour of the truth where a class holds it.
fn word(answer: &Answer, truth: &str) -> String {
    let foreign = answer
        .named
        .iter()
        .find(|class| !class.iter().any(|id| id == truth));
    match (foreign, answer.named.is_empty(), &answer.unknown) {
        (Some(class), _, _) => class[0].clone(),
        // Of a machine file that is right.
        _ if !answer.freed.is_empty() && truth != WRONG_NUMBERS => NUMBERS.to_owned(),
        (None, _, Some(_)) => UNKNOWN.to_owned(),
        (None, false, None) => truth.to_owned(),
        (None, true, None) => NOTHING.to_owned(),
    }
}

/// Logs with one effect or none; what is not in the catalogue is right as unknown.
fn confusion(traced: &[Traced]) -> Confusion {
    let single: Vec<(String, String)> = traced
        .iter()
        .filter(|traced| traced.case.group != Group::Two)
        .map(|traced| {
            let truth = match traced.case.effects.first() {
                Some(effect) => label(effect.kind()),
                None if traced.case.group == Group::Clean => "no effect".to_owned(),
                None => WRONG_NUMBERS.to_owned(),
            };
            let word = word(&traced.answer, &truth);
            (truth, word)
        })
        .collect();
    let mut truths: Vec<String> = Vec::new();
    for (truth, _) in &single {
        if !truths.contains(truth) {
            truths.push(truth.clone());
        }
    }
    let catalogued = |name: &String| model_core::effect::Id::from_id(name).is_some();
    truths.sort_by_key(|truth| !catalogued(truth));
    let mut answers: Vec<String> = truths
        .iter()
        .filter(|name| catalogued(name))
        .cloned()
        .collect();
    for (_, answer) in &single {
        if catalogued(answer) && !answers.contains(answer) {
            answers.push(answer.clone());
        }
    }
    answers.extend([UNKNOWN, NUMBERS, NOTHING].map(str::to_owned));
    let counts = truths
        .iter()
        .map(|truth| {
            let count = |answer: &String| {
                let same = |(t, a): &&(String, String)| t == truth && a == answer;
                single.iter().filter(same).count()
            };
            answers.iter().map(count).collect()
        })
        .collect();
    Confusion {
        truths,
        answers,
        counts,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap_benchmark::Deviation;
    use crate::gap_benchmark::cases::Case;
    use rig::{Effect, EffectKind};

    /// A log of a rotary actuator with a cogging of a strength, or without one, and what was made of it.
    fn traced(strength: Option<f64>, judgement: Judgement, deviations: &[f64]) -> Traced {
        let rig = rig::Machine::rotary_ema();
        let cogging = |strength| Effect::nominal(EffectKind::Cogging, &rig).scaled(strength);
        let named = match judgement {
            Judgement::Right if strength.is_some() => vec![vec!["cogging".to_owned()]],
            Judgement::Wrong => vec![vec!["spring".to_owned()]],
            _ => Vec::new(),
        };
        let answer = Answer {
            named,
            freed: Vec::new(),
            ..Answer::default()
        };
        let deviation = |deviation: &f64| Deviation {
            name: "amplitude".to_owned(),
            deviation: *deviation,
            relative: 0.01,
        };
        Traced {
            case: Case {
                group: strength.map_or(Group::Clean, |_| Group::Named),
                declared: None,
                effects: strength.map(cogging).into_iter().collect(),
                rig,
                strength: strength.unwrap_or(1.0),
                motion: Motion::Sines,
                seed: 1,
            },
            stepwise: answer.clone(),
            stepwise_judgement: Judgement::Wrong,
            after_over_before: (!answer.named.is_empty()).then_some(0.2),
            after_over_oracle: Some(match judgement {
                Judgement::Right => 1.0,
                _ => 4.0,
            }),
            answer,
            judgement,
            deviations: deviations.iter().map(deviation).collect(),
            chances: Vec::new(),
            seconds: 1.0,
        }
    }

    #[test]
    fn a_rate_is_that_of_its_own_logs() {
        let nominal = STRENGTHS[0];
        let all = [
            traced(Some(nominal), Judgement::Right, &[0.3, -1.9]),
            traced(Some(nominal), Judgement::Right, &[2.5]),
            traced(Some(nominal), Judgement::Abstained, &[]),
            traced(Some(nominal), Judgement::Wrong, &[]),
            traced(Some(STRENGTHS[1]), Judgement::Abstained, &[]),
            // Nothing there and nothing found is no answer that knows the truth as well as its oracle.
            Traced {
                after_over_oracle: Some(9.0),
                ..traced(None, Judgement::Right, &[-0.1])
            },
        ];
        let summary = Summary::of(&all);
        let nominal = &summary.groups[0];
        assert_eq!((nominal.logs, nominal.right), (4, 0.5));
        assert_eq!((nominal.abstained, nominal.wrong), (0.25, 0.25));
        assert_eq!(summary.groups[1].abstained, 1.0);
        assert_eq!((summary.coverage, summary.numbers), (0.75, 4));
        assert_eq!(summary.after_over_oracle, [1.0; 2]);
        assert_eq!(summary.abstained_over_oracle, [4.0; 2]);
        let cogging = summary.effects.iter().find(|of| of.of == "cogging × 1");
        assert_eq!(cogging.unwrap().stepwise_wrong, 1.0);
    }
}
