//! The file: its comments, and where it is written.

use std::fs;

use host_tests::machine::{MOTOR, PARAMETERS};
use host_tests::outputs::MARK;

use super::*;

#[test]
fn every_number_says_where_it_comes_from() {
    let text = printed(CART);
    assert!(text.starts_with(&format!("# {MARK} machine")), "{text}");
    let lines: Vec<&str> = text.lines().collect();
    for (place, line) in lines.iter().enumerate() {
        let key = line.split(" = ").next().unwrap();
        if PARAMETERS.iter().any(|known| known.name == key) {
            assert!(line.contains("# "), "{line}");
            assert!(lines[place - 1].starts_with("# "), "{line}");
        }
    }
    for part in [
        "guessed: 10 ms × torque constant² over resistance",
        "--voltage 12V over --stall-current 5.5A",
        "neglected, not given",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    // A name or a source cannot break out of its place.
    let output = hil(&[
        &split(CART)[..],
        &["--name", "a \"b\"\\\n[c]", "--source", "x\ny = 1"],
    ]
    .concat());
    let text = String::from_utf8(output.stdout).unwrap();
    let machine = Machine::of_bytes(Path::new("a.toml"), text.into_bytes()).unwrap();
    assert_eq!(machine.name, "a \"b\"\\\n[c]");
}

/// With a measured current the motor's numbers are fitted too, within what the comments behind them say.
#[test]
fn the_motors_numbers_are_fitted_where_a_current_is_measured() {
    let words = format!("{MICROMOTOR} --measured-current");
    let (with, without) = (machine(&words), machine(MICROMOTOR));
    let text = printed(&words);
    assert!(text.contains("--measured-current\n"), "{text}");
    for name in MOTOR {
        assert!(with.fits(name) && !without.fits(name), "{text}");
        let mut lines = text.lines();
        let line = lines.find(|line| line.starts_with(&format!("{name} = ")));
        // The data sheet gives both, and no maker is nearer than a tenth.
        assert!(line.unwrap().ends_with("±10 %"), "{text}");
        assert!((with.unsure[name] - 1.1).abs() < 1e-12, "{text}");
        assert!(!without.unsure.contains_key(name), "{text}");
    }
}

#[test]
fn a_file_of_the_users_is_not_replaced() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("cart.toml");
    let shown = path.to_str().unwrap();
    let words = [&split(CART)[..], &["--out", shown]].concat();
    let output = hil(&words);
    assert!(output.status.success());
    assert!(output.stdout.is_empty());
    let text = fs::read_to_string(&path).unwrap();
    // Where it is written is no part of it.
    assert_eq!(text, printed(CART));
    assert!(hil(&words).status.success());
    let own = format!("name = \"mine\"\n{}", "# kept\n".repeat(200));
    fs::write(&path, &own).unwrap();
    let error = refused(&words);
    assert!(error.contains("not replaced"), "{error}");
    assert_eq!(fs::read_to_string(&path).unwrap(), own);
    // A wrong call writes nothing.
    let other = directory.path().join("other.toml");
    refused(&["--voltage", "12", "--out", other.to_str().unwrap()]);
    assert!(!other.exists());
}

#[test]
fn gap_reads_what_is_printed() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("cart.toml");
    fs::write(&path, printed(CART)).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_hil"))
        .args([
            "gap",
            "--machine",
            path.to_str().unwrap(),
            "--train",
            "no-such.csv",
        ])
        .output()
        .unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(error.starts_with("error: no-such.csv: "), "{error}");
}

/// What the help shows can be typed.
#[test]
fn the_call_that_the_help_shows_works() {
    let help = String::from_utf8(hil(&["--help"]).stdout).unwrap();
    let call = help.rsplit("cargo hil machine ").next().unwrap();
    let (words, _) = call.split_once(" > ").expect("a file to write to");
    printed(&words.replace('\\', " "));
}
