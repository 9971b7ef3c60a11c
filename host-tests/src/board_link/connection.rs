//! How a board's console is reached, as the command line says it.

use std::path::PathBuf;

use super::Line;
use super::probe::{self, Probe};
use super::serial;
use crate::failure::Failure;

/// One of four ways, or none.
#[derive(Debug, clap::Args)]
#[group(id = "board", multiple = false)]
pub struct Connection {
    /// Serial port of the board's console, such as /dev/ttyUSB0
    #[arg(long, value_name = "DEV")]
    port: Option<PathBuf>,
    /// Without a serial port: the debug probe that is attached; of several, the one of this VID:PID or VID:PID:SERIAL, as
    /// probe-rs has them
    #[arg(long, value_name = "PROBE", num_args = 0..=1, value_parser = probe::choice)]
    probe: Option<Option<String>>,
    /// A program at the probe that runs already and serves RTT channel 1 at this address
    #[arg(long, value_name = "HOST:PORT")]
    rtt: Option<String>,
    /// No board: emulate a controller, with a motor of which its parameters do not say everything
    #[arg(long)]
    emulated: bool,
}

impl Connection {
    /// The serial port, if it is that.
    pub fn port(&self) -> Option<&PathBuf> {
        self.port.as_ref()
    }

    /// Whether a controller is to be emulated in place of a board.
    pub fn is_emulated(&self) -> bool {
        self.emulated
    }

    /// The line to the board; none if no way to one is named.
    ///
    /// # Errors
    /// A port, a probe or a program that is not there.
    pub fn open(&self) -> Result<Option<Box<dyn Line>>, Failure> {
        Ok(match self {
            Self {
                port: Some(port), ..
            } => Some(Box::new(serial::open(port)?)),
            Self {
                probe: Some(choice),
                ..
            } => Some(Box::new(Probe::start(choice.as_deref())?)),
            Self {
                rtt: Some(address), ..
            } => Some(Box::new(Probe::connect(address)?)),
            _ => None,
        })
    }
}
