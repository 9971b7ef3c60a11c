//! A board at the other end of a line: its console, and the [frames](firmware::app::console::frame) for
//! programs among what it says.
//!
//! A *line* is anything that bytes are read from and written to: a serial port, a pseudo-terminal, a debug probe, an image
//! that runs in this program. A read that finds nothing for [`QUIET`] ends with `TimedOut`.

pub mod connection;
pub mod console;
pub mod demultiplexer;
pub mod emulated;
pub mod log_transfer;
pub mod probe;
pub mod serial;

use std::io::{Read, Write};
use std::time::Duration;

/// How long a read waits for a byte: two polls of the board's operator and what a frame takes at 115,200 baud.
pub const QUIET: Duration = Duration::from_millis(30);

/// What a board is at the other end of.
pub trait Line: Read + Write + Send {}

impl<T: Read + Write + Send + ?Sized> Line for T {}
