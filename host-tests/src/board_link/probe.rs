//! A board's console at a debug probe: by the rings in the chip's RAM (RTT), which a program at the probe serves at a TCP port.
//! That is `host-tests/probe`, started here, or what somebody else has started, such as [`OpenOCD`](https://openocd.org).

use std::io::{self, BufRead, BufReader, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, TcpStream};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;

use super::QUIET;
use crate::error::{InputError, one_line};
use crate::failure::Failure;
use crate::package::Package;
use crate::progress::announce;

/// The package of the program at the probe, which reaches the probe by the library of probe-rs.
pub(crate) const PROBE: Package = Package { name: "probe" };

/// Channel of the console in the images, up and down.
const CHANNEL: u32 = 1;

/// How long the program may take to find probe, chip and rings. It gives up before, but where a probe does not answer.
const PATIENCE: Duration = Duration::from_secs(20);

/// A console at a probe. Dropped, the program that was started for it ends.
#[derive(Debug)]
pub struct Probe {
    stream: TcpStream,
    /// What serves it, if it was started here.
    program: Option<Program>,
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
            program: None,
        })
    }

    /// Of a probe at this computer: the only one, or that which `choice` names (VID:PID or VID:PID:SERIAL). The program
    /// at the probe is built first, where it is not yet.
    ///
    /// # Errors
    /// A program that cannot be built; no probe, no chip, an image without rings.
    pub fn start(choice: Option<&str>) -> Result<Self, Failure> {
        let mut program = Program::start(&build()?, choice)?;
        let port = program.port()?;
        let stream = TcpStream::connect((Ipv4Addr::LOCALHOST, port)).and_then(timed);
        let stream = stream.map_err(|error| Failure::system("the program at the probe", error))?;
        Ok(Self {
            stream,
            program: Some(program),
        })
    }
}

/// A probe as the command line names it.
///
/// # Errors
/// What is no VID:PID, VID:PID:SERIAL, or either with an interface behind the PID.
pub fn choice(text: &str) -> Result<String, String> {
    let mut parts = text.splitn(3, ':');
    let is_number =
        |part: Option<&str>| part.is_some_and(|part| u16::from_str_radix(part, 16).is_ok());
    let vendor = parts.next();
    let product = parts.next().map(|product| {
        product
            .split_once('-')
            .map_or(product, |(product, _)| product)
    });
    if is_number(vendor) && is_number(product) {
        return Ok(text.to_owned());
    }
    Err(
        "expected VID:PID or VID:PID:SERIAL in hexadecimal, as `probe-rs list` and `lsusb` show them, such as 0483:374b; the \
         only probe that is attached needs no name"
            .to_owned(),
    )
}

/// Builds the program at the probe, or finds it built.
fn build() -> Result<PathBuf, Failure> {
    if !PROBE.executable(PROBE.name).exists() {
        announce()("the program at the probe (built once, which takes minutes)");
    }
    PROBE.build(PROBE.name, "").map_err(|failure| {
        Failure::other(format!(
            "the program at the probe cannot be built: see that the registry can be reached and try again by `cargo build \
             --release --manifest-path host-tests/probe/Cargo.toml --target-dir target/probe`\n{failure}"
        ))
    })
}

/// Reads that end when nothing comes, writes that are not put off.
fn timed(stream: TcpStream) -> io::Result<TcpStream> {
    stream.set_read_timeout(Some(QUIET))?;
    stream.set_nodelay(true)?;
    Ok(stream)
}

impl Read for Probe {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        match (self.stream.read(bytes), &mut self.program) {
            // A chip that lost its power, a probe that was unplugged.
            (Ok(0), Some(program)) if !bytes.is_empty() => Err(io::Error::other(program.reason())),
            // A read that finds nothing in time is told by the one or the other, system by system.
            (Err(error), _) if error.kind() == ErrorKind::WouldBlock => {
                Err(ErrorKind::TimedOut.into())
            }
            (outcome, _) => outcome,
        }
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

/// The program at the probe. Dropped, it ends: it does so when its standard input ends, with this program however that ends.
#[derive(Debug)]
struct Program(Child);

impl Program {
    fn start(program: &Path, choice: Option<&str>) -> Result<Self, Failure> {
        Command::new(program)
            .args(choice)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            // Ctrl-C at the terminal is for this program alone, which disarms the drive by that one.
            .process_group(0)
            .spawn()
            .map(Self)
            .map_err(|error| Failure::system(program.display(), error))
    }

    /// The port at which it serves the console, once it has found it.
    fn port(&mut self) -> Result<u16, Failure> {
        let (told, line) = channel();
        if let Some(said) = self.0.stdout.take() {
            thread::spawn(move || {
                let mut line = String::new();
                let _ = BufReader::new(said).read_line(&mut line);
                told.send(line)
            });
        }
        let line = line.recv_timeout(PATIENCE).map_err(|_| {
            Failure::other(format!(
                "the probe has not answered within {} s: unplug it, plug it in and try again",
                PATIENCE.as_secs()
            ))
        })?;
        let port = line.trim().parse();
        port.map_err(|_| Failure::other(self.reason()))
    }

    /// Why it ended by itself.
    fn reason(&mut self) -> String {
        let mut said = String::new();
        if let Some(mut complaints) = self.0.stderr.take() {
            // What cannot be read is not said.
            let _ = complaints.read_to_string(&mut said);
        }
        match said.trim() {
            "" => "the program at the probe ended and did not say why".to_owned(),
            reason => one_line(reason),
        }
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        drop(self.0.stdin.take());
        for _ in 0..100 {
            if !matches!(self.0.try_wait(), Ok(None)) {
                return;
            }
            thread::sleep(QUIET);
        }
        // It waits for a probe that does not answer.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
