//! A board's console at a debug probe: by the rings in the chip's RAM (RTT), which a program at the probe serves at a TCP
//! port. That is [`OpenOCD`](https://openocd.org), started here or by somebody else.

use std::io::{self, BufRead, BufReader, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use super::QUIET;
use crate::error::InputError;
use crate::failure::Failure;

/// The program at the probe.
const PROGRAM: &str = "openocd";

/// Channel of the console in the images, up and down.
const CHANNEL: u32 = 1;

/// Where the rings are looked for: the RAM of an STM32F405.
const RAM: &str = "0x20000000 0x20000";

/// Runs it until the standard input ends, with this program however that ends.
const ATTENDED: &str =
    "exec 3<&0; openocd \"$@\" & program=$!; (read -r _ <&3; kill $program) & wait $program";

/// The exit status of a shell that finds no such program.
const NO_PROGRAM: i32 = 127;

/// How often the probe reads and writes, ms: the images keep 0.18 s of what the console says.
const PERIOD_MS: u32 = 10;

/// How long the program may take to find probe, chip and rings.
const PATIENCE: Duration = Duration::from_secs(20);

/// What it says where an image has no rings.
const NO_BLOCK: &str = "No control block found";

/// Probes that are known, by the names of OpenOCD's files for them.
pub const PROBES: [&str; 3] = ["stlink", "cmsis-dap", "jlink"];

/// A console at a probe. Dropped, the program that was started for it ends.
#[derive(Debug)]
pub struct Probe {
    stream: TcpStream,
    /// Held until the end.
    _program: Option<Program>,
}

impl Probe {
    /// Of a program that serves the channel at this address, HOST:PORT.
    ///
    /// # Errors
    /// Nobody there.
    pub fn connect(address: &str) -> Result<Self, Failure> {
        let stream = TcpStream::connect(address).and_then(timed);
        let stream = stream.map_err(|error| {
            let message = format!(
                "cannot be reached ({error}); expected HOST:PORT of a program that serves RTT channel {CHANNEL}, as OpenOCD \
                 does at 127.0.0.1:9090 after `rtt server start 9090 {CHANNEL}`"
            );
            InputError::new(Path::new(address), None, message)
        })?;
        Ok(Self {
            stream,
            _program: None,
        })
    }

    /// Of a probe of this kind at this computer.
    ///
    /// # Errors
    /// No program for it, no probe, no chip, an image without rings.
    pub fn start(kind: &str) -> Result<Self, Failure> {
        let port = free_port().map_err(|error| Failure::system("a TCP port", error))?;
        let mut program = Program::start(kind, port)?;
        let begun = Instant::now();
        loop {
            let ended = program.child.try_wait().ok().flatten();
            let said = program.said();
            if ended.is_some_and(|status| status.code() == Some(NO_PROGRAM)) {
                return Err(Failure::other(
                    "openocd is not there, which reads and writes the probe; install it (`apt install openocd`, `brew \
                     install openocd`)",
                ));
            }
            if said.contains(NO_BLOCK) {
                return Err(Failure::other(
                    "the probe finds no console in the chip's memory: flash `controller` or `throttle` of this version, and \
                     let it start",
                ));
            }
            if ended.is_some() {
                return Err(Failure::other(format!(
                    "{PROGRAM} ended: {}; check that a probe of the kind {kind} is plugged in, that it is joined to the \
                     board, that the board has power and that no other program has the probe",
                    reason(&said)
                )));
            }
            // The rings are found before the port is opened.
            if said.contains("Control block found")
                && let Ok(stream) = TcpStream::connect((Ipv4Addr::LOCALHOST, port)).and_then(timed)
            {
                return Ok(Self {
                    stream,
                    _program: Some(program),
                });
            }
            if begun.elapsed() > PATIENCE {
                return Err(Failure::other(format!(
                    "{PROGRAM} has not found the console within {} s: {}",
                    PATIENCE.as_secs(),
                    reason(&said)
                )));
            }
            thread::sleep(QUIET);
        }
    }
}

/// Reads that end when nothing comes, writes that are not put off.
fn timed(stream: TcpStream) -> io::Result<TcpStream> {
    stream.set_read_timeout(Some(QUIET))?;
    stream.set_nodelay(true)?;
    Ok(stream)
}

fn free_port() -> io::Result<u16> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
    Ok(listener.local_addr()?.port())
}

/// Why it ended, of all that it said.
fn reason(said: &str) -> String {
    let errors = said
        .lines()
        .filter_map(|line| line.strip_prefix("Error: "))
        .collect::<Vec<_>>();
    if errors.is_empty() {
        said.lines().last().unwrap_or("it said nothing").to_owned()
    } else {
        errors.join("; ")
    }
}

impl Read for Probe {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.stream.read(bytes).map_err(|error| {
            // A read that finds nothing in time is told by the one or the other, system by system.
            if error.kind() == ErrorKind::WouldBlock {
                ErrorKind::TimedOut.into()
            } else {
                error
            }
        })
    }
}

impl Write for Probe {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

/// The program at the probe. Dropped, it ends.
#[derive(Debug)]
struct Program {
    child: Child,
    said: Arc<Mutex<String>>,
}

impl Program {
    fn start(kind: &str, port: u16) -> Result<Self, Failure> {
        let mut child = Command::new("sh")
            .args(["-c", ATTENDED, PROGRAM])
            .args(arguments(kind, port))
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            // Ctrl-C at the terminal is for this program alone, which disarms the drive by that one.
            .process_group(0)
            .spawn()
            .map_err(|error| Failure::system("sh", error))?;
        let said = Arc::new(Mutex::new(String::new()));
        if let Some(output) = child.stderr.take() {
            let said = said.clone();
            thread::spawn(move || {
                let mut output = BufReader::new(output);
                let mut line = Vec::new();
                while output
                    .read_until(b'\n', &mut line)
                    .is_ok_and(|read| read > 0)
                {
                    held(&said).push_str(&String::from_utf8_lossy(&line));
                    line.clear();
                }
            });
        }
        Ok(Self { child, said })
    }

    /// Everything so far.
    fn said(&self) -> String {
        held(&self.said).clone()
    }
}

fn held(said: &Mutex<String>) -> MutexGuard<'_, String> {
    said.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Drop for Program {
    fn drop(&mut self) {
        drop(self.child.stdin.take());
        // It may have ended by itself.
        let _ = self.child.wait();
    }
}

/// What has it serve the console at this port. It neither resets nor halts the chip.
fn arguments(kind: &str, port: u16) -> Vec<String> {
    let mut arguments = vec!["-f".to_owned(), format!("interface/{kind}.cfg")];
    let mut command = |text: String| arguments.extend(["-c".to_owned(), text]);
    if kind == "jlink" {
        // The others choose it by themselves, each by its own name.
        command("transport select swd".to_owned());
    }
    for unused in ["gdb", "tcl", "telnet"] {
        command(format!("{unused}_port disabled"));
    }
    command("source [find target/stm32f4x.cfg]".to_owned());
    command("init".to_owned());
    command(format!("rtt setup {RAM} \"SEGGER RTT\""));
    command(format!("rtt polling_interval {PERIOD_MS}"));
    command("rtt start".to_owned());
    command(format!("rtt server start {port} {CHANNEL}"));
    arguments
}
