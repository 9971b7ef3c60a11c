//! From candidates to a verdict: refit on one half of the log, judge on the other.
//!
//! A round screens every effect, refits the best of them together with the base on every second
//! block of the training log and measures the error on the blocks between; then the other way
//! round. The effect that lowers the held-out error most is taken, if the gain is significant,
//! large enough and common to most blocks; then the next round starts from the model with it.

use super::fit::{self, Effort, Fit, Variables};
use super::model::{Base, Model};
use super::replay::{self, Data, Fold, MARGIN, Schedule, WindowError};
use super::screen::{self, Candidate, MOST_CANDIDATES, Screening};
use crate::effect::learned_map::{Kind, LearnedMap, Ranges};
use crate::effect::{Id, Scope};
use crate::numeric::statistics::median;
use crate::numeric::wilcoxon::signed_rank;
use heapless::Vec;

/// Most blocks that held-out errors are kept for.
pub const MOST_BLOCKS: usize = 512;

/// Rounds of the selection: most effects that one run adds.
pub const ROUNDS: usize = 4;

/// Candidates refitted in a round.
const SHORTLIST: usize = 8;

/// A candidate under this score is not refitted.
const LEAST_SCORE: f32 = 0.01;

/// A candidate under this identifiability is absorbed by the base.
const LEAST_IDENTIFIABILITY: f32 = 0.05;

/// Cosine beyond which a log cannot tell two effects apart.
const EQUIVALENT: f32 = 0.9;

/// Cosine beyond which two effects are the same model and only one is refitted.
const IDENTICAL: f32 = 0.9995;

/// An effect whose held-out error is beyond this multiple of the accepted one's is told from it,
/// however alike the two sensitivities are.
const TOLD_APART: f64 = 1.5;

/// Candidates whose held-out errors are within this ratio of the best one's are equally good: the
/// one with the fewest parameters is taken.
const EQUALLY_GOOD: f64 = 1.1;

/// Error of the whole test, shared among the candidates of a round and, for each, among the shapes
/// that were tried for it.
const SIGNIFICANCE: f64 = 0.01;

/// Held-out mean square error that an accepted effect must fall below, as a share of that without.
const LARGEST_RATIO: f64 = 0.9;

/// Least median over blocks of the logarithm of the two errors' ratio.
const LEAST_MEDIAN: f32 = 0.05;

/// Effects that leave more than this share of the held-out error are challenged by learned maps.
const POOR_EXPLANATION: f64 = 0.3;

/// A map that brings the held-out error below this share of what the effects leave replaces them:
/// the catalogue's best guess is then not what the machine has.
const CLEARLY_BETTER: f64 = 0.5;

/// Steps of a full fit and of one inside cross-validation.
const FULL: Effort = Effort { steps: 20 };
const HALF: Effort = Effort { steps: 12 };

/// What a round decided about one effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decision {
    /// Best of those that passed.
    Accepted,
    /// Passed, but another one explains the residual better.
    Outdone {
        /// The one that was taken.
        by: Id,
    },
    /// Passed, but a map over another variable explains the residual better.
    OutdoneByMap {
        /// The one that was taken.
        by: Kind,
    },
    /// The same model as another candidate for this log.
    SameAs {
        /// That other candidate.
        other: Id,
    },
    /// Its sensitivity is a combination of the base's.
    Absorbed,
    /// Physics forbids the sign that the residual asks for.
    WrongSign,
    /// Explains too little of the residual to be refitted.
    ScoreTooLow,
    /// Eight others score higher.
    NotShortlisted,
    /// The held-out gain is not significant.
    NotSignificant,
    /// The held-out error falls too little.
    GainTooSmall,
    /// The held-out gain comes from few blocks.
    GainNotCommon,
    /// Was taken in an earlier round and is not needed beside the later ones.
    Dropped,
}

/// What a look is at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Subject {
    /// An effect of the catalogue.
    Effect(Id),
    /// A learned map.
    Map(Kind),
}

/// One look at one effect, or at one learned map, in one round.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Consideration {
    /// Round, from 1.
    pub round: usize,
    /// The effect or the map.
    pub subject: Subject,
    /// As in [`Candidate`]. For a map: the share that all its knots explain together.
    pub score: f32,
    /// As in [`Candidate`]; 1 for a map, whose knots overlap with the base by their nature.
    pub identifiability: f32,
    /// Held-out mean square error with the effect over that without, if it was refitted.
    pub held_out: Option<Comparison>,
    /// What was decided.
    pub decision: Decision,
}

