//! Polynomials by least squares.

use nalgebra::{DMatrix, DVector};

/// A polynomial, its coefficients from the constant up.
#[derive(Debug, Clone, PartialEq)]
pub struct Polynomial(pub Vec<f64>);

impl Polynomial {
    /// The polynomial of a degree with the least sum of squares, by singular value decomposition.
    /// `None` where the points do not determine it.
    ///
    /// ```
    /// use host_tests::reproduce::bench::polynomial::Polynomial;
    ///
    /// let line = Polynomial::fit(&[0.0, 1.0, 2.0], &[1.0, 3.0, 5.0], 1).unwrap();
    /// assert!((line.at(10.0) - 21.0).abs() < 1e-12);
    /// assert!(Polynomial::fit(&[1.0, 1.0], &[1.0, 3.0], 1).is_none());
    /// ```
    pub fn fit(x: &[f64], y: &[f64], degree: usize) -> Option<Self> {
        // Columns of one size: the powers of a displacement in millimetres are far apart.
        let powers = DMatrix::from_fn(x.len(), degree + 1, |row, power| x[row].powi(power as i32));
        let sizes: Vec<f64> = powers.column_iter().map(|column| column.norm()).collect();
        let scaled = DMatrix::from_fn(x.len(), degree + 1, |row, power| {
            powers[(row, power)] / sizes[power]
        });
        let decomposed = scaled.svd(true, true);
        let least = f64::EPSILON * x.len() as f64;
        if decomposed.rank(least) <= degree {
            return None;
        }
        let found = decomposed
            .solve(&DVector::from_column_slice(y), least)
            .ok()?;
        let coefficients = found.iter().zip(&sizes).map(|(value, size)| value / size);
        Some(Self(coefficients.collect()))
    }

    /// Its value.
    pub fn at(&self, x: f64) -> f64 {
        self.0.iter().rev().fold(0.0, |sum, value| sum * x + value)
    }

    /// Its values.
    pub fn over(&self, x: &[f64]) -> Vec<f64> {
        x.iter().map(|&x| self.at(x)).collect()
    }
}
