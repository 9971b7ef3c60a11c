//! Promise: `cargo hil gap` answers with the JSON of its documentation, the same on one core and on
//! several; says in one line what is wrong with a file and where, and then writes nothing; and is
//! quiet in a pipe.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use crate::pushed_slide::HEADER;
use host_tests::gap::headline::LINES;
use model_core::effect::Id;
use rig::{Experiment, Machine, Trajectory};
use serde_json::Value;
use tempfile::TempDir;

const MACHINE: &str = "machine.toml";
const TRAIN: &str = "train.csv";
const VALIDATE: &str = "validate.csv";
const JSON: &str = "gap.json";
const REPORT: &str = "report";

/// A directory that `hil` is run in, with the machine file and the logs of a slide that is pushed
/// by a constant force its machine file does not mention.
struct Bench {
    directory: TempDir,
}

/// What the bench logged, and 2 s of it.
fn log() -> &'static str {
    static LOG: OnceLock<String> = OnceLock::new();
    LOG.get_or_init(|| crate::pushed_slide::log(6.0))
}

/// The header and the first `rows` rows of the log.
fn head(rows: usize) -> String {
    let lines: Vec<&str> = log().lines().take(rows + 1).collect();
    lines.join("\n") + "\n"
}

/// The first 2 s of the log; `edit` gets line `line`, as an editor counts.
fn edited(line: usize, edit: impl Fn(&str) -> String) -> String {
    let mut lines: Vec<String> = head(2000).lines().map(str::to_owned).collect();
    lines[line - 1] = edit(&lines[line - 1]);
    lines.join("\n") + "\n"
}

/// Replaces one field of a row.
fn with_field(row: &str, place: usize, field: &str) -> String {
    let mut fields: Vec<&str> = row.split(',').collect();
    fields[place] = field;
    fields.join(",")
}

impl Bench {
    fn new() -> Self {
        let directory = tempfile::tempdir().expect("a temporary directory");
        let bench = Self { directory };
        bench.write(MACHINE, Machine::force_slide().to_toml());
        bench.write(TRAIN, log());
        bench.write(VALIDATE, head(2000));
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).expect("a writable temporary directory");
    }

    /// Writes the machine file with one passage replaced.
    fn write_machine(&self, passage: &str, replacement: &str) {
        let text = Machine::force_slide().to_toml();
        assert_eq!(text.matches(passage).count(), 1, "{passage:?} in {text}");
        self.write(MACHINE, text.replace(passage, replacement));
    }

    fn command<S: AsRef<OsStr>>(&self, arguments: &[S]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hil"));
        command
            .current_dir(self.directory.path())
            .arg("gap")
            .args(arguments);
        command
    }

    fn run<S: AsRef<OsStr>>(&self, arguments: &[S]) -> Output {
        let output = self.command(arguments).output().expect("hil starts");
        assert!(!text(&output.stderr).contains("panicked"));
        output
    }

    /// Runs and reads the JSON file.
    #[track_caller]
    fn answer(&self, logs: &[&str]) -> Value {
        let mut arguments = vec!["--machine", MACHINE, "--json", JSON];
        arguments.extend(logs);
        let output = self.run(&arguments);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        self.json()
    }

    fn json(&self) -> Value {
        let written = fs::read_to_string(self.path(JSON)).expect("a JSON file");
        serde_json::from_str(&written).expect("JSON")
    }

    /// Asserts that the command refuses its files: one line that starts with `error: place: ` and
    /// has all the words, status 2, nothing on standard output, nothing written.
    #[track_caller]
    fn refuses(&self, logs: &[&str], place: &str, words: &[&str]) {
        let entries = |directory: &Path| fs::read_dir(directory).unwrap().count();
        let before = entries(self.directory.path());
        let mut arguments = vec!["--machine", MACHINE, "--json", JSON, "--report", REPORT];
        arguments.extend(logs);
        let output = self.run(&arguments);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(
            error.starts_with(&format!("error: {place}: ")),
            "not at {place}: {error}"
        );
        for word in words {
            assert!(error.contains(word), "no {word:?} in: {error}");
        }
        assert!(output.stdout.is_empty());
        assert_eq!(entries(self.directory.path()), before);
    }

    /// Refused as a training log, and as a validation log.
    #[track_caller]
    /// The verdict is that log and machine file disagree in one thing, with that remedy, and no physics.
    fn disagrees(&self, logs: &[&str], what: &str, remedy: &str) {
        let answer = self.answer(logs);
        assert_eq!(answer["verdict"], "log_and_machine_disagree", "{answer}");
        assert_eq!(answer["effects"].as_array().unwrap().len(), 0);
        assert!(answer["unknown"].is_null());
        let [found] = &answer["disagreement"].as_array().unwrap()[..] else {
            panic!("{answer}");
        };
        assert_eq!(found["what"], what);
        let said = found["remedy"].as_str().unwrap();
        assert!(
            said.starts_with("cargo hil import ") && said.contains(remedy),
            "{said}"
        );
        assert!(!found["evidence"].as_str().unwrap().is_empty());
    }

    fn refuses_log(&self, content: impl AsRef<[u8]>, line: Option<usize>, words: &[&str]) {
        self.write("bad.csv", content);
        let place = match line {
            Some(line) => format!("bad.csv:{line}"),
            None => "bad.csv".to_owned(),
        };
        self.refuses(&["--train", "bad.csv"], &place, words);
        self.write("short.csv", head(1000));
        let logs = ["--train", "short.csv", "--validate", "bad.csv"];
        self.refuses(&logs, &place, words);
    }

    /// Refused with one passage of the machine file replaced, at the line that has `at` then.
    #[track_caller]
    fn refuses_machine(&self, (passage, replacement): (&str, &str), at: &str, words: &[&str]) {
        self.write_machine(passage, replacement);
        let machine = fs::read_to_string(self.path(MACHINE)).unwrap();
        let line = 1 + machine.lines().position(|line| line.contains(at)).unwrap();
        let place = format!("{MACHINE}:{line}");
        self.refuses(&["--train", TRAIN], &place, words);
    }

    /// Refused with these declared effects, the first of which stands on the line to blame.
    #[track_caller]
    fn refuses_effects(&self, effects: &str, at: &str, words: &[&str]) {
        let list = format!("[fit]\ndeclared_effects = [\n{effects}\n]");
        self.refuses_machine(("[fit]", &list), at, words);
    }
}

