//! Which effects could explain the residual: scores with the base projected out.
//!
//! Every candidate is simulated at a small strength, with each value of its shape. Projecting the
//! base's sensitivities out of its own and out of the residual leaves what no refit of the base
//! could do; the squared cosine between the two is the candidate's score.

use super::fit::{self, Variables};
use super::model::Model;
use super::replay::{self, COLUMNS, Data, Fold, Lane, Schedule, Sums};
use crate::effect::{Active, Id, MOST_PARAMETERS, Role, Scope};
use crate::numeric::cholesky::Cholesky;
use heapless::Vec;

/// Most candidates that one screening returns: one an effect.
pub const MOST_CANDIDATES: usize = 24;

/// Strength at which candidates are simulated, as a share of their scale.
const STRENGTH: f32 = 0.05;

/// An effect at the shape and the strength that explain the residual best.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// The effect with the strengths of the linear solution.
    pub effect: Active,
    /// Share of the residual's energy that it explains once the base is projected out, 0 to 1.
    pub score: f32,
    /// Share of its own sensitivity that the base cannot imitate, 0 to 1.
    pub identifiability: f32,
    /// Whether physics allows the sign that the residual asks for.
    pub allowed: bool,
}

/// Candidates of one screening.
pub type Candidates = Vec<Candidate, MOST_CANDIDATES>;

/// Sums with the base projected out of all other columns.
struct Projection<'a> {
    sums: &'a Sums,
    /// Columns of the base, behind the residual's.
    base: usize,
    factor: Cholesky<COLUMNS>,
}

impl<'a> Projection<'a> {
    fn new(sums: &'a Sums, base: usize) -> Self {
        let mut normal = [[0.0; COLUMNS]; COLUMNS];
        for row in 0..base {
            for column in 0..=row {
                normal[row][column] = sums.products[row + 1][column + 1];
            }
        }
        Self {
            sums,
            base,
            factor: Cholesky::new(&normal, base),
        }
    }

    fn raw(&self, a: usize, b: usize) -> f64 {
        self.sums.products[a.max(b)][a.min(b)]
    }

    /// A column in the orthonormal coordinates of the base.
    fn along_base(&self, column: usize) -> [f64; COLUMNS] {
        let mut entries = [0.0; COLUMNS];
        for (row, entry) in entries.iter_mut().enumerate().take(self.base) {
            *entry = self.raw(row + 1, column);
        }
        self.factor.forward(&mut entries[..self.base]);
        entries
    }

    /// Product of two columns without their parts along the base.
    fn product(&self, a: usize, b: usize) -> f64 {
        let (along_a, along_b) = (self.along_base(a), self.along_base(b));
        let shared: f64 = along_a
            .iter()
            .zip(along_b)
            .take(self.base)
            .map(|(x, y)| x * y)
            .sum();
        self.raw(a, b) - shared
    }

    /// Product of two combinations of columns.
    fn combined(
        &self,
        (first_a, a): (usize, &[f64]),
        (first_b, b): (usize, &[f64]),
        product: impl Fn(usize, usize) -> f64,
    ) -> f64 {
        let mut sum = 0.0;
        for (i, x) in a.iter().enumerate() {
            for (j, y) in b.iter().enumerate() {
                sum += x * y * product(first_a + i, first_b + j);
            }
        }
        sum
    }

    /// The strengths, in units of the scale, with which the columns from `first` cancel the residual
    /// best.
    fn solve(&self, first: usize, strengths: usize) -> [f64; MOST_PARAMETERS] {
        let mut normal = [[0.0; MOST_PARAMETERS]; MOST_PARAMETERS];
        let mut solution = [0.0; MOST_PARAMETERS];
        for row in 0..strengths {
            for column in 0..=row {
                normal[row][column] = self.product(first + row, first + column);
            }
            solution[row] = -self.product(first + row, 0);
        }
        Cholesky::new(&normal, strengths).solve(&mut solution[..strengths]);
        solution
    }

    fn candidate(&self, effect: Active, first: usize, scope: &Scope) -> Candidate {
        let strengths = effect.id.strengths();
        let solution = self.solve(first, strengths);
        let along = (first, &solution[..strengths]);
        let own = self.combined(along, along, |a, b| self.product(a, b));
        let raw = self.combined(along, along, |a, b| self.raw(a, b));
        let residual = self.product(0, 0);
        let allowed = effect
            .id
            .description()
            .parameters
            .iter()
            .zip(solution)
            .all(|(parameter, value)| parameter.role != Role::Strength || value >= 0.0);
        let mut effect = effect;
        for index in 0..strengths {
            effect.values[index] = solution[index] as f32 * effect.id.scale(scope, index);
        }
        let share = |part: f64, whole: f64| {
            if whole > 0.0 && part > 0.0 {
                (part / whole).min(1.0)
            } else {
                0.0
            }
        };
        Candidate {
            effect,
            score: share(own, residual) as f32,
            identifiability: libm::sqrt(share(own, raw)) as f32,
            allowed,
        }
    }
}

/// The model with an effect added, or `None` if it is full.
pub fn with_effect(model: &Model, effect: Active) -> Option<Model> {
    let mut model = model.clone();
    model.effects.push(effect).ok()?;
    Some(model)
}

/// Copies of the model with the effect at a small strength, one for each of its strengths.
fn effect_lanes(
    model: &Model,
    effect: Active,
    scope: &Scope,
    period: f32,
) -> Option<Vec<Lane, MOST_PARAMETERS>> {
    (0..effect.id.strengths())
        .map(|index| {
            let mut moved = effect;
            moved.values[..effect.id.strengths()].fill(0.0);
            moved.values[index] = STRENGTH * effect.id.scale(scope, index);
            Some(Lane {
                simulator: with_effect(model, moved)?.build(period).ok()?,
                inverse_step: 1.0 / STRENGTH,
            })
        })
        .collect()
}

