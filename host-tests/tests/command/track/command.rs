//! The command as a user calls it, on logs of a rig whose friction grows, or does not.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use rig::{Experiment, Machine, Random, Trajectory};
use serde_json::Value;
use tempfile::TempDir;

/// Coulomb friction of the first log, N·m; what is in the machine file is another value.
const FIRST: f64 = 0.12;

/// Scatter of the friction from log to log, as a share.
const SCATTER: f64 = 0.01;

/// A directory with a machine file and logs `0.csv`, `1.csv` … whose friction grows by `growth` of the first a log.
fn bench(logs: usize, growth: f64) -> TempDir {
    bench_of(logs, |log| 1.0 + growth * log as f64)
}

/// The same with the friction of each log over that of the first.
fn bench_of(logs: usize, level: impl Fn(usize) -> f64) -> TempDir {
    let directory = tempfile::tempdir().unwrap();
    let write = |name: &str, text: String| fs::write(directory.path().join(name), text).unwrap();
    let declared = Machine::rotary_ema();
    write("machine.toml", declared.to_toml());
    let mut random = Random::new(28);
    for log in 0..logs {
        let level = FIRST * level(log) * (1.0 + SCATTER * random.normal());
        let machine = Machine {
            coulomb: level,
            static_friction: 1.25 * level,
            ..declared.clone()
        };
        let trajectory = Trajectory::sines(&machine);
        let recording = Experiment::tracking(machine, trajectory)
            .lasting(3.0)
            .seeded(log as u64)
            .with_step(2e-5)
            .run();
        write(&format!("{log}.csv"), recording.to_csv());
    }
    directory
}

fn track(directory: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hil"))
        .current_dir(directory)
        .args(["track", "--machine", "machine.toml"])
        .args(arguments)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

fn json(directory: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(directory.join("out.json")).unwrap()).unwrap()
}

fn trend<'j>(json: &'j Value, name: &str) -> &'j Value {
    let trends = json["trends"].as_array().unwrap();
    trends.iter().find(|trend| trend["name"] == name).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

const LOGS: [&str; 8] = [
    "0.csv", "1.csv", "2.csv", "3.csv", "4.csv", "5.csv", "6.csv", "7.csv",
];