/// A call with logs, JSON and report, and what came of it; several tests look at the same one.
struct Traced {
    output: Output,
    answer: Value,
    figures: Vec<String>,
}

fn traced() -> &'static Traced {
    static TRACED: OnceLock<Traced> = OnceLock::new();
    TRACED.get_or_init(|| {
        let bench = Bench::new();
        let logs = ["--train", TRAIN, "--validate", VALIDATE];
        let outputs = ["--machine", MACHINE, "--json", JSON, "--report", REPORT];
        let output = bench.run(&[&outputs[..], &logs].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        Traced {
            output,
            answer: bench.json(),
            figures: figures(&bench),
        }
    })
}

/// An answer without the seconds that it took.
fn timeless(answer: &Value) -> Value {
    let mut answer = answer.clone();
    let seconds = answer["cost"]["seconds"].take();
    assert!(seconds.as_f64().unwrap() > 0.0);
    answer
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("UTF-8")
}

mod bad_logs {
    use super::*;

    #[test]
    fn without_rows() {
        let bench = Bench::new();
        bench.refuses_log("", Some(1), &["empty", "expected a log"]);
        let header = format!("{HEADER}\n");
        bench.refuses_log(
            header,
            Some(1),
            &["0 samples", "expected at least 171", "record longer"],
        );
    }

    #[test]
    fn without_a_column() {
        let renamed = edited(1, |header| header.replace("position", "angle"));
        let words = ["no column `position`", "expected a log"];
        Bench::new().refuses_log(renamed, Some(1), &words);
    }

    #[test]
    fn with_a_field_that_is_no_number() {
        let bench = Bench::new();
        for (field, words) in [
            ("NaN", ["`position` is \"NaN\"", "expected a finite number"]),
            (
                "-inf",
                ["`position` is \"-inf\"", "expected a finite number"],
            ),
            (
                "1e39",
                ["`position` is \"1e39\"", "expected a finite number"],
            ),
            ("left", ["`position` is \"left\"", "expected a number"]),
            ("", ["`position` is empty", "expected a number"]),
        ] {
            let log = edited(321, |row| with_field(row, 2, field));
            bench.refuses_log(log, Some(321), &words);
        }
    }

    #[test]
    fn with_a_time_that_runs_backwards() {
        let bench = Bench::new();
        let back = edited(500, |row| with_field(row, 0, "0.400000000"));
        bench.refuses_log(back, Some(500), &["is earlier than that of line 499"]);
    }

    #[test]
    fn cut_short() {
        let bench = Bench::new();
        let whole = head(2000);
        let cut = whole.rfind(',').unwrap();
        let words = ["3 fields, the header has 4", "complete or remove it"];
        bench.refuses_log(&whole[..cut], Some(2001), &words);
    }

    #[test]
    fn of_noise() {
        // A linear congruential generator; the 51st byte is the first that no UTF-8 text has.
        let mut state = 12_345_u32;
        let mut noise = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        let mut bytes = vec![b'x'; 50];
        bytes.push(0xff);
        bytes.extend((0..5000).map(|_| noise()));
        let words = ["not UTF-8 text", "expected a log"];
        Bench::new().refuses_log(bytes, Some(1), &words);
    }

