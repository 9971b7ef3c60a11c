//! Cholesky factorisation of small Gram matrices.

/// Pivots below this share of the original diagonal count as zero: the column is then a linear
/// combination of those before it, and its solution is set to zero.
pub const RELATIVE_PIVOT: f64 = 1e-9;

/// The lower factor of a symmetric positive semidefinite matrix of order `n <= N`.
#[derive(Debug, Clone)]
pub struct Cholesky<const N: usize> {
    order: usize,
    lower: [[f64; N]; N],
}

impl<const N: usize> Cholesky<N> {
    /// Factorises the leading `order` rows and columns; only the lower triangle is read.
    ///
    /// A dependent column (see [`RELATIVE_PIVOT`]) is left out instead of failing, so that a
    /// parameter without influence does no harm to the others.
    ///
    /// ```
    /// use model_core::numeric::cholesky::Cholesky;
    /// let factor = Cholesky::<2>::new(&[[4.0, 0.0], [2.0, 2.0]], 2);
    /// let mut x = [2.0, 5.0];
    /// factor.solve(&mut x);
    /// assert_eq!(x, [-1.5, 4.0]);
    /// ```
    pub fn new(matrix: &[[f64; N]; N], order: usize) -> Self {
        let mut lower = [[0.0; N]; N];
        for row in 0..order {
            for column in 0..=row {
                let mut sum = matrix[row][column];
                for inner in 0..column {
                    sum -= lower[row][inner] * lower[column][inner];
                }
                lower[row][column] = if row == column {
                    if sum > RELATIVE_PIVOT * matrix[row][row] {
                        libm::sqrt(sum)
                    } else {
                        0.0
                    }
                } else if lower[column][column] > 0.0 {
                    sum / lower[column][column]
                } else {
                    0.0
                };
            }
        }
        Self { order, lower }
    }

    /// Whether a column was left out as dependent.
    pub fn is_dependent(&self, column: usize) -> bool {
        self.lower[column][column] == 0.0
    }

    /// Solves `L y = b` in place: the forward half of [`Cholesky::solve`].
    pub fn forward(&self, b: &mut [f64]) {
        for row in 0..self.order {
            let mut sum = b[row];
            for (inner, known) in b.iter().enumerate().take(row) {
                sum -= self.lower[row][inner] * known;
            }
            b[row] = if self.is_dependent(row) {
                0.0
            } else {
                sum / self.lower[row][row]
            };
        }
    }

    /// Solves `L Lᵀ x = b` in place. Entries of dependent columns come out as zero.
    pub fn solve(&self, b: &mut [f64]) {
        self.forward(b);
        for row in (0..self.order).rev() {
            let mut sum = b[row];
            for (inner, known) in b.iter().enumerate().take(self.order).skip(row + 1) {
                sum -= self.lower[inner][row] * known;
            }
            b[row] = if self.is_dependent(row) {
                0.0
            } else {
                sum / self.lower[row][row]
            };
        }
    }
}