#[test]
fn growing_friction_is_an_alarm_with_the_truth_in_its_intervals() {
    let directory = bench(LOGS.len(), 0.03);
    let directory = directory.path();
    let options = [
        "--limit",
        "coulomb=0.2",
        "--json",
        "out.json",
        "--report",
        "report",
    ];
    let output = track(directory, &[&LOGS[..], &options].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let printed = text(&output.stdout);
    assert!(printed.contains("Coulomb friction rises by "), "{printed}");
    assert!(
        printed.contains("it reaches 200 mN·m in about "),
        "{printed}"
    );
    let json = json(directory);
    assert_eq!(json["alarm"], true);
    assert_eq!(json["machine"], "ema-24v");
    let coulomb = trend(&json, "coulomb");
    assert_eq!(coulomb["alarm"], true, "{printed}");
    let inside = |interval: &Value, truth: f64| {
        number(&interval[0]) <= truth && truth <= number(&interval[1])
    };
    assert!(inside(&coulomb["interval"], 0.03 * FIRST), "{coulomb}");
    // The friction of the last log is FIRST × 1.21; from there to 0.2 N·m it is so many logs.
    let remaining = (0.2 / FIRST - 1.0) / 0.03 - 7.0;
    assert!(
        inside(&coulomb["remaining_interval"], remaining),
        "{coulomb}"
    );
    for constant in ["inertia", "viscous"] {
        assert_eq!(trend(&json, constant)["alarm"], false, "{printed}");
    }
    let logs = json["logs"].as_array().unwrap();
    assert_eq!(logs.len(), LOGS.len());
    for (log, name) in logs.iter().zip(LOGS) {
        assert_eq!(log["log"], name);
        assert_eq!(log["fit"].as_array().unwrap().len(), 4);
        assert_eq!(log["errors"]["unexplained"], false, "{printed}");
    }
    let page = fs::read_to_string(directory.join("report/index.html")).unwrap();
    assert_eq!(page.matches("<svg ").count(), 4);
    assert!(page.contains("Coulomb friction rises by "));
}

#[test]
fn constant_friction_is_no_alarm_and_a_log_of_another_unit_is_left_out() {
    let directory = bench(5, 0.0);
    let directory = directory.path();
    // The third log has its position in degrees.
    let rows = fs::read_to_string(directory.join("2.csv")).unwrap();
    let in_degrees = |row: &str| {
        let mut fields: Vec<String> = row.split(',').map(str::to_owned).collect();
        if let Ok(position) = fields[2].parse::<f64>() {
            fields[2] = format!("{:.6}", position.to_degrees());
        }
        fields.join(",") + "\n"
    };
    fs::write(
        directory.join("2.csv"),
        rows.lines().map(in_degrees).collect::<String>(),
    )
    .unwrap();
    let output = track(directory, &[&LOGS[..5], &["--json", "out.json"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let warning = text(&output.stderr);
    assert!(
        warning.starts_with("warning: 2.csv: is left out"),
        "{warning}"
    );
    assert_eq!(warning.lines().count(), 1, "{warning}");
    let printed = text(&output.stdout);
    assert!(printed.contains("1 log left out"), "{printed}");
    let json = json(directory);
    assert_eq!(json["alarm"], false, "{printed}");
    assert_eq!(trend(&json, "coulomb")["logs"], 4);
    let out = &json["logs"][2];
    assert!(out["fit"].as_array().unwrap().is_empty() && out["errors"].is_null());
    assert!(!out["disagreement"].as_array().unwrap().is_empty());
}

#[test]
fn two_logs_prove_no_trend() {
    let directory = bench(2, 0.5);
    let directory = directory.path();
    let output = track(directory, &["0.csv", "1.csv", "--json", "out.json"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let printed = text(&output.stdout);
    assert!(
        printed.contains("No trend can be proven from 2 logs: it takes 3 at least."),
        "{printed}"
    );
    let json = json(directory);
    assert_eq!(json["alarm"], false);
    assert!(trend(&json, "coulomb")["slope_per_log"].is_null());
    // Each log has its numbers nevertheless.
    let fits = json["logs"][1]["fit"].as_array().unwrap();
    let coulomb = fits.iter().find(|fit| fit["name"] == "coulomb").unwrap();
    let off = number(&coulomb["value"]) / (1.5 * FIRST) - 1.0;
    assert!(off.abs() < 4.0 * SCATTER, "{coulomb}");
}

#[test]
fn bad_input_is_named_and_nothing_is_written() {
    let directory = bench(1, 0.0);
    let directory = directory.path();
    fs::write(directory.join("broken.csv"), "time_s,input\n0,1\n").unwrap();
    fs::copy(directory.join("0.csv"), directory.join("again.csv")).unwrap();
    let machine = fs::read_to_string(directory.join("machine.toml")).unwrap();
    let (before, _) = machine.split_once("parameters = ").unwrap();
    let unfitted = format!("{before}parameters = []\n");
    fs::write(directory.join("unfitted.toml"), unfitted).unwrap();
    for (arguments, expected) in [
        (&["missing.csv"][..], "missing.csv: no such file"),
        (&["0.csv", "broken.csv"], "broken.csv:1: "),
        (
            &["0.csv", "again.csv"],
            "again.csv: has the samples of the log 0.csv",
        ),
        (
            &["0.csv", "--limit", "coulomb"],
            "--limit coulomb: expected a number's name",
        ),
        (
            &["0.csv", "--limit", "coulomb=much"],
            "--limit coulomb=much: expected a number's name",
        ),
        (
            &["0.csv", "--limit", "spring=1"],
            "--limit spring=1: [fit] of the machine file does not name",
        ),
        (
            &["0.csv", "--limit", "static=1", "--limit", "static=2"],
            "--limit static=2: `static` has a limit already",
        ),
    ] {
        let output = track(directory, &[arguments, &["--json", "out.json"]].concat());
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.starts_with(&format!("error: {expected}")), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(output.stdout.is_empty() && !directory.join("out.json").exists());
    }
    let output = Command::new(env!("CARGO_BIN_EXE_hil"))
        .current_dir(directory)
        .args(["track", "--machine", "unfitted.toml", "0.csv"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let error = text(&output.stderr);
    assert!(
        error.starts_with("error: unfitted.toml: `[fit]` has no `parameters`"),
        "{error}"
    );
}

/// A friction that rises at once is said in the first lines, with the logs between which it does.
#[test]
fn a_jump_is_named_with_its_logs() {
    let directory = bench_of(7, |log| if log < 4 { 1.0 } else { 1.3 });
    let arguments = [&LOGS[..7], &["--json", "out.json"]].concat();
    let output = track(directory.path(), &arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let json = json(directory.path());
    let jump = &json["jump"];
    assert_eq!(
        (&jump["from"], &jump["to"]),
        (&"3.csv".into(), &"4.csv".into()),
        "{json}"
    );
    assert!(["coulomb", "static"].contains(&jump["name"].as_str().unwrap()));
    assert!(number(&jump["p_value"]) < 0.05);
    // Of the mean change a third at most is the scatter of the two logs.
    let share = number(&jump["change"]) / number(&jump["before"]);
    assert!((share - 0.3).abs() < 0.1, "{jump}");
    let printed = text(&output.stdout).replace('\n', " ");
    let (sentences, _) = printed.split_once("number  ").expect("a table");
    assert!(sentences.contains(" jumps up by "), "{sentences}");
    assert!(sentences.contains("from 3.csv to 4.csv"), "{sentences}");
}
