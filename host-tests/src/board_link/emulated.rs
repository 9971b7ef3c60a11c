//! The controller without a board: the image's own code on this host, a modelled motor at its wires, its
//! console at a pseudo-terminal.

use std::io::{self, ErrorKind};
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use firmware::app::demonstration::UNDECLARED;
use firmware::app::operation::evaluation::Done;
use firmware::app::operation::operator::POLL_PERIOD_MS;
use firmware::app::wiring::Wiring;
use model_core::plant::parameters::Parameters;
use serialport::{SerialPort, TTYPort};

use super::{Line, serial};
use crate::failure::Failure;
use crate::operation_on_host::{Motor, OperationOnHost, SharedFlash};

/// How fast its clock runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pace {
    /// As fast as a real one.
    RealTime,
    /// As fast as this host computes and somebody reads what it says.
    Free,
}

/// Something wrong at the controller's wires.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WireFault {
    /// The encoder's cable is off.
    EncoderLost,
    /// The encoder counts the wrong way round.
    EncoderReversed,
    /// The bridge's driver pulls the break input.
    BridgeBreak,
    /// The emergency stop is pressed.
    EmergencyStop,
    /// The supply falls to 12 V.
    UnderVoltage,
    /// The actuator is blocked where it is.
    Blocked,
    /// The current sensor reads 3 A too much.
    CurrentOffset,
    /// Everything is as it was.
    Healed,
}

impl WireFault {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::EncoderLost,
        Self::EncoderReversed,
        Self::BridgeBreak,
        Self::EmergencyStop,
        Self::UnderVoltage,
        Self::Blocked,
        Self::CurrentOffset,
        Self::Healed,
    ];

    /// What it is called.
    pub const fn name(self) -> &'static str {
        match self {
            Self::EncoderLost => "encoder_lost",
            Self::EncoderReversed => "encoder_reversed",
            Self::BridgeBreak => "bridge_break",
            Self::EmergencyStop => "emergency_stop",
            Self::UnderVoltage => "under_voltage",
            Self::Blocked => "blocked",
            Self::CurrentOffset => "current_offset",
            Self::Healed => "heal",
        }
    }

    /// The one of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|fault| fault.name() == name)
    }

    fn inject(self, motor: &mut Motor) {
        match self {
            Self::EncoderLost => motor.encoder = 0.0,
            Self::EncoderReversed => motor.encoder = -1.0,
            Self::BridgeBreak => motor.broken = true,
            Self::EmergencyStop => motor.stopped = true,
            Self::UnderVoltage => motor.supply = 12.0,
            Self::Blocked => motor.block(),
            Self::CurrentOffset => motor.offset = 3.0,
            Self::Healed => {
                motor.release();
                motor.encoder = 1.0;
                motor.broken = false;
                motor.stopped = false;
                motor.supply = 24.0;
                motor.offset = 0.0;
            }
        }
    }
}

/// The controller of the demonstrations and the line to it. The line is dead once the controller is dropped.
///
/// # Errors
/// A system without pseudo-terminals.
pub fn demonstration(pace: Pace) -> Result<(EmulatedBoard, Box<dyn Line>), Failure> {
    let board = EmulatedBoard::start(UNDECLARED.actuator, pace)
        .map_err(|error| Failure::system("a pseudo-terminal", error))?;
    let line = serial::open(&board.port)?;
    Ok((board, Box::new(line)))
}

