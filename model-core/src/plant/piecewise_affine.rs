//! A piecewise affine model of an actuator (PWARX), learned from its input and output alone.
//!
//! The regressor is the last position, its change since the position before, and the input:
//! x = (y(k−1), y(k−1) − y(k−2), u(k−1)). Space is cut into *cells*; in cell i the position grows in
//! a period by an affine function of x:
//!
//! y(k) = y(k−1) + θᵢᵀ (x, 1) where ηᵢᵀ (x, 1) is the largest of all η.
//!
//! Where one of several affine functions is the largest is a polyhedron, its half-planes
//! (ηᵢ − ηⱼ)ᵀ (x, 1) ≥ 0. The polyhedra cover the space and overlap on their boundaries only; there
//! the first cell is taken. The nearest of several centres, which k-means asks for, is the case
//! ηᵢ = (cᵢ, −½ |cᵢ|²).
//!
//! Source: *On Semi-Automated Modeling of Systems with Friction for HiL-Simulation and Application
//! to Electromechanical Actuators of Passenger Car*, eqs. 21 and 22. There a sub-model gives y(k);
//! growth is the same with one less in the coefficient of y(k−1), and loses no digits in `f32`.
//! The limits are ours: end stops are exact, and no sub-model can carry the position away.

use heapless::Vec;

use super::actuator::INPUT_LIMIT;
use super::{InputRefused, LONGEST_PERIOD};
use crate::numeric::invalid_parameter::{InvalidParameter, require};

/// Most cells of a model.
pub const MOST_CELLS: usize = 10;

/// Largest magnitude of a coefficient, so that no sum of products overflows.
const LARGEST: f32 = 1e12;
/// Largest magnitude of a limit of the position.
const LARGEST_POSITION: f32 = 1e6;

/// An affine function of the regressor.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Affine {
    /// Per rad or m of the last position.
    pub position: f32,
    /// Per rad or m by which the position changed in the last period.
    pub change: f32,
    /// Per unit of the input.
    pub input: f32,
    /// What is left where all of them are zero.
    pub constant: f32,
}

impl Affine {
    /// Its value, summed in the order of the fields.
    #[inline]
    pub fn value(&self, position: f32, change: f32, input: f32) -> f32 {
        self.position * position + self.change * change + self.input * input + self.constant
    }

    /// Whether every coefficient is at most [`LARGEST`]; a NaN is not.
    fn is_bounded(&self) -> bool {
        [self.position, self.change, self.input, self.constant]
            .iter()
            .all(|coefficient| coefficient.abs() <= LARGEST)
    }
}

/// A cell and what the actuator does in it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Cell {
    /// The cell is where this is the largest of all cells'; no unit.
    pub region: Affine,
    /// Growth of the position in a period, rad or m.
    pub growth: Affine,
}

/// What a model is made of.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Parameters {
    /// Period of a step, s, > 0.
    pub period: f32,
    /// Lower limit of the position, rad or m.
    pub lower_limit: f32,
    /// Upper limit of the position, rad or m.
    pub upper_limit: f32,
    /// At least one cell.
    pub cells: Vec<Cell, MOST_CELLS>,
}

/// A model that was checked.
///
/// ```
/// use model_core::plant::piecewise_affine::{Affine, Cell, Parameters, PiecewiseAffine};
///
/// // Below 1 V nothing moves, above it the position grows by 0.01 rad a volt and period.
/// let still = Cell::default();
/// let moving = Cell {
///     region: Affine { input: 1.0, constant: -1.0, ..Affine::default() },
///     growth: Affine { input: 0.01, constant: -0.01, ..Affine::default() },
/// };
/// let model = PiecewiseAffine::build(Parameters {
///     period: 0.01,
///     lower_limit: 0.0,
///     upper_limit: 1.5,
///     cells: [still, moving].into_iter().collect(),
/// })?;
/// let mut state = model.rest(0.5)?;
/// assert_eq!(model.step(&mut state, 0.9)?, 0.5);
/// assert!((model.step(&mut state, 3.0)? - 0.52).abs() < 1e-6);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct PiecewiseAffine {
    parameters: Parameters,
}

/// Where a model stands.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct State {
    position: f32,
    before: f32,
}

impl State {
    /// Position, rad or m.
    #[inline]
    pub fn position(&self) -> f32 {
        self.position
    }
}

impl PiecewiseAffine {
    /// Checks a model.
    ///
    /// # Errors
    /// The first number outside its range.
    pub fn build(parameters: Parameters) -> Result<Self, InvalidParameter> {
        let Parameters {
            period,
            lower_limit,
            upper_limit,
            cells,
        } = &parameters;
        require(
            *period > 0.0 && *period <= LONGEST_PERIOD,
            "period",
            "must be above 0 and at most 10 s",
        )?;
        require(
            lower_limit.abs() <= LARGEST_POSITION && lower_limit < upper_limit,
            "lower_limit",
            "must be below upper_limit and at most 1e6 in magnitude",
        )?;
        require(
            upper_limit.abs() <= LARGEST_POSITION,
            "upper_limit",
            "must be at most 1e6 in magnitude",
        )?;
        require(!cells.is_empty(), "cells", "must hold at least one cell")?;
        for cell in cells {
            let requirement = "must be of finite coefficients of at most 1e12 in magnitude";
            require(cell.region.is_bounded(), "region", requirement)?;
            require(cell.growth.is_bounded(), "growth", requirement)?;
        }
        Ok(Self { parameters })
    }

    /// What it is made of.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// At rest at a position, at the nearer limit if it is beyond one.
    ///
    /// # Errors
    /// A position that is not finite.
    pub fn rest(&self, position: f32) -> Result<State, InputRefused> {
        if !position.is_finite() {
            return Err(InputRefused);
        }
        let position = self.limited(position);
        Ok(State {
            position,
            before: position,
        })
    }

