//! The logs in `host-tests/examples`: a gearmotor with an arm on its shaft that no machine file mentions, as a logger
//! wrote them down.
//!
//! ```sh
//! cargo run --release -p rig --example gearmotor -- 1 > host-tests/examples/run-a.csv
//! cargo run --release -p rig --example gearmotor -- 2 > host-tests/examples/run-b.csv
//! ```

use rig::{Coordinate, Effect, Experiment, Machine, Motor, PidGains, Sine, Trajectory};

/// Supply, V.
const SUPPLY: f64 = 12.0;

fn main() {
    let seed = std::env::args().nth(1).and_then(|seed| seed.parse().ok());
    let seed = seed.unwrap_or(1_u64);
    let machine = Machine {
        name: "gearmotor",
        coordinate: Coordinate::Radian,
        motor: Motor::Winding {
            resistance: 2.2,
            inductance: 1.5e-3,
            torque_constant: 0.55,
        },
        input_limit: SUPPLY,
        inertia: 1.8e-3,
        viscous: 1.2e-3,
        coulomb: 0.065,
        static_friction: 0.08,
        spring: None,
        stops: None,
        // 48 counts a turn of the motor, behind a gear of 50.
        resolution: std::f64::consts::TAU / 2400.0,
        gains: PidGains {
            proportional: 12.0,
            integral: 20.0,
            derivative: 0.15,
            derivative_time: 5e-3,
        },
        stroke: (-1.5, 1.5),
        speed: 12.0,
    };
    // The second drive is another one.
    let scale = if seed == 1 { 1.0 } else { 1.27 };
    let sine = |amplitude, frequency: f64, phase| Sine {
        amplitude,
        frequency: scale * frequency,
        phase,
    };
    let trajectory = Trajectory::Sines {
        centre: 0.2,
        components: vec![
            sine(0.9, 0.31, 0.0),
            sine(0.5, 0.83, 1.0),
            sine(0.15, 2.9, 2.0),
        ],
    };
    let mut experiment = Experiment::tracking(machine, trajectory).with_effects(&[
        Effect::LoadDependentFriction { ratio: 0.3 },
        Effect::Gravity {
            torque: 0.12,
            rest: 0.4,
        },
    ]);
    experiment.sample_rate = 500.0;
    experiment.seed = seed;
    let log = experiment.run();
    println!("# gearmotor, drive {seed}");
    println!("t;pos;duty;i");
    for row in 0..log.time.len() {
        println!(
            "{:.0};{:.2};{:.1};{:.0}",
            1e3 * log.time[row],
            log.position[row].to_degrees(),
            100.0 * log.input[row] / SUPPLY,
            1e3 * log.current[row]
        );
    }
}
