//! Derivatives of a free run by recursion, and the sums of Levenberg–Marquardt over them.

use nalgebra::{DMatrix, DVector};

/// ∂y(k)/∂θ along a run, JᵀJ and Jᵀe.
pub struct Sensitivity {
    now: Vec<f64>,
    before: Vec<f64>,
    /// Lower triangle, row by row.
    gram: Vec<f64>,
    gradient: Vec<f64>,
}

impl Sensitivity {
    /// For so many numbers.
    pub fn new(size: usize) -> Self {
        Self {
            now: vec![0.0; size],
            before: vec![0.0; size],
            gram: vec![0.0; size * size],
            gradient: vec![0.0; size],
        }
    }

    /// At the first sample of a log: its position is given.
    pub fn restart(&mut self) {
        self.now.fill(0.0);
        self.before.fill(0.0);
    }

    /// A period in which the position grew by a function with these derivatives by position and by
    /// its change: ∂y(k) = (1 + p + q) ∂y(k−1) − q ∂y(k−2) + what θ itself does, which `direct`
    /// adds.
    pub fn advance(&mut self, position: f64, change: f64, direct: impl FnOnce(&mut [f64])) {
        // Over the oldest, which is not needed any more.
        for (old, new) in self.before.iter_mut().zip(&self.now) {
            *old = (1.0 + position + change) * new - change * *old;
        }
        core::mem::swap(&mut self.before, &mut self.now);
        direct(&mut self.now);
    }

    /// A period at whose end a limit holds the position, whatever θ is.
    pub fn hold(&mut self) {
        self.before.copy_from_slice(&self.now);
        self.now.fill(0.0);
    }

    /// Adds the error at this sample to the sums.
    pub fn add(&mut self, error: f64) {
        let size = self.now.len();
        for (row, &slope) in self.now.iter().enumerate() {
            if slope == 0.0 {
                continue;
            }
            self.gradient[row] += slope * error;
            let line = &mut self.gram[row * size..=row * size + row];
            for (sum, other) in line.iter_mut().zip(&self.now) {
                *sum += slope * other;
            }
        }
    }

    /// The sums.
    pub fn sums(self) -> (DMatrix<f64>, DVector<f64>) {
        let size = self.now.len();
        let gram = DMatrix::from_fn(size, size, |row, column| {
            self.gram[row.max(column) * size + row.min(column)]
        });
        (gram, DVector::from_vec(self.gradient))
    }
}
