//! Promise: every row of the measured logs' benchmark has its machine file and, where the logs are there, its
//! logs; without them the command says so.

use std::collections::BTreeSet;
use std::fs;
use std::process::Command;

use host_tests::real_benchmark::manifest::ROWS;
use host_tests::{measured, real_benchmark};
use model_core::effect::Id;

#[test]
fn each_row_has_a_machine_file_of_its_own() {
    let mut names = BTreeSet::new();
    for row in &ROWS {
        let machine = real_benchmark::machine(row).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(machine.name, row.log);
        for number in ["inertia", "viscous", "coulomb", "static"] {
            assert!(machine.fit.iter().any(|name| name == number), "{number}");
        }
        assert!(names.insert(row.log), "{} twice", row.log);
    }
}

/// A name that the catalogue does not have could never be said.
#[test]
fn what_is_known_is_in_the_catalogue() {
    let catalogue: Vec<&str> = Id::ALL.iter().map(|id| id.description().id).collect();
    for row in &ROWS {
        for id in row.needed.iter().copied().flatten().chain(row.tolerated) {
            assert!(catalogue.contains(id), "{}: {id}", row.log);
        }
        let cogs = row.needed.iter().any(|set| set.contains(&"cogging"));
        assert_eq!(cogs, !row.per_turn.is_empty(), "{}", row.log);
    }
}

#[test]
fn each_row_has_its_logs() {
    for row in &ROWS {
        for file in row.train.iter().chain(row.validate) {
            let Some(path) = measured::path(&format!("real/{}/{file}", row.log)) else {
                return;
            };
            assert!(fs::metadata(path).is_ok_and(|file| file.len() > 0));
        }
    }
}

fn bench_real(directory: &str) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_hil"))
        .args(["bench", "real", directory])
        .output()
        .expect("hil starts")
}

#[test]
fn an_absent_directory_is_a_usage_error() {
    let output = bench_real("no-such-directory");
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty());
    let error = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(
        error.starts_with("error: no-such-directory: no such directory"),
        "{error}"
    );
    assert_eq!(error.lines().count(), 1, "{error}");
}

/// Logs that are not there, or are none, are rows of the table.
#[test]
fn refused_logs_are_rows_with_a_reason() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let output = bench_real(directory.path().to_str().expect("a UTF-8 path"));
    assert_eq!(output.status.code(), Some(0));
    let table = String::from_utf8(output.stdout).expect("UTF-8");
    assert_eq!(table.matches("refused").count(), ROWS.len(), "{table}");
    assert_eq!(table.matches("no such file").count(), ROWS.len(), "{table}");
}
