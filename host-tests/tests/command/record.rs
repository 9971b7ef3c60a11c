//! `cargo hil record`: a controller at a pseudo-terminal is armed, driven, disarmed and read, whatever happens
//! on the way; and so it is at a debug probe, with a stand-in for the program at the probe, which `host-tests/probe` is.

use std::collections::VecDeque;
use std::fs;
use std::io::{self, Read, Write};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::Ordering::Relaxed;
use std::thread;
use std::time::{Duration, Instant};

use crate::board_image::image;
use firmware::app::machine::EMA;
use host_tests::board_link::emulated::{EmulatedBoard, Pace, WireFault};
use host_tests::board_link::serial;
use host_tests::log::Log;
use host_tests::machine::Machine;
use host_tests::record::drive::{Drive, Ending};
use host_tests::record::record;
use model_core::plant::Directional;
use model_core::plant::parameters::Parameters;
use serialport::SerialPort;
use tempfile::TempDir;

/// A controller at a pseudo-terminal, and a place for files.
pub struct Bench {
    pub board: EmulatedBoard,
    pub directory: TempDir,
}

impl Bench {
    pub fn new(motor: Parameters) -> Self {
        Self {
            board: EmulatedBoard::start(motor, Pace::Free).unwrap(),
            directory: tempfile::tempdir().unwrap(),
        }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    /// `cargo hil record` at its port, with what else is said.
    fn command(&self, arguments: &[&str]) -> Command {
        let port = self.board.port.to_str().unwrap();
        hil(
            &self.directory,
            &[&["record", "--port", port], arguments].concat(),
        )
    }

    fn record(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    pub fn is_armed(&self) -> bool {
        self.board.wiring.latch().is_armed()
    }

    /// Whether a voltage drives the motor.
    fn is_driven(&self) -> bool {
        self.is_armed() && self.board.wiring.duty() != 0
    }

    pub fn was_armed(&self) -> bool {
        self.board.was_armed.load(Relaxed)
    }

    fn files(&self) -> Vec<PathBuf> {
        let entries = fs::read_dir(self.directory.path()).unwrap();
        entries.map(|entry| entry.unwrap().path()).collect()
    }
}

/// `cargo hil` there.
fn hil(directory: &TempDir, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hil"));
    command
        .current_dir(directory.path())
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

fn text(bytes: &[u8]) -> &str {
    str::from_utf8(bytes).unwrap()
}

/// Bytes that a probe's ring for lines holds, as the images have it.
const RING: usize = 255;

/// Serves a board's pseudo-terminal at a TCP port, as a program at a probe serves the console: what does not fit into the ring
/// at once is lost.
pub fn serve(port: &Path) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let mut board = serialport::new(port.to_str().unwrap(), 115_200)
        .timeout(Duration::from_millis(10))
        .open()
        .unwrap();
    thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        stream
            .set_read_timeout(Some(Duration::from_millis(10)))
            .unwrap();
        let mut bytes = [0; 1024];
        loop {
            match stream.read(&mut bytes) {
                Ok(0) => return,
                Ok(read) => board.write_all(&bytes[..read.min(RING)]).unwrap(),
                Err(_) => (),
            }
            if let Ok(read) = board.read(&mut bytes)
                && stream.write_all(&bytes[..read]).is_err()
            {
                return;
            }
        }
    });
    address
}

#[test]
fn a_board_at_a_probe_that_is_served_is_driven_recorded_and_left_disarmed() {
    let bench = Bench::new(worn());
    let address = serve(&bench.board.port);
    let output = hil(
        &bench.directory,
        &[
            "record", "--rtt", &address, "--arm", "--signal", SWEEP, "--out", "recorded",
        ],
    )
    .output()
    .unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(bench.was_armed() && !bench.is_armed());
    assert_eq!(
        Log::read(&bench.path("recorded/log.csv"))
            .unwrap()
            .samples(),
        10_000
    );
    let machine = Machine::read(&bench.path("recorded/machine.toml")).unwrap();
    assert_eq!(machine.parameter("coulomb"), Some(0.12));
}

