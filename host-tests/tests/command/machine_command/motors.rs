//! The machine files of real motors, valves and servos.

use std::fs;
use std::path::PathBuf;

use super::*;

fn motors() -> Vec<PathBuf> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/motors");
    let entries = fs::read_dir(directory).unwrap();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// The words of the call at a file's head.
fn head(text: &str) -> Vec<String> {
    let start = text.find("# cargo hil machine ").expect("a call");
    let mut call = String::new();
    for line in text[start..].lines() {
        let line = line.strip_prefix('#').expect("a comment").trim();
        call.push_str(line.trim_end_matches('\\'));
        if !line.ends_with('\\') {
            break;
        }
    }
    let mut words = vec![String::new()];
    let mut inside = false;
    for character in call.chars() {
        match character {
            '"' => inside = !inside,
            ' ' if !inside => words.push(String::new()),
            other => words.last_mut().unwrap().push(other),
        }
    }
    words.retain(|word| !word.is_empty());
    words.drain(..3);
    words
}

#[test]
fn the_motors_are_what_their_heads_call_makes() {
    let files = motors();
    assert!(files.len() >= 10, "{files:?}");
    for path in files {
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains("#     --source "), "{}", path.display());
        let output = hil(&head(&text));
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{}: {error}", path.display());
        assert_eq!(
            String::from_utf8(output.stdout).unwrap(),
            text,
            "{}",
            path.display()
        );
        let machine = Machine::read(&path).unwrap();
        assert_eq!(
            Some(machine.name.as_ref()),
            path.file_stem().unwrap().to_str()
        );
        declared::model(&machine).unwrap();
    }
}

/// Every motor in the tree turns and draws what its sheet says, as far as makers keep to theirs.
#[test]
fn the_motors_do_what_their_sheets_say() {
    // Name, V, no-load speed in the coordinate's unit, stall current, stall torque or force: from the sheets.
    for (name, volts, speed, current, torque) in [
        ("pololu-37d-50", 12.0, 200.0 * RPM, 5.5, 210.0 * KGF_MM),
        ("pololu-37d-131", 12.0, 76.0 * RPM, 5.5, 450.0 * KGF_MM),
        ("robotis-xl330-m288", 5.0, 103.0 * RPM, 1.47, 0.52),
        ("robotis-xl-320", 7.4, 114.0 * RPM, 1.1, 0.39),
        ("robotis-mx-28", 12.0, 55.0 * RPM, 1.4, 2.5),
        ("robotis-ax-18a", 12.0, 97.0 * RPM, 2.2, 1.8),
        (
            "faulhaber-1331t012sr",
            12.0,
            9900.0 * RPM,
            12.0 / 13.7,
            9.90e-3,
        ),
        (
            "faulhaber-0816k012sr",
            12.0,
            12_600.0 * RPM,
            12.0 / 101.8,
            1e-3,
        ),
        ("maxon-re-65", 48.0, 3670.0 * RPM, 131.0, 16.1),
        ("actuonix-l16-35", 12.0, 0.032, 0.65, 100.0),
    ] {
        let path = motors();
        let path = path.iter().find(|path| path.file_stem().unwrap() == name);
        let path = path.unwrap_or_else(|| panic!("{name}"));
        let text = declaring_the_loss(&fs::read_to_string(path).unwrap());
        let machine = Machine::of_bytes(path, text.into_bytes()).unwrap();
        let line = |load: f64| settled(&machine, volts, load).0;
        // A sheet that gives the constants gives them with 10 %; without them the printed digits decide.
        let tolerance = if name.starts_with(['f', 'm']) {
            0.1
        } else {
            6.0 * PRINTED
        };
        near(line(0.0), speed, tolerance);
        near(blocked(&machine, volts), current, tolerance);
        let half = line(0.5 * torque);
        // A loss of 6 % of the torque may be none, and has no line to put in.
        let tolerance = if name == "robotis-mx-28" {
            0.04
        } else {
            tolerance
        };
        assert!(
            (half - 0.5 * speed).abs() < tolerance * speed,
            "{name}: {half}"
        );
    }
}