/// Two models compared on held-out blocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// Mean square error of the larger model over that of the smaller, product over the channels.
    pub ratio: f64,
    /// One-sided Wilcoxon p that the larger model is better.
    pub p_value: f64,
    /// Median over blocks of the logarithm of the smaller model's error over the larger one's.
    pub median: f32,
}

impl Comparison {
    fn judge(&self, looks: usize) -> Option<Decision> {
        if self.p_value >= SIGNIFICANCE / looks.max(1) as f64 {
            Some(Decision::NotSignificant)
        } else if self.ratio > LARGEST_RATIO {
            Some(Decision::GainTooSmall)
        } else if self.median < LEAST_MEDIAN {
            Some(Decision::GainNotCommon)
        } else {
            None
        }
    }
}

/// An accepted effect.
#[derive(Debug, Clone)]
pub struct Accepted {
    /// Which, with score and identifiability from the screening of the round that took it.
    pub candidate: Candidate,
    /// From the held-out blocks.
    pub p_value: f64,
    /// Effects that this log cannot tell from it.
    pub equivalent: Vec<Id, MOST_CANDIDATES>,
}

/// Structure that no effect of the catalogue explains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unknown {
    /// The map that explains it best; the final model has it.
    pub kind: Kind,
    /// Share of the residual's energy that it explains once the base is projected out, 0 to 1.
    pub score: f32,
}

/// The result of the tracing.
#[derive(Debug, Clone)]
pub struct Trace {
    /// The base fit.
    pub before: Fit,
    /// The final fit: the base fit again where nothing was found.
    pub after: Fit,
    /// Variables of the final fit.
    pub variables: Variables,
    /// What was accepted, in the order of the final model's effects behind the declared ones.
    pub accepted: Vec<Accepted, ROUNDS>,
    /// Structure that none of the catalogue explains, where nothing was accepted.
    pub unknown: Option<Unknown>,
    /// How the log was cut and weighed in the end.
    pub settings: replay::Settings,
    /// Windows of the judging length simulated.
    pub simulated: u64,
}

/// How the tracing runs.
#[derive(Debug, Clone, Copy)]
pub struct Options<'a> {
    /// Parameters of the declared actuator that may be re-estimated.
    pub base: &'a [Base],
    /// Sizes to scale by.
    pub scope: Scope,
    /// Ranges to lay learned maps over.
    pub ranges: Ranges,
    /// Samples in a window for screening.
    pub screen_window: usize,
    /// Samples that a block of held-out windows should have.
    pub block: usize,
}

/// Held-out errors by block and channel.
struct HeldOut {
    blocks: Vec<WindowError, MOST_BLOCKS>,
}

/// Windows in a block: about as long as asked, at least two dozen blocks where the log allows it.
fn windows_per_block(data: &Data, samples: usize) -> usize {
    let windows = data.windows();
    let asked = (samples as f32 / data.settings.window as f32 + 0.5) as usize;
    asked
        .min(windows / 24)
        .max(windows.div_ceil(MOST_BLOCKS))
        .max(1)
}

/// Fits on each half and measures on the other.
fn cross_validate(
    data: &Data,
    schedule: &impl Schedule,
    block: usize,
    model: &Model,
    variables: &Variables,
    simulated: &mut u64,
) -> Option<HeldOut> {
    let period = data.logs.first()?.period;
    let mut blocks: Vec<WindowError, MOST_BLOCKS> = Vec::new();
    let _ = blocks.resize(
        data.windows().div_ceil(block).min(MOST_BLOCKS),
        WindowError::default(),
    );
    for (train, test) in [(Fold::Even, Fold::Odd), (Fold::Odd, Fold::Even)] {
        let fit = fit::fit(data, schedule, (train, block), model, variables, HALF)?;
        *simulated += fit.simulated;
        let simulator = fit.model.build(period).ok()?;
        schedule.run(
            data.windows(),
            |number| {
                let window = data.window(number).filter(|_| test.takes(number / block))?;
                Some(replay::window_error(data, window, &simulator))
            },
            |number, error| {
                let Some(error) = error else { return };
                *simulated += 1;
                if let Some(sum) = blocks.get_mut(number / block) {
                    sum.position += error.position;
                    sum.current += error.current;
                }
            },
        );
    }
    Some(HeldOut { blocks })
}

