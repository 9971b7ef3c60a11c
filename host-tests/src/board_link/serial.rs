//! A serial port, or a pseudo-terminal in its place.

use std::path::Path;

use serialport::SerialPort;

use super::QUIET;
use crate::error::InputError;
use crate::failure::Failure;

/// What the images' console has, 8N1.
const BAUD: u32 = 115_200;

/// Opens it. No other program may have it open meanwhile.
///
/// # Errors
/// A port that is not there, is taken, or may not be used; a file that is no port.
pub fn open(path: &Path) -> Result<Box<dyn SerialPort>, Failure> {
    let opened = serialport::new(path.to_string_lossy(), BAUD)
        .timeout(QUIET)
        .open();
    opened.map_err(|error| {
        let remedy = match error.kind() {
            serialport::ErrorKind::NoDevice => {
                "plug the adapter in, or name another port: `ls /dev/ttyUSB* /dev/ttyACM*`; a terminal program that \
                 has it open must be closed"
            }
            serialport::ErrorKind::Io(std::io::ErrorKind::PermissionDenied) => {
                "you may not use it: `sudo usermod -aG dialout $USER`, then log in anew"
            }
            _ => "expected a serial port, such as /dev/ttyUSB0",
        };
        InputError::new(path, None, format!("cannot be opened ({error}); {remedy}")).into()
    })
}
