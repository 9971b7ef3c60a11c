//! The core's plant against the traces that SciPy integrated (`host-tests/traces`, its README says
//! how).

use model_core::plant::actuator::Actuator;
use model_core::plant::parameters::{Drive, Parameters};
use model_core::plant::{Directional, State};
use std::f64::consts::TAU;
use std::path::Path;

/// One row of a trace.
struct Row {
    time: f64,
    input: f64,
    position: f64,
    velocity: f64,
    current: f64,
    command: f64,
}

fn read(name: &str) -> Vec<Row> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("traces")
        .join(name);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    text.lines()
        .skip(1)
        .map(|line| {
            let mut numbers = line.split(',').map(|number| number.parse().unwrap());
            let mut next = || numbers.next();
            Row {
                time: next().unwrap(),
                input: next().unwrap(),
                position: next().unwrap(),
                velocity: next().unwrap(),
                current: next().unwrap(),
                command: next().unwrap_or(f64::NAN),
            }
        })
        .collect()
}

/// Root mean square and largest magnitude of an error.
#[derive(Default)]
struct Deviation {
    squares: f64,
    count: f64,
    largest: f64,
}

impl Deviation {
    fn see(&mut self, error: f64) {
        self.squares += error * error;
        self.count += 1.0;
        // Not `max`, which would pass over a NaN.
        if error.is_nan() || error.abs() > self.largest {
            self.largest = error.abs();
        }
    }

    fn rms(&self) -> f64 {
        (self.squares / self.count).sqrt()
    }
}

/// Deviations from the rows of a trace.
#[derive(Default)]
struct Deviations {
    position: Deviation,
    velocity: Deviation,
    current: Deviation,
}

impl Deviations {
    fn see(&mut self, row: &Row, position: f64, velocity: f64, current: f64) {
        self.position.see(position - row.position);
        self.velocity.see(velocity - row.velocity);
        self.current.see(current - row.current);
    }

    fn see_state(&mut self, row: &Row, state: &State) {
        self.see(
            row,
            f64::from(state.position.value()),
            f64::from(state.velocity.value()),
            f64::from(state.current),
        );
    }

    fn print(&self, name: &str) {
        let Self {
            position,
            velocity,
            current,
        } = self;
        println!(
            "{name}: rms (largest) {:.1e} ({:.1e}) rad, {:.1e} ({:.1e}) rad/s, {:.1e} ({:.1e}) A",
            position.rms(),
            position.largest,
            velocity.rms(),
            velocity.largest,
            current.rms(),
            current.largest,
        );
    }
}

fn ema(breakaway: f32) -> Parameters {
    Parameters {
        drive: Drive::Voltage {
            resistance: 1.0,
            inductance: 1e-3,
            torque_constant: 0.06,
        },
        gain: 1.0,
        inertia: 1.2e-4,
        viscous: Directional::both(2e-4),
        coulomb: Directional::both(0.12),
        breakaway: Directional::both(breakaway),
        spring: 0.0,
        spring_rest: 0.0,
        spring_preload: 0.0,
        offset: 0.0,
        lower_stop: f32::NEG_INFINITY,
        upper_stop: f32::INFINITY,
    }
}

fn throttle() -> Parameters {
    Parameters {
        drive: Drive::Voltage {
            resistance: 2.0,
            inductance: 1.2e-3,
            torque_constant: 0.38,
        },
        inertia: 1.6e-3,
        viscous: Directional::both(8e-3),
        coulomb: Directional::both(0.24),
        breakaway: Directional::both(0.28),
        spring: 0.25,
        spring_rest: 0.2,
        spring_preload: 0.3,
        lower_stop: 0.02,
        upper_stop: 1.57,
        ..ema(0.15)
    }
}

/// The voltage of the sweeps at a time in s.
fn sweep(time: f64) -> f64 {
    12.0 * (TAU * (0.2 * time + 0.24 * time * time)).sin()
}

const SWEEPS: [(&str, f32, &str, f64); 6] = [
    ("coulomb", 0.12, "50us", 5e-5),
    ("coulomb", 0.12, "100us", 1e-4),
    ("coulomb", 0.12, "1ms", 1e-3),
    ("static", 0.15, "50us", 5e-5),
    ("static", 0.15, "100us", 1e-4),
    ("static", 0.15, "1ms", 1e-3),
];

#[test]
fn voltage_sweep() {
    for (friction, breakaway, label, hold) in SWEEPS {
        let name = format!("sweep-{friction}-{label}.csv");
        let actuator = Actuator::build(&ema(breakaway), hold as f32).unwrap();
        let mut state = State::new(0.0, 0.0);
        let mut deviations = Deviations::default();
        let every = (5e-3 / hold).round() as usize;
        for (number, row) in read(&name).iter().enumerate() {
            deviations.see_state(row, &state);
            for step in number * every..(number + 1) * every {
                let input = sweep(step as f64 * hold) as f32;
                actuator.step(&mut state, input).unwrap();
            }
        }
        deviations.print(&name);
    }
}

#[test]
fn throttle_over_its_rest_and_into_its_stops() {
    let actuator = Actuator::build(&throttle(), 1e-3).unwrap();
    let mut state = State::new(0.2, 0.0);
    let mut deviations = Deviations::default();
    for row in read("throttle.csv") {
        deviations.see_state(&row, &state);
        actuator.step(&mut state, row.input as f32).unwrap();
    }
    deviations.print("throttle.csv");
}

#[test]
fn position_loop() {
    let actuator = Actuator::build(&ema(0.15), 1e-3).unwrap();
    let mut state = State::new(0.0, 0.0);
    let mut deviations = Deviations::default();
    for row in read("pid.csv") {
        deviations.see_state(&row, &state);
        actuator.step(&mut state, row.input as f32).unwrap();
    }
    deviations.print("pid.csv");
}
