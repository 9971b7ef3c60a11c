//! A printed machine against logs of the gearmotor that its data sheet describes, played by a plant that shares
//! no code with the core.

use std::fmt::Write as _;
use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use super::*;

/// The gearmotor of [`CART`], by the lines of its sheet; inertia and friction are its own.
struct Gearmotor {
    resistance: f64,
    constant: f64,
    efficiency: f64,
    inertia: f64,
    coulomb: f64,
    breakaway: f64,
    viscous: f64,
}

impl Gearmotor {
    fn of_the_sheet() -> Self {
        let (volts, idle, stall, speed) = (12.0, 0.2, 5.5, 200.0 * RPM);
        let resistance = volts / stall;
        let constant = (volts - idle * resistance) / speed;
        Self {
            resistance,
            constant,
            // Three quarters of what rubs without a load rub at standstill.
            efficiency: 210.0 * KGF_MM / (constant * (stall - 0.75 * idle)),
            // A half more than what is guessed of them, viscous friction half of it.
            inertia: 2.2e-3,
            coulomb: 0.09,
            breakaway: 0.1,
            viscous: 5e-4,
        }
    }

    /// Twelve seconds under five sines, one thousand samples a second, with the encoder's counts.
    fn log(&self, phase: f64) -> String {
        const STEPS: usize = 50;
        const STEP: f64 = 2e-5;
        let count = TAU / 3200.0;
        let (mut speed, mut position) = (0.0_f64, 0.0_f64);
        let mut text = "time_s,input,position\n".to_owned();
        for sample in 0..12_000 {
            let time = sample as f64 * 1e-3;
            let input: f64 = [0.3, 0.7, 1.3, 2.1, 3.7]
                .into_iter()
                .enumerate()
                .map(|(place, hertz)| {
                    2.2 * (TAU * hertz * time + phase * (1.0 + place as f64)).sin()
                })
                .sum();
            let seen = (position / count).round() * count;
            writeln!(text, "{time:.3},{input:.9},{seen:.9}").unwrap();
            for _ in 0..STEPS {
                let torque = self.constant * (input - self.constant * speed) / self.resistance;
                let lost = (1.0 - self.efficiency) * torque.abs();
                if speed == 0.0 && torque.abs() <= self.breakaway + lost {
                    continue;
                }
                let direction = if speed == 0.0 {
                    torque.signum()
                } else {
                    speed.signum()
                };
                let rubbing = (self.coulomb + lost) * direction + self.viscous * speed;
                let next = speed + STEP * (torque - rubbing) / self.inertia;
                speed = if next * speed < 0.0 { 0.0 } else { next };
                position += STEP * speed;
            }
        }
        text
    }

    /// A directory with two such logs, `a.csv` and `b.csv`.
    fn recorded(&self) -> TempDir {
        let directory = tempfile::tempdir().unwrap();
        for (name, phase) in [("a.csv", 1.0), ("b.csv", 2.0)] {
            fs::write(directory.path().join(name), self.log(phase)).unwrap();
        }
        directory
    }
}

/// The answer to these files, in JSON and in words.
fn traced(directory: &Path, machine: &str) -> (Value, String) {
    fs::write(directory.join("machine.toml"), machine).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_hil"))
        .current_dir(directory)
        .args([
            "gap",
            "--machine",
            "machine.toml",
            "--train",
            "a.csv",
            "--validate",
            "b.csv",
        ])
        .args(["--json", "out.json"])
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
    let answer = serde_json::from_slice(&fs::read(directory.join("out.json")).unwrap()).unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    let words: Vec<&str> = said.split_whitespace().collect();
    (answer, words.join(" "))
}

/// The loss of the gear is all that the answer names, and it is as large as it is.
fn names_the_loss(found: &Value, loss: f64) {
    assert_eq!(found["verdict"], "effects_found", "{found}");
    let effects = found["effects"].as_array().unwrap();
    assert_eq!(effects.len(), 1, "{found}");
    assert_eq!(effects[0]["id"], "load_dependent_friction");
    let share = &effects[0]["parameters"][0];
    let number = |key: &str| share[key].as_f64().unwrap();
    assert!(
        (number("value") - loss).abs() < 3.0 * number("std"),
        "{share}"
    );
}

/// Nothing is missing in what the data sheet's machine has, its guesses fitted, but the loss of the gear. Where that is declared as
/// the sheet has it, nothing is.
#[test]
fn the_printed_machine_lacks_the_loss_of_its_gear_alone() {
    let gearmotor = Gearmotor::of_the_sheet();
    let directory = gearmotor.recorded();
    let text = printed(CART);
    let (found, _) = traced(directory.path(), &text);
    names_the_loss(&found, 1.0 - gearmotor.efficiency);

    let (found, _) = traced(directory.path(), &declaring_the_loss(&text));
    assert_eq!(found["verdict"], "no_missing_effect", "{found}");
    for (name, truth) in [
        ("inertia", gearmotor.inertia),
        ("coulomb", gearmotor.coulomb),
    ] {
        let fit = found["fit"].as_array().unwrap();
        let fitted = fit.iter().find(|fit| fit["name"] == name).unwrap();
        // The printed winding has four digits, and Euler's steps of 20 µs stand for the motion.
        near(fitted["fitted"].as_f64().unwrap(), truth, 0.01);
    }
}

/// A gear that loses a tenth of the torque where its sheet has three: with the printed file that is what is found. Whoever declares
/// what the sheet says has another number called wrong, and is told that it may be that.
#[test]
fn a_loss_that_the_sheet_has_wrong_is_found() {
    let gearmotor = Gearmotor {
        efficiency: 0.9,
        ..Gearmotor::of_the_sheet()
    };
    let directory = gearmotor.recorded();
    let text = printed(CART);
    let (found, _) = traced(directory.path(), &text);
    names_the_loss(&found, 1.0 - gearmotor.efficiency);

    let (_, said) = traced(directory.path(), &declaring_the_loss(&text));
    let advice = "if load_dependent_friction in `declared_effects` comes from a data sheet, leave it out there";
    assert!(said.contains(advice), "{said}");
}
