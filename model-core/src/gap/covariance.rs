//! How surely a fit determines its variables.

use super::criterion::DECLARED_WEIGHT;
use super::fit::{MOST_VARIABLES, Matrix, Problem, Target, Variable};
use super::model::Model;
use super::replay::{Data, Fold, Schedule, Sums, WindowSums, replay_windows};
use crate::effect::MOST_STRENGTHS;
use crate::numeric::cholesky::Cholesky;
use crate::numeric::statistics::median;
use crate::numeric::triangle::{Triangle, entries};
use heapless::Vec;

/// Share of a window's normal matrix that is left out: what one window alone determines is still
/// determined without it, if by little.
const LEFT_OUT: f64 = 0.95;

/// What a log says about the variables of a fit at its minimum.
///
/// The jackknife over windows, linearised: with the normal matrix N of the log, N_w of a window and
/// its gradient g_w, leaving the window out moves the fit by about
///
/// ```text
/// d_w = (N − 0.95 N_w)⁻¹ g_w
/// ```
///
/// and the covariance is the sum of d_w d_wᵀ. Residuals may be correlated within a window. A window
/// that decides much (the one in which the machine breaks away) pulls the fit to itself and has small
/// residuals for it: the sandwich N⁻¹ G N⁻¹, with the sum G of g_w g_wᵀ, takes it at its word and says
/// too little, the jackknife does not. Source: R. M. Bell, D. F. McCaffrey, *Bias reduction in standard
/// errors for linear regression with multi-stage samples*, 2002, there without the 0.95, which is ours.
///
/// What all windows have in common no jackknife sees. Replays restart from smoothed states, which are
/// off by what the smoothing takes away; and a law that is not quite the machine's has other best numbers over another length of
/// prediction. [`Information::allow_for_others`] adds what either may do, of logs that are restarted or cut otherwise.
#[derive(Debug, Clone, Default)]
pub struct Information {
    sums: Sums,
    /// Squares and products of what the windows, each left out, move the variables by.
    moves: Matrix,
}

/// Covariance of the variables of a fit in SI units.
pub type Covariance = Matrix;

/// How far the variables are moved by leaving out a window.
#[inline(never)]
fn move_without(log: &Sums, window: &WindowSums, count: usize) -> [f64; MOST_VARIABLES] {
    let rest = Matrix::leading(count, |row, column| {
        let left_out = LEFT_OUT * f64::from(window.at(row + 1, column + 1));
        log.products.at(row + 1, column + 1) - left_out
    });
    let mut step = [0.0; MOST_VARIABLES];
    for (row, slope) in step.iter_mut().enumerate().take(count) {
        *slope = f64::from(window.at(row + 1, 0));
    }
    Cholesky::new(rest, count).solve(&mut step[..count]);
    step
}

/// Adds a weighted s sᵀ.
fn add_square(matrix: &mut Matrix, step: &[f64], weight: f64) {
    for (row, own) in step.iter().enumerate() {
        for (product, other) in matrix.row_mut(row).iter_mut().zip(step) {
            *product += weight * own * other;
        }
    }
}

/// How far the sums are from their minimum.
#[inline(never)]
fn step_left(sums: &Sums, count: usize) -> [f64; MOST_VARIABLES] {
    let mut step = [0.0; MOST_VARIABLES];
    for (row, slope) in step.iter_mut().enumerate().take(count) {
        *slope = sums.products.at(row + 1, 0);
    }
    Cholesky::new(sums.normal(count), count).solve(&mut step[..count]);
    step
}

impl Information {
    /// Replays all windows with the fitted model, twice. Gives the windows simulated, each copy
    /// counted.
    ///
    /// `None` if the model cannot be built.
    // In a frame of its own, as what follows it: the replays lie deepest in the stack.
    #[inline(never)]
    pub fn gather(
        &mut self,
        data: &Data,
        schedule: &impl Schedule,
        model: &Model,
        variables: &[Variable],
    ) -> Option<u64> {
        let mut problem = Problem {
            data,
            schedule,
            fold: (Fold::All, 1),
            variables,
            simulated: 0,
        };
        let Self { sums, moves } = self;
        *moves = Matrix::default();
        problem.with_copies(model, |problem, copies| {
            problem.sum(sums, model, copies);
            replay_windows(data, schedule, problem.fold, copies, |window| {
                let step = move_without(sums, window, variables.len());
                add_square(moves, &step[..variables.len()], 1.0);
            });
            problem.simulated += sums.simulated(copies);
        })?;
        self.allow_for_sensor(variables);
        Some(problem.simulated)
    }

