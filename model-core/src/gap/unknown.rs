//! Structure that no effect of the catalogue explains: which variable carries it?

use super::criterion::{FAR_BEHIND, LEAST_SCORE, LEFT_BY_MAP, NEAR};
use super::held_out::{HeldOut, compare};
use super::mechanism::Mechanism;
use super::model::Model;
use super::replay::Schedule;
use super::verdict::{Consideration, Decision, Subject};
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
    /// The base model with that map, where a fit of it starts; once it has been taken, as it was fitted.
    pub start: Model,
    /// The effect of the catalogue that it is another law of, where there is one.
    pub mechanism: Option<Mechanism>,
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

/// The leading map, and its held-out error over that of the base.
struct Leading {
    ratio: f64,
    map: Unknown,
}

/// Looks for the variable over which a learned torque or friction explains best what is left of the
/// base model, given with its held-out errors. A map counts if it brings these under `limit` times
/// what they are; if none does and the error is `structured`, too large to be noise, the one that
/// comes nearest counts. `most`: so many maps are refitted, those that explain most.
///
/// `None` outside if a model cannot be built, inside if no map counts.
pub fn learn(
    workbench: &mut Workbench<impl Schedule>,
    (base, smaller): (&Model, &HeldOut),
    (limit, most): (f64, usize),
    structured: bool,
    observe: &mut dyn FnMut(&Consideration),
) -> Option<Option<Unknown>> {
    let with_map = |map: LearnedMap| Model {
        map: Some(map),
        ..base.clone()
    };
    let mut looks: Vec<(LearnedMap, Consideration), { Kind::ALL.len() }> = Vec::new();
    for kind in Kind::ALL {
        let map = LearnedMap::flat(kind, &workbench.options.ranges);
        let score = workbench.map_score(&with_map(map))?;
        let look = Consideration {
            round: 1,
            subject: Subject::Map(kind),
            score,
            identifiability: 1.0,
            held_out: None,
            decision: Decision::ScoreTooLow,
        };
        let _ = looks.push((map, look));
    }
    looks.sort_unstable_by(|a, b| b.1.score.total_cmp(&a.1.score));
    // Those far behind the first that has passed need no refit. Of a structured error what is linear says
    // little, unless that one has left little of it.
    let mut passed: Option<Consideration> = None;
    let mut leading: Option<Leading> = None;
    for (place, (map, look)) in looks.iter_mut().enumerate() {
        if look.score < LEAST_SCORE && !structured {
            continue;
        }
        if place >= most {
            look.decision = Decision::NotShortlisted;
            continue;
        }
        let ahead = |passed: &Consideration| look.score < FAR_BEHIND * passed.score;
        if let Some(passed) = passed.filter(ahead) {
            look.decision = Decision::FarBehind { of: passed.subject };
            continue;
        }
        let start = workbench.remove_bias(&with_map(*map))?;
        let is_near = |tested: &HeldOut| {
            let comparison = compare(smaller, tested);
            structured || !comparison.is_hopeless() && comparison.ratio < NEAR * limit
        };
        let comparison = compare(smaller, &workbench.held_out_while(&start, &is_near)?);
        look.held_out = Some(comparison);
        look.decision = match comparison.refusal(Kind::ALL.len()) {
            Some(refusal) => Decision::Refused(refusal),
            None if comparison.ratio > limit => Decision::NotClearlyBetter,
            None => Decision::Accepted,
        };
        let counts = look.decision == Decision::Accepted;
        let spares = !structured || comparison.ratio < LEFT_BY_MAP;
        if spares && counts && passed.is_none() {
            passed = Some(*look);
        }
        let ratio = comparison.ratio;
        let is_behind = |leading: &Leading| ratio < leading.ratio;
        if counts && leading.as_ref().is_none_or(is_behind) {
            let map = Unknown {
                kind: map.kind,
                score: look.score,
                start,
                mechanism: None,
            };
            leading = Some(Leading { ratio, map });
        }
    }
    for (_, look) in &mut looks {
        if let Some(Leading { map, .. }) = &leading {
            let by = Subject::Map(map.kind);
            if look.subject != by && look.decision == Decision::Accepted {
                look.decision = Decision::Outdone { by };
            }
        }
        observe(look);
    }
    Some(leading.map(|leading| leading.map))
}