/// Compares two models block by block. The channels' logarithms add: each has its own, unknown
/// noise, and a channel that is mere noise does not hide a gain in the other.
fn compare(smaller: &HeldOut, larger: &HeldOut) -> Comparison {
    let mut differences: Vec<f32, MOST_BLOCKS> = Vec::new();
    let mut totals = [WindowError::default(); 2];
    for (before, after) in smaller.blocks.iter().zip(&larger.blocks) {
        let gain = |before: f32, after: f32| {
            if before > 0.0 && after > 0.0 {
                libm::logf(before / after)
            } else {
                0.0
            }
        };
        let _ = differences
            .push(gain(before.position, after.position) + gain(before.current, after.current));
        for (total, error) in totals.iter_mut().zip([before, after]) {
            total.position += error.position;
            total.current += error.current;
        }
    }
    let ratio = |before: f32, after: f32| {
        if before > 0.0 {
            f64::from(after) / f64::from(before)
        } else {
            1.0
        }
    };
    let p_value = signed_rank(&mut differences).map_or(1.0, |test| test.p_value);
    Comparison {
        ratio: ratio(totals[0].position, totals[1].position)
            * ratio(totals[0].current, totals[1].current),
        p_value,
        median: median(&mut differences).unwrap_or(0.0),
    }
}

/// Root mean squares of the two channels' residuals over all windows.
pub fn residual_scales(data: &Data, schedule: &impl Schedule, model: &Model) -> Option<(f64, f64)> {
    let simulator = model.build(data.logs.first()?.period).ok()?;
    let (mut position, mut current, mut windows) = (0.0f64, 0.0f64, 0usize);
    schedule.run(
        data.windows(),
        |number| {
            data.window(number)
                .map(|window| replay::window_error(data, window, &simulator))
        },
        |_, error| {
            if let Some(error) = error {
                position += f64::from(error.position);
                current += f64::from(error.current);
                windows += 1;
            }
        },
    );
    let samples = (windows * data.settings.window).max(1) as f64;
    Some((
        libm::sqrt(position / samples),
        libm::sqrt(current / samples),
    ))
}

/// Half widths of the smoothing that are tried.
const HALF_WIDTHS: [usize; 7] = [2, 3, 4, 6, 8, 12, MARGIN];

/// The data with replays that restart from the state that short replays of the model follow best: a
/// quiet sensor wants little smoothing, a coarse one much.
fn restarted<'a>(
    data: &Data<'a>,
    schedule: &impl Schedule,
    model: &Model,
    window: usize,
) -> Option<Data<'a>> {
    let measured = data.logs.iter().all(|log| log.velocity.is_some());
    let mut best: Option<(Data<'a>, f64)> = None;
    for measured_velocity in [false, true] {
        for half_width in HALF_WIDTHS {
            if measured_velocity && !measured {
                continue;
            }
            let mut tried = *data;
            tried.settings.half_width = half_width;
            tried.settings.measured_velocity = measured_velocity;
            let (error, _) = residual_scales(&tried.with_window(window), schedule, model)?;
            if best.is_none_or(|(_, least)| error < least) {
                best = Some((tried, error));
            }
        }
    }
    best.map(|(data, _)| data)
}

/// The data with each channel weighed by one over its residual, but not finer than the sensor.
fn weighed<'a>(data: &Data<'a>, schedule: &impl Schedule, model: &Model) -> Option<Data<'a>> {
    let (position, current) = residual_scales(data, schedule, model)?;
    let floor = f64::from(0.3 * data.settings.resolution).max(1e-9);
    let mut weighed = *data;
    weighed.settings.position_weight = (1.0 / position.max(floor)) as f32;
    weighed.settings.current_weight = if current > 0.0 {
        (1.0 / current) as f32
    } else {
        0.0
    };
    Some(weighed)
}