/// A controller that runs. Dropped, it ends.
pub struct EmulatedBoard {
    /// The other end of its serial line.
    pub port: PathBuf,
    /// Its wires.
    pub wiring: &'static Wiring,
    /// Whether it was armed at any time.
    pub was_armed: Arc<AtomicBool>,
    faults: Sender<WireFault>,
    ending: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl EmulatedBoard {
    /// Starts it with this motor at its wires.
    ///
    /// # Errors
    /// A system without pseudo-terminals.
    pub fn start(motor: Parameters, pace: Pace) -> io::Result<Self> {
        let (mut board_end, other_end) = TTYPort::pair()?;
        board_end.set_timeout(SHORTEST_WAIT)?;
        let port = other_end.name().map(PathBuf::from);
        let port = port.ok_or_else(|| io::Error::other("a pseudo-terminal without a name"))?;
        // Whoever wants to talk to the board opens it anew, for himself alone.
        drop(other_end);
        let ending = Arc::new(AtomicBool::new(false));
        let was_armed = Arc::new(AtomicBool::new(false));
        let (faults, injected) = channel();
        let (started, wires) = channel();
        let thread = {
            let (ending, was_armed) = (ending.clone(), was_armed.clone());
            thread::spawn(move || {
                // An image is of one thread: it is made in its own.
                let image = OperationOnHost::controller(&SharedFlash::new(), &motor);
                let _ = started.send(image.wiring);
                let work = Work {
                    image,
                    injected,
                    was_armed,
                    evaluation: None,
                };
                work.run(&mut board_end, pace, &ending);
            })
        };
        let wiring = wires.recv().map_err(io::Error::other)?;
        Ok(Self {
            port,
            wiring,
            was_armed,
            faults,
            ending,
            thread: Some(thread),
        })
    }

    /// Makes something wrong at its wires.
    pub fn inject(&self, fault: WireFault) {
        // One that has ended has no wires any more.
        let _ = self.faults.send(fault);
    }
}

impl Drop for EmulatedBoard {
    fn drop(&mut self) {
        self.ending.store(true, Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// How long a byte is waited for in each poll: a real board's polls take five times as long.
const SHORTEST_WAIT: Duration = Duration::from_millis(1);

/// What the thread does.
struct Work {
    image: OperationOnHost<Motor>,
    injected: Receiver<WireFault>,
    was_armed: Arc<AtomicBool>,
    /// The refit or the check that is under way.
    evaluation: Option<JoinHandle<Done>>,
}

impl Work {
    fn run(mut self, line: &mut dyn Line, pace: Pace, ending: &AtomicBool) {
        let period = Duration::from_millis(POLL_PERIOD_MS.into());
        let mut due = Instant::now();
        while !ending.load(Relaxed) {
            for fault in self.injected.try_iter() {
                fault.inject(&mut self.image.plant);
            }
            let mut bytes = [0; 256];
            let typed = line.read(&mut bytes).unwrap_or_else(|error| {
                if error.kind() != ErrorKind::TimedOut {
                    // Nobody has the other end open: that is told at once.
                    thread::sleep(SHORTEST_WAIT);
                }
                0
            });
            self.end_evaluation();
            let said = self.image.type_in(&bytes[..typed]);
            self.begin_evaluation();
            say(line, said.as_bytes(), ending);
            self.image.run_ms(POLL_PERIOD_MS);
            if self.image.wiring.latch().is_armed() {
                self.was_armed.store(true, Relaxed);
            }
            if pace == Pace::RealTime {
                due += period;
                let now = Instant::now();
                if due < now {
                    // It was held up: nothing is made up for.
                    due = now;
                }
                thread::sleep(due - now);
            }
        }
    }

    /// Begins a refit or a check that was asked for, beside everything else: as the chip's task of lowest priority, it
    /// must not hold up the drive.
    fn begin_evaluation(&mut self) {
        // A board that ends does not wait for it: the log that it has is never freed.
        if let Some(job) = self.image.job() {
            self.evaluation = Some(thread::spawn(move || job.run()));
        }
    }

    /// Takes a refit or a check back once it is done.
    fn end_evaluation(&mut self) {
        let done = self.evaluation.take_if(|thread| thread.is_finished());
        if let Some(done) = done {
            // As on the chip, the board does not outlive a panic of its task.
            let done = done.join().unwrap_or_else(|panic| resume_unwind(panic));
            self.image.finish(done);
        }
    }
}

/// Writes all of it. Nobody may read for a while; a real line would lose it.
fn say(line: &mut dyn Line, mut bytes: &[u8], ending: &AtomicBool) {
    while !bytes.is_empty() && !ending.load(Relaxed) {
        match line.write(bytes) {
            Ok(written) => bytes = bytes.get(written..).unwrap_or_default(),
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {}
            Err(_) => return,
        }
    }
}
