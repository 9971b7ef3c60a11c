//! The firmware's own code on this host: console, drive, protections, flash, the throttle's pins.

mod any_drive;
mod board;
mod console;
mod demonstration;
mod drive_faults;
mod drive_limits;
mod drive_protections;
mod drive_restarts;
mod ecu;
mod encoder_check;
mod faults;
mod friction_refit;
mod operation;
mod pins;
mod position_loop;
mod queue;
mod rtt;
mod store;