/// Traces the gap between `model` and the logs of `data`. `observe` is told of every look at every
/// candidate, round by round.
///
/// `None` if the model cannot be built or there is no whole window.
pub fn trace(
    data: &Data,
    schedule: &impl Schedule,
    model: &Model,
    options: &Options,
    mut observe: impl FnMut(&Consideration),
) -> Option<Trace> {
    if data.windows() == 0 {
        return None;
    }
    let scope = &options.scope;
    let mut simulated = 0;

    // Short windows first: far from the truth, they are the smoother problem.
    let variables = fit::variables(model, model, options.base, scope);
    let mut fitted = model.clone();
    let mut data = *data;
    for window in [
        options.screen_window,
        data.settings.window,
        data.settings.window,
    ] {
        data = weighed(&data.with_window(window), schedule, &fitted)?;
        let fit = fit::fit(&data, schedule, (Fold::All, 1), &fitted, &variables, FULL)?;
        simulated += fit.simulated;
        fitted = fit.model;
    }
    data = restarted(&data, schedule, &fitted, options.screen_window)?;
    data = weighed(&data, schedule, &fitted)?;
    let mut before = fit::fit(&data, schedule, (Fold::All, 1), &fitted, &variables, FULL)?;
    simulated += before.simulated;

    let block = windows_per_block(&data, options.block);
    let mut after = before.clone();
    let mut variables = variables;
    let mut accepted: Vec<Accepted, ROUNDS> = Vec::new();
    for round in 1..=ROUNDS {
        let screening = data.with_window(options.screen_window);
        let screened = screen::screen(&screening, schedule, &after.model, &variables, scope)?;
        simulated +=
            screened.simulated * options.screen_window as u64 / data.settings.window as u64;
        let judgement = consider(
            &Round {
                data: &data,
                declared: model,
                fit: &after,
                variables: &variables,
                options,
                block,
            },
            schedule,
            &screened,
            &mut simulated,
        )?;
        for look in &judgement.looks {
            observe(&Consideration { round, ..*look });
        }
        let Some(winner) = judgement.winner else {
            break;
        };
        let Some(larger) = screen::with_effect(&after.model, winner.candidate.effect) else {
            break;
        };
        variables = fit::variables(model, &larger, options.base, scope);
        after = fit::fit(&data, schedule, (Fold::All, 1), &larger, &variables, FULL)?;
        simulated += after.simulated;
        let _ = accepted.push(winner);
        data = restarted(&data, schedule, &after.model, options.screen_window)?;
        data = weighed(&data, schedule, &after.model)?;
        after = fit::fit(
            &data,
            schedule,
            (Fold::All, 1),
            &after.model,
            &variables,
            FULL,
        )?;
        simulated += after.simulated;
    }
    if !accepted.is_empty() {
        // Both models are judged on the same restarts, so the first is fitted to these too.
        let base = fit::variables(model, &before.model, options.base, scope);
        before = fit::fit(&data, schedule, (Fold::All, 1), &before.model, &base, FULL)?;
        simulated += before.simulated;
    }
    // An effect taken early may have stood in for what a later one explains.
    let mut slot = 0;
    while accepted.len() > 1 && slot < accepted.len() {
        let mut smaller = after.model.clone();
        smaller.effects.remove(model.effects.len() + slot);
        let fewer = fit::variables(model, &smaller, options.base, scope);
        let without = cross_validate(&data, schedule, block, &smaller, &fewer, &mut simulated)?;
        let with = cross_validate(
            &data,
            schedule,
            block,
            &after.model,
            &variables,
            &mut simulated,
        )?;
        if compare(&without, &with).judge(1).is_none() {
            slot += 1;
            continue;
        }
        let dropped = accepted.remove(slot);
        variables = fewer;
        after = fit::fit(&data, schedule, (Fold::All, 1), &smaller, &variables, FULL)?;
        simulated += after.simulated;
        observe(&Consideration {
            round: accepted.len() + 1,
            subject: Subject::Effect(dropped.candidate.effect.id),
            score: dropped.candidate.score,
            identifiability: dropped.candidate.identifiability,
            held_out: None,
            decision: Decision::Dropped,
        });
    }

    // Does anything lie under it that the catalogue does not have?
    let mut unknown = None;
    let left = if accepted.is_empty() {
        1.0
    } else {
        let base = fit::variables(model, &before.model, options.base, scope);
        let without = cross_validate(&data, schedule, block, &before.model, &base, &mut simulated)?;
        let with = cross_validate(
            &data,
            schedule,
            block,
            &after.model,
            &variables,
            &mut simulated,
        )?;
        compare(&without, &with).ratio
    };
    if left > POOR_EXPLANATION {
        let base = fit::variables(model, &before.model, options.base, scope);
        let round = Round {
            data: &data,
            declared: model,
            fit: &before,
            variables: &base,
            options,
            block,
        };
        let limit = if accepted.is_empty() {
            LARGEST_RATIO
        } else {
            left * CLEARLY_BETTER
        };
        let found = learn(&round, schedule, limit, &mut observe, &mut simulated)?;
        if let Some((larger, score)) = found {
            accepted.clear();
            variables = fit::variables(model, &larger, options.base, scope);
            after = fit::fit(&data, schedule, (Fold::All, 1), &larger, &variables, FULL)?;
            simulated += after.simulated;
            unknown = larger.map.map(|map| Unknown {
                kind: map.kind,
                score,
            });
        }
    }
    Some(Trace {
        before,
        after,
        variables,
        accepted,
        unknown,
        settings: data.settings,
        simulated,
    })
}