/// What a terminal program keeps of `dump log console` becomes the log that `record` reads over the same line.
#[test]
fn a_capture_of_the_console_decodes_to_the_recorded_log() {
    let bench = Bench::new(EMA.plant);
    let output = bench.record(&[
        "--arm",
        "--signal",
        SWEEP,
        "--seconds",
        "2",
        "--out",
        "recorded",
    ]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let mut port = serial::open(&bench.board.port).unwrap();
    port.write_all(b"status\rdump log console\r").unwrap();
    let mut kept = String::new();
    let is_whole = |kept: &str| {
        let end = kept.rsplit_once("\x1eend ");
        end.is_some_and(|(_, end)| end.contains('\n'))
    };
    while !is_whole(&kept) {
        let mut bytes = [0; 1024];
        let read = port.read(&mut bytes).unwrap_or(0);
        kept += text(&bytes[..read]);
    }
    fs::write(bench.path("image"), image("rzcobs")).unwrap();
    fs::write(bench.path("kept"), &kept).unwrap();
    fs::write(bench.path("cut"), &kept[..kept.len() / 2]).unwrap();
    let decode = |log: &str| {
        let arguments = ["decode", "image", log, "--csv", &format!("{log}.csv")];
        hil(&bench.directory, &arguments).output().unwrap()
    };
    let output = decode("kept");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let read = |name: &str| fs::read_to_string(bench.path(name)).unwrap();
    assert_eq!(read("kept.csv"), read("recorded/log.csv"));
    let output = decode("cut");
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("the log on the console ends behind row"),
        "{said}"
    );
    assert!(!bench.path("cut.csv").exists());
}

/// Stands in for the program at the probe: serves the board of this pseudo-terminal, as that does with the rings of a chip.
const STAND_IN: &str = r#"#!/usr/bin/env python3
import os, select, socket, sys, tty
open("probe.told", "w").write(" ".join(sys.argv[1:]))
open("probe.pid", "w").write(str(os.getpid()))
if "SAYS" in os.environ:
    sys.exit(os.environ["SAYS"])
board = os.open(os.environ["BOARD"], os.O_RDWR | os.O_NOCTTY)
tty.setraw(board)
server = socket.create_server(("127.0.0.1", 0))
print(server.getsockname()[1], flush=True)
client, _ = server.accept()
while True:
    for ready in select.select([client, board, sys.stdin], [], [])[0]:
        if ready is client:
            typed = client.recv(1024)
            if not typed:
                sys.exit()
            if b"arm" in typed and "LEAVES" in os.environ:
                sys.exit(os.environ["LEAVES"])
            os.write(board, typed[:255])
        elif ready is board:
            client.sendall(os.read(board, 1024))
        elif not os.read(0, 1):
            sys.exit()
"#;

/// A cargo that has nothing to do but to find the program at the probe built.
const CARGO: &str = r#"#!/bin/sh
echo "$@" > ../cargo.told
test -z "$FAILS" || { echo "$FAILS" >&2; exit 101; }
"#;

fn program(path: &Path, text: &str) {
    use std::os::unix::fs::PermissionsExt;
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, text).unwrap();
    fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
}

/// Has a command find the stand-in where the program at the probe is in a clone of the project.
pub fn serve_at_probe(bench: &Bench, command: &mut Command) {
    let clone = bench.path("clone");
    program(&clone.join("target/probe/release/probe"), STAND_IN);
    program(&bench.path("bin/cargo"), CARGO);
    let path = std::env::var("PATH").unwrap();
    command
        .env("CARGO_MANIFEST_DIR", clone.join("host-tests"))
        .env("PATH", format!("{}:{path}", bench.path("bin").display()))
        .env("BOARD", &bench.board.port);
}

/// `hil` with it.
fn at_probe(bench: &Bench, arguments: &[&str]) -> Command {
    let mut command = hil(&bench.directory, arguments);
    serve_at_probe(bench, &mut command);
    command.env_remove("SAYS").env_remove("LEAVES");
    command
}

/// Whether the program that was started for the probe still runs.
fn is_served(bench: &Bench) -> bool {
    let pid = fs::read_to_string(bench.path("probe.pid")).unwrap();
    Path::new("/proc").join(pid.trim()).exists()
}

