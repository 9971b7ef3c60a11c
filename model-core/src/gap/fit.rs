//! Levenberg–Marquardt on the sums of the windowed replay.

use super::criterion::{DECLARED_WEIGHT, SENSOR_GAIN, SENSOR_OFFSET, SENSOR_REACH};
use super::current_sensor::Reading;
use super::ensemble::{Ensemble, Store};
use super::model::{Base, Model};
use super::replay::{self, Data, Fold, Schedule, Sums};
use crate::effect::learned_map::KNOTS;
use crate::effect::{Id, MOST_PARAMETERS, REACH, Role, Scope};
use crate::numeric::cholesky::Cholesky;
use crate::numeric::triangle::{Triangle, entries};
use crate::unit::Dimension;
use heapless::Vec;

/// Most variables of one fit: the fifteen of the base, the three of the current's sensor, and eleven of effects, of which each has
/// three at most, and a cogging seven with its overtones. What comes last has no room and stays as it is.
pub const MOST_VARIABLES: usize = 29;

/// Share of a variable's scale that sensitivities are taken over: far above the rounding of an
/// `f32` simulation, far below where a parameter's influence bends.
const DIFFERENCE: f32 = 0.01;

/// Increases of the damping before a fit is taken as converged, and by how much each is.
const MOST_REFUSALS: u32 = 4;
const MORE_DAMPING: f64 = 6.0;

/// Damping under which a step hardly differs from the undamped one: what is refused there is not
/// tried again.
const LEAST_DAMPING: f64 = 0.02;

/// What a variable of a fit sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// A parameter of the declared actuator.
    Base(Base),
    /// A number of the current's sensor.
    Current(Reading),
    /// A value of the effect in this slot of the model.
    Effect {
        /// Index in the model's effects.
        slot: usize,
        /// Index in the effect's values.
        index: usize,
    },
    /// A knot of the learned map.
    Knot(usize),
}

/// A variable of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variable {
    /// What it sets.
    pub target: Target,
    /// Its typical size, > 0.
    pub scale: f32,
    /// Its smallest value.
    pub lower: f32,
    /// Its largest value.
    pub upper: f32,
    /// The value that the user declares.
    pub declared: Option<f32>,
}

/// The variables of a fit.
pub type Variables = Vec<Variable, MOST_VARIABLES>;

impl Variable {
    /// A base parameter, bounded to 1/50 to 50 times its declared value (zero below, where it may
    /// be zero). An input is early by a sample at most: what a row holds acts from there on, or until there.
    pub fn base(model: &Model, parameter: Base, scope: &Scope) -> Self {
        let declared = model.get(parameter);
        let natural = match parameter {
            Base::Viscous => scope.friction / scope.speed,
            Base::Spring => scope.friction / scope.stroke,
            Base::SpringRest | Base::GravityRest | Base::LowerStop | Base::UpperStop => {
                0.1 * scope.stroke
            }
            Base::SpringPreload | Base::GravityTorque | Base::Coulomb | Base::Static => {
                scope.friction
            }
            Base::Inductance => 1e-3 * model.get(Base::Resistance),
            Base::Resistance | Base::TorqueConstant | Base::Inertia => declared,
            Base::InputLead => scope.period,
        };
        let scale = if parameter.dimension() == Dimension::Position {
            natural
        } else {
            declared.abs().max(natural)
        };
        let (lower, upper) = if parameter.dimension() == Dimension::Position {
            (
                declared - 10.0 * scope.stroke,
                declared + 10.0 * scope.stroke,
            )
        } else if parameter == Base::InputLead {
            (0.0, scale)
        } else if parameter.is_signed() {
            (-50.0 * scale, 50.0 * scale)
        } else if parameter.is_positive() {
            (0.02 * declared, 50.0 * declared)
        } else {
            (0.0, 50.0 * scale)
        };
        Self {
            target: Target::Base(parameter),
            scale,
            lower,
            upper,
            declared: Some(declared),
        }
    }

    /// A value of an effect in the model: within the parameter's bounds, a strength no farther out than
    /// the effect's reach, a shape no farther than three times off where it starts, nor above the largest that
    /// a log shows, unless it starts there.
    pub fn effect(id: Id, slot: usize, index: usize, value: f32, scope: &Scope) -> Self {
        let parameter = &id.description().parameters[index];
        let (scale, lower, upper) = match parameter.role {
            Role::Strength | Role::Overtone => {
                let reach = id.reach(scope, index);
                (id.scale(scope, index), -reach, reach)
            }
            Role::Shape => {
                let largest = id.largest_shape(scope).max(value);
                (0.2 * value, 0.3 * value, largest.min(3.0 * value))
            }
        };
        Self {
            target: Target::Effect { slot, index },
            scale,
            lower: lower.max(parameter.bounds.lower()),
            upper: upper.min(parameter.bounds.upper()),
            declared: None,
        }
    }

