//! The fuzz targets for a bounded time, where cargo-fuzz is installed.
//!
//! A machine without it has not failed: what the targets run is in [`crate::exercise`] and
//! [`crate::console_on_host`], and the host tests run that too, on damaged examples.

use std::fs;
use std::process::{Command, Output};

use crate::failure::Failure;
use crate::toolchain::clean_command;
use crate::workspace;

/// Targets, each with the directory of `host-tests` that has examples to start from, if one has.
const TARGETS: [(&str, Option<&str>); 4] = [
    ("console", None),
    ("decode", None),
    ("log", Some("traces")),
    ("machine", Some("machines")),
];

/// Time for a target, s.
const SECONDS: u32 = 10;

/// What libFuzzer puts before the number of its runs.
const RUNS: &str = "stat::number_of_executed_units: ";

/// What became of the targets, for the user to read.
///
/// # Errors
/// A finding, with the file that reproduces it.
pub fn run() -> Result<Vec<String>, Failure> {
    if !succeeds(&mut cargo_fuzz("--version")) {
        return Ok(vec![
            "not run: cargo-fuzz is not installed (cargo install cargo-fuzz)".to_owned(),
        ]);
    }
    if !succeeds(&mut with_settings("build")) {
        // libFuzzer wants a C++ compiler, which nothing else here does.
        return Ok(vec![
            "not run: libFuzzer does not build here; cd host-tests && cargo fuzz build --sanitizer none"
                .to_owned(),
        ]);
    }
    TARGETS
        .iter()
        .map(|(target, from)| fuzz(target, *from))
        .collect()
}

fn fuzz(target: &str, examples: Option<&str>) -> Result<String, Failure> {
    // What it finds worth keeping goes into the first directory.
    let corpus = workspace::root()
        .join("host-tests/fuzz/corpus")
        .join(target);
    fs::create_dir_all(&corpus).map_err(|error| Failure::system(corpus.display(), &error))?;
    let output = with_settings("run")
        .arg(target)
        .arg(corpus)
        .args(examples)
        .arg("--")
        .args([
            format!("-max_total_time={SECONDS}"),
            "-max_len=8192".to_owned(),
            "-timeout=10".to_owned(),
            "-verbosity=0".to_owned(),
            "-print_final_stats=1".to_owned(),
        ])
        .output()
        .map_err(|error| Failure::system("cargo cannot be run", &error))?;
    let said = String::from_utf8_lossy(&output.stderr);
    if output.status.success() {
        Ok(format!(
            "{target}: {} runs in {SECONDS} s, nothing found",
            runs(&said)
        ))
    } else {
        Err(Failure::Other(format!(
            "the fuzz target {target} found something\n{}",
            ending(&said)
        )))
    }
}

fn cargo_fuzz(command: &str) -> Command {
    let mut cargo = clean_command("cargo");
    cargo
        .current_dir(workspace::root().join("host-tests"))
        .args(["fuzz", command]);
    cargo
}

/// Sanitizers are for the unsafe code that there is none of, and want a nightly compiler.
fn with_settings(command: &str) -> Command {
    let mut cargo = cargo_fuzz(command);
    cargo.args(["--sanitizer", "none"]);
    cargo
}

fn succeeds(command: &mut Command) -> bool {
    let output: std::io::Result<Output> = command.output();
    output.is_ok_and(|output| output.status.success())
}

/// What libFuzzer says of its runs.
fn runs(said: &str) -> &str {
    said.lines()
        .find_map(|line| line.strip_prefix(RUNS))
        .map_or("uncounted", str::trim)
}

/// The last lines, in which the panic and the file that reproduces it are.
fn ending(said: &str) -> String {
    let lines: Vec<&str> = said.lines().collect();
    lines[lines.len().saturating_sub(20)..].join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_of_runs_is_read() {
        let said = "INFO: Seed: 1\nstat::number_of_executed_units: 102\nstat::new_units_added: 3\n";
        assert_eq!(runs(said), "102");
        assert_eq!(runs("INFO: Seed: 1\n"), "uncounted");
    }

    #[test]
    fn every_target_is_built() {
        let manifest = include_str!("../fuzz/Cargo.toml");
        let manifest: toml::Table = toml::from_str(manifest).unwrap();
        let built: Vec<&str> = manifest["bin"]
            .as_array()
            .unwrap()
            .iter()
            .filter_map(|bin| bin["name"].as_str())
            .collect();
        assert_eq!(built, TARGETS.map(|(target, _)| target));
    }
}