    #[test]
    fn with_too_little_in_them() {
        let bench = Bench::new();
        // To train on, eight entries of the torque balance beside the five that are left out at either end. There is
        // one for each ten samples; the last ten need not be whole.
        // To validate, one window as long as those of the training log, here 0.2 s; 16 samples on either side and
        // the one that the last step reaches.
        bench.write("170.csv", head(170));
        bench.write("232.csv", head(232));
        // One number, however few there are.
        bench.refuses_log(head(15), Some(16), &["15 samples", "expected at least 171"]);
        let words = [
            "too short",
            "expected at least 171 samples (0.171 s)",
            "record longer, or give several with --train",
        ];
        bench.refuses(&["--train", "170.csv"], "170.csv", &words);
        bench.write("171.csv", head(171));
        bench.answer(&["--train", "171.csv"]);
        let words = ["too short", "expected at least 233 samples (0.233 s)"];
        let logs = ["--train", TRAIN, "--validate", "232.csv"];
        bench.refuses(&logs, "232.csv", &words);
    }

    #[test]
    fn sampled_so_slowly_that_the_torque_balance_has_no_samples() {
        let every_tenth: Vec<&str> = log().lines().skip(1).step_by(10).take(170).collect();
        let slow = format!("{HEADER}\n{}\n", every_tenth.join("\n"));
        let bench = Bench::new();
        bench.write("slow.csv", slow);
        let words = ["too short", "expected at least 171 samples (1.710 s)"];
        bench.refuses(&["--train", "slow.csv"], "slow.csv", &words);
    }

    #[test]
    fn that_say_nothing_about_the_machine() {
        let bench = Bench::new();
        let made = |row: fn(f64) -> (f64, f64)| {
            let rows: Vec<String> = (0..1000)
                .map(|index| {
                    let (input, position) = row(f64::from(index) * 1e-3);
                    format!("{:.3},{input},{position}", f64::from(index) * 1e-3)
                })
                .collect();
            format!("time_s,input,position\n{}\n", rows.join("\n"))
        };
        let still = made(|time| (time.sin(), 0.1));
        bench.refuses_log(
            still,
            None,
            &["never changes", "expected a log", "in motion"],
        );
        let idle = made(|time| (0.0, 0.1 * time));
        bench.refuses_log(idle, None, &["0 throughout", "expected a log", "driven"]);
    }

    #[test]
    fn of_different_sampling_periods() {
        let bench = Bench::new();
        let every_second: Vec<&str> = log().lines().skip(1).step_by(2).collect();
        let half = format!("{HEADER}\n{}\n", every_second.join("\n"));
        bench.write("half.csv", half);
        let words = ["0.002 s", "0.001 s", "expected one sampling period"];
        let later = ["--train", TRAIN, "--validate", "half.csv"];
        bench.refuses(&later, "half.csv", &words);
    }

    #[test]
    fn that_were_trained_on() {
        let bench = Bench::new();
        bench.write("copy.csv", log());
        let words = ["has the samples of the training log train.csv"];
        let logs = ["--train", TRAIN, "--validate", "copy.csv"];
        bench.refuses(&logs, "copy.csv", &words);
    }

    /// Degrees where radians are declared, or millimetres where metres are.
    #[test]
    fn far_beyond_the_declared_stops() {
        let bench = Bench::new();
        let stops = "[mechanics]\nlower_stop = -0.12\nupper_stop = 0.12";
        bench.write_machine("[mechanics]", stops);
        let rows = log().lines().map(|row| {
            let position = row.split(',').nth(2).unwrap().parse::<f64>();
            position.map_or(row.to_owned(), |metres| {
                with_field(row, 2, &(1e3 * metres).to_string())
            })
        });
        bench.write("mm.csv", rows.collect::<Vec<_>>().join("\n") + "\n");
        bench.disagrees(
            &["--train", "mm.csv"],
            "position is in millimetres",
            "--position position:mm",
        );
    }

    #[test]
    fn in_milliseconds() {
        let bench = Bench::new();
        let rows = log().lines().skip(1).enumerate();
        let rows: Vec<String> = rows
            .map(|(index, row)| with_field(row, 0, &index.to_string()))
            .collect();
        bench.write("ms.csv", format!("{HEADER}\n{}\n", rows.join("\n")));
        bench.disagrees(
            &["--train", "ms.csv"],
            "time_s is in milliseconds",
            "--time time_s:ms",
        );
    }

    /// Each log needs its own call: also those of which nothing is read for the fit.
    #[test]
    fn in_milliseconds_for_validation_too() {
        let bench = Bench::new();
        let rows = log().lines().skip(1).enumerate();
        let rows: Vec<String> = rows
            .map(|(index, row)| with_field(row, 0, &index.to_string()))
            .collect();
        let logs = ["a.csv", "b.csv", "c.csv"];
        for name in logs {
            bench.write(name, format!("{HEADER}\n{}\n", rows.join("\n")));
        }
        let given = [
            "--train",
            "a.csv",
            "--train",
            "b.csv",
            "--validate",
            "c.csv",
        ];
        let output = bench.run(&[&["--machine", MACHINE], &given[..]].concat());
        let said = text(&output.stdout);
        for name in logs {
            let call = format!("\n  cargo hil import {name} --time time_s:ms ");
            assert_eq!(said.matches(&call).count(), 1, "{name}: {said}");
        }
        assert_eq!(
            said.matches("time_s is in milliseconds").count(),
            1,
            "{said}"
        );
    }

