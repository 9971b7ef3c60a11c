//! Promise: what a text for people says can be typed is run by a test, as it stands there. [`WAYS`] says how each is run, and
//! a command that is not in it fails.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, OpenOptions};
use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::fs::symlink;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use firmware::app::machine::EMA;
use host_tests::documents::{Documented, commands};
use host_tests::log::Log;
use host_tests::machine::{Machine, PARAMETERS};
use host_tests::{measured, workspace};
use serialport::{SerialPort, TTYPort};
use tempfile::TempDir;

use crate::identify_command::logs;
use crate::import::matlab;
use crate::record::{Bench, serve, serve_at_probe};

/// How a command is run.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Way {
    /// In a directory with the files that its text speaks of.
    AsItStands,
    /// The same, where there are the measured logs that it names.
    OnMeasuredLogs,
    /// As it stands but for the name of a port: a board is emulated where the text has one.
    AtABoard,
    /// As it stands, with `cargo hil test --cases`.
    OtherCases,
    /// The same, where there are the measured logs.
    OtherCasesOnMeasuredLogs,
    /// As it stands, with `cargo hil test --all`.
    AtLength,
    /// By `cargo hil test`, where this file of the project has this text.
    Elsewhere(&'static str, &'static str),
    /// By no test, for this reason.
    Never(&'static str),
}
use Way::{
    AsItStands, AtABoard, AtLength, Elsewhere, Never, OnMeasuredLogs, OtherCases,
    OtherCasesOnMeasuredLogs,
};

const CHIPS: &str = "host-tests/src/check/images.rs";
const BOARD: &str = "it flashes or reads a board, which a machine that tests has not; the images run on emulated chips";
const INSTALLS: &str = "it installs programs for the whole machine";

/// A serial port and a program at a probe, as the texts have them.
const PORT: &str = "/dev/ttyUSB0";
const SERVED: &str = "127.0.0.1:9090";

const README: &str = "README.md";

/// A part of what takes longest, with the same options.
const QUICK: &str = "cargo hil bench gap --worlds 1 --seed 20270114";

/// How each command is run: the first line that it fits. A star at the end stands for anything.
const WAYS: [(&str, Way); 23] = [
    // Under --all these three run as they stand, too.
    ("cargo hil", Elsewhere(CHIPS, "emulated_chips(toolchain)?")),
    ("cargo hil ecu", Elsewhere(CHIPS, "board_run::ECU, ")),
    (
        "cargo hil onboard --json onboard.json",
        Elsewhere(CHIPS, "prepared.verdicts()?"),
    ),
    (
        "cargo hil test",
        Elsewhere(".ci/run", "exec cargo hil test"),
    ),
    ("cargo hil machine *", AsItStands),
    ("cargo hil import *", AsItStands),
    (
        "cargo hil gap --machine host-tests/machines/emps.toml *",
        OnMeasuredLogs,
    ),
    ("cargo hil gap *", AsItStands),
    ("cargo hil export *", AsItStands),
    ("cargo hil track *", AsItStands),
    ("cargo hil identify *", AsItStands),
    ("cargo hil record *", AtABoard),
    ("cargo hil live*", AtABoard),
    ("cargo hil reproduce prognostics *", OtherCases),
    (
        "cargo hil reproduce bench --json bench.json",
        Elsewhere(
            "host-tests/tests/models/reproduce_bench.rs",
            "fn the_command_gives_them_at_every_level_of_backlash",
        ),
    ),
    (
        "cargo hil reproduce throttle *",
        Elsewhere(CHIPS, "run_on_emulated_chips(limit)?"),
    ),
    ("cargo hil bench real", OtherCasesOnMeasuredLogs),
    ("cargo hil bench gap *", AtLength),
    ("cargo install *", Never(INSTALLS)),
    ("openocd *", Never(BOARD)),
    ("cargo flash-*", Never(BOARD)),
    ("cargo run --release -p firmware *", Never(BOARD)),
    (
        "MIRIFLAGS=*",
        Never("it takes a nightly compiler; `cargo hil test` lists the tests that it names"),
    ),
];

/// How a command is run, if it is.
fn way(command: &Documented) -> Option<&'static (&'static str, Way)> {
    let words = command.words.join(" ");
    WAYS.iter()
        .find(|(shape, _)| match shape.strip_suffix('*') {
            Some(start) => words.starts_with(start),
            None => words == *shape,
        })
}

/// The commands of blocks that are run so.
fn of_way(wanted: Way) -> Vec<Documented> {
    let mut commands = commands().unwrap();
    commands
        .retain(|command| command.is_whole && way(command).is_some_and(|(_, way)| *way == wanted));
    assert!(!commands.is_empty(), "{wanted:?}");
    commands
}

#[test]
fn every_number_of_a_machine_file_is_explained() {
    let text = fs::read_to_string(workspace::root().join("docs/log.md")).unwrap();
    let rows: Vec<&str> = text.lines().filter(|line| line.starts_with("| ")).collect();
    for parameter in PARAMETERS {
        let key = format!("`{}`", parameter.name);
        assert!(rows.iter().any(|row| row.contains(&key)), "{key}");
    }
}

