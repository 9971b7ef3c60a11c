//! Which effects could explain the residual: scores with the base projected out.
//!
//! Every candidate is simulated at a small strength, with each value of its shape. Projecting the
//! base's sensitivities out of its own and out of the residual leaves what no refit of the base
//! could do; the squared cosine between the two is the candidate's score.

use super::ensemble::{COLUMNS, Ensemble, MOST_SIMULATORS, Store};
use super::fit::{self, MOST_VARIABLES, Matrix, Target, Variables};
use super::model::Model;
use super::replay::{Data, Fold, Schedule, Sums};
use crate::effect::{Active, Id, MOST_PARAMETERS, MOST_STRENGTHS, Scope};
use crate::numeric::cholesky::Cholesky;
use crate::numeric::triangle::{Triangle, entries};
use crate::plant::parameters::Drive;
use heapless::Vec;

/// Most candidates that one screening returns, however many effects there are: those that are refitted whatever their
/// score, and more of the others than are ever refitted. What is compared with each other fits the chip's memory.
pub const MOST_CANDIDATES: usize = 12 + Id::BIASING;

/// Strength at which candidates are simulated, as a share of their scale.
const STRENGTH: f32 = 0.05;

/// Windows that shapes are compared on: every second one. What is said of the best shape is measured
/// on all.
const SCAN: (Fold, usize) = (Fold::Even, 1);

/// An effect at the shape and the strength that explain the residual best.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// The effect with the strengths of the linear solution, of those that may not be negative the sizes.
    pub effect: Active,
    /// Share of the residual's energy that it explains once the base is projected out, 0 to 1.
    pub score: f32,
    /// Share of its own sensitivity that no change of the base makes, 0 to 1.
    pub identifiability: f32,
    /// Whether physics allows the sign that the residual asks for.
    pub allowed: bool,
    /// Shapes that were tried before this one was found best.
    pub tries: u32,
}

/// Candidates of one screening.
pub type Candidates = Vec<Candidate, MOST_CANDIDATES>;

/// Sums with the base projected out of all other columns.
struct Projection<'a> {
    sums: &'a Sums,
    /// Columns of the base, behind the residual's.
    base: usize,
    factor: Cholesky<{ entries(MOST_VARIABLES) }>,
}

/// A matrix over the strengths of an effect.
type Strengths = Triangle<f64, { entries(MOST_STRENGTHS) }>;

impl<'a> Projection<'a> {
    fn new(sums: &'a Sums, base: usize) -> Self {
        let mut normal = Matrix::default();
        for row in 0..base {
            let products = &sums.products.row(row + 1)[1..];
            normal.row_mut(row).copy_from_slice(products);
        }
        Self {
            sums,
            base,
            factor: Cholesky::new(normal, base),
        }
    }

    fn raw(&self, a: usize, b: usize) -> f64 {
        self.sums.products.at(a, b)
    }

