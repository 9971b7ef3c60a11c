//! Cholesky factorisation of small Gram matrices.

use super::triangle::Triangle;

/// Pivots below this share of the original diagonal count as zero: the column is then a linear
/// combination of those before it, and its solution is set to zero.
pub const RELATIVE_PIVOT: f64 = 1e-9;

/// The lower factor of a symmetric positive semidefinite matrix, in the matrix's place.
#[derive(Debug, Clone)]
pub struct Cholesky<const ENTRIES: usize> {
    order: usize,
    lower: Triangle<f64, ENTRIES>,
}

impl<const ENTRIES: usize> Cholesky<ENTRIES> {
    /// Factorises the leading `order` rows and columns.
    ///
    /// A dependent column (see [`RELATIVE_PIVOT`]) is left out instead of failing, so that a
    /// parameter without influence does no harm to the others.
    ///
    /// ```
    /// use model_core::numeric::cholesky::Cholesky;
    /// use model_core::numeric::triangle::{Triangle, entries};
    /// let mut matrix = Triangle::<f64, { entries(2) }>::default();
    /// matrix.row_mut(0)[0] = 4.0;
    /// matrix.row_mut(1).copy_from_slice(&[2.0, 2.0]);
    /// let mut x = [2.0, 5.0];
    /// Cholesky::new(matrix, 2).solve(&mut x);
    /// assert_eq!(x, [-1.5, 4.0]);
    /// ```
    pub fn new(matrix: Triangle<f64, ENTRIES>, order: usize) -> Self {
        let mut lower = matrix;
        for row in 0..order {
            for column in 0..=row {
                let own = lower.at(row, column);
                let mut sum = own;
                for inner in 0..column {
                    sum -= lower.at(row, inner) * lower.at(column, inner);
                }
                lower.row_mut(row)[column] = if row == column {
                    if sum > RELATIVE_PIVOT * own {
                        libm::sqrt(sum)
                    } else {
                        0.0
                    }
                } else if lower.at(column, column) > 0.0 {
                    sum / lower.at(column, column)
                } else {
                    0.0
                };
            }
        }
        Self { order, lower }
    }

    /// Whether a column was left out as dependent.
    pub fn is_dependent(&self, column: usize) -> bool {
        self.lower.at(column, column) == 0.0
    }

    /// Solves `L y = b` in place: the forward half of [`Cholesky::solve`].
    pub fn forward(&self, b: &mut [f64]) {
        for row in 0..self.order {
            let mut sum = b[row];
            for (inner, known) in b.iter().enumerate().take(row) {
                sum -= self.lower.at(row, inner) * known;
            }
            b[row] = if self.is_dependent(row) {
                0.0
            } else {
                sum / self.lower.at(row, row)
            };
        }
    }

    /// Solves `L Lᵀ x = b` in place. Entries of dependent columns come out as zero.
    pub fn solve(&self, b: &mut [f64]) {
        self.forward(b);
        for row in (0..self.order).rev() {
            let mut sum = b[row];
            for (inner, known) in b.iter().enumerate().take(self.order).skip(row + 1) {
                sum -= self.lower.at(inner, row) * known;
            }
            b[row] = if self.is_dependent(row) {
                0.0
            } else {
                sum / self.lower.at(row, row)
            };
        }
    }
}
