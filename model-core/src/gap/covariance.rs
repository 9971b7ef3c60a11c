//! How surely a fit determines its variables.

use super::fit::{DECLARED_WEIGHT, MOST_VARIABLES, Matrix, Problem, Variable};
use super::model::Model;
use super::replay::{Data, Fold, Schedule, Sums};
use crate::effect::MOST_PARAMETERS;
use crate::numeric::cholesky::Cholesky;
use crate::numeric::triangle::{Triangle, entries};
use heapless::Vec;

/// What a log says about the variables of a fit at its minimum.
#[derive(Debug, Clone, Default)]
pub struct Information {
    sums: Sums,
    /// Products of each window's gradient with itself.
    gradients: Matrix,
}

/// Covariance of the variables of a fit in SI units.
pub type Covariance = Matrix;

impl Information {
    /// Replays all windows with the fitted model. Gives the windows simulated, each copy counted.
    ///
    /// `None` if the model cannot be built.
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
        let Self { sums, gradients } = self;
        *gradients = Matrix::default();
        problem.linearise(sums, model, |window| {
            for row in 0..variables.len() {
                let slope = f64::from(window.at(row + 1, 0));
                for (column, product) in gradients.row_mut(row).iter_mut().enumerate() {
                    *product += slope * f64::from(window.at(column + 1, 0));
                }
            }
        })?;
        Some(problem.simulated)
    }

    /// Covariance by the sandwich rule over windows, N⁻¹ G N⁻¹ with the normal matrix N and the
    /// products G of the windows' gradients: residuals may be correlated within a window. A variable
    /// that the log does not determine has an infinite variance.
    #[inline(never)]
    pub fn covariance(&self, variables: &[Variable]) -> Covariance {
        let count = variables.len();
        let mut normal = Matrix::default();
        for row in 0..count {
            let products = &self.sums.products.row(row + 1)[1..];
            normal.row_mut(row).copy_from_slice(products);
        }
        let factor = Cholesky::new(normal, count);
        let windows = self.sums.windows as f64;
        let small_sample = windows / (windows - count as f64).max(1.0);
        let mut covariance = Covariance::default();
        for column in 0..count {
            let mut inverse = [0.0; MOST_VARIABLES];
            inverse[column] = 1.0;
            factor.solve(&mut inverse[..count]);
            let mut entries = [0.0; MOST_VARIABLES];
            for (row, entry) in entries.iter_mut().enumerate().take(count) {
                let products = (0..count).map(|inner| self.gradients.at(row, inner));
                *entry = products.zip(inverse).map(|(g, x)| g * x).sum();
            }
            factor.solve(&mut entries[..count]);
            for row in column..count {
                let scale = f64::from(variables[row].scale) * f64::from(variables[column].scale);
                covariance.row_mut(row)[column] = entries[row] * scale * small_sample;
            }
            let declared_rules = variables[column].declared.is_some()
                && self.sums.products.at(column + 1, column + 1) < 10.0 * DECLARED_WEIGHT;
            if factor.is_dependent(column) || declared_rules {
                covariance.row_mut(column)[column] = f64::INFINITY;
            }
        }
        covariance
    }

    /// How many standard deviations the strengths of the effect in this slot are from zero, jointly.
    #[inline(never)]
    pub fn certainty(&self, model: &Model, variables: &[Variable], slot: usize) -> f64 {
        let covariance = self.covariance(variables);
        let mut own: Vec<usize, MOST_PARAMETERS> = Vec::new();
        for (place, variable) in variables.iter().enumerate() {
            if variable.is_strength_of(model, slot) {
                let _ = own.push(place);
            }
        }
        let mut normal = Triangle::<f64, { entries(MOST_PARAMETERS) }>::default();
        let mut strengths = [0.0; MOST_PARAMETERS];
        for (row, &a) in own.iter().enumerate() {
            strengths[row] = f64::from(variables[a].get(model));
            for (entry, &b) in normal.row_mut(row).iter_mut().zip(&own) {
                *entry = covariance.at(a, b);
            }
        }
        // ‖L⁻¹ a‖² is chi-square with as many degrees of freedom as there are strengths.
        let count = own.len();
        Cholesky::new(normal, count).forward(&mut strengths[..count]);
        let square: f64 = strengths[..count].iter().map(|x| x * x).sum();
        libm::sqrt(square / count.max(1) as f64)
    }
}