    #[test]
    fn with_a_current_of_the_wrong_sign() {
        let machine = Machine::rotary_ema();
        let bench = Bench::new();
        bench.write(MACHINE, machine.to_toml());
        let moves = Trajectory::moves(&machine);
        let right = Experiment::tracking(machine, moves)
            .lasting(4.0)
            .run()
            .to_csv();
        let header = right.lines().next().unwrap();
        let place = header
            .split(',')
            .position(|name| name == "current_a")
            .unwrap();
        let turned: Vec<String> = right
            .lines()
            .map(
                |row| match row.split(',').nth(place).unwrap().parse::<f64>() {
                    Ok(current) => with_field(row, place, &(-current).to_string()),
                    Err(_) => row.to_owned(),
                },
            )
            .collect();
        bench.write("right.csv", right);
        bench.answer(&["--train", "right.csv"]);
        fs::remove_file(bench.path(JSON)).unwrap();
        bench.write("turned.csv", turned.join("\n") + "\n");
        let what = "current_a has the wrong sign";
        bench.disagrees(
            &["--train", "turned.csv"],
            what,
            "--current \"current_a:A*-1\"",
        );
    }

    #[test]
    fn behind_good_ones() {
        let bench = Bench::new();
        bench.write("bad.csv", edited(9, |row| with_field(row, 1, "off")));
        let train = ["--train", TRAIN, "--train", "bad.csv"];
        bench.refuses(&train, "bad.csv:9", &["`input` is \"off\""]);
        let validate = [
            "--train",
            TRAIN,
            "--validate",
            VALIDATE,
            "--validate",
            "bad.csv",
        ];
        bench.refuses(&validate, "bad.csv:9", &["`input` is \"off\""]);
    }
}

mod bad_machines {
    use super::*;

    #[test]
    fn with_impossible_numbers() {
        let bench = Bench::new();
        for value in ["0.0", "-95.0"] {
            let line = format!("inertia = {value}");
            let words = ["`inertia` is", "expected more than 0"];
            bench.refuses_machine(("inertia = 95.0", &line), &line, &words);
        }
        let words = ["`static` 12.0 is less than `coulomb` 20.0", "expected"];
        let below = ("static = 24.0", "static = 12.0");
        bench.refuses_machine(below, "static", &words);
        let words = ["NaN is not a number", "expected 0 or"];
        let nan = ("viscous = 200.0", "viscous = nan");
        bench.refuses_machine(nan, "viscous", &words);
    }

    #[test]
    fn beyond_what_the_plant_takes() {
        let bench = Bench::new();
        bench.write_machine("inertia = 95.0", "inertia = 1e13");
        let words = ["inertia must be", "at most 1e12"];
        bench.refuses(&["--train", TRAIN], MACHINE, &words);
    }

    #[test]
    fn that_cannot_have_moved_as_the_log_says() {
        let bench = Bench::new();
        bench.write_machine("inertia = 95.0", "inertia = 1e-30");
        let words = ["inertia must be larger beside the other parameters"];
        bench.refuses(&["--train", TRAIN], MACHINE, &words);
    }

    #[test]
    fn with_unknown_keys() {
        let bench = Bench::new();
        let words = ["unknown key `mass`", "`inertia`"];
        let mass = ("inertia = 95.0", "inertia = 95.0\nmass = 95.0");
        bench.refuses_machine(mass, "mass", &words);
        let words = ["unknown key `noise`", "`resolution`"];
        let noise = ("[sensor]", "[sensor]\nnoise = 1.0");
        bench.refuses_machine(noise, "noise", &words);
        let words = ["unknown key `gearbox`", "`mechanics`"];
        let section = ("[fit]", "[gearbox]\nratio = 3.0\n[fit]");
        bench.refuses_machine(section, "gearbox", &words);
    }

    #[test]
    fn with_a_fit_parameter_that_they_do_not_have() {
        let unknown = ("\"viscous\"", "\"resistance\"");
        let words = ["`resistance` cannot be fitted", "expected `inertia`"];
        Bench::new().refuses_machine(unknown, "resistance", &words);
    }

    #[test]
    fn with_effects_that_the_catalogue_does_not_have() {
        let bench = Bench::new();
        bench.refuses_effects(
            "{ id = \"magnetism\", torque = 1.0 },",
            "magnetism",
            &[
                "unknown effect `magnetism`",
                "expected one of offset_torque,",
            ],
        );
        bench.refuses_effects(
            "{ id = \"offset_torque\", torque = 1.0 },\n{ id = \"stribeck\", speed = 1.0 },",
            "stribeck",
            &[
                "`stribeck` has no parameter `speed`",
                "expected drop (0 or more, in N), velocity (more than 0, in m/s)",
            ],
        );
        bench.refuses_effects(
            "{ id = \"stribeck\", drop = 1.0 },",
            "stribeck",
            &[
                "lacks its parameter `velocity`",
                "expected drop (0 or more, in N), velocity (more than 0, in m/s)",
            ],
        );
        bench.refuses_effects(
            "{ id = \"magnetism\" },",
            "magnetism",
            &["unknown effect `magnetism`"],
        );
        bench.refuses_effects(
            "{ id = \"stribeck\" },",
            "stribeck",
            &["an effect without parameters", "expected"],
        );
        bench.refuses_effects(
            "{ id = \"offset_torque\", torque = 1.0, torque = 2.0 },",
            "offset_torque",
            &["duplicate key"],
        );
    }

