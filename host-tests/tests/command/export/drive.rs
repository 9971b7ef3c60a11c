//! Machines with effects, as the rig has them and as a machine file declares them, and an input that shows both.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use rig::{Effect, Machine, Motor, Plant, ReturnSpring};

/// Rows a second.
pub const RATE: f64 = 1000.0;

/// Rows of a drive.
pub const ROWS: usize = 3000;

/// A machine, what the rig adds to it, and the line that declares the same.
pub struct Case {
    pub name: &'static str,
    pub machine: Machine,
    pub effects: Vec<Effect>,
    pub declared: &'static str,
    /// Where it starts.
    pub start: f64,
}

fn case(name: &'static str, machine: Machine, effects: &[Effect], declared: &'static str) -> Case {
    let start = machine.spring.map_or(0.0, |spring| spring.rest);
    Case {
        name,
        machine,
        effects: effects.to_vec(),
        declared,
        start,
    }
}

/// The rotary actuator with breakaway at the Coulomb level, where the rig's laws of both are those of the catalogue.
fn level() -> Machine {
    let machine = Machine::rotary_ema();
    Machine {
        static_friction: machine.coulomb,
        ..machine
    }
}

/// Machines as they are, and with effects that the rig has the catalogue's law of.
pub fn cases() -> Vec<Case> {
    bare().into_iter().chain(with_effects()).collect()
}

fn bare() -> Vec<Case> {
    let ema = Machine::rotary_ema;
    let quick = Machine {
        motor: Motor::Winding {
            resistance: 1.0,
            inductance: 0.0,
            torque_constant: 0.06,
        },
        ..ema()
    };
    let sprung = Machine {
        spring: Some(ReturnSpring {
            stiffness: 0.02,
            rest: 0.3,
            preload: 0.05,
        }),
        ..ema()
    };
    vec![
        case("ema", ema(), &[], ""),
        case("ema without inductance", quick, &[], ""),
        case("ema with a limp-home spring", sprung, &[], ""),
        case("throttle", Machine::throttle(), &[], ""),
        case("swirl flap", Machine::swirl_flap(), &[], ""),
        case("slide", Machine::force_slide(), &[], ""),
    ]
}

/// Viscous friction that is 1e-4 N·m·s/rad more forward and as much less backward.
const ONE_SIDED: Effect = Effect::AsymmetricViscous {
    forward: 1e-4,
    backward: -1e-4,
};

fn with_effects() -> Vec<Case> {
    let ema = Machine::rotary_ema;
    vec![
        case(
            "offset and drag",
            ema(),
            &[
                Effect::OffsetTorque { torque: 0.02 },
                Effect::QuadraticDrag { coefficient: 2e-6 },
            ],
            "{ id = \"offset_torque\", torque = 0.02 }, { id = \"quadratic_drag\", coefficient = 2e-6 }",
        ),
        case(
            "asymmetric friction",
            level(),
            &[Effect::AsymmetricCoulomb { ratio: 0.25 }, ONE_SIDED],
            "{ id = \"asymmetric_coulomb\", difference = 0.03 }, { id = \"asymmetric_viscous\", difference = 1e-4 }",
        ),
        case(
            "Stribeck and gravity",
            ema(),
            &[
                Effect::Stribeck {
                    drop: 0.04,
                    speed: 5.0,
                },
                Effect::Gravity {
                    torque: 0.05,
                    rest: 0.0,
                },
            ],
            "{ id = \"stribeck\", drop = 0.04, velocity = 5.0 }, { id = \"gravity\", sine = 0.05, cosine = 0.0 }",
        ),
        case(
            "spring and cogging",
            ema(),
            &[
                Effect::Spring {
                    stiffness: 0.01,
                    rest: 0.5,
                },
                Effect::Cogging {
                    amplitude: 0.03,
                    period: 0.8,
                    phase: 0.0,
                },
            ],
            "{ id = \"spring\", stiffness = 0.01, torque = 0.005 }, { id = \"cogging\", sine = 0.03, cosine = 0.0, period = 0.8 }",
        ),
        case(
            "friction by load and time",
            ema(),
            &[
                Effect::FrictionDrift { rate: 0.1 },
                Effect::LoadDependentFriction { ratio: 0.12 },
            ],
            "{ id = \"friction_drift\", rate = 0.1 }, { id = \"load_dependent_friction\", share = 0.12 }",
        ),
        case(
            "friction by place",
            level(),
            &[Effect::PositionDependentFriction {
                ratio: 0.25,
                period: 4.0,
                phase: 0.0,
            }],
            "{ id = \"position_dependent_friction\", sine = 0.03, cosine = 0.0, period = 4.0 }",
        ),
        case(
            "saturation",
            ema(),
            &[Effect::TorqueSaturation { fall: 0.5 }],
            "{ id = \"torque_saturation\", fall = 0.5 }",
        ),
    ]
}

impl Case {
    /// Its machine file.
    pub fn toml(&self) -> String {
        format!(
            "{}declared_effects = [{}]\n",
            self.machine.to_toml(),
            self.declared
        )
    }

    /// Its input, row by row: slow and fast, to both sides, and nothing at all for a while.
    pub fn input(&self) -> Vec<f64> {
        let limit = self.machine.input_limit;
        let at = |row: usize| {
            let time = row as f64 / RATE;
            match time {
                0.9..1.1 => 0.0,
                _ => limit * (0.35 * (5.0 * time).sin() + 0.2 * (23.0 * time + 1.0).sin()),
            }
        };
        (0..ROWS).map(at).collect()
    }

    /// Positions behind each row, by the rig in steps of `step`.
    pub fn played(&self, step: f64) -> Vec<f64> {
        let mut plant = Plant::new(&self.machine, &self.effects).with_step(step);
        plant.place(self.start, 0.0);
        let input = self.input();
        let rows = input.iter().map(|&input| {
            plant.advance(input, 1.0 / RATE);
            plant.state().position
        });
        rows.collect()
    }
}

/// `cargo hil export` of this machine file to a target.
pub fn export(directory: &Path, toml: &str, arguments: &[&str]) -> Output {
    fs::write(directory.join("machine.toml"), toml).unwrap();
    Command::new(env!("CARGO_BIN_EXE_hil"))
        .current_dir(directory)
        .args(["export", "--machine", "machine.toml", "--to"])
        .args(arguments)
        .output()
        .unwrap()
}

pub fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

/// Position, current and reading behind each row, as a simulation prints them.
pub fn columns(printed: &[u8]) -> [Vec<f64>; 3] {
    let mut columns = [const { Vec::new() }; 3];
    for line in text(printed).lines() {
        for (column, field) in columns.iter_mut().zip(line.split(' ')) {
            column.push(field.parse().unwrap());
        }
    }
    columns
}

/// The largest distance of two series.
pub fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

/// The way that a series covers.
pub fn travel(positions: &[f64]) -> f64 {
    let low = positions.iter().copied().fold(f64::INFINITY, f64::min);
    let high = positions.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    high - low
}
