//! `cargo hil identify` as a user meets it: files, help, bad input.

use std::path::Path;
use std::process::{Command, Output};

use model_core::signal::{aprts, growing_triangle};
use rig::{Experiment, Machine, Noise};

const MACHINE: &str = "machines/intake-throttle-12v.toml";

/// The machine file with inertia and friction that are wrong.
fn start(directory: &Path) {
    let machine = Path::new(env!("CARGO_MANIFEST_DIR")).join(MACHINE);
    let mut text = std::fs::read_to_string(machine).unwrap();
    for (right, wrong) in [
        ("inertia = 1.6e-3", "inertia = 3.2e-3"),
        ("coulomb = 0.24", "coulomb = 0.1"),
        ("static = 0.28", "static = 0.1"),
        ("spring = 0.25", "spring = 0.5"),
    ] {
        assert!(text.contains(right), "{right}");
        text = text.replace(right, wrong);
    }
    std::fs::write(directory.join("start.toml"), text).unwrap();
}

fn hil(directory: &Path, arguments: &[&str]) -> Output {
    start(directory);
    Command::new(env!("CARGO_BIN_EXE_hil"))
        .current_dir(directory)
        .args(["identify", "--machine", "start.toml"])
        .args(arguments)
        .output()
        .unwrap()
}

fn write(path: &Path, input: Vec<f64>) {
    let machine = Machine::intake_throttle();
    let noise = Noise::potentiometer(&machine);
    let recording = Experiment::replaying(machine, input, 1000.0)
        .with_noise(noise)
        .run();
    std::fs::write(path, recording.to_csv()).unwrap();
}

/// A slow and a fast log of the throttle.
pub fn logs(directory: &Path) {
    let triangle = growing_triangle::Parameters {
        offset: -3.1,
        amplitude: 2.4,
        first: 14,
        last: 24,
        duration: 40.0,
    }
    .build(1e-3)
    .unwrap();
    let steps = aprts::Parameters {
        lower: -6.0,
        upper: -0.5,
        shortest_hold: 0.1,
        longest_hold: 0.8,
        seed: 1,
    }
    .build(1e-3)
    .unwrap();
    let sample = |at: &dyn Fn(u32) -> f32, count| (0..count).map(|k| f64::from(at(k))).collect();
    write(
        &directory.join("slow.csv"),
        sample(&|k| triangle.at(k), 40_000),
    );
    write(
        &directory.join("fast.csv"),
        sample(&|k| steps.at(k), 20_000),
    );
}

#[test]
fn files_are_written_and_read_back() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    logs(directory);
    let arguments = [
        "--slow",
        "slow.csv",
        "--fast",
        "fast.csv",
        "--validate",
        "fast.csv",
        "--machine-out",
        "out.toml",
        "--json",
        "out.json",
        "--report",
        "report",
    ];
    let output = hil(directory, &arguments);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    for name in ["a0/b0", "cH/b0", "L1 uniform opening", "validation"] {
        assert!(text.contains(name), "{text}");
    }
    // Of b₀ alone a log of 20 s says little; all numbers together leave hardly a doubt.
    for (file, inertia, friction) in [
        ("out.toml", 0.01, 0.01),
        ("report/polished.toml", 0.01, 0.01),
        ("report/reduced.toml", 0.2, 0.02),
        ("report/full.toml", 0.2, 0.02),
    ] {
        let found = host_tests::machine::Machine::read(&directory.join(file)).unwrap();
        let off = |value: f64, truth: f64| (value / truth - 1.0).abs();
        assert!(off(found.mechanics.inertia, 1.6e-3) < inertia, "{file}");
        assert!(off(found.friction.coulomb, 0.24) < friction, "{file}");
        assert!(off(found.friction.r#static, 0.28) < friction, "{file}");
        assert!(off(found.mechanics.spring, 0.25) < friction, "{file}");
    }
    let json = std::fs::read_to_string(directory.join("out.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["models"][0]["numbers"].as_array().unwrap().len(), 6);
    let svg = std::fs::read_to_string(directory.join("report/characteristic.svg")).unwrap();
    roxmltree::Document::parse(&svg).unwrap();
    // The end says how good it is and what to do with it; the logs are of the very machine that is identified.
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let verdict = "Verdict: the model \"polished, full motor\" follows the validation log, which nothing was fitted to:";
    assert!(words.contains(verdict), "{text}");
    let command = "\n  cargo hil gap --machine out.toml --train fast.csv --validate fast.csv\n";
    assert!(text.ends_with(command), "{text}");
    // The page holds both, and the drawing in the width of the window.
    let page = std::fs::read_to_string(directory.join("report/index.html")).unwrap();
    for part in ["Verdict: ", "<svg", "svg { display: block; width: 100%;"] {
        assert!(page.contains(part), "no {part:?}");
    }
}

/// The six numbers know no effects: a file that declares one is refused before anything is written.
#[test]
fn declared_effects_are_refused() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    logs(directory);
    start(directory);
    let start = std::fs::read_to_string(directory.join("start.toml")).unwrap();
    let declared = start.replace(
        "declared_effects = []",
        "declared_effects = [{ id = \"offset_torque\", torque = 0.1 }]",
    );
    assert_ne!(declared, start);
    std::fs::write(directory.join("effect.toml"), declared).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_hil"))
        .current_dir(directory)
        .args(["identify", "--machine", "effect.toml", "--slow", "slow.csv"])
        .args(["--fast", "fast.csv", "--machine-out", "out.toml"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(
        message.starts_with("error: effect.toml: declares effects"),
        "{message}"
    );
    assert!(!directory.join("out.toml").exists());
}

#[test]
fn bad_input_is_named_and_nothing_is_written() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    logs(directory);
    let still = (0..2000).map(|k| format!("{:.3},0.0,1.57\n", f64::from(k) * 1e-3));
    let still = String::from("time_s,input,position\n") + &still.collect::<String>();
    std::fs::write(directory.join("still.csv"), still).unwrap();
    std::fs::write(directory.join("broken.csv"), "time_s,input\n0,1\n").unwrap();
    for (slow, fast, place) in [
        (
            "missing.csv",
            "fast.csv",
            "error: missing.csv: no such file",
        ),
        ("broken.csv", "fast.csv", "error: broken.csv:1: "),
        (
            "still.csv",
            "fast.csv",
            "error: still.csv: no stretch of uniform motion",
        ),
        (
            "slow.csv",
            "slow.csv",
            "error: slow.csv: has the samples of the slow log",
        ),
        ("fast.csv", "slow.csv", "error: fast.csv: "),
        (
            "slow.csv",
            "still.csv",
            "error: still.csv: no acceleration gain",
        ),
    ] {
        let output = hil(
            directory,
            &["--slow", slow, "--fast", fast, "--json", "out.json"],
        );
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.starts_with(place), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(!directory.join("out.json").exists());
    }
}