#[test]
fn no_command_of_a_block_is_left_out() {
    let mut used = BTreeSet::new();
    for command in commands().unwrap() {
        if !command.is_whole {
            continue;
        }
        let place = format!("{}: {}", command.document, command.line);
        let (shape, way) = way(&command).unwrap_or_else(|| panic!("{place}: no test runs it"));
        used.insert(*shape);
        if let Elsewhere(file, part) = way {
            let text = fs::read_to_string(workspace::root().join(file)).unwrap();
            assert!(text.contains(part), "{place}: {file} has no {part}");
        }
    }
    let idle: Vec<&str> = WAYS.iter().map(|(shape, _)| *shape).collect();
    let idle = idle.iter().find(|shape| !used.contains(*shape));
    assert_eq!(idle, None, "no block has it any more");
}

/// A place to type a text's commands in: the tree's files and the measured ones are where a text has them, from the project's
/// root.
struct Place(TempDir);

impl Place {
    fn new() -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        let root = workspace::root();
        fs::create_dir(place.path("")).unwrap();
        symlink(root.join("host-tests"), place.path("host-tests")).unwrap();
        symlink(root.join("../shared"), place.path("../shared")).unwrap();
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join("project").join(name)
    }

    /// Runs a command as it stands; what it wrote is there then.
    #[track_caller]
    fn run(&self, line: &str) {
        let output = shell(&self.path(""), line).output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{line}\n{error}");
        let words: Vec<&str> = line.split_whitespace().collect();
        for pair in words.windows(2) {
            if ["--out", "--json", "--report", "--machine-out", ">"].contains(&pair[0]) {
                assert!(self.path(pair[1]).exists(), "{line}\n{}", pair[1]);
            }
        }
    }

    /// Writes what the commands of a text read, where no command of the text itself makes it.
    fn prepare(&self, document: &str) {
        match document {
            "docs/log.md" => self.prepare_months(),
            "docs/export.md" => {
                let commands = of_way(AsItStands).into_iter();
                for command in commands.filter(|command| command.document == "README.md") {
                    if command.words[2] != "gap" {
                        self.run(&command.line);
                    }
                }
            }
            "docs/throttle.md" => {
                logs(&self.path(""));
                fs::rename(self.path("slow.csv"), self.path("triangle.csv")).unwrap();
                fs::copy(self.path("fast.csv"), self.path("more.csv")).unwrap();
                fs::rename(self.path("fast.csv"), self.path("steps.csv")).unwrap();
            }
            "docs/evaluation.md" => {
                for name in ["DATA_EMPS.mat", "DATA_EMPS_PULSES.mat"] {
                    let file = matlab::of_vectors(&["t", "qg", "vir", "qm"]);
                    fs::write(self.path(name), file).unwrap();
                }
            }
            _ => (),
        }
    }

    /// The README's two drives, and four parts of the first for the months.
    fn prepare_months(&self) {
        for (drive, name) in [("run-a", "run.csv"), ("run-b", "other.csv")] {
            let from = self.path(&format!("host-tests/examples/{drive}.csv"));
            fs::copy(from, self.path(name)).unwrap();
        }
        let columns = "--time t:ms --position pos:deg --input 'duty:%*12' --current i:mA";
        self.run(&format!("cargo hil import other.csv {columns} --out b.csv"));
        for (place, month) in ["march", "april", "may", "june"].iter().enumerate() {
            let first = 3 + 1250 * place;
            let lines = format!("{first}-{}", first + 1249);
            self.run(&format!(
                "cargo hil import run.csv {columns} --header 2 --lines {lines} --out {month}.csv"
            ));
        }
    }
}

/// A shell with this command.
fn shell(directory: &Path, line: &str) -> Command {
    let mut shell = Command::new("sh");
    shell
        .args(["-ec", &line.replace("cargo hil", env!("CARGO_BIN_EXE_hil"))])
        .current_dir(directory)
        .stdin(Stdio::null());
    shell
}

/// What the README shows leads from a data sheet and two logs to the arm on the shaft, of 0.12 N·m, and to the 30 % of the motor's
/// torque that the gear loses (`rig/examples/gearmotor.rs`).
#[test]
fn the_calls_that_the_readme_shows_find_the_arm() {
    let place = Place::new();
    for command in of_way(AsItStands) {
        if command.document == README {
            place.run(&command.line.replace(" gap ", " gap --json answer.json "));
        }
    }
    assert!(place.path("report/index.html").is_file());
    let answer = fs::read(place.path("answer.json")).unwrap();
    let answer: serde_json::Value = serde_json::from_slice(&answer).unwrap();
    assert_eq!(answer["verdict"], "effects_found");
    let effects = answer["effects"].as_array().unwrap();
    let [gravity, loss] = &effects[..] else {
        panic!("{effects:?}");
    };
    assert_eq!(gravity["id"], "gravity");
    let torque = gravity["parameters"][0]["value"].as_f64().unwrap();
    assert!((torque / 0.12 - 1.0).abs() < 0.02, "{torque}");
    assert_eq!(loss["id"], "load_dependent_friction");
    let share = loss["parameters"][0]["value"].as_f64().unwrap();
    assert!((share / 0.3 - 1.0).abs() < 0.02, "{share}");
    let errors = &answer["errors"]["validate"];
    let position = |stage: &str| errors[stage]["position_rms"].as_f64().unwrap();
    assert!(position("after") < 0.1 * position("before"), "{errors}");
}