    /// A column in the orthonormal coordinates of the base.
    fn along_base(&self, column: usize) -> [f64; MOST_VARIABLES] {
        let mut entries = [0.0; MOST_VARIABLES];
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
    fn solve(&self, first: usize, strengths: usize) -> [f64; MOST_STRENGTHS] {
        let mut normal = Strengths::default();
        let mut solution = [0.0; MOST_STRENGTHS];
        for row in 0..strengths {
            for column in 0..=row {
                normal.row_mut(row)[column] = self.product(first + row, first + column);
            }
            solution[row] = -self.product(first + row, 0);
        }
        Cholesky::new(normal, strengths).solve(&mut solution[..strengths]);
        solution
    }

    /// Cosine between an effect's sensitivity at its strengths and the span of another's columns.
    fn collinearity(
        &self,
        (effect, first): (Active, usize),
        (other, start): (Active, usize),
        scope: &Scope,
    ) -> f32 {
        let mut direction = [0.0; MOST_STRENGTHS];
        for index in 0..effect.id.strengths() {
            let scale = effect.id.scale(scope, index);
            direction[index] = f64::from(effect.values[index] / scale);
        }
        let along = (first, &direction[..effect.id.strengths()]);
        let product = |a: usize, b: usize| self.product(a, b);
        let own = self.combined(along, along, product);
        let strengths = other.id.strengths();
        let mut normal = Strengths::default();
        let mut shared = [0.0; MOST_STRENGTHS];
        for row in 0..strengths {
            for column in 0..=row {
                normal.row_mut(row)[column] = self.product(start + row, start + column);
            }
            shared[row] = self.combined(along, (start + row, &[1.0]), product);
        }
        // ‖L⁻¹ Sᵀv‖ is the length of v's projection on the columns of the other.
        Cholesky::new(normal, strengths).forward(&mut shared[..strengths]);
        let length: f64 = shared[..strengths].iter().map(|x| x * x).sum();
        if own > 0.0 {
            libm::sqrt((length / own).min(1.0)) as f32
        } else {
            0.0
        }
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
            .all(|(parameter, value)| parameter.bounds.are_signed() || value >= 0.0);
        let mut effect = effect;
        for index in 0..strengths {
            let tried = effect.values[index];
            let linear = solution[index] as f32 * effect.id.scale(scope, index);
            // Between two trials nothing is linear.
            effect.values[index] = if effect.id.trial(scope, 0).is_some() {
                tried
            } else {
                linear
            };
        }
        let share = |part: f64, whole: f64| {
            if whole > 0.0 && part > 0.0 {
                (part / whole).min(1.0)
            } else {
                0.0
            }
        };
        Candidate {
            effect: effect.with_allowed_signs(),
            score: share(own, residual) as f32,
            identifiability: libm::sqrt(share(own, raw)) as f32,
            allowed,
            tries: 1,
        }
    }
}

/// The model with an effect added, or `None` if it is full.
pub fn with_effect(model: &Model, effect: Active) -> Option<Model> {
    let mut model = model.clone();
    model.effects.push(effect).ok()?;
    Some(model)
}

/// Which copies an effect is simulated with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sides {
    /// One of each strength: enough to find the best shape.
    One,
    /// Where the strength may have either sign, one of each.
    Both,
}

/// Adds copies of the model with the effect at a small strength, for each of its strengths.
fn add_effect<'m>(
    ensemble: &mut Ensemble<'m>,
    store: &'m Store,
    model: &Model,
    effect: Active,
    (sides, scope): (Sides, &Scope),
) -> Option<()> {
    if effect.id.trial(scope, 0).is_some() {
        let moved = with_effect(model, effect)?;
        let inverse_step = effect.id.scale(scope, 0) / effect.values[0];
        return ensemble
            .push(store, (&moved, None), inverse_step, scope.period)
            .ok();
    }
    for index in 0..effect.id.strengths() {
        let at = |share: f32| {
            let mut moved = effect;
            moved.values[..effect.id.strengths()].fill(0.0);
            moved.values[index] = share * effect.id.scale(scope, index);
            with_effect(model, moved)
        };
        let bounds = effect.id.description().parameters[index].bounds;
        let moved = at(STRENGTH)?;
        let (opposite, inverse_step) = if bounds.are_signed() && sides == Sides::Both {
            (Some(at(-STRENGTH)?), 0.5 / STRENGTH)
        } else {
            (None, 1.0 / STRENGTH)
        };
        let copies = (&moved, opposite.as_ref());
        ensemble
            .push(store, copies, inverse_step, scope.period)
            .ok()?;
    }
    Some(())
}

/// Effects that the model lacks, each at every shape to be tried.
fn options<'a>(model: &'a Model, scope: &'a Scope) -> impl Iterator<Item = Active> + 'a {
    let has_winding = matches!(model.plant.drive, Drive::Voltage { .. });
    Id::ALL
        .iter()
        .copied()
        .filter(|id| !model.has(*id))
        .filter(|id| scope.rotary || !id.description().rotary_only)
        .filter(move |id| has_winding || !id.needs_winding())
        .flat_map(move |id| {
            let scanned = move |index| {
                id.trial(scope, index).or_else(|| {
                    let mut values = [0.0; MOST_PARAMETERS];
                    let room = values.iter_mut().skip(id.strengths());
                    for (value, shape) in room.zip(id.shapes(scope, index)?) {
                        *value = shape;
                    }
                    Some(values)
                })
            };
            let plain = scanned(0).is_none();
            (0..).map_while(move |index| {
                let nothing = (plain && index == 0).then_some([0.0; MOST_PARAMETERS]);
                let values = scanned(index).or(nothing)?;
                Some(Active { id, values })
            })
        })
}

/// What a screening found.
pub struct Screening {
    /// The best of the effects that the model lacks, each at its best shape; the highest scores first,
    /// equal ones in the order of the catalogue.
    pub candidates: Candidates,
    /// Effects that were screened, these and others.
    pub screened: usize,
    /// How collinear they are.
    pub collinearity: Collinearity,
    /// Windows simulated, each copy counted.
    pub simulated: u64,
}

