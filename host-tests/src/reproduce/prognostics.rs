//! The prognostics paper.
pub mod calibration;
pub mod campaign;
pub mod command_file;
pub mod detection;
pub mod estimate;
pub mod methods;
pub mod stand;
pub mod statistics;