/// Each text in a place of its own, in the order of its commands.
#[test]
fn the_calls_that_the_other_texts_show_run() {
    let commands = of_way(AsItStands);
    for text in commands.chunk_by(|one, next| one.document == next.document) {
        let document = text[0].document.as_str();
        if document == README {
            continue;
        }
        let place = Place::new();
        place.prepare(document);
        for command in text {
            place.run(&command.line);
        }
    }
}

#[test]
fn the_calls_on_measured_logs_run() {
    if measured::path("emps/train.csv").is_some() {
        run_each(OnMeasuredLogs);
    }
}

fn run_each(way: Way) {
    for command in of_way(way) {
        Place::new().run(&command.line);
    }
}

#[test]
#[ignore = "other cases"]
fn what_takes_minutes_runs_as_it_stands() {
    run_each(OtherCases);
}

#[test]
#[ignore = "at length"]
fn what_takes_longest_runs_as_it_stands() {
    run_each(AtLength);
}

#[test]
#[ignore = "other cases"]
fn what_takes_minutes_on_measured_logs_runs_as_it_stands() {
    if measured::path("real/README.md").is_some() {
        run_each(OtherCasesOnMeasuredLogs);
    }
}

#[test]
fn what_takes_longest_begins() {
    Place::new().run(QUICK);
}

/// The ways to a board that the texts show, in a sentence too where it says more than a command's name.
fn at_a_board(command: &str) -> BTreeMap<String, String> {
    let mut commands = commands().unwrap();
    commands.retain(|it| {
        let is_shown = it.is_whole || it.words.len() > 3;
        is_shown && it.words.get(2).is_some_and(|word| word == command)
    });
    let lines = commands.into_iter();
    lines.map(|it| (it.words.join(" "), it.line)).collect()
}

/// A command at an emulated board, which is where the text has one.
fn at(bench: &Bench, line: &str) -> Command {
    let mut line = line.replace(PORT, bench.board.port.to_str().unwrap());
    if line.contains(SERVED) {
        line = line.replace(SERVED, &serve(&bench.board.port));
    }
    let mut command = shell(bench.directory.path(), &format!("exec {line}"));
    serve_at_probe(bench, &mut command);
    command.stdout(Stdio::piped());
    command
}

/// At a terminal, where `arm` is typed when it is asked for: without a terminal nothing moves.
#[test]
fn a_board_of_the_texts_is_recorded() {
    let commands = at_a_board("record");
    assert!(commands.len() >= 5, "{commands:?}");
    for line in commands.values() {
        let bench = Bench::new(EMA.plant);
        let (mut keyboard, terminal) = TTYPort::pair().unwrap();
        let name = terminal.name().unwrap();
        drop(terminal);
        let terminal = || OpenOptions::new().read(true).write(true).open(&name);
        let mut command = at(&bench, line);
        command.stdin(terminal().unwrap());
        command.stderr(terminal().unwrap());
        let child = command.spawn().unwrap();
        // It is read once it is asked for.
        keyboard.write_all(b"arm\n").unwrap();
        let output = child.wait_with_output().unwrap();
        let mut asked = [0; 4096];
        let read = keyboard.read(&mut asked).unwrap();
        let asked = String::from_utf8_lossy(&asked[..read]);
        assert!(output.status.success(), "{line}\n{asked}");
        assert!(asked.contains("Type `arm` to let it: "), "{line}\n{asked}");
        assert!(bench.was_armed() && !bench.is_armed(), "{line}");
        let log = Log::read(&bench.path("recorded/log.csv")).unwrap();
        assert_eq!(log.samples(), 10_000, "{line}");
        Machine::read(&bench.path("recorded/machine.toml")).unwrap();
    }
}

/// Up to the address for the browser, and to Ctrl-C.
#[test]
fn a_board_of_the_texts_is_watched() {
    let commands = at_a_board("live");
    assert!(commands.len() >= 3, "{commands:?}");
    for line in commands.values() {
        let bench = Bench::new(EMA.plant);
        let mut command = at(&bench, line);
        let mut child = command.stderr(Stdio::null()).spawn().unwrap();
        let mut address = String::new();
        let out = child.stdout.as_mut().unwrap();
        BufReader::new(out).read_line(&mut address).unwrap();
        assert!(address.starts_with("http://127.0.0.1:"), "{line}");
        let id = child.id().to_string();
        let sent = Command::new("kill").args(["-INT", &id]).status();
        assert!(sent.unwrap().success());
        // Once all is in order it ends by that signal, as a shell expects.
        let status = child.wait().unwrap();
        assert!(
            status.success() || status.signal() == Some(2),
            "{line}\n{status}"
        );
        assert!(!bench.was_armed(), "{line}");
    }
}
