//! The program as a user meets it: help, exit statuses, one line for each error.

use std::process::{Command, Output};

fn hil(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hil"))
        .args(arguments)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

#[test]
fn help_ends_with_an_example() {
    for command in [
        &[][..],
        &["test"],
        &["gap"],
        &["import"],
        &["machine"],
        &["track"],
        &["export"],
        &["ecu"],
        &["emulate"],
        &["decode"],
        &["bench"],
    ] {
        let output = hil(&[command, &["--help"]].concat());
        assert!(output.status.success());
        let last = text(&output.stdout).lines().last().unwrap();
        let call = ["Example: cargo hil", &command.join(" ")].join(" ");
        assert!(last.starts_with(call.trim_end()), "{last}");
        assert!(output.stderr.is_empty());
    }
}

#[test]
fn the_version_is_the_packages() {
    for option in ["--version", "-V"] {
        let output = hil(&[option]);
        assert!(output.status.success());
        assert_eq!(
            text(&output.stdout),
            concat!("cargo hil ", env!("CARGO_PKG_VERSION"), "\n")
        );
        assert!(output.stderr.is_empty());
    }
}

#[test]
fn a_usage_error_is_one_line_and_status_2() {
    for (arguments, part) in [
        (&["--nonsense"][..], "'--nonsense'"),
        (&["nonsense"], "'nonsense'"),
        (&["gap"], "--machine"),
        (&["gap", "--machine", "a.toml"], "--train"),
        (&["import", "raw.csv", "--out", "a.csv"], "--input"),
        (&["machine"], "--resistance"),
        (&["machine", "--voltage", "-12V"], "--voltage=-12V"),
        (&["machine", "--voltage=-12V"], "--voltage -12V"),
        (&["bench", "gap", "--seed", "-1"], "--seed=-1"),
        (&["track", "--machine", "a.toml"], "<LOG>"),
        (&["export", "--machine", "a.toml"], "--to"),
        (&["decode", "image"], "<LOG>"),
        (&["test", "surplus"], "'surplus'"),
        (&["reproduce", "prognostics", "--repeat", "3"], "--repeat"),
        (&["reproduce", "bench", "--repeat", "3"], "--repeat"),
    ] {
        let output = hil(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty());
        let error = text(&output.stderr);
        assert!(error.starts_with("error: "), "{error}");
        assert!(error.contains(part), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
}

/// Commands that work for minutes look first whether there is a place for their result.
#[test]
fn a_result_without_a_place_is_refused_before_the_work() {
    let directory = std::env::temp_dir();
    let directory = directory.to_str().unwrap();
    for (path, remedy) in [
        ("no-such-directory/out.json", "create it"),
        (directory, "expected the name of a file"),
    ] {
        for command in [
            &["reproduce", "prognostics"][..],
            &["reproduce", "throttle"],
            &["reproduce", "bench"],
            &["onboard"],
            &["ecu"],
            &["bench"],
        ] {
            let output = hil(&[command, &["--json", path]].concat());
            assert_eq!(output.status.code(), Some(1), "{command:?}");
            assert!(output.stdout.is_empty());
            let error = text(&output.stderr);
            assert!(error.starts_with(&format!("error: {path}: ")), "{error}");
            assert!(error.contains(remedy), "{error}");
            assert_eq!(error.lines().count(), 1, "{error}");
        }
    }
}