    #[test]
    fn with_an_effect_twice() {
        Bench::new().refuses_effects(
            "{ id = \"offset_torque\", torque = 1.0 },\n{ id = \"offset_torque\", torque = 2.0 },",
            "torque = 2.0",
            &["`offset_torque` is declared twice", "remove one"],
        );
    }

    #[test]
    fn with_effects_that_cannot_be() {
        let bench = Bench::new();
        bench.refuses_effects(
            "{ id = \"quadratic_drag\", coefficient = -1.0 },",
            "quadratic_drag",
            &[
                "`coefficient` of effect `quadratic_drag` is -1.0",
                "expected 0 or more",
            ],
        );
        for period in ["0.0", "-0.01"] {
            let cogging =
                format!("{{ id = \"cogging\", sine = -1.0, cosine = 0.0, period = {period} }},");
            let words = ["`period` of effect `cogging`", "expected more than 0"];
            bench.refuses_effects(&cogging, "cogging", &words);
        }
        bench.refuses_effects(
            "{ id = \"gravity\", sine = 1.0, cosine = 0.0 },",
            "gravity",
            &[
                "`gravity` is for rotary machines only",
                "`coordinate = \"rad\"`",
            ],
        );
        bench.refuses_effects(
            "{ id = \"supply_sag\", share = 1e-3 },",
            "supply_sag",
            &[
                "`supply_sag` is for machines with a voltage input only",
                "`kind = \"voltage\"`",
            ],
        );
        for delay in ["0.3", "1e30"] {
            let late = format!("{{ id = \"input_delay\", delay = {delay} }},");
            let words = [
                "`delay` of effect `input_delay`",
                "expected 0 to 0.25, in s",
            ];
            bench.refuses_effects(&late, "input_delay", &words);
        }
        bench.refuses_effects(
            "{ id = \"offset_torque\", torque = 1e13 },",
            "offset_torque",
            &["offset must be", "at most 1e12"],
        );
    }

    #[test]
    fn of_another_language() {
        let words = ["expected"];
        let bench = Bench::new();
        bench.refuses_machine(("[mechanics]", "[mechanics"), "[mechanics", &words);
        bench.write(MACHINE, [0xff, 0xfe, 0x00]);
        let words = ["not UTF-8 text", "expected a machine file"];
        bench.refuses(&["--train", TRAIN], &format!("{MACHINE}:1"), &words);
    }
}

#[test]
fn files_that_are_not_there_are_named() {
    let bench = Bench::new();
    let words = ["no such file", "expected a log"];
    bench.refuses(&["--train", "no.csv"], "no.csv", &words);
    let logs = ["--train", TRAIN, "--validate", "no.csv"];
    bench.refuses(&logs, "no.csv", &words);
    fs::create_dir(bench.path("logs")).unwrap();
    let logs = ["--train", TRAIN, "--validate", "logs"];
    bench.refuses(&logs, "logs", &["is a directory", "expected a log"]);
    fs::remove_file(bench.path(MACHINE)).unwrap();
    let words = ["no such file", "expected a machine file"];
    bench.refuses(&["--train", TRAIN], MACHINE, &words);
}

