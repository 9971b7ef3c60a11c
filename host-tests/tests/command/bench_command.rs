//! `cargo hil bench` as a user meets it. How fast it is, is no matter of a test.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn bench(json: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hil"))
        .args(["bench", "--quick", "--json"])
        .arg(json)
        .output()
        .unwrap()
}

#[track_caller]
fn assert_positive(object: &Value, keys: &[&str]) {
    for key in keys {
        let number = object[key].as_f64();
        assert!(
            number.is_some_and(|number| number > 0.0 && number.is_finite()),
            "{key} in {object}"
        );
    }
}

#[test]
fn json_has_the_documented_keys() {
    let directory = tempfile::tempdir().unwrap();
    let json = directory.path().join("bench.json");
    let output = bench(&json);
    assert!(output.status.success());
    assert!(output.stderr.is_empty(), "no progress in a pipe");
    let files = std::fs::read_dir(directory.path()).unwrap().count();
    assert_eq!(files, 1, "nothing but the result");
    let outcome: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();

    let plants = outcome["plants"].as_array().unwrap();
    let names: Vec<_> = plants.iter().map(|plant| &plant["name"]).collect();
    assert_eq!(
        names,
        [
            "ema",
            "throttle",
            "ema_karnopp_1us",
            "ema_reference_f64",
            "bench",
            "bench_switching_1us"
        ]
    );
    for plant in plants {
        assert_positive(
            plant,
            &["step_s", "ns_per_step", "seconds_per_simulated_second"],
        );
        // Two ways to say the same.
        let number = |key: &str| plant[key].as_f64().unwrap();
        let ratio =
            number("seconds_per_simulated_second") * number("step_s") / number("ns_per_step");
        assert!((ratio * 1e9 - 1.0).abs() < 1e-6, "{plant}");
    }
    assert_eq!(plants[0]["step_s"], 1e-4);

    let refit = &outcome["refit"];
    assert_positive(refit, &["seconds", "evaluations", "simulated_seconds"]);
    let gap = &outcome["gap"];
    assert_positive(gap, &["seconds", "simulations", "samples"]);
    assert_eq!(gap["found"], serde_json::json!(["asymmetric_viscous"]));
    let tracings = outcome["tracings"].as_array().unwrap();
    // Without `--quick` six, which takes a minute.
    assert_eq!(tracings.len(), 6, "two logs of three machines");
    for tracing in tracings {
        assert_positive(
            tracing,
            &[
                "seconds",
                "samples",
                "simulations",
                "samples_per_second_and_core",
            ],
        );
    }
    assert_positive(&outcome["batch"], &["cores", "steps_per_second"]);

    // The table says the same to people.
    let table = String::from_utf8(output.stdout).unwrap();
    for part in [
        "ema_karnopp_1us",
        "friction refit",
        "simulations",
        "on one core",
    ] {
        assert!(table.contains(part), "{table}");
    }
}

#[test]
fn a_result_that_cannot_be_written_is_an_error() {
    let directory = tempfile::tempdir().unwrap();
    let output = bench(&directory.path().join("missing/bench.json"));
    assert_eq!(output.status.code(), Some(1));
    assert!(output.stdout.is_empty());
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(error.starts_with("error: ") && error.contains("missing"));
    assert_eq!(error.lines().count(), 1, "{error}");
}
