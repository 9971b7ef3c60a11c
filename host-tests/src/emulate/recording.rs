//! `cargo hil record` at the emulated controller, driven and read as a board's: the first drive with its console at a
//! pseudo-terminal, the second with it at an emulated debug probe.

use std::io::{self, BufRead, BufReader, ErrorKind, Read, Write};
use std::path::PathBuf;
use std::process::{Child, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::thread;

use serialport::{SerialPort, TTYPort};
use signal_hook::consts::{SIGINT, SIGTERM};

use super::run::{Built, directory, rate};
use super::tracing::MACHINE;
use crate::board_link::probe::Probe;
use crate::board_link::{Line, serial};
use crate::failure::Failure;
use crate::gap::engine;
use crate::gap::outcome::Stages;
use crate::log::Log;
use crate::machine::Machine;
use crate::outputs::write_own;
use crate::record::drive::{Drive, Ending};
use crate::record::record;
use crate::toolchain::clean_command;
use crate::workspace;

/// What is driven, and what its log is called: the sweep of the loop's first drive, which is traced, and the triangle of
/// its other one, on which that is judged.
const DRIVES: [(&str, &str); 2] = [
    ("sweep 0.6 0.4 0.7 4 5", "recorded.csv"),
    ("triangle 0.55 0.4 1.3", "recorded-validate.csv"),
];

/// For how long each, s.
pub const SECONDS: f64 = 5.0;

/// What came over the line, and what it shows.
#[derive(Debug)]
pub struct Recording {
    /// Rows of each log.
    pub rows: [usize; 2],
    /// Effects that the tracing finds in the first.
    pub effects: Vec<String>,
    /// What they leave of the position error on the second.
    pub remaining: f64,
}

/// The emulation, and the threads that carry bytes between it and a pseudo-terminal. Dropped, it ends.
struct Served {
    child: Child,
    ending: Arc<AtomicBool>,
}

impl Drop for Served {
    fn drop(&mut self) {
        self.ending.store(true, Relaxed);
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Records the controller in its loop, and traces the log.
///
/// # Errors
/// An emulation that does not run, what `cargo hil record` and `cargo hil gap` refuse.
pub fn run(built: &Built, cycles: f64) -> Result<Recording, Failure> {
    let system = |error: io::Error| Failure::system("a pseudo-terminal", error);
    let (near, far) = TTYPort::pair().map_err(|error| system(error.into()))?;
    let port = far.name().map(PathBuf::from).unwrap_or_default();
    // It is opened as a board's port is.
    drop(far);
    let mut line = serial::open(&port)?;
    let (served, probe) = serve(built, cycles, near).map_err(system)?;
    let mut probe = Probe::connect(&format!("127.0.0.1:{probe}"))?;
    // Nothing moves in truth: a terminal that is closed ends the program as ever.
    let ending = Ending::watch(&[SIGINT, SIGTERM])?;
    let mut lines: [&mut dyn Line; 2] = [&mut line, &mut probe];
    let mut recorded = DRIVES
        .iter()
        .zip(&mut lines)
        .map(|(&(signal, name), line)| {
            let drive = Drive {
                mode: "position",
                signal: Some(signal.to_owned()),
                seconds: SECONDS,
            };
            let csv = directory().join(name);
            write_own(&csv, record(*line, &drive, &ending, || Ok(()))?.csv()?)?;
            Ok::<_, Failure>(Log::read(&csv)?)
        });
    let (Some(train), Some(validate)) = (recorded.next(), recorded.next()) else {
        return Err(Failure::other("two drives"));
    };
    let (train, validate) = (train?, validate?);
    drop(served);
    let machine = Machine::read(&workspace::root().join(MACHINE))?;
    let rows = [train.samples(), validate.samples()];
    let report = engine::run(&machine, &[train], || Ok(vec![validate]), |_| ())?;
    let effects = report.outcome.effects.iter();
    let errors = report.outcome.errors.validate.as_ref();
    Ok(Recording {
        rows,
        effects: effects.map(|effect| effect.id.clone()).collect(),
        remaining: errors.map_or(f64::NAN, Stages::remaining),
    })
}

/// The emulation, with the port of its probe.
fn serve(built: &Built, cycles: f64, near: TTYPort) -> io::Result<(Served, u16)> {
    let Built { emulation, images } = built;
    let mut child = clean_command(emulation)
        .arg("serve")
        .args([&images.throttle.elf, &images.controller.elf, &directory()])
        .arg(rate(cycles))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()?;
    let pipes = (child.stdin.take(), child.stdout.take());
    let ending = Arc::new(AtomicBool::new(false));
    let served = Served {
        child,
        ending: ending.clone(),
    };
    let (Some(keys), Some(said)) = pipes else {
        return Err(io::Error::other("a child without pipes"));
    };
    // However long this machine takes to start it: only then is an answer waited for.
    let mut said = BufReader::new(said);
    let mut port = String::new();
    said.read_line(&mut port)?;
    let port = port.trim().parse().map_err(io::Error::other)?;
    let other = near.try_clone_native()?;
    let still = ending.clone();
    thread::spawn(move || carry(near, keys, &ending));
    thread::spawn(move || carry(said, other, &still));
    Ok((served, port))
}

/// Carries bytes until either side ends.
fn carry(mut from: impl Read, mut to: impl Write, ending: &AtomicBool) {
    let waits =
        |error: &io::Error| matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted);
    let mut bytes = [0; 1024];
    while !ending.load(Relaxed) {
        let mut rest = match from.read(&mut bytes) {
            Ok(0) => return,
            Ok(read) => &bytes[..read],
            Err(error) if waits(&error) => continue,
            Err(_) => return,
        };
        while !rest.is_empty() && !ending.load(Relaxed) {
            match to.write(rest) {
                Ok(written) => rest = rest.get(written..).unwrap_or_default(),
                Err(error) if waits(&error) => (),
                Err(_) => return,
            }
        }
        let _ = to.flush();
    }
}
