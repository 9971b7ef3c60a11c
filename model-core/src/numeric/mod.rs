//! Numerical tools: nothing here knows what an actuator is.

pub mod chi_square;
pub mod cholesky;
pub mod exponential;
pub mod invalid_parameter;
pub mod ljung_box;
pub mod matrix_exponential;
pub mod normal;
pub mod random;
pub mod sine;
pub mod statistics;
pub mod straight_line;
pub mod student;
pub mod sum;
pub mod triangle;
pub mod wilcoxon;
