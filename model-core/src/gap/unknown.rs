//! Structure that no effect of the catalogue explains: which variable carries it?

use super::held_out::{HeldOut, compare};
use super::model::Model;
use super::replay::Schedule;
use super::select::{Consideration, Decision, LEAST_SCORE, Subject};
use super::workbench::Workbench;
use crate::effect::learned_map::{Kind, LearnedMap};
use heapless::Vec;

/// Structure that no effect of the catalogue explains.
#[derive(Debug, Clone)]
pub struct Unknown {
    /// The map that explains it best; the final model has it.
    pub kind: Kind,
    /// Share of the residual's energy that it explains once the base is projected out, 0 to 1.
    pub score: f32,
    /// The base model with that map, where a fit of it starts.
    pub start: Model,
}

impl Unknown {
    /// A look at the map, which is not needed beside effects that were found later.
    pub(super) fn dropped(&self) -> Consideration {
        Consideration {
            round: 1,
            subject: Subject::Map(self.kind),
            score: self.score,
            identifiability: 1.0,
            held_out: None,
            decision: Decision::Dropped,
        }
    }
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
    let with_map = |map: LearnedMap| Model {
        map: Some(map),
        ..base.clone()
    };
    let mut looks: Vec<(LearnedMap, f64, Consideration), { Kind::ALL.len() }> = Vec::new();
    let mut tried = 0;
    for kind in Kind::ALL {
        let mut best: Option<(f32, LearnedMap)> = None;
        for map in LearnedMap::trials(kind, &workbench.options.ranges) {
            let score = workbench.map_score(&with_map(map))?;
            if best.is_none_or(|(highest, _)| score > highest) {
                best = Some((score, map));
            }
            tried += 1;
        }
        let (score, map) = best?;
        let mut look = Consideration {
            round: 1,
            subject: Subject::Map(kind),
            score,
            identifiability: 1.0,
            held_out: None,
            decision: Decision::ScoreTooLow,
        };
        if score < LEAST_SCORE && !structured {
            let _ = looks.push((map, f64::INFINITY, look));
            continue;
        }
        let start = workbench.unbend(&with_map(map))?;
        let comparison = compare(smaller, &workbench.held_out(&start)?);
        look.held_out = Some(comparison);
        let _ = looks.push((map, comparison.ratio, look));
    }
    for (.., look) in &mut looks {
        if let Some(comparison) = look.held_out {
            look.decision = match comparison.refusal(tried) {
                Some(refusal) => Decision::Refused(refusal),
                None if comparison.ratio > limit => Decision::NotClearlyBetter,
                None => Decision::Accepted,
            };
        }
    }
    let best = looks
        .iter()
        .filter(|(.., look)| look.decision == Decision::Accepted)
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(map, _, look)| (*map, look.score));
    let nearest = looks
        .iter()
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|_| structured && best.is_none())
        .map(|(map, _, look)| (*map, look.score));
    for (map, _, look) in &mut looks {
        if nearest.is_some_and(|(by, _)| by.kind == map.kind) {
            look.decision = Decision::LeastBad;
        }
        if let Some((by, _)) = best
            && look.decision == Decision::Accepted
            && map.kind != by.kind
        {
            let by = Subject::Map(by.kind);
            look.decision = Decision::Outdone { by };
        }
        observe(look);
    }
    let Some((map, score)) = best.or(nearest) else {
        return Some(None);
    };
    // Unbent once more: to keep every map's model until one has won would be too much for the chip's stack.
    Some(Some(Unknown {
        kind: map.kind,
        score,
        start: workbench.unbend(&with_map(map))?,
    }))
}
