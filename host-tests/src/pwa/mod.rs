//! Piecewise affine model.
pub mod file;
pub mod identify;
pub mod k_means;
pub mod levenberg_marquardt;
pub mod model;
pub mod parallel;
pub mod reading;
pub mod run;
pub mod sampled;
pub mod sensitivity;
pub mod series_parallel;
pub mod soft;