    /// A number of the current's sensor; what it is declared as, unless the log says otherwise. `rms`: root mean
    /// square of the current, A.
    fn current(declared: &Model, reading: Reading, rms: f32, period: f32) -> Self {
        let declared = declared.current_sensor.get(reading);
        let scale = match reading {
            Reading::Gain => SENSOR_GAIN,
            Reading::Offset => SENSOR_OFFSET * rms,
            Reading::Lag => period,
        };
        // A sensor is not early.
        let lower = match reading {
            Reading::Lag => declared,
            Reading::Gain | Reading::Offset => declared - SENSOR_REACH * scale,
        };
        Self {
            target: Target::Current(reading),
            scale,
            lower,
            upper: declared + SENSOR_REACH * scale,
            declared: Some(declared),
        }
    }

    /// A knot of the learned map; zero unless the log says otherwise.
    fn knot(index: usize, scope: &Scope) -> Self {
        let scale = scope.strong().friction;
        Self {
            target: Target::Knot(index),
            scale,
            lower: -REACH * scale,
            upper: REACH * scale,
            declared: Some(0.0),
        }
    }

    /// Whether it is a strength of an effect.
    pub fn is_strength(&self, model: &Model) -> bool {
        matches!(self.target, Target::Effect { slot, .. } if self.is_strength_of(model, slot))
    }

    /// Whether it is a strength of the effect in this slot.
    pub fn is_strength_of(&self, model: &Model, slot: usize) -> bool {
        matches!(self.target, Target::Effect { slot: own, index }
            if own == slot && index < model.effects[slot].id.strengths())
    }

    /// What its declared value weighs in a fit.
    pub(super) fn weight(&self) -> f64 {
        self.declared.map_or(0.0, |_| DECLARED_WEIGHT)
    }

    /// How far it is from its declared value, in scales.
    pub(super) fn departure(&self, model: &Model) -> f64 {
        self.declared.map_or(0.0, |declared| {
            f64::from((self.get(model) - declared) / self.scale)
        })
    }

    /// Its value in a model.
    pub fn get(&self, model: &Model) -> f32 {
        match self.target {
            Target::Base(parameter) => model.get(parameter),
            Target::Current(reading) => model.current_sensor.get(reading),
            Target::Effect { slot, index } => model.effects[slot].values[index],
            Target::Knot(index) => model.map.map_or(0.0, |map| map.knots[index]),
        }
    }

    /// The nearest value that it may have.
    // Not `clamp`, which panics where rounding has crossed the bounds.
    pub fn within_bounds(&self, value: f32) -> f32 {
        value.max(self.lower).min(self.upper)
    }

    /// Sets it in a model.
    pub fn set(&self, model: &mut Model, value: f32) {
        match self.target {
            Target::Base(parameter) => model.set(parameter, value),
            Target::Current(reading) => model.current_sensor.set(reading, value),
            Target::Effect { slot, index } => model.effects[slot].values[index] = value,
            Target::Knot(index) => {
                if let Some(map) = &mut model.map {
                    map.knots[index] = value;
                }
            }
        }
    }
}

/// The variables of a model: those of its base, of the effects and of the map that the declared
/// one does not have, and of the current's sensor these. What the user declares of an effect stays as it is.
pub fn variables(
    declared: &Model,
    model: &Model,
    (base, readings): (&[Base], &[Reading]),
    scope: &Scope,
) -> Variables {
    let mut variables = Variables::new();
    for &parameter in base {
        let _ = variables.push(Variable::base(declared, parameter, scope));
    }
    for (slot, effect) in model
        .effects
        .iter()
        .enumerate()
        .skip(declared.effects.len())
    {
        for index in (0..MOST_PARAMETERS).filter(|&index| effect.has(index)) {
            let value = effect.values[index];
            let _ = variables.push(Variable::effect(effect.id, slot, index, value, scope));
        }
    }
    if model.map.is_some() {
        for index in 0..KNOTS {
            let _ = variables.push(Variable::knot(index, scope));
        }
    }
    let rms = scope.torque / declared.plant.torque_per_current();
    for &reading in readings {
        let _ = variables.push(Variable::current(declared, reading, rms, scope.period));
    }
    variables
}

