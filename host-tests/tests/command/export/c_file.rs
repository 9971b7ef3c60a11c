//! The exported C, compiled by the host's compiler with every warning an error, beside the rig and beside the core.

use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

use host_tests::gap::declared;
use host_tests::machine::Machine;
use model_core::gap::simulator::{Course, Given};
use model_core::plant::State;
use model_core::plant::actuator::External;

use super::drive::{Case, RATE, apart, cases, columns, export, text, travel};

/// A program that reads where to start, the period, and inputs, and prints what each comes to.
const MAIN: &str = r#"
#include <stdio.h>
#include "model.c"

int main(void)
{
    actuator_state state;
    double start, period, input;
    if (scanf("%lf %lf", &start, &period) != 2)
        return 1;
    actuator_start(&state, start);
    while (scanf("%lf", &input) == 1) {
        actuator_step(&state, input, 0.0, period);
        printf("%.17g %.17g %.17g\n", state.position, state.current, state.reported);
    }
    return 0;
}
"#;

/// What the exported C makes of an input: position, current and reading behind each row.
pub fn computed(directory: &Path, toml: &str, start: f64, input: &[f64]) -> [Vec<f64>; 3] {
    let exported = export(directory, toml, &["c", "--out", "model.c"]);
    assert!(exported.status.success(), "{}", text(&exported.stderr));
    fs::write(directory.join("main.c"), MAIN).unwrap();
    let options = [
        "-std=c99",
        "-pedantic",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-O2",
        "-o",
        "main",
    ];
    let compiled = Command::new("cc")
        .current_dir(directory)
        .args(options)
        .args(["main.c", "-lm"])
        .output()
        .expect("a C compiler");
    assert!(compiled.status.success(), "{}", text(&compiled.stderr));
    let mut program = Command::new(directory.join("main"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut rows = format!("{start:?} {:?}\n", 1.0 / RATE);
    rows.extend(input.iter().map(|input| format!("{input:?}\n")));
    let mut pipe = program.stdin.take().unwrap();
    let writing = std::thread::spawn(move || pipe.write_all(rows.as_bytes()));
    let output = program.wait_with_output().unwrap();
    writing.join().unwrap().unwrap();
    assert!(output.status.success());
    columns(&output.stdout)
}

/// The rig integrates by another method, in steps of 2 µs, and is itself off by about what half as many steps change. A number of the
/// machine file goes through single precision, which is exact to 6e-8 of it, and a sum of two to as much again.
#[test]
fn c_moves_as_the_rig_does() {
    for case in cases() {
        let directory = tempfile::tempdir().unwrap();
        let [positions, _, _] = computed(directory.path(), &case.toml(), case.start, &case.input());
        let (fine, coarse) = (case.played(1e-6), case.played(2e-6));
        let way = travel(&fine);
        assert!(way > 0.0, "{} does not move", case.name);
        let bound = 3.0 * apart(&fine, &coarse) + 2e-7 * way;
        let off = apart(&positions, &fine);
        println!(
            "{}: way {way:.3}, off {off:.1e}, rig {:.1e}",
            case.name,
            apart(&fine, &coarse)
        );
        assert!(off <= bound, "{}: {off:e} beyond {bound:e}", case.name);
    }
}

/// What the core makes of an input in steps of `period`, `parts` of them to a row.
fn stepped(machine: &Machine, start: f64, input: &[f64], parts: usize) -> [Vec<f64>; 3] {
    let model = declared::model(machine).unwrap();
    let simulator = model.build((1.0 / RATE / parts as f64) as f32).unwrap();
    let mut course = Course::new(State::new(start as f32, 0.0));
    let mut columns = [const { Vec::new() }; 3];
    for (row, &input) in input.iter().enumerate() {
        let mut current = 0.0;
        for part in 0..parts {
            let given = Given {
                input: input as f32,
                previous: input as f32,
                external: External::NONE,
                index: row * parts + part,
            };
            current = simulator.step(&mut course, &given).unwrap();
        }
        columns[0].push(f64::from(course.state.position.value()));
        columns[1].push(f64::from(current));
        columns[2].push(f64::from(simulator.reported(&course)));
    }
    columns
}

/// What the rig has another law of, or none: beside the core, which holds an effect over half a step and is off by about what half as
/// many steps change.
#[test]
fn c_has_the_cores_laws_of_winding_and_sensor() {
    for declared in [
        "{ id = \"supply_sag\", share = 1e-3 }",
        "{ id = \"brush_drop\", drop = 0.6 }",
        "{ id = \"dead_time\", loss = 0.6 }",
        "{ id = \"brush_drop\", drop = 0.4 }, { id = \"dead_time\", loss = 0.5 }",
        "{ id = \"thermal_drift\", rate = 2e-3, time_constant = 4.0 }",
        "{ id = \"external_load\", torque = 0.08, end = 2.0, duration = 0.7 }",
        "{ id = \"encoder_eccentricity\", sine = 0.02, cosine = 0.01, period = 6.0 }",
        "{ id = \"backlash\", width = 0.05 }",
        "{ id = \"cogging\", sine = 0.02, cosine = 0.01, period = 0.8, cosine_2 = 0.01, sine_3 = -0.005 }",
    ] {
        let directory = tempfile::tempdir().unwrap();
        let [ema, ..] = &cases()[..] else {
            unreachable!()
        };
        let case = Case {
            name: declared,
            machine: ema.machine.clone(),
            effects: Vec::new(),
            declared,
            start: 0.0,
        };
        let input = case.input();
        let found = computed(directory.path(), &case.toml(), 0.0, &input);
        let machine = Machine::read(&directory.path().join("machine.toml")).unwrap();
        let (fine, coarse) = (
            stepped(&machine, 0.0, &input, 20),
            stepped(&machine, 0.0, &input, 10),
        );
        // Without the effect it would not do.
        let plain = case_without(&case);
        let without = Machine::of_bytes("plain.toml".as_ref(), plain.into_bytes()).unwrap();
        let without = stepped(&without, 0.0, &input, 20);
        let mut bound = 0.0;
        for (name, column) in [("position", 0), ("reading", 2)] {
            let way = travel(&fine[column]);
            bound = 3.0 * apart(&fine[column], &coarse[column]) + 2e-6 * way;
            let off = apart(&found[column], &fine[column]);
            println!(
                "{declared}: {name} off {off:.1e}, core {:.1e}, way {way:.2}",
                apart(&fine[column], &coarse[column]),
            );
            assert!(off <= bound, "{declared}: {name} {off:e} beyond {bound:e}");
        }
        let effect = apart(&fine[2], &without[2]);
        assert!(effect > 10.0 * bound, "{declared} does nothing");
    }
}

fn case_without(case: &Case) -> String {
    let none = Case {
        declared: "",
        machine: case.machine.clone(),
        effects: Vec::new(),
        ..*case
    };
    none.toml()
}

/// What C does not say is said, on standard error with its line and in the file.
#[test]
fn what_c_does_not_express_is_named() {
    let directory = tempfile::tempdir().unwrap();
    let [ema, ..] = &cases()[..] else {
        unreachable!()
    };
    let toml = format!(
        "{}declared_effects = [\n{{ id = \"input_delay\", delay = 0.002 }},\n{{ id = \"brush_drop\", drop = 0.2 }},\n{{ id = \
         \"compliance\", trailing = 1e-5, share = 0.2, damping = 0.1 }},\n]\n",
        ema.machine.to_toml()
    );
    let line = |id: &str| toml.lines().position(|line| line.contains(id)).unwrap() + 1;
    let output = export(directory.path(), &toml, &["c"]);
    assert!(output.status.success());
    let (printed, said) = (text(&output.stdout), text(&output.stderr));
    assert!(printed.contains(" * Effects: brush_drop\n"), "{printed}");
    for id in ["input_delay", "compliance"] {
        let named = format!("effect `{id}` is not expressed");
        assert!(
            said.contains(&format!(
                "warning: machine.toml:{}: in `c`, {named}",
                line(id)
            )),
            "{said}"
        );
        assert!(
            printed.contains(&format!(" * NOT EXPRESSED: {named}")),
            "{printed}"
        );
    }
    assert!(said.contains("`resolution` is not expressed"), "{said}");
    assert!(!said.contains("brush_drop"));
}
