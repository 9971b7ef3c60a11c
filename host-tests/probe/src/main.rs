//! Serves the console of the board at a debug probe to one program at a TCP port of this computer. `cargo hil record --probe` and
//! `cargo hil live --probe` build and start it.
//!
//! One argument, VID:PID or VID:PID:SERIAL, chooses the probe; without it the only one is taken. The first line of the standard
//! output is the port. It ends when its standard input ends, when the program at the port leaves, and when the chip no longer
//! answers.

mod chip;
mod choice;
#[cfg(test)]
mod simulated;

use std::io::{self, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::thread;
use std::time::{Duration, Instant};

use rtt::{Channel, PERIOD, serve};

use crate::chip::{Bus, RAM};

/// Channel of the console in the images, up and down.
const CONSOLE: u32 = 1;

/// How long a board that has just got its power may take to start its image.
const START: Duration = Duration::from_secs(2);

fn main() -> ExitCode {
    let choice = std::env::args().nth(1);
    match run(choice.as_deref()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("{}", reason.replace('\n', " "));
            ExitCode::FAILURE
        }
    }
}

/// Serves the console until whoever started this program, or whoever it serves, ends.
///
/// # Errors
/// No probe or several, one that cannot be opened, a chip that does not answer, an image without a console.
fn run(choice: Option<&str>) -> Result<(), String> {
    let ended = watch();
    let mut port = chip::attach(choice::open(choice)?).map_err(chip::unanswered)?;
    let mut chip = Bus::of(&mut *port).map_err(chip::unanswered)?;
    let mut console = Channel::new(RAM, CONSOLE);
    let begun = Instant::now();
    while !console.find(&mut chip).map_err(chip::unanswered)? {
        if begun.elapsed() > START || ended.load(Relaxed) {
            return Err(
                "the probe finds no console in the chip's memory: flash `controller` or `throttle` of this version, and let \
                 it start"
                    .to_owned(),
            );
        }
    }
    // What it said while nobody listened is told to nobody.
    let mut typed = Vec::new();
    console
        .exchange(&mut chip, &mut typed)
        .map_err(chip::unanswered)?;
    match connection(&ended).map_err(|error| format!("a TCP port: {error}"))? {
        Some(stream) => serve(
            stream,
            |typed| console.exchange(&mut chip, typed),
            || ended.load(Relaxed),
        )
        .map_err(chip::unanswered),
        None => Ok(()),
    }
}

/// Whether the standard input has ended, which whoever started this program holds open.
fn watch() -> Arc<AtomicBool> {
    let ended = Arc::new(AtomicBool::new(false));
    let told = ended.clone();
    thread::spawn(move || {
        let mut bytes = [0; 64];
        while io::stdin().read(&mut bytes).is_ok_and(|read| read > 0) {}
        told.store(true, Relaxed);
    });
    ended
}

/// Opens a port, says which, and waits for a program; none if `ended` comes first.
fn connection(ended: &AtomicBool) -> io::Result<Option<TcpStream>> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
    let mut out = io::stdout();
    writeln!(out, "{}", listener.local_addr()?.port())?;
    out.flush()?;
    listener.set_nonblocking(true)?;
    while !ended.load(Relaxed) {
        match listener.accept() {
            Ok((stream, _)) => {
                stream.set_nonblocking(false)?;
                return Ok(Some(stream));
            }
            Err(error) if error.kind() == ErrorKind::WouldBlock => thread::sleep(PERIOD),
            Err(error) => return Err(error),
        }
    }
    Ok(None)
}
