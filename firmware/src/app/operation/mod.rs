//! What a person at a terminal does with an image that runs for good: arm, command, record, estimate
//! anew, store.
//!
//! | who | where | does |
//! |---|---|---|
//! | [`body`] or [`actuator`] | plant interrupt, 20 kHz | steps an emulated throttle body, or reads a real actuator's sensors |
//! | [`drive`] | control interrupt, 1 kHz | judges the measurements, follows the command, queues a sample |
//! | [`operator`] | task, every few milliseconds | empties the queue, performs what the console is told, stores |
//! | [`evaluation`] | task below it | the refit and the check, which take their time |
//!
//! An image is a [`kit`]: which actuator, which limits, which modes. What stands between converters and
//! the drive, a board calls and a test can: the [`bridge`]'s duties, the [`current_limit`], the [`motion_limit`], the [`encoder`]'s 16 bits, the
//! [`duty_input`], the outputs' [`calibration`].

pub mod actuator;
pub mod body;
pub mod bridge;
pub mod calibration;
pub mod current_limit;
pub mod current_offset;
pub mod drive;
pub mod duty_input;
pub mod encoder;
pub mod encoder_check;
pub mod evaluation;
pub mod homing;
pub mod kit;
pub mod live;
pub mod motion_limit;
pub mod operator;
pub mod order;
pub mod setup;
pub mod supply_limit;
pub mod temperature;
mod transfer;
