//! The prognostics paper.
pub mod calibration;
pub mod campaign;
pub mod command_file;
pub mod estimate;
pub mod stand;
pub mod statistics;