/// Where a round of the selection starts.
struct Round<'a> {
    data: &'a Data<'a>,
    declared: &'a Model,
    fit: &'a Fit,
    variables: &'a Variables,
    options: &'a Options<'a>,
    block: usize,
}

/// What a round decided.
struct Judgement {
    looks: Vec<Consideration, MOST_CANDIDATES>,
    winner: Option<Accepted>,
}

/// Judges the candidates of a round.
fn consider(
    round: &Round,
    schedule: &impl Schedule,
    screened: &Screening,
    simulated: &mut u64,
) -> Option<Judgement> {
    let fit = round.fit;
    let scope = &round.options.scope;
    let Screening {
        candidates,
        imitation,
        ..
    } = screened;
    let mut looks: Vec<Consideration, MOST_CANDIDATES> = candidates
        .iter()
        .map(|candidate| Consideration {
            round: 0,
            subject: Subject::Effect(candidate.effect.id),
            score: candidate.score,
            identifiability: candidate.identifiability,
            held_out: None,
            decision: if candidate.identifiability < LEAST_IDENTIFIABILITY {
                Decision::Absorbed
            } else if !candidate.allowed {
                Decision::WrongSign
            } else if candidate.score < LEAST_SCORE {
                Decision::ScoreTooLow
            } else {
                Decision::NotShortlisted
            },
        })
        .collect();
    let shortlist: Vec<usize, SHORTLIST> = (0..looks.len())
        .filter(|index| looks[*index].decision == Decision::NotShortlisted)
        .take(SHORTLIST)
        .collect();
    let smaller = held_out(round, schedule, &fit.model, round.variables, simulated)?;
    for &index in &shortlist {
        let own = candidates[index].effect;
        // Of effects that are one model here, the catalogue's first is refitted for all.
        let same = shortlist.iter().find(|&&other| {
            (candidates[other].effect.id as usize) < own.id as usize
                && imitation[index][other] > IDENTICAL
                && imitation[other][index] > IDENTICAL
        });
        if let Some(&other) = same {
            looks[index].decision = Decision::SameAs {
                other: candidates[other].effect.id,
            };
            continue;
        }
        let Some(larger) = screen::with_effect(&fit.model, own) else {
            break;
        };
        let more = fit::variables(round.declared, &larger, round.options.base, scope);
        let larger = held_out(round, schedule, &larger, &more, simulated)?;
        let comparison = compare(&smaller, &larger);
        looks[index].held_out = Some(comparison);
        // Passed is Accepted for now; who wins is known when all have been refitted.
        looks[index].decision = comparison
            .judge(candidates.len() * candidates[index].tries as usize)
            .unwrap_or(Decision::Accepted);
    }

    let passed = |index: usize| {
        looks[index]
            .held_out
            .filter(|_| looks[index].decision == Decision::Accepted)
    };
    let ratios = |index: &usize| passed(*index).map(|held_out| held_out.ratio);
    let Some(least) = shortlist.iter().filter_map(ratios).min_by(f64::total_cmp) else {
        return Some(Judgement {
            looks,
            winner: None,
        });
    };
    let parameters = |index: usize| candidates[index].effect.id.description().parameters.len();
    let (best, comparison) = shortlist
        .iter()
        .filter_map(|&index| passed(index).map(|held_out| (index, held_out)))
        .filter(|(_, held_out)| held_out.ratio <= EQUALLY_GOOD * least)
        .min_by(|a, b| {
            let fewer = parameters(a.0).cmp(&parameters(b.0));
            fewer.then(a.1.ratio.total_cmp(&b.1.ratio))
        })?;

    // The error of an effect that was not refitted is that of the one it is the same as.
    let error = |id: Id| {
        let find = |id: Id| {
            looks
                .iter()
                .find(|look| look.subject == Subject::Effect(id))
        };
        let look = find(id)?;
        let refitted = match look.decision {
            Decision::SameAs { other } => find(other)?,
            _ => look,
        };
        refitted.held_out.map(|held_out| held_out.ratio)
    };
    let told_apart = |id: Id| error(id).is_some_and(|ratio| ratio > TOLD_APART * least);
    let equivalent = shortlist
        .iter()
        .filter(|&&other| other != best && imitation[best][other] > EQUIVALENT)
        .map(|&other| candidates[other].effect.id)
        .filter(|&id| !told_apart(id))
        .collect();

    let winner = candidates[best];
    for (index, look) in looks.iter_mut().enumerate() {
        if index != best && look.decision == Decision::Accepted {
            look.decision = Decision::Outdone {
                by: winner.effect.id,
            };
        }
    }
    Some(Judgement {
        looks,
        winner: Some(Accepted {
            candidate: winner,
            p_value: comparison.p_value,
            equivalent,
        }),
    })
}