/// Effects that the model lacks, each at every shape to be tried.
fn options<'a>(model: &'a Model, scope: &'a Scope) -> impl Iterator<Item = Active> + 'a {
    Id::ALL
        .iter()
        .copied()
        .filter(|id| !model.has(*id) && (scope.rotary || !id.description().rotary_only))
        .flat_map(move |id| {
            let shapeless = id.shape(scope, 0).is_none();
            (0..)
                .map_while(move |index| {
                    if shapeless {
                        (index == 0).then_some(None)
                    } else {
                        id.shape(scope, index).map(Some)
                    }
                })
                .map(move |shape| {
                    let mut values = [0.0; MOST_PARAMETERS];
                    if let Some(shape) = shape {
                        values[id.strengths()] = shape;
                    }
                    Active { id, values }
                })
        })
}

/// Scores every effect that the model lacks, each at its best shape. The second value counts the
/// windows simulated.
pub fn screen(
    data: &Data,
    schedule: &impl Schedule,
    model: &Model,
    variables: &Variables,
    scope: &Scope,
) -> Option<(Candidates, u64)> {
    let period = data.logs.first()?.period;
    let base = model.build(period).ok()?;
    let base_lanes = fit::lanes(model, variables, period)?;
    let mut best = Candidates::new();
    let mut simulated = 0;
    let mut options = options(model, scope).peekable();
    while options.peek().is_some() {
        let mut lanes: Vec<Lane, COLUMNS> = base_lanes.iter().cloned().collect();
        let mut batch: Vec<(Active, usize), COLUMNS> = Vec::new();
        while let Some(option) =
            options.next_if(|option| lanes.len() + option.id.strengths() < COLUMNS)
        {
            let _ = batch.push((option, lanes.len() + 1));
            for lane in effect_lanes(model, option, scope, period)? {
                let _ = lanes.push(lane);
            }
        }
        let sums = replay::sums(data, schedule, (Fold::All, 1), &base, &lanes);
        simulated += sums.windows as u64 * (lanes.len() as u64 + 1);
        let projection = Projection::new(&sums, variables.len());
        for (option, first) in batch {
            let candidate = projection.candidate(option, first, scope);
            let rank = |candidate: &Candidate| (candidate.allowed, candidate.score);
            match best
                .iter_mut()
                .find(|known| known.effect.id == candidate.effect.id)
            {
                Some(known) if rank(&candidate) > rank(known) => *known = candidate,
                Some(_) => {}
                None => {
                    let _ = best.push(candidate);
                }
            }
        }
    }
    Some((best, simulated))
}

/// How well one effect imitates another: `[a][b]` is the cosine between the sensitivity of
/// candidate `a` at its best strengths and what candidate `b` can do with any strengths, the base
/// projected out of both. At 1 the log cannot tell `a` from `b`.
pub type Imitation = [[f32; MOST_CANDIDATES]; MOST_CANDIDATES];

/// Compares the candidates with each other. The second value counts the windows simulated.
pub fn imitation(
    data: &Data,
    schedule: &impl Schedule,
    model: &Model,
    variables: &Variables,
    candidates: &[Candidate],
    scope: &Scope,
) -> Option<(Imitation, u64)> {
    let period = data.logs.first()?.period;
    let base = model.build(period).ok()?;
    let mut lanes: Vec<Lane, COLUMNS> = fit::lanes(model, variables, period)?.into_iter().collect();
    let mut columns: Vec<(usize, [f64; MOST_PARAMETERS], usize), MOST_CANDIDATES> = Vec::new();
    for candidate in candidates {
        let effect = candidate.effect;
        let strengths = effect.id.strengths();
        if lanes.len() + strengths >= COLUMNS {
            break;
        }
        let mut direction = [0.0; MOST_PARAMETERS];
        for index in 0..strengths {
            let scale = effect.id.scale(scope, index);
            direction[index] = f64::from(effect.values[index] / scale);
        }
        let _ = columns.push((lanes.len() + 1, direction, strengths));
        for lane in effect_lanes(model, effect, scope, period)? {
            let _ = lanes.push(lane);
        }
    }
    let sums = replay::sums(data, schedule, (Fold::All, 1), &base, &lanes);
    let simulated = sums.windows as u64 * (lanes.len() as u64 + 1);
    let projection = Projection::new(&sums, variables.len());
    let mut imitation = [[0.0; MOST_CANDIDATES]; MOST_CANDIDATES];
    for (a, (first_a, direction, strengths_a)) in columns.iter().enumerate() {
        let along_a = (*first_a, &direction[..*strengths_a]);
        let own = projection.combined(along_a, along_a, |x, y| projection.product(x, y));
        for (b, (first_b, _, strengths_b)) in columns.iter().enumerate() {
            let mut normal = [[0.0; MOST_PARAMETERS]; MOST_PARAMETERS];
            let mut shared = [0.0; MOST_PARAMETERS];
            for row in 0..*strengths_b {
                for column in 0..=row {
                    normal[row][column] = projection.product(first_b + row, first_b + column);
                }
                shared[row] = projection.combined(along_a, (first_b + row, &[1.0]), |x, y| {
                    projection.product(x, y)
                });
            }
            // ‖L⁻¹ Sᵀv‖ is the length of v's projection on the columns of b.
            Cholesky::new(&normal, *strengths_b).forward(&mut shared[..*strengths_b]);
            let length: f64 = shared[..*strengths_b].iter().map(|x| x * x).sum();
            if own > 0.0 {
                imitation[a][b] = libm::sqrt((length / own).min(1.0)) as f32;
            }
        }
    }
    Some((imitation, simulated))
}
