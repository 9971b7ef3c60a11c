//! The host side of the actuator model: machine files, logs, the gap loop, its report.

pub mod error;
pub mod gap;
pub mod log;
pub mod machine;
