//! The plant against the traces that SciPy integrated (`host-tests/traces`, its README says how).

use rig::{Machine, Motor, Pid, PidGains, Plant, ReturnSpring, Stops};
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
        .join("../traces")
        .join(name);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    text.lines()
        .skip(1)
        .map(|line| {
            let mut numbers = line.split(',').map(|n| n.parse().unwrap());
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

/// Largest differences seen so far, for one bound each at the end.
#[derive(Default)]
struct Worst {
    position: f64,
    velocity: f64,
    current: f64,
}

impl Worst {
    fn see(&mut self, plant: &Plant, row: &Row) {
        let state = plant.state();
        self.position = self.position.max((state.position - row.position).abs());
        self.velocity = self.velocity.max((state.velocity - row.velocity).abs());
        self.current = self.current.max((state.current - row.current).abs());
    }

    fn assert_below(&self, position: f64, velocity: f64, current: f64, name: &str) {
        let Self {
            position: x,
            velocity: v,
            current: i,
        } = self;
        println!("{name}: {x:.1e} rad, {v:.1e} rad/s, {i:.1e} A");
        assert!(
            *x < position && *v < velocity && *i < current,
            "{name}: {x} {v} {i}"
        );
    }
}

#[test]
fn voltage_sweep() {
    for (friction, level) in [("coulomb", 0.12), ("static", 0.15)] {
        for (label, hold) in [("50us", 5e-5), ("100us", 1e-4), ("1ms", 1e-3)] {
            let name = format!("sweep-{friction}-{label}.csv");
            let machine = Machine {
                static_friction: level,
                ..Machine::rotary_ema()
            };
            let mut plant = Plant::new(&machine, &[]);
            let mut worst = Worst::default();
            let every = (5e-3_f64 / hold).round() as usize;
            for (n, row) in read(&name).iter().enumerate() {
                worst.see(&plant, row);
                for k in n * every..(n + 1) * every {
                    let t = k as f64 * hold;
                    let phase = TAU * (0.2 * t + 0.5 * 0.48 * t * t);
                    plant.advance(12.0 * phase.sin(), hold);
                }
            }
            worst.assert_below(1e-7, 1e-5, 1e-5, &name);
        }
    }
}

#[test]
fn throttle_over_its_rest_and_into_its_stops() {
    let machine = Machine {
        motor: Motor::Winding {
            resistance: 2.0,
            inductance: 1.2e-3,
            torque_constant: 0.38,
        },
        inertia: 1.6e-3,
        viscous: 8.0e-3,
        coulomb: 0.24,
        static_friction: 0.28,
        spring: Some(ReturnSpring {
            stiffness: 0.25,
            rest: 0.2,
            preload: 0.3,
        }),
        stops: Some(Stops {
            lower: 0.02,
            upper: 1.57,
        }),
        ..Machine::throttle()
    };
    let mut plant = Plant::new(&machine, &[]);
    plant.place(0.2, 0.0);
    let mut worst = Worst::default();
    let rows = read("throttle.csv");
    for row in &rows {
        worst.see(&plant, row);
        plant.advance(row.input, 1e-3);
    }
    worst.assert_below(1e-7, 1e-4, 1e-5, "throttle.csv");
    let touches = |x: f64| rows.iter().filter(|row| row.position == x).count();
    assert!(touches(0.02) > 10 && touches(1.57) > 10 && touches(0.2) > 10);
}

#[test]
fn position_loop() {
    let machine = Machine::rotary_ema();
    let gains = PidGains {
        proportional: 17.0,
        integral: 60.0,
        derivative: 0.25,
        derivative_time: 3.0e-3,
    };
    let rows = read("pid.csv");
    let mut plant = Plant::new(&machine, &[]);
    let mut replayed = Worst::default();
    let mut pid = Pid::new(gains, 24.0, 1e-3);
    let mut furthest = 0.0_f64;
    for row in &rows {
        replayed.see(&plant, row);
        // The same controller on the reference's positions: it puts out whole microvolts, and
        // half a nanoradian of the file is seen through a gain of kp + kd / (τ + T) = 80 V/rad.
        let input = pid.step(row.command, row.position);
        furthest = furthest.max((input - row.input).abs());
        plant.advance(row.input, 1e-3);
    }
    replayed.assert_below(1e-7, 1e-5, 1e-5, "pid.csv");
    assert!(furthest < 1e-6, "{furthest}");
    assert!(
        rows.iter().any(|row| row.input == 24.0),
        "the output limit is reached"
    );
    assert!(rows.last().unwrap().time == 6.0);
}
