//! What is refused, in one line, with nothing written.

use std::fs;

use rig::Machine;

use super::drive::{export, text};

#[test]
fn bad_input_is_named_and_nothing_is_written() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    let sound = Machine::rotary_ema().to_toml();
    let unknown = format!("{sound}declared_effects = [{{ id = \"magic\", size = 1.0 }}]\n");
    fs::write(directory.join("mine.c"), "int mine;\n").unwrap();
    for (toml, arguments, expected) in [
        (sound.as_str(), &["spice", "--out", "out"][..], "error: "),
        (&unknown, &["c", "--out", "out"], "error: machine.toml:"),
        (
            &sound,
            &["c", "--out", "machine.toml"],
            "error: machine.toml: is read by this command",
        ),
        (
            &sound,
            &["c", "--out", "mine.c"],
            "error: mine.c: is there already",
        ),
    ] {
        let output = export(directory, toml, arguments);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.starts_with(expected), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(output.stdout.is_empty() && !directory.join("out").exists());
    }
    assert_eq!(
        fs::read_to_string(directory.join("mine.c")).unwrap(),
        "int mine;\n"
    );
}
