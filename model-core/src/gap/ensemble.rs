//! A model and its perturbed copies, which are replayed in lockstep.
//!
//! Modes are most of a simulator's size and nearly all of the work of building one, and few
//! perturbations change them: copies share what they have in common.

use super::current_sensor::{CurrentSensor, Reading};
use super::fit::MOST_VARIABLES;
use super::held::{Held, Varied};
use super::model::Model;
use super::simulator::Simulator;
use crate::plant::mode_store::ModeStore;
use crate::plant::modes::Modes;
use crate::plant::parameters::ParameterError;
use core::cell::OnceCell;
use heapless::Vec;

/// Columns of the sums: the residual and a perturbed copy for each of the variables of the largest fit.
pub const COLUMNS: usize = MOST_VARIABLES + 1;

/// Most copies that are moved the opposite way; a screening has more signed strengths, and moves the
/// last ones one way only.
const MOST_OPPOSITES: usize = 8;

/// Most simulators: one a column that is not the current's sensor's, and the opposite ones.
pub const MOST_SIMULATORS: usize = COLUMNS - Reading::ALL.len() + MOST_OPPOSITES;

/// Most modes that the copies of one model need: its own, those with another resistance, inductance,
/// torque constant, inertia, viscous friction or declared spring, with the spring of the catalogue,
/// with viscous friction that differs by direction (either way in a screening), with two other
/// delays and another lead of the input, and its own at half the step, under held effects. A delay that ends inside a step
/// doubles them.
const MOST_MODES: usize = 28;

/// What the simulators of an ensemble share.
#[derive(Debug)]
pub struct Store {
    modes: ModeStore<MOST_MODES>,
    /// What the model holds over a step.
    held: OnceCell<Held>,
}

impl Store {
    /// An empty store.
    // As in `ModeStore`: 16 KB are not to be made twice.
    #[inline(always)]
    pub fn new() -> Self {
        Self {
            modes: ModeStore::new(),
            held: OnceCell::new(),
        }
    }
}

impl Default for Store {
    fn default() -> Self {
        Self::new()
    }
}

/// One simulator among those that share a store.
pub type Member<'m> = Simulator<&'m Modes, Varied<'m>>;

/// Whose residuals give a column.
#[derive(Debug, Clone, Copy)]
pub enum Source {
    /// Those of a copy of the model with one parameter moved, or of two moved opposite ways.
    Copies {
        /// Whether there is a copy moved the other way, where a difference to both sides is wanted:
        /// friction makes the two sides differ.
        two_sided: bool,
        /// One over the distance of the two copies (or of the copy from the model), in units of the
        /// fit's variable.
        inverse_step: f32,
    },
    /// Those of the model itself, in which a number of the current's sensor changes the second alone.
    Sensor {
        /// The number.
        reading: Reading,
        /// What the fit's variable counts it in.
        scale: f32,
    },
}

/// A column of the sums behind the residual's.
#[derive(Debug, Clone)]
pub struct Lane {
    /// Whose residuals give it.
    pub source: Source,
    /// Its products are wanted with the columns before the first number, and from the second on.
    partners: (usize, usize),
}

/// A model and its perturbed copies.
#[derive(Debug, Clone)]
pub struct Ensemble<'m> {
    /// The model; then of each lane the copy, and the opposite one where there is one.
    simulators: Vec<Member<'m>, MOST_SIMULATORS>,
    lanes: Vec<Lane, { COLUMNS - 1 }>,
    /// Columns before all groups, and the first of the group that is open.
    group: Option<(usize, usize)>,
    one_run_in: bool,
}

/// What a full ensemble says.
const FULL: ParameterError = ParameterError {
    parameter: "variables",
    requirement: "no more than there is room for",
};

impl<'m> Ensemble<'m> {
    /// Nobody, yet.
    #[inline]
    pub const fn new() -> Self {
        Self {
            simulators: Vec::new(),
            lanes: Vec::new(),
            group: None,
            one_run_in: false,
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
        self.group = None;
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
            self.push_lane(Source::Copies {
                two_sided: opposite.is_some(),
                inverse_step,
            })
        })();
        if pushed.is_err() {
            self.simulators.truncate(simulators);
        }
        pushed
    }

    /// Adds a number of the current's sensor, which needs no copy.
    ///
    /// # Errors
    /// More columns than there is room for.
    pub fn push_reading(&mut self, reading: Reading, scale: f32) -> Result<(), ParameterError> {
        self.push_lane(Source::Sensor { reading, scale })
    }

    fn push_lane(&mut self, source: Source) -> Result<(), ParameterError> {
        let lane = Lane {
            source,
            partners: self.group.unwrap_or((0, 0)),
        };
        self.lanes.push(lane).map_err(|_| FULL)
    }

    fn push_simulator(
        &mut self,
        store: &'m Store,
        model: &Model,
        period: f32,
    ) -> Result<(), ParameterError> {
        // The first to come is the model.
        let share = |held: Held| match store.held.get() {
            Some(common) => Varied::new(common, &held),
            None => Varied::new(store.held.get_or_init(|| held.clone()), &held),
        };
        let simulator = Simulator::new(model, period, |basis| store.modes.modes(basis), share)?;
        self.simulators.push(simulator).map_err(|_| FULL)
    }

    /// Opens a group. The products of its columns with those of other groups are left out of the
    /// sums.
    pub fn separate(&mut self) {
        let columns = 1 + self.lanes.len();
        let before = self.group.map_or(columns, |(before, _)| before);
        self.group = Some((before, columns));
    }

    /// The columns up to `column` with which its products are wanted: those before the first number,
    /// and those from the second on.
    #[inline]
    pub fn partners(&self, column: usize) -> (usize, usize) {
        match column.checked_sub(1) {
            Some(lane) => self.lanes[lane].partners,
            None => (0, 0),
        }
    }

    /// Keeps the first copies. No group is open any more.
    pub fn truncate(&mut self, lanes: usize) {
        self.group = None;
        self.lanes.truncate(lanes);
        let copies = self.lanes.iter().map(|lane| match lane.source {
            Source::Copies { two_sided, .. } => 1 + usize::from(two_sided),
            Source::Sensor { .. } => 0,
        });
        self.simulators.truncate(1 + copies.sum::<usize>());
    }

    /// Has copies that run in to a window like the model start from where it comes to, as all start from
    /// one measured state: what they would change in the run-in is left out.
    pub fn share_run_in(&mut self) {
        self.one_run_in = true;
    }

    /// The model, where they do.
    pub fn shared_run_in(&self) -> Option<&Member<'m>> {
        self.simulators.first().filter(|_| self.one_run_in)
    }

    /// How the model's current is measured.
    pub fn current_sensor(&self) -> CurrentSensor {
        let model = self.simulators.first();
        model.map_or_else(CurrentSensor::default, |model| *model.current_sensor())
    }

    /// Whether the current is read within a step of the model, not at the end of one.
    pub fn reads_within_steps(&self) -> bool {
        let model = self.simulators.first();
        model.is_some_and(|model| model.current_lateness().share > 0.0)
    }

    /// The copies: one a column of the sums behind the residual's.
    pub fn lanes(&self) -> &[Lane] {
        &self.lanes
    }

    /// The model; then of each lane the copy, and the opposite one where there is one.
    pub fn simulators(&self) -> &[Member<'m>] {
        &self.simulators
    }
}

impl Default for Ensemble<'_> {
    fn default() -> Self {
        Self::new()
    }
}
