//! Machines whose laws no rig has, in explicit steps: a PID moves them over sines, and a logger takes down every row.

use std::f64::consts::PI;
use std::path::Path;

use host_tests::log::Log;
use host_tests::machine::Machine;

/// What moves, and how it is driven. SI units.
pub struct Stepped<const WAVES: usize> {
    pub inertia: f64,
    pub viscous: f64,
    pub coulomb: f64,
    /// What friction holds at rest.
    pub breakaway: f64,
    /// A count of the encoder.
    pub count: f64,
    /// A row's time, and the steps in it.
    pub period: f64,
    pub steps: usize,
    pub rows: usize,
    /// Frequencies and amplitudes of the sines.
    pub frequencies: [f64; WAVES],
    pub amplitudes: [f64; WAVES],
    /// Gains of the PID: of the error, of its integral, of its rate; and the largest input.
    pub gains: [f64; 3],
    pub limit: f64,
}

/// A geared motor in steps of 0.1 ms; friction and inertia at its shaft.
pub const GEARMOTOR: Stepped<4> = Stepped {
    inertia: 0.09,
    viscous: 0.02,
    coulomb: 0.34,
    breakaway: 0.40,
    count: 2.0 * PI / 56_000.0,
    period: 0.002,
    steps: 20,
    rows: 6000,
    frequencies: [0.15, 0.37, 0.81, 1.43],
    amplitudes: [0.55, 0.4, 0.3, 0.25],
    gains: [40.0, 30.0, 0.8],
    limit: 24.0,
};

/// A geared motor as a machine file has it, its friction and inertia not quite those of [`GEARMOTOR`]. `motor`: resistance,
/// inductance and torque constant; `sensor`: the lines of `[sensor]`; `fit`: what is fitted beside the mechanics.
pub fn gearmotor(motor: [f64; 3], sensor: &str, fit: &str) -> Machine {
    let [resistance, inductance, torque_constant] = motor;
    let text = format!(
        r#"
name = "gearmotor"
coordinate = "rad"
[input]
kind = "voltage"
gain = 1.0
[motor]
resistance = {resistance}
inductance = {inductance}
torque_constant = {torque_constant}
[mechanics]
inertia = 0.08
viscous = 0.02
[friction]
coulomb = 0.3
static = 0.35
[sensor]
{sensor}
[fit]
parameters = [{fit}"inertia", "viscous", "coulomb", "static"]
declared_effects = []
"#
    );
    Machine::of_bytes(Path::new("gearmotor.toml"), text.into()).unwrap()
}

/// A machine that a torque drives, as a machine file has it. `mechanics`: inertia and viscous friction; `friction`: Coulomb
/// and breakaway level; `fit`: the names of what is fitted.
pub fn torque_driven(
    mechanics: [f64; 2],
    friction: [f64; 2],
    resolution: f64,
    fit: &[&str],
) -> Machine {
    let [inertia, viscous] = mechanics;
    let [coulomb, breakaway] = friction;
    let text = format!(
        r#"
name = "torque-driven"
coordinate = "rad"
[input]
kind = "torque"
gain = 1.0
[mechanics]
inertia = {inertia:e}
viscous = {viscous:e}
[friction]
coulomb = {coulomb:e}
static = {breakaway:e}
[sensor]
resolution = {resolution:e}
[fit]
parameters = {fit:?}
declared_effects = []
"#
    );
    Machine::of_bytes(Path::new("torque-driven.toml"), text.into()).unwrap()
}

/// The line of a machine file that says what a count of [`GEARMOTOR`]'s encoder is.
pub const COUNTS: &str = "resolution = 1.122e-4";

impl<const WAVES: usize> Stepped<WAVES> {
    /// Length of a step.
    pub fn step(&self) -> f64 {
        self.period / self.steps as f64
    }

    /// Inputs and measured positions, row by row. `torque`: that at the machine but for friction, of the row's input, the
    /// position and the velocity, asked once a step.
    pub fn drive(
        &self,
        phases: [f64; WAVES],
        mut torque: impl FnMut(f64, f64, f64) -> f64,
    ) -> (Vec<f64>, Vec<f64>) {
        let step = self.step();
        let (mut position, mut velocity) = (0.0_f64, 0.0_f64);
        let (mut integral, mut last) = (0.0, 0.0);
        let (mut input, mut positions) = (Vec::new(), Vec::new());
        for row in 0..self.rows {
            let time = row as f64 * self.period;
            let wave = |(place, phase): (usize, &f64)| {
                self.amplitudes[place] * (2.0 * PI * self.frequencies[place] * time + phase).sin()
            };
            let command: f64 = phases.iter().enumerate().map(wave).sum();
            let measured = (position / self.count).round() * self.count;
            let error = command - measured;
            integral += error * self.period;
            let [of_error, of_integral, of_rate] = self.gains;
            let rate = of_rate * (error - last) / self.period;
            let told = of_error * error + of_integral * integral + rate;
            last = error;
            let acting = told.clamp(-self.limit, self.limit);
            input.push(acting);
            positions.push(measured);
            for _ in 0..self.steps {
                let torque = torque(acting, position, velocity);
                if velocity == 0.0 && torque.abs() < self.breakaway {
                    continue;
                }
                let direction = if velocity == 0.0 { torque } else { velocity }.signum();
                let friction = self.viscous * velocity;
                let left = torque - friction - self.coulomb * direction;
                let moved = velocity + step * left / self.inertia;
                let stops = velocity * moved < 0.0 && torque.abs() < self.breakaway;
                velocity = if stops { 0.0 } else { moved };
                position += step * velocity;
            }
        }
        (input, positions)
    }

    /// As [`Stepped::drive`], as a log without a current.
    pub fn log_of_position(
        &self,
        path: &str,
        phases: [f64; WAVES],
        torque: impl FnMut(f64, f64, f64) -> f64,
    ) -> Log {
        let (input, position) = self.drive(phases, torque);
        Log {
            path: path.into(),
            period_s: self.period,
            input,
            position,
            ..Log::default()
        }
    }

    /// As [`Stepped::drive`], with the current as it was so many steps before each row. `acts`: the torque, and the current
    /// that flows behind the step.
    pub fn log(
        &self,
        path: &str,
        phases: [f64; WAVES],
        late: usize,
        mut acts: impl FnMut(f64, f64, f64) -> (f64, f64),
    ) -> Log {
        // A row has what flows as it begins.
        let mut amperes = vec![0.0; 1 + late];
        let torque = |input: f64, position: f64, velocity: f64| {
            let (torque, flow) = acts(input, position, velocity);
            amperes.push(flow);
            torque
        };
        let log = self.log_of_position(path, phases, torque);
        let current = amperes.into_iter().step_by(self.steps).take(self.rows);
        Log {
            current: Some(current.collect()),
            ..log
        }
    }
}