#[test]
fn a_board_at_a_probe_is_driven_by_a_program_that_is_built_and_ends_then() {
    for named in [&[][..], &["0483:374b"], &["1366:0105-1:000504"]] {
        let bench = Bench::new(EMA.plant);
        let arguments = [
            &["record", "--probe"],
            named,
            &["--arm", "--seconds", "1", "--out", "log.csv"],
        ]
        .concat();
        let output = at_probe(&bench, &arguments).output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!(bench.was_armed() && !bench.is_armed());
        assert!(Log::read(&bench.path("log.csv")).unwrap().samples() >= 1000);
        assert!(!is_served(&bench));
        let told = |name: &str| fs::read_to_string(bench.path(name)).unwrap();
        assert_eq!(told("probe.told"), named.concat());
        assert!(
            told("cargo.told").starts_with(
                "build --manifest-path host-tests/probe/Cargo.toml --release --locked"
            ),
            "{}",
            told("cargo.told")
        );
    }
}

/// Ctrl-C at a terminal goes to every program of the group that runs there.
#[test]
fn ctrl_c_disarms_a_drive_at_a_probe() {
    use std::os::unix::process::CommandExt;
    let bench = Bench::new(EMA.plant);
    let mut command = at_probe(&bench, &["record", "--probe", "--arm", "--out", "log.csv"]);
    let child = begun(&bench, command.process_group(0));
    let group = format!("-{}", child.id());
    let sent = Command::new("kill").args(["-INT", "--", &group]).status();
    assert!(sent.unwrap().success());
    assert!(!child.wait_with_output().unwrap().status.success());
    assert!(!bench.is_armed());
    let begun = Instant::now();
    while is_served(&bench) {
        assert!(begun.elapsed() < Duration::from_secs(10), "it goes on");
        thread::sleep(Duration::from_millis(10));
    }
    assert!(!bench.path("log.csv").exists());
}

#[test]
fn what_is_wrong_at_a_probe_is_said() {
    let arguments = ["record", "--probe", "--arm", "--out", "log.csv"];
    let bench = Bench::new(EMA.plant);
    let refused = |command: &mut Command, status: i32, part: &str| {
        let output = command.output().unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{said}");
        assert!(said.contains(part), "{said}");
        assert!(!bench.was_armed());
        assert!(!bench.path("log.csv").exists());
    };
    let none = "no debug probe is attached: plug one in";
    refused(
        at_probe(&bench, &arguments).env("SAYS", none),
        1,
        &format!("error: {none}\n"),
    );
    let gone = "the chip does not answer the probe";
    refused(
        at_probe(&bench, &arguments).env("LEAVES", gone),
        1,
        &format!("the line to the board: {gone}"),
    );
    refused(
        at_probe(&bench, &arguments).env("FAILS", "error: no network"),
        1,
        "--target-dir target/probe`\nhost-tests/probe does not build\nerror: no network",
    );
    refused(
        &mut at_probe(&bench, &["record", "--probe", "jlink", "--out", "log.csv"]),
        2,
        "expected VID:PID or VID:PID:SERIAL",
    );
    let record = |arguments: &[&str]| {
        let arguments = [&["record"], arguments, &["--out", "log.csv"]].concat();
        hil(&bench.directory, &arguments)
    };
    refused(
        &mut record(&["--rtt", "127.0.0.1:1"]),
        2,
        "rtt server start 9090 1",
    );
    refused(&mut record(&[]), 2, "--port, --probe or --rtt");
    refused(
        &mut record(&["--probe", "--port", "/dev/null"]),
        2,
        "cannot be used with",
    );
}

/// The program at the probe itself, which is built for this. What a machine has attached has other numbers.
#[test]
#[ignore = "other cases: it builds other people's drivers of probes"]
fn a_probe_that_is_not_attached_is_said_to_be_that() {
    let bench = Bench::new(EMA.plant);
    let arguments = [
        "record",
        "--probe",
        "ffff:ffff",
        "--arm",
        "--out",
        "log.csv",
    ];
    let output = hil(&bench.directory, &arguments).output().unwrap();
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    let last = said.lines().last().unwrap();
    assert!(
        last.starts_with("error: no debug probe ffff:ffff is attached; "),
        "{said}"
    );
    assert!(!bench.path("log.csv").exists());
}

/// A sweep that turns round often; about where the motor stands.
const SWEEP: &str = "sweep 0 0.3 0.3 3 10";

/// A motor whose friction nobody told the controller of.
fn worn() -> Parameters {
    Parameters {
        coulomb: Directional::both(0.15),
        breakaway: Directional::both(0.18),
        ..EMA.plant
    }
}

