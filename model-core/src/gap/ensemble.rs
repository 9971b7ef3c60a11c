//! A model and its perturbed copies, which are replayed in lockstep.
//!
//! Modes are most of a simulator's size and nearly all of the work of building one, and few
//! perturbations change them: copies share what they have in common.

use super::model::{Model, Simulator};
use crate::plant::mode_store::ModeStore;
use crate::plant::modes::Modes;
use crate::plant::parameters::ParameterError;
use heapless::Vec;

/// Columns of the sums: the residual and up to 31 perturbed copies.
pub const COLUMNS: usize = 32;

/// Most copies that are moved the opposite way: one a signed strength of the catalogue.
const MOST_OPPOSITES: usize = 8;

/// Most simulators: one a column, and the opposite ones.
pub const MOST_SIMULATORS: usize = COLUMNS + MOST_OPPOSITES;

/// Most modes that the copies of one model need. Moved are resistance, inductance, torque constant,
/// inertia, viscous friction, its asymmetry (in a screening to both sides), the declared spring, the
/// effect, and the delay by either end: with the model itself eleven. The twelfth is the model's own
/// with half the step, under held effects. A delay inside a step doubles them.
const MOST_MODES: usize = 24;

/// Room for the modes of an ensemble.
pub type Store = ModeStore<MOST_MODES>;

/// A copy of the model with one parameter moved, or two moved opposite ways.
#[derive(Debug, Clone)]
pub struct Lane {
    /// Whether there is a copy moved the other way, where a difference to both sides is wanted:
    /// friction makes the two sides differ.
    pub two_sided: bool,
    /// One over the distance of the two copies (or of the copy from the model), in units of the
    /// fit's variable.
    pub inverse_step: f32,
}

/// A model and its perturbed copies.
#[derive(Debug, Clone)]
pub struct Ensemble<'m> {
    /// The model; then of each lane the copy, and the opposite one where there is one.
    simulators: Vec<Simulator<&'m Modes>, MOST_SIMULATORS>,
    lanes: Vec<Lane, { COLUMNS - 1 }>,
}

/// What a full ensemble says.
const FULL: ParameterError = ParameterError {
    parameter: "variables",
    requirement: "no more than there is room for",
};

impl<'m> Ensemble<'m> {
    /// Nobody, yet.
    pub const fn new() -> Self {
        Self {
            simulators: Vec::new(),
            lanes: Vec::new(),
        }
    }

    /// Takes a model without copies.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn start(
        &mut self,
        store: &'m Store,
        model: &Model,
        period: f32,
    ) -> Result<(), ParameterError> {
        self.simulators.clear();
        self.lanes.clear();
        self.push_simulator(store, model, period)
    }

    /// Adds a copy, and the one moved the other way where there is one.
    ///
    /// # Errors
    /// A parameter outside its range, more copies than there is room for. Nothing is added.
    pub fn push(
        &mut self,
        store: &'m Store,
        (moved, opposite): (&Model, Option<&Model>),
        inverse_step: f32,
        period: f32,
    ) -> Result<(), ParameterError> {
        let simulators = self.simulators.len();
        let pushed = (|| {
            self.push_simulator(store, moved, period)?;
            if let Some(opposite) = opposite {
                self.push_simulator(store, opposite, period)?;
            }
            let lane = Lane {
                two_sided: opposite.is_some(),
                inverse_step,
            };
            self.lanes.push(lane).map_err(|_| FULL)
        })();
        if pushed.is_err() {
            self.simulators.truncate(simulators);
        }
        pushed
    }

    fn push_simulator(
        &mut self,
        store: &'m Store,
        model: &Model,
        period: f32,
    ) -> Result<(), ParameterError> {
        let simulator = model.build_with(period, |basis| store.modes(basis))?;
        self.simulators.push(simulator).map_err(|_| FULL)
    }

    /// Keeps the first copies.
    pub fn truncate(&mut self, lanes: usize) {
        self.lanes.truncate(lanes);
        let opposites = self.lanes.iter().filter(|lane| lane.two_sided).count();
        self.simulators.truncate(1 + self.lanes.len() + opposites);
    }

    /// The copies: one a column of the sums behind the residual's.
    pub fn lanes(&self) -> &[Lane] {
        &self.lanes
    }

    /// The model; then of each lane the copy, and the opposite one where there is one.
    pub fn simulators(&self) -> &[Simulator<&'m Modes>] {
        &self.simulators
    }
}

impl Default for Ensemble<'_> {
    fn default() -> Self {
        Self::new()
    }
}