#[test]
fn what_cannot_be_written_is_status_1_and_leaves_no_part() {
    let bench = Bench::new();
    fs::create_dir(bench.path("taken")).unwrap();
    for (option, path, expected) in [
        ("--json", "missing/gap.json", "create it"),
        ("--json", "taken", "the name of a file"),
        ("--report", TRAIN, "the name of a directory"),
    ] {
        let output = bench.run(&["--machine", MACHINE, "--train", TRAIN, option, path]);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{error}");
        assert!(error.contains(expected), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(error.starts_with(&format!("error: {path}: ")), "{error}");
        assert!(output.stdout.is_empty());
    }
    let mut names: Vec<_> = fs::read_dir(bench.directory.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    names.sort();
    assert_eq!(names, [MACHINE, "taken", TRAIN, VALIDATE]);
}

#[test]
fn help_has_an_example() {
    for arguments in [&["help"][..], &["gap", "--help"], &["help", "gap"]] {
        let output = Command::new(env!("CARGO_BIN_EXE_hil"))
            .args(arguments)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}");
        assert!(text(&output.stdout).contains("Example: cargo hil"));
        assert!(output.stderr.is_empty());
    }
}

#[test]
fn the_help_lists_every_effect_with_what_its_parameters_may_be() {
    let output = Command::new(env!("CARGO_BIN_EXE_hil"))
        .args(["gap", "--help"])
        .output()
        .unwrap();
    let help = text(&output.stdout);
    for id in Id::ALL {
        let description = id.description();
        let entry = format!("  {}: {}", description.id, description.summary.of(true));
        let mut lines = help.lines().skip_while(|line| !line.starts_with(&entry));
        let parameters = lines.nth(1).expect(description.id);
        for parameter in description.parameters {
            let named = format!("{} ({}", parameter.name, parameter.bounds);
            assert!(parameters.contains(&named), "{parameters}: {named}");
        }
    }
}

#[test]
fn a_wrong_call_is_status_2_and_one_line() {
    let bench = Bench::new();
    for (arguments, part) in [
        (&["--machine", MACHINE, "--train"][..], "--train"),
        (&["--machine", MACHINE, "--train", TRAIN, "more"], "'more'"),
        (
            &["--machine", MACHINE, "--train", TRAIN, "--jsn", JSON],
            "'--jsn'",
        ),
        (
            &["--machine", MACHINE, "--machine", MACHINE, "--train", TRAIN],
            "--machine",
        ),
        (&["--train", TRAIN], "--machine"),
    ] {
        let output = bench.run(arguments);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(error.starts_with("error: "), "{error}");
        assert!(error.contains(part), "{error}");
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn no_output_replaces_what_is_read() {
    let bench = Bench::new();
    let read = || [MACHINE, TRAIN, VALIDATE].map(|name| fs::read(bench.path(name)).unwrap());
    let before = read();
    let directory = bench.directory.path().file_name().unwrap();
    let train_by_another_name = format!("../{}/{TRAIN}", directory.display());
    for (output, file) in [
        ("--json", MACHINE),
        ("--json", TRAIN),
        ("--json", VALIDATE),
        ("--experiment", TRAIN),
        ("--experiment", &train_by_another_name),
    ] {
        let logs = ["--train", TRAIN, "--validate", VALIDATE];
        let arguments = [&["--machine", MACHINE][..], &logs, &[output, file]].concat();
        let said = bench.run(&arguments);
        let error = text(&said.stderr);
        assert_eq!(said.status.code(), Some(2), "{error}");
        assert!(error.starts_with(&format!("error: {file}: ")), "{error}");
        assert!(error.contains("would be replaced"), "{error}");
        assert_eq!(read(), before);
    }
    let both = ["--json", "new", "--experiment", "new"];
    let said = bench.run(&[&["--machine", MACHINE, "--train", TRAIN][..], &both].concat());
    assert_eq!(said.status.code(), Some(2));
    assert!(!bench.path("new").exists());
}

#[test]
fn a_pipe_gets_the_answer_and_nothing_else() {
    let Traced { output, .. } = traced();
    assert_eq!(text(&output.stderr), "");
    let table = text(&output.stdout);
    assert!(!table.contains('\x1b'), "{table:?}");
    let finding = table.split(':').nth(1).unwrap();
    assert!(finding.starts_with(" one effect was missing, "), "{table}");
    assert!(finding.contains("offset_torque"), "{table}");

    // Twelve lines, which say what pushes, on unseen data, and what to do; the numbers are one option away.
    assert!(table.lines().count() <= LINES, "{table}");
    for part in [
        "A constant force of",
        "On the validation log",
        "Next: ",
        "declared_effects = [{ id",
    ] {
        assert!(table.contains(part), "no {part:?} in {table}");
    }
    assert!(!table.contains("Round 1 of the selection"), "{table}");
    let bench = Bench::new();
    let verbose = bench.run(&["--machine", MACHINE, "--verbose", "--train", TRAIN]);
    assert!(!bench.path(REPORT).exists() && !bench.path(JSON).exists());
    let numbers = text(&verbose.stdout);
    for part in [
        "\nErrors\n",
        "\nEffects\n",
        "Round 1 of the selection",
        "Cost: ",
    ] {
        assert!(numbers.contains(part), "no {part:?} in {numbers}");
    }
}

/// Rows at uneven times are put on a grid, and the answer says so wherever it is given.
#[test]
fn an_uneven_log_is_traced_and_the_answer_says_what_was_changed() {
    let bench = Bench::new();
    let lines: Vec<&str> = log().lines().collect();
    let hole = [&lines[..700], &lines[705..]].concat();
    bench.write("hole.csv", hole.join("\n") + "\n");
    let output = bench.run(&["--machine", MACHINE, "--train", "hole.csv", "--json", JSON]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let table = text(&output.stdout);
    assert!(table.contains("hole.csv was resampled"), "{table}");
    let answer = bench.json();
    assert_eq!(answer["effects"][0]["id"], "offset_torque");
    let resampled = &answer["resampled"][0];
    assert_eq!(resampled["log"], "hole.csv");
    assert_eq!(
        (&resampled["filled"], &resampled["merged"]),
        (&5.into(), &0.into())
    );
    assert!(
        resampled["position_error"]
            .as_f64()
            .is_some_and(f64::is_finite)
    );
    assert_eq!(resampled["rows"], lines.len() - 6);

    // An even log has no such key.
    let answer = bench.answer(&["--train", VALIDATE]);
    assert!(answer.get("resampled").is_none());
}

/// The structure of the JSON. Every function panics with the path of what is wrong.
mod structure {
    use super::*;

    fn get<'v>(value: &'v Value, path: &str, key: &str) -> &'v Value {
        value
            .get(key)
            .unwrap_or_else(|| panic!("{path} has no `{key}`: {value}"))
    }

    pub fn text<'v>(value: &'v Value, path: &str, key: &str) -> &'v str {
        let found = get(value, path, key);
        found
            .as_str()
            .unwrap_or_else(|| panic!("{path}.{key} is no text: {found}"))
    }

    pub fn list<'v>(value: &'v Value, path: &str, key: &str) -> &'v [Value] {
        let found = get(value, path, key);
        found
            .as_array()
            .unwrap_or_else(|| panic!("{path}.{key} is no list: {found}"))
    }

    /// JSON has no number that is not finite: it would be null.
    pub fn number(value: &Value, path: &str, key: &str) -> f64 {
        let found = get(value, path, key);
        found
            .as_f64()
            .unwrap_or_else(|| panic!("{path}.{key} is no number: {found}"))
    }

    fn share(value: &Value, path: &str, key: &str) {
        let found = number(value, path, key);
        assert!((0.0..=1.0).contains(&found), "{path}.{key}: {found}");
    }

    fn probability(value: &Value, path: &str, key: &str) {
        let found = number(value, path, key);
        assert!(found > 0.0 && found <= 1.0, "{path}.{key}: {found}");
    }

    fn errors(value: &Value, path: &str, with_current: bool) {
        for key in [
            "window_s",
            "position_rms",
            "position_max",
            "position_nrmse",
            "torque_rel",
            "free_run_rms",
        ] {
            assert!(number(value, path, key) > 0.0, "{path}.{key}");
        }
        if with_current {
            assert!(number(value, path, "current_rms") > 0.0);
        } else {
            assert!(get(value, path, "current_rms").is_null(), "{path}");
        }
    }

    /// Checks an answer; `validated` and `with_current` say what the logs were.
    pub fn check(answer: &Value, validated: bool, with_current: bool) {
        assert!(!text(answer, "", "machine").is_empty());
        let verdict = text(answer, "", "verdict");
        let effects = list(answer, "", "effects");
        let unknown = get(answer, "", "unknown");
        match verdict {
            "no_missing_effect" => assert!(effects.is_empty() && unknown.is_null()),
            "effects_found" => assert!(!effects.is_empty()),
            "unknown_effect" => {
                let variable = text(unknown, "unknown", "depends_on");
                assert!(
                    ["position", "velocity", "current", "load", "time"].contains(&variable),
                    "{variable}"
                );
                share(unknown, "unknown", "score");
            }
            other => panic!("verdict: {other}"),
        }
        for (index, effect) in effects.iter().enumerate() {
            let path = &format!("effects[{index}]");
            assert!(!text(effect, path, "id").is_empty());
            share(effect, path, "score");
            share(effect, path, "identifiability");
            probability(effect, path, "p_value");
            for id in list(effect, path, "equivalent") {
                assert!(id.is_string(), "{path}.equivalent: {id}");
            }
            let parameters = list(effect, path, "parameters");
            assert!(!parameters.is_empty());
            for parameter in parameters {
                assert!(!text(parameter, path, "name").is_empty());
                number(parameter, path, "value");
                assert!(number(parameter, path, "std") >= 0.0);
                text(parameter, path, "unit");
            }
        }
        for parameter in list(answer, "", "fit") {
            let name = text(parameter, "fit", "name");
            number(parameter, name, "declared");
            number(parameter, name, "fitted");
            let std = get(parameter, name, "std");
            assert!(std.is_null() || std.as_f64().unwrap() >= 0.0, "{name}");
            assert!(!text(parameter, name, "unit").is_empty());
        }
        let both = get(answer, "", "errors");
        for log in ["train", "validate"] {
            let stages = get(both, "errors", log);
            if log == "validate" && !validated {
                assert!(stages.is_null(), "{stages}");
                continue;
            }
            for stage in ["declared", "before", "after"] {
                let path = format!("errors.{log}.{stage}");
                errors(get(stages, &path, stage), &path, with_current);
            }
        }
    }
}