/// Looks for a variable over which a learned torque or friction explains what no effect does. Gives
/// the model with the map, still flat, and its score; a map counts if it brings the held-out error
/// under `limit` times that of the base.
#[allow(clippy::type_complexity)]
fn learn(
    round: &Round,
    schedule: &impl Schedule,
    limit: f64,
    observe: &mut impl FnMut(&Consideration),
    simulated: &mut u64,
) -> Option<Option<(Model, f32)>> {
    let Round { fit, options, .. } = *round;
    let smaller = held_out(round, schedule, &fit.model, round.variables, simulated)?;
    let mut looks: Vec<Consideration, { Kind::ALL.len() }> = Vec::new();
    for kind in Kind::ALL {
        let larger = with_map(&fit.model, kind, options);
        let more = fit::variables(round.declared, &larger, options.base, &options.scope);
        let base = round.variables.len();
        let screening = round.data.with_window(options.screen_window);
        let (score, windows) = screen::map_score(&screening, schedule, &larger, &more, base)?;
        *simulated += windows * options.screen_window as u64 / round.data.settings.window as u64;
        let larger = held_out(round, schedule, &larger, &more, simulated)?;
        let comparison = compare(&smaller, &larger);
        let _ = looks.push(Consideration {
            round: 1,
            subject: Subject::Map(kind),
            score,
            identifiability: 1.0,
            held_out: Some(comparison),
            decision: comparison
                .judge(Kind::ALL.len())
                .or((comparison.ratio > limit).then_some(Decision::GainTooSmall))
                .unwrap_or(Decision::Accepted),
        });
    }
    let best = looks
        .iter()
        .filter(|look| look.decision == Decision::Accepted)
        .filter_map(|look| look.held_out.map(|held_out| (*look, held_out.ratio)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(look, _)| look);
    for look in &mut looks {
        if let (Some(best), Decision::Accepted) = (best, look.decision)
            && let Subject::Map(by) = best.subject
            && look.subject != best.subject
        {
            look.decision = Decision::OutdoneByMap { by };
        }
        observe(look);
    }
    Some(best.and_then(|best| match best.subject {
        Subject::Map(kind) => Some((with_map(&fit.model, kind, options), best.score)),
        Subject::Effect(_) => None,
    }))
}

/// The model with a flat map.
fn with_map(model: &Model, kind: Kind, options: &Options) -> Model {
    Model {
        map: Some(LearnedMap::flat(kind, &options.ranges)),
        ..model.clone()
    }
}

/// Held-out errors of a model in a round.
fn held_out(
    round: &Round,
    schedule: &impl Schedule,
    model: &Model,
    variables: &Variables,
    simulated: &mut u64,
) -> Option<HeldOut> {
    cross_validate(
        round.data,
        schedule,
        round.block,
        model,
        variables,
        simulated,
    )
}