/// How long a fit may take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Most steps.
    pub steps: u32,
    /// A step that lowers the cost by less than this share, or promises to, ends the fit. Small,
    /// because where a parameter and a missing effect stand in for each other the way down is long
    /// and flat.
    pub converged: f64,
}

/// A fitted model.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The model at the minimum.
    pub model: Model,
    /// Sum of the squared weighted residuals.
    pub cost: f64,
    /// Windows simulated, each copy counted, those too that were left out of what a refused step costs.
    pub simulated: u64,
}

/// Adds perturbed copies of a model, one a variable, moved by a share of the variable's scale.
pub fn perturb<'m>(
    ensemble: &mut Ensemble<'m>,
    store: &'m Store,
    model: &Model,
    variables: &[Variable],
    period: f32,
) -> Option<()> {
    for variable in variables {
        if let Target::Current(reading) = variable.target {
            ensemble.push_reading(reading, variable.scale).ok()?;
            continue;
        }
        let value = variable.get(model);
        // Downwards where upwards would leave the bounds, or the plant's range: two end stops
        // must not meet.
        [DIFFERENCE, -DIFFERENCE].into_iter().find_map(|step| {
            let moved_value = value + step * variable.scale;
            if moved_value > variable.upper {
                return None;
            }
            let mut moved = model.clone();
            variable.set(&mut moved, moved_value);
            ensemble
                .push(store, (&moved, None), 1.0 / step, period)
                .ok()
        })?;
    }
    Some(())
}

/// What is fitted to what.
pub(super) struct Problem<'a, S> {
    pub data: &'a Data<'a>,
    pub schedule: &'a S,
    pub fold: (Fold, usize),
    pub variables: &'a [Variable],
    /// Windows simulated, each copy counted.
    pub simulated: u64,
}

impl<S: Schedule> Problem<'_, S> {
    /// Calls `work` with a model and its perturbed copies, one a variable.
    ///
    /// `None` if one of them cannot be built.
    #[inline(never)]
    pub fn with_copies(
        &mut self,
        model: &Model,
        work: impl FnOnce(&mut Self, &Ensemble),
    ) -> Option<()> {
        let period = self.data.logs.first()?.period;
        let store = Store::new();
        let mut ensemble = Ensemble::new();
        ensemble.start(&store, model, period).ok()?;
        perturb(&mut ensemble, &store, model, self.variables, period)?;
        work(self, &ensemble);
        Some(())
    }

    /// The sums at a model, sensitivities per scale of each variable, with the weight of the declared
    /// values.
    pub fn sum(&mut self, sums: &mut Sums, model: &Model, copies: &Ensemble) {
        sums.replay(self.data, self.schedule, self.fold, copies);
        self.simulated += sums.simulated(copies);
        sums.products.row_mut(0)[0] += self.cost_of_departure(model);
        for (index, variable) in self.variables.iter().enumerate() {
            let weight = variable.weight();
            let row = sums.products.row_mut(index + 1);
            row[0] += weight * variable.departure(model);
            row[index + 1] += weight;
        }
    }

    fn linearise(&mut self, sums: &mut Sums, model: &Model) -> Option<()> {
        self.with_copies(model, |problem, copies| problem.sum(sums, model, copies))
    }

    /// Sum of the squared weighted residuals of a model, the first of the sums, if it is below `limit`.
    #[inline(never)]
    fn cost_below(&mut self, limit: f64, model: &Model) -> Option<f64> {
        let simulator = model.build(self.data.logs.first()?.period).ok()?;
        self.simulated += self.data.windows_in_fold(self.fold) as u64;
        let cost = replay::cost_below(limit, self.data, self.schedule, self.fold, &simulator)?;
        let cost = cost + self.cost_of_departure(model);
        (cost < limit).then_some(cost)
    }

    fn cost_of_departure(&self, model: &Model) -> f64 {
        let cost = |variable: &Variable| {
            let departure = variable.departure(model);
            variable.weight() * departure * departure
        };
        self.variables.iter().map(cost).sum()
    }
}

