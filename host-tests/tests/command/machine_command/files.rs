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

/// What the README shows leads from a data sheet and two logs to the arm on the shaft, of 0.12 N·m, and to the 30 % of the motor's
/// torque that the gear loses (`rig/examples/gearmotor.rs`).
#[test]
fn the_calls_that_the_readme_shows_find_the_arm() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let readme = fs::read_to_string(root.join("README.md")).unwrap();
    let (_, section) = readme.split_once("## Your own motor").unwrap();
    let (_, block) = section.split_once("```sh\n").unwrap();
    let (calls, _) = block.split_once("```").unwrap();
    let examples = root.join("host-tests/examples");
    let script = calls
        .replace("cargo hil", env!("CARGO_BIN_EXE_hil"))
        .replace("host-tests/examples", examples.to_str().unwrap());
    let script = format!("set -e\n{script}").replace(" gap ", " gap --json answer.json ");
    let directory = tempfile::tempdir().unwrap();
    let mut shell = Command::new("sh");
    let output = shell
        .args(["-c", &script])
        .current_dir(&directory)
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.contains(" Plots: report/index.html."), "{said}");
    let answer = fs::read(directory.path().join("answer.json")).unwrap();
    let answer: serde_json::Value = serde_json::from_slice(&answer).unwrap();
    assert_eq!(answer["verdict"], "effects_found");
    let effects = answer["effects"].as_array().unwrap();
    let [gravity, loss] = &effects[..] else {
        panic!("{effects:?}");
    };
    assert_eq!(gravity["id"], "gravity");
    let torque = gravity["parameters"][0]["value"].as_f64().unwrap();
    assert!((torque / 0.12 - 1.0).abs() < 0.02, "{torque}");
    assert_eq!(loss["id"], "load_dependent_friction");
    let share = loss["parameters"][0]["value"].as_f64().unwrap();
    assert!((share / 0.3 - 1.0).abs() < 0.02, "{share}");
    let errors = &answer["errors"]["validate"];
    let position = |stage: &str| errors[stage]["position_rms"].as_f64().unwrap();
    assert!(position("after") < 0.1 * position("before"), "{errors}");
}

/// What the texts show for logs and machine files runs as it stands, in the order of a text: with the README's two drives under
/// the names that stand there, and four parts of the first for the months.
#[test]
fn the_calls_that_the_texts_show_run() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let directory = tempfile::tempdir().unwrap();
    let run = |script: &str| {
        let script = script.replace("cargo hil", env!("CARGO_BIN_EXE_hil"));
        let mut shell = Command::new("sh");
        let shell = shell.args(["-ec", &script]).current_dir(&directory);
        let output = shell.output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{script}{error}");
    };
    for (drive, name) in [("run-a", "run.csv"), ("run-b", "other.csv")] {
        let from = root.join(format!("host-tests/examples/{drive}.csv"));
        fs::copy(from, directory.path().join(name)).unwrap();
    }
    let columns = "--time t:ms --position pos:deg --input 'duty:%*12' --current i:mA";
    run(&format!("cargo hil import other.csv {columns} --out b.csv"));
    for (place, month) in ["march", "april", "may", "june"].iter().enumerate() {
        let first = 3 + 1250 * place;
        let lines = format!("{first}-{}", first + 1249);
        run(&format!(
            "cargo hil import run.csv {columns} --header 2 --lines {lines} --out {month}.csv"
        ));
    }
    let mut blocks = 0;
    for text in ["log.md", "export.md"] {
        let text = fs::read_to_string(root.join("docs").join(text)).unwrap();
        for block in text.split("```sh\n").skip(1) {
            let (calls, _) = block.split_once("```").unwrap();
            run(calls);
            blocks += 1;
        }
    }
    assert!(blocks >= 3, "{blocks}");
    for made in [
        "out.json",
        "report/index.html",
        "found.toml",
        "actuator.c",
        "actuator.fmu",
        "actuator.xml",
    ] {
        assert!(directory.path().join(made).is_file(), "{made}");
    }
}