    /// Adds what is known of the current's sensor beforehand: it is known as surely as its weight says.
    #[inline(never)]
    fn allow_for_sensor(&mut self, variables: &[Variable]) {
        let own = |variable: &&Variable| matches!(variable.target, Target::Current(_));
        if !variables.iter().any(|variable| own(&variable)) {
            return;
        }
        let factor = Cholesky::new(self.sums.normal(variables.len()), variables.len());
        let places = variables.iter().enumerate();
        for (place, variable) in places.filter(|(_, variable)| own(variable)) {
            let mut step = [0.0; MOST_VARIABLES];
            step[place] = 1.0;
            factor.solve(&mut step[..variables.len()]);
            add_square(&mut self.moves, &step[..variables.len()], variable.weight());
        }
    }

    /// Adds the mean square of how far the fit would be moved by the same logs, cut or restarted otherwise. Gives the windows
    /// simulated, each copy counted.
    ///
    /// `None` if the model cannot be built.
    #[inline(never)]
    pub fn allow_for_others(
        &mut self,
        others: &[Option<Data>; 2],
        schedule: &impl Schedule,
        model: &Model,
        variables: &[Variable],
    ) -> Option<u64> {
        let mut simulated = 0;
        let count = variables.len();
        let own = step_left(&self.sums, count);
        let weight = 1.0 / others.iter().flatten().count().max(1) as f64;
        for data in others.iter().flatten() {
            let mut problem = Problem {
                data,
                schedule,
                fold: (Fold::All, 1),
                variables,
                simulated: 0,
            };
            let mut sums = Sums::default();
            problem.with_copies(model, |problem, copies| {
                problem.sum(&mut sums, model, copies);
            })?;
            simulated += problem.simulated;
            let mut moved = step_left(&sums, count);
            for (moved, own) in moved.iter_mut().zip(own) {
                *moved -= own;
            }
            add_square(&mut self.moves, &moved[..count], weight);
        }
        Some(simulated)
    }

    /// How many times as large as of independent residuals the variances are, the median of the variables.
    pub fn inflation(&self, count: usize) -> f64 {
        let factor = Cholesky::new(self.sums.normal(count), count);
        let ratios = (0..count).filter_map(|place| {
            let mut column = [0.0; MOST_VARIABLES];
            column[place] = 1.0;
            factor.solve(&mut column[..count]);
            (column[place] > 0.0).then(|| (self.moves.at(place, place) / column[place]) as f32)
        });
        let mut ratios: Vec<f32, MOST_VARIABLES> = ratios.collect();
        f64::from(median(&mut ratios).unwrap_or(1.0))
    }

    /// Variance of a variable, in squared scales.
    pub fn variance(&self, place: usize) -> f64 {
        self.moves.at(place, place)
    }

    /// Adds what a number may be off by that the variables go with: by so much of their scales for one of its own, which has
    /// this variance.
    pub fn allow_for(&mut self, moved: &[f64], variance: f64) {
        if variance > 0.0 {
            add_square(&mut self.moves, moved, variance);
        }
    }

    /// Covariance of the variables. One that the log does not determine has an infinite variance.
    #[inline(never)]
    pub fn covariance(&self, variables: &[Variable]) -> Covariance {
        let count = variables.len();
        let scale = |place: usize| f64::from(variables[place].scale);
        let mut covariance = Covariance::leading(count, |row, column| {
            self.moves.at(row, column) * scale(row) * scale(column)
        });
        let factor = Cholesky::new(self.sums.normal(count), count);
        for (place, variable) in variables.iter().enumerate() {
            let declared_rules = variable.declared.is_some()
                && self.sums.products.at(place + 1, place + 1) < 10.0 * DECLARED_WEIGHT;
            if factor.is_dependent(place) || declared_rules {
                covariance.row_mut(place)[place] = f64::INFINITY;
            }
        }
        covariance
    }

    /// How many standard deviations the strengths of the effect in this slot are from zero, jointly.
    #[inline(never)]
    pub fn certainty(&self, model: &Model, variables: &[Variable], slot: usize) -> f64 {
        let covariance = self.covariance(variables);
        let mut own: Vec<usize, MOST_STRENGTHS> = Vec::new();
        for (place, variable) in variables.iter().enumerate() {
            if variable.is_strength_of(model, slot) {
                let _ = own.push(place);
            }
        }
        let own_covariance =
            Triangle::<f64, { entries(MOST_STRENGTHS) }>::leading(own.len(), |row, column| {
                covariance.at(own[row], own[column])
            });
        let mut strengths = [0.0; MOST_STRENGTHS];
        for (strength, &place) in strengths.iter_mut().zip(&own) {
            *strength = f64::from(variables[place].get(model));
        }
        // ‖L⁻¹ a‖² is chi-square with as many degrees of freedom as there are strengths.
        let count = own.len();
        Cholesky::new(own_covariance, count).forward(&mut strengths[..count]);
        let square: f64 = strengths[..count].iter().map(|x| x * x).sum();
        libm::sqrt(square / count.max(1) as f64)
    }
}