/// A line of a host that is busy: after each read the next one finds nothing, and the order to arm waits until the board has said
/// how its drive is, if it says so at all.
struct HeldUp {
    line: Box<dyn SerialPort>,
    read_ahead: VecDeque<u8>,
    has_read: bool,
}

impl Read for HeldUp {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.has_read = !self.has_read;
        if !self.has_read {
            return Err(io::ErrorKind::TimedOut.into());
        }
        if self.read_ahead.is_empty() {
            return self.line.read(bytes);
        }
        self.read_ahead.read(bytes)
    }
}

impl Write for HeldUp {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if bytes == b"arm\r" {
            let mut read = [0; 256];
            if let Ok(count) = self.line.read(&mut read) {
                thread::sleep(Duration::from_millis(5));
                self.read_ahead.extend(&read[..count]);
            }
        }
        self.line.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.line.flush()
    }
}

#[test]
fn what_was_said_before_the_drive_was_armed_does_not_shorten_the_recording() {
    let drive = Drive {
        mode: "position",
        signal: None,
        seconds: 0.5,
    };
    let ending = Ending::watch(&[]).unwrap();
    for _ in 0..5 {
        let bench = Bench::new(EMA.plant);
        let mut line = HeldUp {
            line: serial::open(&bench.board.port).unwrap(),
            read_ahead: VecDeque::new(),
            has_read: false,
        };
        let recorded = record(&mut line, &drive, &ending, || Ok(())).unwrap();
        let samples = recorded.csv().unwrap().lines().count() - 1;
        assert!(samples >= 500, "{samples}");
    }
}

