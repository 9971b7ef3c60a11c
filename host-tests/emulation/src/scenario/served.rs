//! The loop with the controller's console at this program's standard input and output, and at a TCP port as a program
//! at a debug probe serves what it reads and writes, for a program that operates it.

use std::fs;
use std::io::{Read, Write, stdin, stdout};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc::{Sender, TryRecvError, channel};
use std::thread;

use super::{Call, Consoles, MILLISECOND, PARAMETERS, Pair, Side};

/// How often the probe reads and writes, ms.
const PROBED: u64 = 10;

/// Runs until the standard input ends. A line with the TCP port comes first, once it is ready.
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
    let listener = TcpListener::bind("127.0.0.1:0").map_err(|error| error.to_string())?;
    let port = listener.local_addr().map_err(|error| error.to_string())?;
    let (typed, keys) = channel();
    thread::spawn(move || listen(stdin(), &typed));
    let (connected, connections) = channel();
    thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let (typed, keys) = channel();
            if let Ok(reader) = stream.try_clone() {
                thread::spawn(move || listen(reader, &typed));
            }
            if connected.send((stream, keys)).is_err() {
                break;
            }
        }
    });
    // From here on the board answers.
    say(format!("{}\n", port.port()).as_bytes())?;
    let mut told = pair.controller.heard.len();
    let mut probe = None;
    let mut probed = 0;
    for time in 0_u64.. {
        match keys.try_recv() {
            Ok(bytes) => pair.controller.next.typed.extend(bytes),
            Err(TryRecvError::Empty) => (),
            Err(TryRecvError::Disconnected) => return Ok(()),
        }
        if let Ok(connection) = connections.try_recv() {
            probe = Some(connection);
        }
        if let Some((_, keys)) = &probe
            && time.is_multiple_of(PROBED)
        {
            pair.controller.next.probed = Some(keys.try_iter().flatten().collect());
        }
        pair.run_for(MILLISECOND)?;
        say(&pair.controller.heard[told..])?;
        told = pair.controller.heard.len();
        let lost = probe.as_mut().is_some_and(|(stream, _)| {
            let stream: &mut TcpStream = stream;
            stream.write_all(&pair.controller.probed[probed..]).is_err()
        });
        probed = pair.controller.probed.len();
        if lost {
            probe = None;
        }
    }
    Ok(())
}

/// Passes on what is typed, until nobody types any more.
fn listen(mut keys: impl Read, typed: &Sender<Vec<u8>>) {
    let mut bytes = [0; 256];
    while let Ok(read @ 1..) = keys.read(&mut bytes) {
        if typed.send(bytes[..read].to_vec()).is_err() {
            break;
        }
    }
}

fn say(bytes: &[u8]) -> Result<(), String> {
    let mut out = stdout();
    let written = out.write_all(bytes).and_then(|()| out.flush());
    written.map_err(|error| format!("standard output: {error}"))
}