impl Screening {
    /// Looks among which the one at this candidate is the luckiest: at all effects, in the shapes that were
    /// tried of it.
    pub fn tries(&self, candidate: usize) -> usize {
        self.screened * self.candidates[candidate].tries as usize
    }
}

/// Collinearity of effects: `[a][b]` is the cosine between the sensitivity of
/// candidate `a` at its best strengths and what candidate `b` can do with any strengths, the base
/// projected out of both. At 1 the log cannot tell `a` from `b`.
pub type Collinearity = [[f32; MOST_CANDIDATES]; MOST_CANDIDATES];

/// The best of the effects that have been screened so far.
#[derive(Default)]
struct Ranking {
    best: Candidates,
    /// The effect of which shapes are being tried.
    current: Option<Candidate>,
    screened: usize,
}

impl Ranking {
    /// Takes the next shape: of the effect of which shapes are being tried, or of another one.
    fn take(&mut self, candidate: Candidate, scope: &Scope, passed_over: impl FnMut(&Candidate)) {
        let id = candidate.effect.id;
        if let Some(known) = self.current.as_mut().filter(|known| known.effect.id == id) {
            let rank = |candidate: &Candidate| (candidate.allowed, candidate.score);
            // A strength is fitted wherever its scan began.
            let tries = known.tries + u32::from(id.trial(scope, 0).is_none());
            if rank(&candidate) > rank(known) {
                *known = candidate;
            }
            known.tries = tries;
        } else {
            self.close(passed_over);
            self.current = Some(candidate);
        }
    }

    /// No shape of the effect of which shapes were being tried comes any more. Where there are too many
    /// effects, the one that is the least likely to be refitted is passed over.
    fn close(&mut self, mut passed_over: impl FnMut(&Candidate)) {
        let Some(current) = self.current.take() else {
            return;
        };
        self.screened += 1;
        let Err(mut current) = self.best.push(current) else {
            return;
        };
        let hope = |candidate: &Candidate| {
            let biases_base = candidate.effect.id.biases_base();
            (biases_base, candidate.allowed, candidate.score)
        };
        let least = |a: &&mut Candidate, b: &&mut Candidate| {
            let (a, b) = (hope(a), hope(b));
            (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2))
        };
        if let Some(least) = self.best.iter_mut().min_by(least)
            && hope(&current) > hope(least)
        {
            core::mem::swap(least, &mut current);
        }
        passed_over(&current);
    }
}

/// Scores every effect that the model lacks, each at its best shape, and compares the best.
/// `passed_over` is told of those that are not among them, with the score of the scan.
pub fn screen(
    data: &Data,
    schedule: &impl Schedule,
    model: &Model,
    variables: &Variables,
    scope: &Scope,
    mut passed_over: impl FnMut(&Candidate),
) -> Option<Screening> {
    let period = data.logs.first()?.period;
    let store = Store::new();
    let mut ensemble = Ensemble::new();
    ensemble.start(&store, model, period).ok()?;
    // Run-ins would be most of the work: they are longer than the windows.
    ensemble.share_run_in();
    fit::perturb(&mut ensemble, &store, model, variables, period)?;
    let base = variables.len();
    let mut sums = Sums::default();
    let mut ranking = Ranking::default();
    let mut columns = Columns::new();
    let mut simulated = 0;
    let mut options = options(model, scope).peekable();
    while options.peek().is_some() {
        ensemble.truncate(base);
        columns.clear();
        while let Some(option) =
            options.next_if(|option| ensemble.lanes().len() + option.id.strengths() < COLUMNS)
        {
            ensemble.separate();
            let _ = columns.push((option, ensemble.lanes().len() + 1));
            add_effect(&mut ensemble, &store, model, option, (Sides::One, scope))?;
        }
        if columns.is_empty() {
            break;
        }
        sums.replay(data, schedule, SCAN, &ensemble);
        simulated += sums.simulated(&ensemble);
        rank_shapes(
            &mut ranking,
            (&sums, base),
            &columns,
            scope,
            &mut passed_over,
        );
    }
    ranking.close(passed_over);
    let Ranking {
        mut best, screened, ..
    } = ranking;
    sort(&mut best);

    // Once more at the best shapes, to both sides and together: scores that compare.
    ensemble.truncate(base);
    columns.clear();
    for candidate in &best {
        let effect = candidate.effect;
        if ensemble.lanes().len() + effect.id.strengths() >= COLUMNS {
            break;
        }
        let _ = columns.push((effect, ensemble.lanes().len() + 1));
        // To both sides as long as there is room: the best come first.
        let room = MOST_SIMULATORS - ensemble.simulators().len();
        let opposites = room.saturating_sub(COLUMNS - 1 - ensemble.lanes().len());
        let sides = if opposites < effect.id.strengths() {
            Sides::One
        } else {
            Sides::Both
        };
        add_effect(&mut ensemble, &store, model, effect, (sides, scope))?;
    }
    sums.replay(data, schedule, (Fold::All, 1), &ensemble);
    simulated += sums.simulated(&ensemble);
    let mut collinearity = [[0.0; MOST_CANDIDATES]; MOST_CANDIDATES];
    compare(&mut best, &mut collinearity, (&sums, base), &columns, scope);
    Some(Screening {
        candidates: best,
        screened,
        collinearity,
        simulated,
    })
}

