//! The loop with the controller's console at this program's standard input and output, for a program that
//! operates it.

use std::fs;
use std::io::{Read, Write, stdin, stdout};
use std::sync::mpsc::{TryRecvError, channel};
use std::thread;

use super::{Call, Consoles, MILLISECOND, PARAMETERS, Pair, Side};

/// Runs until the standard input ends. A line feed comes first, once it is ready.
///
/// # Errors
/// No stored parameters, an image that ends, an output that nobody takes.
pub(super) fn serve(call: &Call) -> Result<(), String> {
    let path = call.directory.join(PARAMETERS);
    let parameters = fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let mut pair = Pair::storing(call, &parameters)?;
    pair.run_for(100 * MILLISECOND)?;
    pair.ready_throttle()?;
    pair.order(Side::Controller, "zero")?;
    let (typed, keys) = channel();
    thread::spawn(move || {
        let mut bytes = [0; 256];
        while let Ok(read @ 1..) = stdin().read(&mut bytes) {
            if typed.send(bytes[..read].to_vec()).is_err() {
                break;
            }
        }
    });
    // From here on the board answers.
    say(b"\n")?;
    let mut told = pair.controller.heard.len();
    loop {
        match keys.try_recv() {
            Ok(bytes) => pair.controller.next.typed.extend(bytes),
            Err(TryRecvError::Empty) => (),
            Err(TryRecvError::Disconnected) => return Ok(()),
        }
        pair.run_for(MILLISECOND)?;
        say(&pair.controller.heard[told..])?;
        told = pair.controller.heard.len();
    }
}

fn say(bytes: &[u8]) -> Result<(), String> {
    let mut out = stdout();
    let written = out.write_all(bytes).and_then(|()| out.flush());
    written.map_err(|error| format!("standard output: {error}"))
}