/// Fits the variables to the windows of a fold, starting from the model as it is.
///
/// `None` if the model cannot be built.
pub fn fit(
    data: &Data,
    schedule: &impl Schedule,
    fold: (Fold, usize),
    start: &Model,
    variables: &[Variable],
    effort: Effort,
) -> Option<Fit> {
    let mut problem = Problem {
        data,
        schedule,
        fold,
        variables,
        simulated: 0,
    };
    let mut model = start.clone();
    for variable in variables {
        let value = variable.get(&model);
        variable.set(&mut model, value.max(variable.lower).min(variable.upper));
    }
    let mut sums = Sums::default();
    problem.linearise(&mut sums, &model)?;
    let mut least = sums.products.at(0, 0);
    let mut damping = 1e-3;
    // Breakaway acts through sticking alone, which comes and goes by jumps: a derivative across a
    // jump misleads the whole step. What is refused with it is tried without.
    let breakaway = variables
        .iter()
        .any(|variable| variable.target == Target::Base(Base::Static));
    for _ in 0..effort.steps {
        if variables.is_empty() {
            break;
        }
        let cost = least;
        let mut stepped = None;
        for _ in 0..MOST_REFUSALS {
            let (candidate, promised) = damped_step(&model, variables, &sums, damping, None);
            // A smaller step, or one with a variable held, promises less still.
            if promised < effort.converged * cost {
                break;
            }
            // A step that leaves the plant's range is refused like one that raises the cost.
            let mut lowered = |candidate: Model| {
                let trial = problem.cost_below(cost, &candidate)?;
                Some((candidate, trial))
            };
            let mut better = lowered(candidate);
            if better.is_none() && breakaway {
                let held = Some(Base::Static);
                let (candidate, without) = damped_step(&model, variables, &sums, damping, held);
                if without >= effort.converged * cost {
                    better = lowered(candidate);
                }
            }
            if better.is_some() {
                damping = (damping * 0.2f64).max(1e-7);
                stepped = better;
                break;
            }
            damping = damping.max(LEAST_DAMPING) * MORE_DAMPING;
        }
        let Some((candidate, lowered)) = stepped else {
            break;
        };
        model = candidate;
        least = lowered;
        // Nothing asks for the sensitivities at the minimum.
        if lowered > cost * (1.0 - effort.converged) {
            break;
        }
        problem.linearise(&mut sums, &model)?;
    }
    Some(Fit {
        model,
        cost: least,
        simulated: problem.simulated,
    })
}

/// A matrix over the variables of a fit.
pub type Matrix = Triangle<f64, { entries(MOST_VARIABLES) }>;

impl Sums {
    /// The normal matrix of the first `count` variables.
    #[inline]
    pub fn normal(&self, count: usize) -> Matrix {
        Matrix::leading(count, |row, column| self.products.at(row + 1, column + 1))
    }
}

/// The damped Gauss–Newton step, clipped to the variables' bounds, and by how much it lowers the
/// cost as far as the sensitivities tell.
///
/// A variable at a bound that the slope pushes it against stays there, and so does `held`: the
/// others are stepped without them.
#[inline(never)]
fn damped_step(
    model: &Model,
    variables: &[Variable],
    sums: &Sums,
    damping: f64,
    held: Option<Base>,
) -> (Model, f64) {
    let slope = |index: usize| sums.products.at(index + 1, 0);
    let stays = |index: usize| {
        let variable = &variables[index];
        let (value, slope) = (variable.get(model), slope(index));
        held.is_some_and(|base| variable.target == Target::Base(base))
            || (value <= variable.lower && slope > 0.0)
            || (value >= variable.upper && slope < 0.0)
    };
    let count = variables.len();
    let mut normal = Matrix::default();
    let mut step = [0.0; MOST_VARIABLES];
    for row in 0..count {
        // An empty row counts as dependent, and its step is zero.
        if stays(row) {
            continue;
        }
        step[row] = -slope(row);
        let entries = normal.row_mut(row);
        for column in (0..=row).filter(|&column| !stays(column)) {
            entries[column] = sums.products.at(row + 1, column + 1);
        }
        entries[row] *= 1.0 + damping;
    }
    Cholesky::new(normal, count).solve(&mut step[..count]);
    let mut moved = model.clone();
    for (variable, step) in variables.iter().zip(&mut step) {
        let start = variable.get(model);
        let value = start + *step as f32 * variable.scale;
        if value.is_finite() {
            let value = variable.within_bounds(value);
            variable.set(&mut moved, value);
            *step = f64::from((value - start) / variable.scale);
        }
    }
    let promised = (0..count).map(|row| {
        let curve = (0..count).map(|column| sums.products.at(row + 1, column + 1) * step[column]);
        -step[row] * (2.0 * slope(row) + curve.sum::<f64>())
    });
    (moved, promised.sum())
}
