//! `cargo hil machine` as a user meets it: data sheets in, machine files out, which do what the sheets say.
//!
//! References: the data sheets' own numbers, and the closed forms of a brushed DC motor behind a gear.

use std::f64::consts::TAU;
use std::path::Path;
use std::process::{Command, Output};

use host_tests::gap::declared;
use host_tests::machine::Machine;
use model_core::gap::model::Model;
use model_core::gap::simulator::{Course, Given};
use model_core::plant::State;
use model_core::plant::actuator::External;

mod drawn;
mod files;
mod friction;
mod motors;
mod numbers;
mod refused;
mod traced;

const RPM: f64 = TAU / 60.0;
/// Gram-force on a millimetre, N·m.
const KGF_MM: f64 = 9.806_65e-3;

/// A gearmotor of a shop's page: Pololu 4753.
const CART: &str = "--voltage 12V --no-load-speed 200rpm --no-load-current 0.2A --stall-torque 210kg.mm \
                    --stall-current 5.5A --gear-ratio 50 --values-of gearmotor";

/// A motor of a maker's data sheet, which says everything twice: Faulhaber 1331 T 012 SR.
const MICROMOTOR: &str = "--voltage 12V --no-load-speed 9900rpm --no-load-current 0.0105A --stall-torque \
                          9.90mNm --resistance 13.7ohm --torque-constant 11.4mNm/A --rotor-inertia 0.67gcm2 \
                          --mechanical-time-constant 7ms --inductance 310uH";

fn hil<S: AsRef<str>>(words: &[S]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hil"))
        .arg("machine")
        .args(words.iter().map(AsRef::as_ref))
        .output()
        .unwrap()
}

fn split(text: &str) -> Vec<&str> {
    text.split_whitespace().collect()
}

/// The file that these words print.
fn printed(words: &str) -> String {
    let output = hil(&split(words));
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{words}: {error}");
    assert_eq!(error, "");
    String::from_utf8(output.stdout).unwrap()
}

fn machine(words: &str) -> Machine {
    let text = printed(words);
    Machine::of_bytes(Path::new("printed.toml"), text.into_bytes()).unwrap()
}

/// A printed file with the gear's loss as its comment has it, declared.
fn declaring_the_loss(text: &str) -> String {
    let Some((head, loss)) = text.split_once("\n# declared_effects = ") else {
        return text.to_owned();
    };
    let (loss, rest) = loss.split_once("\ndeclared_effects = []").unwrap();
    format!("{head}\ndeclared_effects = {loss}{rest}")
}

fn machine_with_loss(words: &str) -> Machine {
    let text = declaring_the_loss(&printed(words));
    Machine::of_bytes(Path::new("printed.toml"), text.into_bytes()).unwrap()
}

/// The one line on standard error with which these words are refused.
fn refused<S: AsRef<str>>(words: &[S]) -> String {
    let output = hil(words);
    let shown: Vec<&str> = words.iter().map(AsRef::as_ref).collect();
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{shown:?}: {error}");
    assert!(output.stdout.is_empty(), "{shown:?}");
    assert!(error.starts_with("error: "), "{error}");
    assert_eq!(error.lines().count(), 1, "{error}");
    error
}

fn near(value: f64, expected: f64, tolerance: f64) {
    let off = (value / expected - 1.0).abs();
    assert!(off <= tolerance, "{value} for {expected}, {off} off");
}

/// Largest relative error of a number that is printed with four digits.
const PRINTED: f64 = 5e-4;

/// Velocity and current on which the machine settles at this input against this load, N·m or N.
fn settled(machine: &Machine, input: f64, load: f64) -> (f64, f64) {
    let mut model = declared::model(machine).unwrap();
    model.plant.lower_stop = f32::NEG_INFINITY;
    model.plant.upper_stop = f32::INFINITY;
    model.plant.spring = 0.0;
    model.plant.offset = -load as f32;
    let motor = machine.motor.unwrap();
    let settling = machine.mechanics.inertia * motor.resistance / motor.torque_constant.powi(2);
    // Moving already: this is about sliding, not about breaking away.
    let start = 0.1 * machine.gain * input / motor.torque_constant;
    run(&model, settling, input, State::new(0.0, start as f32))
}

/// Current at standstill against a stop.
fn blocked(machine: &Machine, input: f64) -> f64 {
    let mut model = declared::model(machine).unwrap();
    model.plant.upper_stop = 0.0;
    model.plant.lower_stop = -1.0;
    run(&model, 0.01, input, State::new(0.0, 0.0)).1
}

fn run(model: &Model, settling: f64, input: f64, state: State) -> (f64, f64) {
    let simulator = model.build(settling as f32 / 20.0).unwrap();
    let mut course = Course::new(state);
    let mut current = 0.0;
    for index in 0..600 {
        let given = Given {
            input: input as f32,
            previous: input as f32,
            external: External::NONE,
            index,
        };
        current = simulator.step(&mut course, &given).unwrap();
    }
    (f64::from(course.state.velocity.value()), f64::from(current))
}
