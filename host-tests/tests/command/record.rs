//! `cargo hil record`: a controller at a pseudo-terminal is armed, driven, disarmed and read, whatever happens
//! on the way.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::Ordering::Relaxed;
use std::thread;
use std::time::Duration;

use firmware::app::machine::EMA;
use host_tests::board_link::emulated::{EmulatedBoard, Pace, WireFault};
use host_tests::log::Log;
use host_tests::machine::Machine;
use model_core::plant::Directional;
use model_core::plant::parameters::Parameters;
use tempfile::TempDir;

/// A controller at a pseudo-terminal, and a place for files.
struct Bench {
    board: EmulatedBoard,
    directory: TempDir,
}

impl Bench {
    fn new(motor: Parameters) -> Self {
        Self {
            board: EmulatedBoard::start(motor, Pace::Free).unwrap(),
            directory: tempfile::tempdir().unwrap(),
        }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    /// `cargo hil record` at its port, with what else is said.
    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hil"));
        command
            .current_dir(self.directory.path())
            .args(["record", "--port"])
            .arg(&self.board.port)
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    fn record(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    fn is_armed(&self) -> bool {
        self.board.wiring.latch().is_armed()
    }

    fn was_armed(&self) -> bool {
        self.board.was_armed.load(Relaxed)
    }

    fn files(&self) -> Vec<PathBuf> {
        let entries = fs::read_dir(self.directory.path()).unwrap();
        entries.map(|entry| entry.unwrap().path()).collect()
    }
}

fn text(bytes: &[u8]) -> &str {
    str::from_utf8(bytes).unwrap()
}

/// What probe-rs prints of a board that was asked for another recording, then for its log of so many rows.
fn printed(rows: usize, lost: Option<usize>) -> String {
    let head = |name: &str, steps: usize| {
        format!(
            "0.001040 [INFO ] experiment name={name} plant_period_us=50 control_period_us=1000 steps={steps} (firmware \
             src/app/capture.rs:426)\n"
        )
    };
    let row = |name: f32, k: usize| {
        format!(
            "{k}.001040 [INFO ] sample sequence={k} time_us={} input={name} position=0.25 command=NaN current_a=-0.5 \
             true_position=NaN true_velocity=NaN true_current_a=NaN (firmware src/app/record.rs:221)\n",
            1000 * k
        )
    };
    let mut text = head("capture", 2) + &row(7.0, 0) + &row(7.0, 1) + &head("log", rows);
    text += "0.001040 [INFO ] capture quantities=input,position,current_a trigger_row=0 (firmware src/app/capture.rs:432)\n";
    for k in (0..rows).filter(|k| lost != Some(*k)) {
        text += &row(1.5, k);
    }
    text
}

/// A program of the name probe-rs that prints this text and then does `end`; what `hil` with it on its path says.
fn listen(directory: &Path, text: &str, end: &str, arguments: &[&str]) -> Output {
    use std::os::unix::fs::PermissionsExt;
    let programs = directory.join("bin");
    fs::create_dir_all(&programs).unwrap();
    fs::write(directory.join("printed.txt"), text).unwrap();
    fs::write(directory.join("controller"), "an image").unwrap();
    let program = programs.join("probe-rs");
    let script = format!(
        "#!/bin/sh\n[ \"$*\" = 'attach --chip STM32F405RGTx controller' ] || exit 3\ncat printed.txt\n{end}\n"
    );
    fs::write(&program, script).unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    let path = format!("{}:{}", programs.display(), std::env::var("PATH").unwrap());
    Command::new(env!("CARGO_BIN_EXE_hil"))
        .current_dir(directory)
        .env("PATH", path)
        .args(["record", "--probe", "controller"])
        .args(arguments)
        .stdin(Stdio::null())
        .output()
        .unwrap()
}

/// probe-rs goes on for as long as nobody ends it.
const GOES_ON: &str = "exec sleep 1000";

#[test]
fn what_a_probe_hears_of_dump_log_becomes_a_log() {
    let directory = tempfile::tempdir().unwrap();
    let output = listen(
        directory.path(),
        &printed(500, None),
        GOES_ON,
        &["--out", "recorded"],
    );
    assert!(output.status.success(), "{}", text(&output.stderr));
    let log = Log::read(&directory.path().join("recorded/log.csv")).unwrap();
    assert_eq!((log.samples(), log.period_s), (500, 1e-3));
    // The other recording is none of it.
    assert!(log.input.iter().all(|input| *input == 1.5));
    assert_eq!(log.current.unwrap()[0], -0.5);
    assert!(text(&output.stdout).contains("recorded/log.csv: 500 rows"));
    assert!(
        text(&output.stderr).contains("`dump log`")
            && text(&output.stderr).contains("cargo hil machine")
    );
    assert!(!directory.path().join("recorded/machine.toml").exists());
}

#[test]
fn a_probe_that_hears_too_little_leaves_nothing() {
    for (printed, end, said) in [
        (printed(500, Some(99)), GOES_ON, "1 of 500 rows were lost"),
        (
            printed(500, Some(499)),
            "exit 1",
            "probe-rs ended after 499 of 500 rows",
        ),
        (String::new(), "exit 1", "probe-rs ended after 0 of 0 rows"),
    ] {
        let directory = tempfile::tempdir().unwrap();
        let output = listen(directory.path(), &printed, end, &["--out", "log.csv"]);
        assert_eq!(output.status.code(), Some(1));
        assert!(
            text(&output.stderr).contains(said),
            "{}",
            text(&output.stderr)
        );
        assert!(!directory.path().join("log.csv").exists());
    }
}

/// A probe has no way to the console: it neither drives nor asks.
#[test]
fn what_a_probe_cannot_do_is_refused() {
    let directory = tempfile::tempdir().unwrap();
    for arguments in [
        &["--arm"][..],
        &["--signal", SWEEP],
        &["--seconds", "5"],
        &["--machine-out", "m.toml"],
        &["--port", "/dev/null"],
    ] {
        let arguments = [arguments, &["--out", "log.csv"]].concat();
        let output = listen(directory.path(), "", GOES_ON, &arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(
            text(&output.stderr).contains("--probe"),
            "{}",
            text(&output.stderr)
        );
    }
    let mine = directory.path().join("mine.csv");
    fs::write(&mine, "mine").unwrap();
    let output = listen(
        directory.path(),
        &printed(500, None),
        GOES_ON,
        &["--out", "mine.csv"],
    );
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
    assert_eq!(fs::read_to_string(mine).unwrap(), "mine");
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

/// A recording that has begun to move.
fn begun(bench: &Bench) -> Child {
    let mut child = bench
        .command(&["--arm", "--signal", SWEEP, "--out", "log.csv"])
        .spawn()
        .unwrap();
    while !bench.is_armed() {
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
    let child = begun(&bench);
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
        let child = begun(&bench);
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
