//! Promise: `cargo hil import` makes a log of any logger's file, in SI units to the last digit, says what
//! it found and did, and replaces nothing; and where `cargo hil gap` refuses a log for its form, the call
//! that it prints makes a log which it accepts.

mod angles;
mod carriage;
mod damaged;
mod doubts;
mod files;
mod formats;
mod layouts;
pub mod matlab;
mod mended;
mod rates;
mod stamps;
mod units;

use std::f64::consts::{PI, TAU};
use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;

use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};
use host_tests::log::Log;
use rig::Machine;
use serde_json::Value;
use tempfile::TempDir;

/// A directory that `hil` is run in.
struct Place {
    directory: TempDir,
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("UTF-8")
}

impl Place {
    fn new() -> Self {
        Self {
            directory: tempfile::tempdir().expect("a temporary directory"),
        }
    }

    fn with(name: &str, content: impl AsRef<[u8]>) -> Self {
        let place = Self::new();
        place.write(name, content);
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).expect("a writable temporary directory");
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.directory.path()).expect("a directory");
        let mut names: Vec<String> = entries
            .map(|entry| {
                entry
                    .expect("an entry")
                    .file_name()
                    .into_string()
                    .expect("UTF-8")
            })
            .collect();
        names.sort();
        names
    }

    fn command(&self, words: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hil"));
        command
            .current_dir(self.directory.path())
            .args(words.split(' ').map(|word| word.replace('~', " ")));
        command
    }

    /// Runs it; a `~` stands for a space inside a word.
    fn run(&self, words: &str) -> Output {
        let output = self.command(words).output().expect("hil starts");
        assert!(!text(&output.stderr).contains("panicked"), "{words}");
        output
    }

    /// Imports to `log.csv`: the log, and what was printed.
    #[track_caller]
    fn import(&self, words: &str) -> (Log, String) {
        let output = self.run(&format!("import {words} --out log.csv"));
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        assert!(output.stderr.is_empty());
        let log = Log::read(&self.path("log.csv")).expect("a log");
        fs::remove_file(self.path("log.csv")).expect("the log");
        (log, text(&output.stdout).to_owned())
    }

    /// Refused in one line with these words, status 2, nothing printed, nothing written.
    #[track_caller]
    fn refuses(&self, words: &str, expected: &[&str]) {
        let before = self.names();
        let output = self.run(words);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(error.starts_with("error: "), "{error}");
        for word in expected {
            assert!(error.contains(word), "no {word:?} in: {error}");
        }
        assert!(output.stdout.is_empty());
        assert_eq!(self.names(), before);
    }

    /// Runs a printed call as a shell does.
    #[track_caller]
    fn follow(&self, call: &str) {
        let program = format!("\"{}\" import ", env!("CARGO_BIN_EXE_hil"));
        let output = Command::new("sh")
            .current_dir(self.directory.path())
            .args(["-c", &call.replacen("cargo hil import ", &program, 1)])
            .output()
            .expect("a shell");
        assert!(output.status.success(), "{call}\n{}", text(&output.stderr));
    }
}

/// Rows from a header and a rule.
fn rows(header: &str, count: usize, row: impl Fn(usize) -> String) -> String {
    let rows: Vec<String> = (0..count).map(row).collect();
    format!("{header}\n{}\n", rows.join("\n"))
}

#[track_caller]
fn near(values: &[f64], expected: impl Fn(usize) -> f64) {
    for (at, value) in values.iter().enumerate() {
        let expected = expected(at);
        let scale = expected.abs().max(1e-3);
        assert!(
            (value - expected).abs() < 1e-12 * scale,
            "{at}: {value} {expected}"
        );
    }
}
