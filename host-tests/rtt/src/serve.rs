//! A channel served to a program that connects by TCP.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::thread;
use std::time::Duration;

/// How long it is from one exchange to the next, at most: the images keep 0.18 s of what the console says.
pub const PERIOD: Duration = Duration::from_millis(10);

/// So many exchanges in a row may fail: a motor next to the probe's wires disturbs one or another.
pub const FAILURES: u32 = 20;

/// Carries bytes between the program at the other end of `stream` and a channel, until that program leaves or `is_ended`.
/// `exchange` takes from what is typed what there is room for, and gives what was said.
///
/// # Errors
/// The last one of `exchange`, where [`FAILURES`] of them fail in a row.
pub fn serve<E>(
    mut stream: TcpStream,
    mut exchange: impl FnMut(&mut Vec<u8>) -> Result<Vec<u8>, E>,
    is_ended: impl Fn() -> bool,
) -> Result<(), E> {
    // Without them it would be served late, but served.
    let _ = stream.set_nodelay(true);
    let _ = stream.set_read_timeout(Some(PERIOD));
    let mut typed = Vec::new();
    let mut failures = 0;
    let mut bytes = [0; 1024];
    while !is_ended() {
        if typed.is_empty() {
            match stream.read(&mut bytes) {
                Ok(0) => return Ok(()),
                Ok(count) => typed.extend(&bytes[..count]),
                Err(error) if is_nothing_yet(error.kind()) => (),
                Err(_) => return Ok(()),
            }
        } else {
            // Whoever types waits for the chip.
            thread::sleep(PERIOD);
        }
        match exchange(&mut typed) {
            Ok(heard) => {
                failures = 0;
                if stream.write_all(&heard).is_err() {
                    return Ok(());
                }
            }
            Err(_) if failures + 1 < FAILURES => {
                failures += 1;
                thread::sleep(PERIOD);
            }
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

/// Whether a read found nothing in time, as the one system says it or the other.
fn is_nothing_yet(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
    )
}