#[test]
fn a_board_is_driven_recorded_and_left_disarmed() {
    let bench = Bench::new(worn());
    let output = bench.record(&["--arm", "--signal", SWEEP, "--out", "recorded"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(bench.was_armed() && !bench.is_armed());

    let machine = Machine::read(&bench.path("recorded/machine.toml")).unwrap();
    assert_eq!(machine.parameter("resistance"), Some(1.0));
    assert_eq!(machine.parameter("coulomb"), Some(0.12));
    let log = Log::read(&bench.path("recorded/log.csv")).unwrap();
    // The ring keeps 10 s, and that is what was asked for.
    assert_eq!(log.samples(), 10_000);
    let (least, most) = log
        .position
        .iter()
        .fold((0.0_f64, 0.0_f64), |(low, high), &p| {
            (low.min(p), high.max(p))
        });
    assert!(least < -0.2 && most > 0.2, "{least} to {most} rad");

    let said = text(&output.stdout);
    assert!(said.contains("recorded/log.csv: 10000 rows"), "{said}");
    let next = said.lines().last().unwrap();
    let call = next.strip_prefix("next: cargo hil ").unwrap();
    let traced = Command::new(env!("CARGO_BIN_EXE_hil"))
        .current_dir(bench.directory.path())
        .args(call.split(' '))
        .args(["--json", "gap.json"])
        .output()
        .unwrap();
    assert!(traced.status.success(), "{}", text(&traced.stderr));
    let answer = fs::read_to_string(bench.path("gap.json")).unwrap();
    let answer: serde_json::Value = serde_json::from_str(&answer).unwrap();
    // All that is wrong with the machine file is its friction. That a voltage reaches the winding in a tick
    // behind the step that asked for it is true of every such drive, and may be found.
    let effects = answer["effects"].as_array().unwrap();
    assert!(
        effects.iter().all(|effect| effect["id"] == "input_delay"),
        "{effects:?}"
    );
    let fits = answer["fit"].as_array().unwrap();
    let coulomb = fits.iter().find(|fit| fit["name"] == "coulomb").unwrap();
    let fitted = coulomb["fitted"].as_f64().unwrap();
    assert!((fitted - 0.15).abs() < 0.005, "{fitted}");
}

/// Who has no board yet records an emulated one, and finds what its machine file does not say.
#[test]
fn without_a_board_an_emulated_one_is_recorded_to_a_verdict() {
    let directory = tempfile::tempdir().unwrap();
    let output = hil(&directory, &["record", "--emulated", "--out", "recorded"])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let trace = [
        "gap",
        "--machine",
        "recorded/machine.toml",
        "--train",
        "recorded/log.csv",
    ];
    assert!(text(&output.stdout).contains("recorded/machine.toml --train"));
    let output = hil(&directory, &trace).output().unwrap();
    let said = text(&output.stdout);
    assert!(
        said.contains("one effect was missing, asymmetric_viscous"),
        "{said}"
    );
}

#[test]
fn nothing_moves_before_somebody_allows_it() {
    let bench = Bench::new(EMA.plant);
    let output = bench.record(&["--signal", SWEEP, "--out", "log.csv"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("add --arm"));
    assert!(!bench.was_armed());
    assert_eq!(bench.files(), [] as [PathBuf; 0]);
}

#[test]
fn a_file_that_is_there_is_kept_and_nothing_moves() {
    let bench = Bench::new(EMA.plant);
    for (there, arguments) in [
        ("log.csv", &["--out", "log.csv"][..]),
        ("m.toml", &["--out", "log.csv", "--machine-out", "m.toml"]),
        ("out/machine.toml", &["--out", "out"]),
    ] {
        let path = bench.path(there);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, "mine").unwrap();
        let output = bench.record(&[&["--arm"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{there}");
        assert!(text(&output.stderr).contains("is not replaced"), "{there}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "mine");
        assert!(!bench.was_armed());
        fs::remove_file(path).unwrap();
    }
}

#[test]
fn what_the_console_would_not_take_is_refused_before_the_port_is_opened() {
    let directory = tempfile::tempdir().unwrap();
    let refused = |arguments: &[&str], part: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_hil"))
            .current_dir(directory.path())
            .args(["record", "--port", "absent", "--arm", "--out", "log.csv"])
            .args(arguments)
            .output()
            .unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(part), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
    };
    refused(&["--signal", "sine 0 0.2"], "--signal: error: column 11");
    refused(&["--signal", "arm"], "--signal: expected step, ramp");
    refused(&["--mode", "voltage"], "needs a --signal");
    refused(&["--seconds", "11"], "0.5 to 10");
    refused(&[], "absent: cannot be opened");
}

#[test]
fn a_drive_with_a_fault_is_not_armed() {
    let bench = Bench::new(EMA.plant);
    bench.board.inject(WireFault::UnderVoltage);
    while bench.board.wiring.latch().causes().is_empty() {
        thread::sleep(Duration::from_millis(1));
    }
    let output = bench.record(&["--arm", "--out", "log.csv"]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("under_voltage, holds now"), "{said}");
    assert!(!bench.was_armed());
}

/// A recording of a sweep.
fn sweep(bench: &Bench) -> Command {
    bench.command(&["--arm", "--signal", SWEEP, "--out", "log.csv"])
}

/// A recording that has begun to move: armed alone, the drive rests, until the signal comes.
fn begun(bench: &Bench, command: &mut Command) -> Child {
    let mut child = command.spawn().unwrap();
    while !bench.is_driven() {
        if let Some(status) = child.try_wait().unwrap() {
            panic!("{status} before it moved");
        }
        thread::sleep(Duration::from_millis(1));
    }
    child
}

#[test]
fn a_fault_on_the_way_ends_it_disarmed_and_with_its_name() {
    let bench = Bench::new(EMA.plant);
    let child = begun(&bench, &mut sweep(&bench));
    bench.board.inject(WireFault::BridgeBreak);
    let output = child.wait_with_output().unwrap();
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("the drive let go after"), "{said}");
    assert!(said.contains("bridge_break"), "{said}");
    assert!(!bench.is_armed());
    assert_eq!(bench.files(), [] as [PathBuf; 0]);
}

#[test]
fn a_signal_disarms_the_drive_before_it_ends_the_program() {
    for signal in ["INT", "TERM", "HUP"] {
        let bench = Bench::new(EMA.plant);
        let child = begun(&bench, &mut sweep(&bench));
        let sent = Command::new("kill")
            .args([&format!("-{signal}"), &child.id().to_string()])
            .status()
            .unwrap();
        assert!(sent.success());
        let output = child.wait_with_output().unwrap();
        assert!(!output.status.success());
        assert!(!bench.is_armed(), "{signal}");
        assert_eq!(bench.files(), [] as [PathBuf; 0], "{signal}");
    }
}

#[test]
fn a_file_that_is_no_port_is_named() {
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("port"), "").unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_hil"))
        .current_dir(directory.path())
        .args(["record", "--port", "port", "--arm", "--out", "log.csv"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).starts_with("error: port: cannot be opened"));
    assert!(!Path::new(&directory.path().join("log.csv")).exists());
}
