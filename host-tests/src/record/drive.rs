//! The part that moves: armed, commanded, disarmed, whatever happens on the way.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::flag;

use crate::board_link::console::Console;
use crate::failure::Failure;
use crate::outputs::defer_signals;

/// Lines a second on how the drive is while it is recorded.
const WATCH_RATE: u32 = 20;

/// Control steps in a second.
const STEPS_PER_SECOND: f64 = firmware::app::timing::STEPS_PER_SECOND as f64;

/// What is driven.
#[derive(Debug, Clone)]
pub struct Drive {
    /// `position` or `voltage`.
    pub mode: &'static str,
    /// A signal as the console takes it; none for [`default_signal`].
    pub signal: Option<String>,
    /// For how long, s on the board's clock.
    pub seconds: f64,
}

/// A sweep about where the actuator stands: 0.2 rad either way, from 0.3 to 3 Hz in 10 s, so that it turns
/// round often and runs from 0.4 to 4 rad/s at most.
pub fn default_signal(position: f32) -> String {
    format!("sweep {position:.4} 0.2 0.3 3 10")
}

/// What ends a program that holds a board: the user, the system, a terminal that is closed.
pub const ENDS: [i32; 3] = [SIGINT, SIGTERM, SIGHUP];

/// Whether the user, or the system, wants this program to end.
pub struct Ending(Arc<AtomicBool>);

impl Ending {
    /// Told of these signals from here on, which alone end nothing any more.
    ///
    /// # Errors
    /// What the system reports.
    pub fn watch(signals: &[i32]) -> Result<Self, Failure> {
        let flag = Arc::new(AtomicBool::new(false));
        for &signal in signals {
            flag::register(signal, flag.clone())
                .map_err(|error| Failure::system("signals cannot be watched", error))?;
        }
        Ok(Self(flag))
    }

    /// Whether it came.
    pub fn is_asked(&self) -> bool {
        self.0.load(Relaxed)
    }
}

/// Refuses a drive that is armed or has faults latched: nothing is done to it then.
///
/// # Errors
/// Why it cannot be driven, and what to do about it.
pub fn require_ready(console: &mut Console) -> Result<(), Failure> {
    let status = console.ask("status")?;
    if status.starts_with("armed") {
        return Err(Failure::other(
            "the drive is armed already: somebody else drives it; `disarm` it on its console first",
        ));
    }
    if !status.lines().any(|line| line == "latched: none") {
        let faults = console.ask("faults")?;
        return Err(Failure::other(format!(
            "faults are latched; end what causes them, then `clear` on the console\n  {}",
            faults.replace('\n', "\n  ")
        )));
    }
    Ok(())
}

/// Drives, and takes the drive's power in the end: after an error and after a signal too.
///
/// # Errors
/// What the board refuses, a fault that is latched on the way, a line that ends; the end of the program, asked
/// for.
pub fn drive(console: &mut Console, drive: &Drive, ending: &Ending) -> Result<(), Failure> {
    // A signal waits until the drive is disarmed.
    let _deferred = defer_signals();
    if ending.is_asked() {
        return Err(interrupted());
    }
    let driven = commanded(console, drive, ending);
    let disarmed = console.disarm();
    let quiet = console.quiet();
    driven.and(disarmed).and(quiet)
}

fn interrupted() -> Failure {
    Failure::other("interrupted; the drive is disarmed and nothing is written")
}

fn commanded(console: &mut Console, drive: &Drive, ending: &Ending) -> Result<(), Failure> {
    let watch = format!("stream {WATCH_RATE}");
    console.order(&format!("mode {}", drive.mode))?;
    let signal = match &drive.signal {
        Some(signal) => signal.clone(),
        None => {
            console.order(&watch)?;
            let rest = console.live()?;
            // What the drive said before it was armed must not count as recorded.
            console.quiet()?;
            default_signal(rest.position)
        }
    };
    console.order("arm")?;
    console.order(&signal)?;
    console.order(&watch)?;
    let start = console.live()?.sequence;
    let steps = (drive.seconds * STEPS_PER_SECOND).ceil() as u32;
    loop {
        if ending.is_asked() {
            return Err(interrupted());
        }
        let live = console.live()?;
        if !live.armed || !live.latched.is_empty() {
            let faults = console.ask("faults")?;
            return Err(Failure::other(format!(
                "the drive let go after {:.2} s; nothing is written\n  {}",
                f64::from(live.sequence.wrapping_sub(start)) / STEPS_PER_SECOND,
                faults.replace('\n', "\n  ")
            )));
        }
        if live.sequence.wrapping_sub(start) >= steps {
            return Ok(());
        }
    }
}
