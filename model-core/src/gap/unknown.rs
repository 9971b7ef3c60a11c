//! Structure that no effect of the catalogue explains: which variable carries it?

use super::held_out::{HeldOut, Refusal, compare};
use super::model::Model;
use super::replay::Schedule;
use super::select::{Consideration, Decision, LEAST_SCORE, Subject};
use super::workbench::Workbench;
use crate::effect::learned_map::{Kind, LearnedMap, Ranges};
use heapless::Vec;

/// Structure that no effect of the catalogue explains.
#[derive(Debug, Clone)]
pub struct Unknown {
    /// The map that explains it best; the final model has it.
    pub kind: Kind,
    /// Share of the residual's energy that it explains once the base is projected out, 0 to 1.
    pub score: f32,
    /// The base model with that map, still flat.
    pub start: Model,
}

/// Looks for the variable over which a learned torque or friction explains best what is left of the
/// base model, given with its held-out errors. A map counts if it brings these under `limit` times
/// what they are; if none does and the error is `structured`, too large to be noise, the one that
/// comes nearest counts.
///
/// `None` outside if a model cannot be built, inside if no map counts.
pub fn learn(
    workbench: &mut Workbench<impl Schedule>,
    (base, smaller): (&Model, &HeldOut),
    limit: f64,
    structured: bool,
    observe: &mut impl FnMut(&Consideration),
) -> Option<Option<Unknown>> {
    let with_map = |ranges: &Ranges, kind| Model {
        map: Some(LearnedMap::flat(kind, ranges)),
        ..base.clone()
    };
    let mut looks: Vec<(Kind, f64, Consideration), { Kind::ALL.len() }> = Vec::new();
    for kind in Kind::ALL {
        let model = with_map(&workbench.options.ranges, kind);
        let score = workbench.map_score(&model)?;
        let mut look = Consideration {
            round: 1,
            subject: Subject::Map(kind),
            score,
            identifiability: 1.0,
            held_out: None,
            decision: Decision::ScoreTooLow,
        };
        if score < LEAST_SCORE && !structured {
            let _ = looks.push((kind, f64::INFINITY, look));
            continue;
        }
        let comparison = compare(smaller, &workbench.held_out(&model)?);
        let refusal = comparison
            .refusal(Kind::ALL.len())
            .or((comparison.ratio > limit).then_some(Refusal::GainTooSmall));
        look.held_out = Some(comparison);
        look.decision = refusal.map_or(Decision::Accepted, Decision::Refused);
        let _ = looks.push((kind, comparison.ratio, look));
    }
    let best = looks
        .iter()
        .filter(|(.., look)| look.decision == Decision::Accepted)
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(kind, _, look)| (*kind, look.score));
    let nearest = looks
        .iter()
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|_| structured && best.is_none())
        .map(|(kind, _, look)| (*kind, look.score));
    for (kind, _, look) in &mut looks {
        if nearest.is_some_and(|(by, _)| by == *kind) {
            look.decision = Decision::LeastBad;
        }
        if let Some((by, _)) = best
            && look.decision == Decision::Accepted
            && *kind != by
        {
            let by = Subject::Map(by);
            look.decision = Decision::Outdone { by };
        }
        observe(look);
    }
    Some(best.or(nearest).map(|(kind, score)| Unknown {
        kind,
        score,
        start: with_map(&workbench.options.ranges, kind),
    }))
}