#[test]
fn the_json_has_its_structure_and_finds_the_push() {
    let Traced { answer, .. } = traced();
    structure::check(answer, true, false);
    assert_eq!(answer["machine"], "slide-95kg");
    assert_eq!(answer["verdict"], "effects_found");
    assert_eq!(answer["effects"].as_array().unwrap().len(), 1);
    let effect = &answer["effects"][0];
    assert_eq!(effect["id"], "offset_torque");
    assert_eq!(effect["parameters"][0]["unit"], "N");
    // The rig's nominal push is 15 % of its Coulomb friction of 20 N.
    let push = effect["parameters"][0]["value"].as_f64().unwrap();
    assert!((push - 3.0).abs() < 0.3, "{push} N");
    let names: Vec<&str> = answer["fit"]
        .as_array()
        .unwrap()
        .iter()
        .map(|parameter| parameter["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["inertia", "viscous", "coulomb", "static"]);
    assert_eq!(answer["errors"]["train"]["after"]["window_s"], 0.2);
}

#[test]
fn without_a_validation_log_its_errors_are_null() {
    let answer = Bench::new().answer(&["--train", TRAIN]);
    structure::check(&answer, false, false);
    assert!(answer["errors"]["validate"].is_null());
    assert!(answer["errors"].get("validate").is_some());
}

#[test]
fn a_measured_current_has_its_error() {
    let machine = Machine::rotary_ema();
    let bench = Bench::new();
    bench.write(MACHINE, machine.to_toml());
    let sines = Trajectory::sines(&machine);
    let log = Experiment::tracking(machine, sines).lasting(3.0);
    bench.write(TRAIN, log.run().to_csv());
    bench.write(VALIDATE, log.seeded(2).run().to_csv());
    let answer = bench.answer(&["--train", TRAIN, "--validate", VALIDATE]);
    structure::check(&answer, true, true);
}

#[test]
fn nothing_to_fit_leaves_the_declared_model() {
    let bench = Bench::new();
    bench.write_machine(
        "parameters = [\"inertia\", \"viscous\", \"coulomb\", \"static\"]",
        "parameters = []",
    );
    let answer = bench.answer(&["--train", TRAIN]);
    structure::check(&answer, false, false);
    assert_eq!(answer["fit"].as_array().unwrap().len(), 0);
    let train = &answer["errors"]["train"];
    assert_eq!(train["declared"], train["before"]);
}

#[test]
fn several_logs_are_one_training_set() {
    let bench = Bench::new();
    let row = |row: usize| log().lines().nth(row).unwrap().to_owned() + "\n";
    let second: String = (3001..=6000).map(row).collect();
    bench.write("first.csv", head(3000));
    bench.write("second.csv", format!("{HEADER}\n{second}"));
    let answer = bench.answer(&["--train", "first.csv", "--train", "second.csv"]);
    structure::check(&answer, false, false);
    assert_eq!(answer["verdict"], "effects_found");
    assert_eq!(answer["effects"][0]["id"], "offset_torque");
    assert_eq!(answer["cost"]["samples"], 6000);
    // Half the log alone gives another answer: the second one takes part.
    let first = bench.answer(&["--train", "first.csv"]);
    assert_eq!(first["cost"]["samples"], 3000);
    assert_ne!(first["fit"], answer["fit"]);
}

/// What stands in the figures of a report.
fn figures(bench: &Bench) -> Vec<String> {
    let page = fs::read_to_string(bench.path(REPORT).join("index.html")).unwrap();
    let figures: Vec<String> = page
        .split("<svg")
        .skip(1)
        .map(|figure| figure.split("</svg>").next().unwrap().to_owned())
        .collect();
    assert!(!figures.is_empty());
    figures
}

/// Logs often start at the seconds since 1970, which single precision holds to two minutes.
#[test]
fn the_answer_does_not_depend_on_when_the_log_starts() {
    let late = Bench::new();
    for name in [TRAIN, VALIDATE] {
        let log = fs::read_to_string(late.path(name)).unwrap();
        let mut lines = log.lines();
        let mut shifted = lines.next().unwrap().to_owned();
        for row in lines {
            let (time, rest) = row.split_once(',').unwrap();
            let time: f64 = time.parse().unwrap();
            shifted += &format!("\n{:.6},{rest}", time + 1.7e9);
        }
        late.write(name, shifted);
    }
    let logs = ["--train", TRAIN, "--validate", VALIDATE];
    let answer = late.answer(&[&["--report", REPORT][..], &logs].concat());
    let early = traced();
    assert_eq!(timeless(&answer), timeless(&early.answer));
    assert_eq!(figures(&late), early.figures);
}

#[test]
fn the_answer_depends_on_neither_run_nor_cores() {
    let bench = Bench::new();
    let run = |threads: &str| {
        let logs = ["--train", TRAIN, "--validate", VALIDATE];
        let outputs = ["--machine", MACHINE, "--json", JSON, "--report", REPORT];
        let mut command = bench.command(&[&outputs[..], &logs].concat());
        command.env("RAYON_NUM_THREADS", threads);
        assert_eq!(command.output().unwrap().status.code(), Some(0));
        timeless(&bench.json())
    };
    // That of another run, on as many cores as there are.
    let answer = timeless(&traced().answer);
    assert_eq!(run("1"), answer);
    assert_eq!(run("2"), answer);
}
