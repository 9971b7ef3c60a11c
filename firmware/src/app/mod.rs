//! What every board runs. Four levels of urgency share the processor:
//!
//! 1. [`emulate`]: the plant, 20 kHz, in the most urgent interrupt;
//! 2. [`control`]: the position loop, 1 kHz, in the next interrupt;
//! 3. [`record`]: a task that logs what the loop saw and keeps the last seconds in a [`memory`];
//! 4. `session`: a task that goes from [`experiment`] to experiment and has each log evaluated, by
//!    [`refit`] or [`check`].
//!
//! [`wiring`] joins plant and drive; what can go wrong is a [`fault`], and one that is latched cuts
//! the wires. Sensors and bridge quantise by [`conversion`], and the position goes out on two
//! [`tracks`]; [`machine`] holds the actuators' numbers, [`profile`] what they are asked to do.
//! A terminal, or a debug probe over [`rtt`], gives orders by the [`console`], and has a [`capture`] of what follows.
//! A recorded drive comes on a [`tape`] and is put through the plant by [`replay`]
//! and `playback`.
//! That every task goes on is watched by [`liveness`].
//! What outlives a power cut is in the [`store`], which is written only while the drive is
//! disarmed, see [`arming`].
//! What a person at a terminal has done with an image is the [`operation`].
//! What there is to run: the [`demonstration`], the [`failures`], and a log for each kind of the check's
//! [`verdicts`]. In an image of its own an emulated engine controller, [`ecu`], is in the place of the
//! loop, and a [`digest`] stands for what was on its wires.

pub mod arming;
mod atomic;
pub mod capture;
pub mod check;
pub mod console;
pub mod control;
pub mod conversion;
pub mod debounce;
pub mod demonstration;
pub mod digest;
pub mod ecu;
pub mod emulate;
#[cfg(feature = "tasks")]
pub mod evaluate;
pub mod experiment;
pub mod failures;
pub mod fault;
pub mod liveness;
pub mod machine;
pub mod memory;
pub mod operation;
#[cfg(feature = "tasks")]
pub mod playback;
pub mod profile;
pub mod record;
pub mod refit;
pub mod replay;
pub mod rtt;
#[cfg(feature = "tasks")]
pub mod session;
pub mod square_root;
pub mod store;
pub mod tape;
pub mod timing;
pub mod tracks;
pub mod verdicts;
pub mod wiring;
pub mod work;