    /// The cell in which the model is with this input.
    #[inline]
    pub fn cell(&self, state: &State, input: f32) -> usize {
        self.cell_at(state.position, state.position - state.before, input)
    }

    /// The cell that a regressor lies in: the first of those whose function is the largest.
    #[inline]
    pub fn cell_at(&self, position: f32, change: f32, input: f32) -> usize {
        let mut best = 0;
        let mut largest = f32::NEG_INFINITY;
        for (index, cell) in self.parameters.cells.iter().enumerate() {
            let value = cell.region.value(position, change, input);
            if value > largest {
                best = index;
                largest = value;
            }
        }
        best
    }

    /// Advances by a period in which the input is held (or has this mean) and returns the position,
    /// which is always within the limits.
    ///
    /// # Errors
    /// An input that is not finite or beyond [`INPUT_LIMIT`]; the state is unchanged.
    #[inline]
    pub fn step(&self, state: &mut State, input: f32) -> Result<f32, InputRefused> {
        // A NaN fails the comparison.
        let taken = input.abs() <= INPUT_LIMIT;
        if !taken {
            return Err(InputRefused);
        }
        let growth = &self.parameters.cells[self.cell(state, input)].growth;
        let change = state.position - state.before;
        let grown = state.position + growth.value(state.position, change, input);
        state.before = state.position;
        state.position = self.limited(grown);
        Ok(state.position)
    }

    /// The nearest position within the limits.
    fn limited(&self, position: f32) -> f32 {
        if position < self.parameters.lower_limit {
            self.parameters.lower_limit
        } else if position > self.parameters.upper_limit {
            self.parameters.upper_limit
        } else {
            position
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::Random;

    /// Three cells by the sign of the change and one by the input.
    fn parameters() -> Parameters {
        let cell = |region, growth| Cell { region, growth };
        let affine = |[position, change, input, constant]: [f32; 4]| Affine {
            position,
            change,
            input,
            constant,
        };
        Parameters {
            period: 0.01,
            lower_limit: -1.0,
            upper_limit: 1.0,
            cells: [
                cell(affine([0.0; 4]), affine([0.0, 0.5, 0.0, 0.0])),
                cell(
                    affine([0.5, 8.0, 1.0, -0.5]),
                    affine([-0.02, 0.75, 0.03, -0.01]),
                ),
                cell(
                    affine([-0.5, -8.0, -1.0, -0.5]),
                    affine([-0.03, 0.7, 0.02, 0.01]),
                ),
            ]
            .into_iter()
            .collect(),
        }
    }

    #[test]
    fn steps_are_those_by_hand() {
        let model = PiecewiseAffine::build(parameters()).unwrap();
        let mut state = model.rest(0.5).unwrap();
        // Regions 0, 0.25 − 0.5 + u and −0.75 − u: at rest between −0.75 and 0.25.
        assert_eq!(model.cell(&state, 0.2), 0);
        assert_eq!(model.cell(&state, 0.3), 1);
        assert_eq!(model.cell(&state, -0.8), 2);
        let cases = [
            // 0.5 − 0.02·0.5 + 0.03·2 − 0.01
            (2.0, 0.54_f32),
            // In cell 1 by its change: 0.27 + 0.32 − 0.5 > 0; 0.54 − 0.0108 + 0.03 − 0.01
            (0.0, 0.5492),
        ];
        for (input, expected) in cases {
            let position = model.step(&mut state, input).unwrap();
            assert!((position - expected).abs() < 1e-6, "{position}");
        }
    }

    #[test]
    fn positions_stay_within_the_limits_whatever_the_sub_models() {
        let mut wild = parameters();
        for cell in &mut wild.cells {
            cell.growth.position = 3.0;
            cell.growth.change = 1e12;
            cell.growth.input = -1e12;
        }
        let model = PiecewiseAffine::build(wild).unwrap();
        let mut random = Random::new(1, 1);
        let mut state = model.rest(7.0).unwrap();
        assert_eq!(state.position(), 1.0);
        for _ in 0..1000 {
            let input = INPUT_LIMIT * (2.0 * random.uniform() - 1.0);
            let position = model.step(&mut state, input).unwrap();
            assert!((-1.0..=1.0).contains(&position));
        }
    }

    #[test]
    fn what_is_no_input_is_refused_and_changes_nothing() {
        let model = PiecewiseAffine::build(parameters()).unwrap();
        let mut state = model.rest(0.25).unwrap();
        model.step(&mut state, 1.0).unwrap();
        let before = state;
        for input in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 2e6] {
            assert_eq!(model.step(&mut state, input), Err(InputRefused));
            assert_eq!(state, before);
        }
        assert_eq!(model.rest(f32::NAN), Err(InputRefused));
    }

    #[test]
    fn what_is_no_model_is_refused_by_name() {
        type Spoil = fn(&mut Parameters);
        let spoilt: [(Spoil, &str); 8] = [
            (|p| p.period = 0.0, "period"),
            (|p| p.period = f32::NAN, "period"),
            (|p| p.lower_limit = 1.0, "lower_limit"),
            (|p| p.lower_limit = f32::NEG_INFINITY, "lower_limit"),
            (|p| p.upper_limit = f32::INFINITY, "upper_limit"),
            (|p| p.cells.clear(), "cells"),
            (|p| p.cells[1].region.change = f32::NAN, "region"),
            (|p| p.cells[2].growth.constant = 1e13, "growth"),
        ];
        for (spoil, name) in spoilt {
            let mut parameters = parameters();
            spoil(&mut parameters);
            let error = PiecewiseAffine::build(parameters).unwrap_err();
            assert_eq!(error.name, name);
        }
    }
}