/// Effects, each with the first of its columns.
type Columns = Vec<(Active, usize), COLUMNS>;

/// Takes the shapes of a batch into the ranking.
#[inline(never)]
fn rank_shapes(
    ranking: &mut Ranking,
    (sums, base): (&Sums, usize),
    columns: &Columns,
    scope: &Scope,
    mut passed_over: impl FnMut(&Candidate),
) {
    let projection = Projection::new(sums, base);
    for (option, first) in columns {
        let candidate = projection.candidate(*option, *first, scope);
        ranking.take(candidate, scope, &mut passed_over);
    }
}

/// Scores the best shapes, sorts them, and compares each with each.
#[inline(never)]
fn compare(
    best: &mut Candidates,
    collinearity: &mut Collinearity,
    (sums, base): (&Sums, usize),
    columns: &Columns,
    scope: &Scope,
) {
    let projection = Projection::new(sums, base);
    for (candidate, (effect, first)) in best.iter_mut().zip(columns) {
        *candidate = Candidate {
            tries: candidate.tries,
            ..projection.candidate(*effect, *first, scope)
        };
    }
    let place = |id: Id| columns.iter().find(|(effect, _)| effect.id == id);
    sort(best);
    for (a, candidate) in best.iter().enumerate() {
        let Some((_, first)) = place(candidate.effect.id) else {
            continue;
        };
        for (b, other) in best.iter().enumerate() {
            if let Some((collinear, start)) = place(other.effect.id) {
                collinearity[a][b] = projection.collinearity(
                    (candidate.effect, *first),
                    (*collinear, *start),
                    scope,
                );
            }
        }
    }
}

fn sort(candidates: &mut Candidates) {
    candidates.sort_unstable_by(|a, b| {
        let order = |candidate: &Candidate| candidate.effect.id as usize;
        let catalogue = order(a).cmp(&order(b));
        b.score.total_cmp(&a.score).then(catalogue)
    });
}

/// Score of a learned map that is flat in `model`: the share of the residual's energy that its knots
/// explain together once the base is projected out. With it, the windows simulated, each copy
/// counted.
pub fn map_score(
    data: &Data,
    schedule: &impl Schedule,
    model: &Model,
    variables: &Variables,
) -> Option<(f32, u64)> {
    let period = data.logs.first()?.period;
    let store = Store::new();
    let mut ensemble = Ensemble::new();
    ensemble.start(&store, model, period).ok()?;
    // Run-ins would be most of the work: they are longer than the windows.
    ensemble.share_run_in();
    fit::perturb(&mut ensemble, &store, model, variables, period)?;
    let mut sums = Sums::default();
    sums.replay(data, schedule, (Fold::All, 1), &ensemble);
    // The knots come last.
    let knots = variables
        .iter()
        .filter(|variable| matches!(variable.target, Target::Knot(_)))
        .count();
    let without = unexplained(&sums, variables.len() - knots);
    let with = unexplained(&sums, variables.len());
    let score = if without > 0.0 {
        (1.0 - with / without).max(0.0)
    } else {
        0.0
    };
    Some((score as f32, sums.simulated(&ensemble)))
}

/// Energy of the residual with the first columns projected out.
#[inline(never)]
fn unexplained(sums: &Sums, base: usize) -> f64 {
    Projection::new(sums, base).product(0, 0)
}
