//! The host side of the actuator model: machine files, logs, the gap loop, its report; and the
//! firmware's, from its build to its log.

pub mod app_on_host;
pub mod bench;
pub mod board_log;
pub mod board_run;
mod cells;
pub mod check;
pub mod comparison;
pub mod decode;
pub mod ecu;
pub mod ecu_on_host;
pub mod emulator;
pub mod error;
pub mod failure;
pub mod figures;
pub mod free_run;
pub mod gap;
pub mod gap_benchmark;
pub mod hil;
pub mod identify;
pub mod image;
pub mod log;
pub mod machine;
pub mod measured;
pub mod on_target_run;
pub mod onboard;
mod page;
pub mod pwa;
mod quantity;
pub mod remap;
pub mod replay_run;
pub mod reproduce;
pub mod toolchain;
pub mod whole_file;
pub mod workspace;
