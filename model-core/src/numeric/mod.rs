//! Numerical parts that the other modules stand on.

pub mod cholesky;
pub mod matrix_exponential;
