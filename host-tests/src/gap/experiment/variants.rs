//! The candidates with numbers a little off: what a machine may be whose logs leave them uncertain.

use model_core::gap::fit::Target;
use model_core::gap::model::Model;
use model_core::gap::replay::Schedule;
use model_core::gap::workbench::Workbench;
use model_core::numeric::random::Random;
use model_core::unit::Dimension;

/// Variants beside the candidates as they are fitted.
pub(super) const VARIANTS: usize = 3;

/// How far a fitted number is off at most, either way, as a share of it.
pub(super) const OFF: f32 = 0.05;

/// Stream of the random numbers: every search has the same variants.
const STREAM: u64 = 7;

/// The variants of a model, the first of them the model itself. All models have the same numbers of
/// the machine off by the same shares.
pub(super) fn of(workbench: &Workbench<impl Schedule>, model: &Model) -> Vec<Model> {
    let moved = (0..VARIANTS).map(|variant| {
        let mut random = Random::new(variant as u64, STREAM);
        let mut beside = model.clone();
        for variable in &workbench.variables(model) {
            let value = variable.get(model);
            // A position has no natural zero.
            let size = match variable.target {
                Target::Base(base) if base.dimension() == Dimension::Position => variable.scale,
                _ => value,
            };
            let moved = value + OFF * (2.0 * random.uniform() - 1.0) * size;
            variable.set(&mut beside, moved.clamp(variable.lower, variable.upper));
        }
        beside
    });
    std::iter::once(model.clone()).chain(moved).collect()
}
