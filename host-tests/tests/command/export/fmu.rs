//! The exported FMU, loaded and stepped by a master of its own, beside the exported C.

use std::fs;
use std::path::Path;
use std::process::Command;

use super::c_file::computed;
use super::drive::{Case, RATE, apart, cases, columns, export, text, travel};

const MASTER: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/tests/command/export/fmu_master.py"
);

/// What the FMU makes of a case: position, current and reading behind each row.
fn simulated(directory: &Path, case: &Case) -> [Vec<f64>; 3] {
    let output = export(directory, &case.toml(), &["fmu", "--out", "model.fmu"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let rows: String = case
        .input()
        .iter()
        .map(|input| format!("{input:?}\n"))
        .collect();
    fs::write(directory.join("inputs"), rows).unwrap();
    let output = Command::new("python3")
        .current_dir(directory)
        .args([MASTER, "model.fmu", "unpacked"])
        .args([
            format!("{:?}", case.start),
            format!("{:?}", 1.0 / RATE),
            "inputs".into(),
        ])
        .output()
        .expect("Python");
    assert!(output.status.success(), "{}", text(&output.stderr));
    columns(&output.stdout)
}

#[test]
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
fn an_fmu_moves_as_the_c_file_does() {
    for name in ["ema", "throttle", "slide", "Stribeck and gravity"] {
        let case = cases().into_iter().find(|case| case.name == name).unwrap();
        let directory = tempfile::tempdir().unwrap();
        let found = simulated(directory.path(), &case);
        let expected = computed(directory.path(), &case.toml(), case.start, &case.input());
        for (found, expected) in found.iter().zip(&expected) {
            // One text, compiled twice: rounding alone.
            let bound = 1e-9 * travel(expected);
            let off = apart(found, expected);
            println!("{name}: off {off:e}");
            assert!(off <= bound, "{name}: {off:e} beyond {bound:e}");
        }
        // A second export takes the place of the first, another file does not lose its place to it.
        let again = export(
            directory.path(),
            &case.toml(),
            &["fmu", "--out", "model.fmu"],
        );
        assert!(again.status.success(), "{}", text(&again.stderr));
        let refused = export(directory.path(), &case.toml(), &["fmu", "--out", "inputs"]);
        assert_eq!(refused.status.code(), Some(2), "{}", text(&refused.stderr));
    }
}

#[test]
fn an_fmu_needs_a_file_and_names_what_it_lacks() {
    let directory = tempfile::tempdir().unwrap();
    let case = cases().swap_remove(0);
    let output = export(directory.path(), &case.toml(), &["fmu"]);
    assert_eq!(output.status.code(), Some(2));
    let error = text(&output.stderr);
    assert!(
        error.starts_with("error: ") && error.contains("--out"),
        "{error}"
    );
    assert_eq!(error.lines().count(), 1, "{error}");
    let late = case.toml().replace(
        "declared_effects = []",
        "declared_effects = [{ id = \"sensor_delay\", delay = 0.003 }]",
    );
    let output = export(directory.path(), &late, &["fmu", "--out", "model.fmu"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let named = "effect `sensor_delay` is not expressed";
    assert!(
        text(&output.stderr).contains(&format!("in `fmu`, {named}")),
        "{}",
        text(&output.stderr)
    );
    // The archive's files are stored as they are: its description and its sources both have it.
    let bytes = fs::read(directory.path().join("model.fmu")).unwrap();
    let count = String::from_utf8_lossy(&bytes)
        .matches(&format!("NOT EXPRESSED: {named}"))
        .count();
    assert!(count >= 2, "{count}");
}
