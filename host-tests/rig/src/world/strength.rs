//! Which effects a world has, in which law, and how strong: from barely visible to dominant.

use std::f64::consts::TAU;

use super::dice::{between, chance, log_between, pick, sign};
use super::draw::Kind;
use super::laws::Law;
use super::machine::{InputKind, Machine};
use super::parts::{coarse_ripple, course, fine_ripple, joint};
use super::plant::finest_step;
use super::shapes::{Along, Fall, Saturation};
use crate::random::Random;

/// An effect of the catalogue by its id, or a law outside it by its name in parentheses.
pub(super) type Effect = &'static str;

/// Every effect of the catalogue.
pub const CATALOGUE: [Effect; 23] = [
    "stribeck",
    "asymmetric_coulomb",
    "asymmetric_viscous",
    "load_dependent_friction",
    "position_dependent_friction",
    "friction_drift",
    "presliding",
    "quadratic_drag",
    "offset_torque",
    "spring",
    "gravity",
    "cogging",
    "external_load",
    "supply_sag",
    "brush_drop",
    "dead_time",
    "torque_saturation",
    "thermal_drift",
    "input_delay",
    "sensor_delay",
    "encoder_eccentricity",
    "backlash",
    "compliance",
];

/// Every law outside it.
pub const OUTSIDE: [Effect; 7] = [
    "(hysteresis)",
    "(cubic_spring)",
    "(current_limit)",
    "(crank_inertia)",
    "(rough_spot)",
    "(speed_band)",
    "(warm_up)",
];

/// What the strength of an effect is drawn for.
pub(super) struct Scene<'a> {
    pub machine: &'a Machine,
    /// Length of the log, s.
    pub seconds: f64,
    /// Rows a second, Hz.
    pub rate: f64,
    /// What was drawn for a delay, s.
    pub delay: f64,
    /// Whether nothing else is there.
    pub alone: bool,
}

/// What a world of a kind has.
pub(super) fn kinds(random: &mut Random, kind: Kind) -> Vec<Effect> {
    match kind {
        Kind::OneEffect => vec![pick(random, &CATALOGUE)],
        Kind::TwoEffects => {
            let first = pick(random, &CATALOGUE);
            loop {
                let second = pick(random, &CATALOGUE);
                // One joint, one memory of friction at most.
                let joint = |id: Effect| ["backlash", "compliance", "presliding"].contains(&id);
                let constant = |id: Effect| ["offset_torque", "asymmetric_coulomb"].contains(&id);
                let same = |is: &dyn Fn(Effect) -> bool| is(first) && is(second);
                if second != first && !same(&joint) && !same(&constant) {
                    return vec![first, second];
                }
            }
        }
        Kind::Outside => vec![pick(random, &OUTSIDE)],
        Kind::None | Kind::NoneWithSins | Kind::Misdeclared => Vec::new(),
    }
}

/// An effect in one of its laws.
pub(super) fn draw(random: &mut Random, effect: Effect, scene: &Scene) -> Law {
    let machine = scene.machine;
    let friction = machine.coulomb;
    // What the motor fights in an ordinary motion.
    let usual = friction + 0.15 * machine.torque;
    // Of two, neither hides behind the other.
    let strength = log_between(random, if scene.alone { 0.1 } else { 0.25 }, 1.3);
    match effect {
        "stribeck"
        | "asymmetric_coulomb"
        | "asymmetric_viscous"
        | "load_dependent_friction"
        | "position_dependent_friction"
        | "friction_drift"
        | "presliding"
        | "quadratic_drag" => of_friction(random, effect, scene, strength),
        "supply_sag" | "brush_drop" | "dead_time" | "torque_saturation" | "thermal_drift" => {
            of_motor(random, effect, scene, strength)
        }
        "offset_torque" => Law::OffsetTorque {
            torque: sign(random) * 0.5 * strength * usual,
        },
        "spring" => Law::Spring {
            stiffness: 0.7 * strength * usual / machine.amplitude,
            rest: machine.centre + machine.amplitude * between(random, -0.8, 0.8),
        },
        "gravity" => Law::Gravity {
            torque: 0.7 * strength * usual,
            rest: between(random, -3.1, 3.1),
        },
        "cogging" => Law::Cogging {
            amplitude: 0.5 * strength * usual,
            ripple: fine_ripple(random, scene),
        },
        "external_load" => Law::ExternalLoad {
            torque: sign(random) * 0.8 * strength.max(0.15) * usual,
            course: course(random, scene),
        },
        "input_delay" => Law::InputDelay {
            seconds: scene.delay,
        },
        "sensor_delay" => Law::SensorDelay {
            seconds: scene.delay,
        },
        "encoder_eccentricity" => {
            let ripple = coarse_ripple(random, machine);
            // No reading that runs backwards.
            let most = 0.1 * ripple.period / TAU;
            Law::EncoderEccentricity {
                amplitude: (most * strength)
                    .max(1.5 * machine.resolution)
                    .min(3.0 * most),
                ripple,
            }
        }
        "backlash" => Law::Backlash {
            width: (0.06 * strength * machine.amplitude).max(2.5 * machine.resolution),
            joint: joint(random, scene, true),
        },
        "compliance" => Law::Compliance(joint(random, scene, false)),
        _ => of_outside(random, effect, scene, strength),
    }
}

fn of_friction(random: &mut Random, effect: Effect, scene: &Scene, strength: f64) -> Law {
    let machine = scene.machine;
    let friction = machine.coulomb;
    let usual = friction + machine.viscous * machine.speed();
    match effect {
        "stribeck" => Law::Stribeck {
            fall: pick(random, &[Fall::Exponential, Fall::Gaussian, Fall::Rational]),
            drop: (machine.breakaway - friction) + friction * 1.2 * strength,
            speed: machine.speed() * log_between(random, 0.02, 0.3),
        },
        "asymmetric_coulomb" => Law::AsymmetricCoulomb {
            difference: sign(random) * 0.6 * strength * friction,
        },
        "asymmetric_viscous" => {
            let more = strength * usual / machine.speed();
            let (forward, backward) = if chance(random, 0.5) {
                (more, 0.0)
            } else {
                (0.0, more)
            };
            Law::AsymmetricViscous { forward, backward }
        }
        "load_dependent_friction" => Law::LoadDependentFriction {
            share: 0.45 * strength,
            preload: if chance(random, 0.6) {
                0.0
            } else {
                machine.torque * between(random, 0.02, 0.2)
            },
        },
        "position_dependent_friction" => along_the_stroke(random, machine, strength),
        "friction_drift" => {
            let change = if chance(random, 0.5) {
                1.5 * strength
            } else {
                -0.7 * strength
            };
            Law::FrictionDrift {
                rate: change / scene.seconds,
                viscous: chance(random, 0.4),
            }
        }
        "presliding" => {
            let bend = machine.amplitude * 0.04 * strength;
            // Not stiffer than the plant resolves.
            let stiffest = machine.inertia * (0.1 / finest_step(scene.seconds)).powi(2);
            let stiffness = (friction / bend.max(2.0 * machine.resolution)).min(stiffest);
            let critical = 2.0 * (stiffness * machine.inertia).sqrt();
            Law::Presliding {
                stiffness,
                damping: critical * pick(random, &[0.05, 0.3, 0.5, 1.0]),
                speed: machine.speed() * log_between(random, 0.005, 0.1),
            }
        }
        _ => Law::QuadraticDrag {
            torque: strength * usual,
            speed: machine.speed(),
            exponent: pick(random, &[2.0, 2.0, 1.75]),
        },
    }
}

/// Friction that varies with the position: added, multiplied, or tight at one end.
fn along_the_stroke(random: &mut Random, machine: &Machine, strength: f64) -> Law {
    let ripple = coarse_ripple(random, machine);
    let along = pick(
        random,
        &[
            Along::Added(ripple),
            Along::Multiplied(ripple),
            Along::Slope {
                centre: machine.centre,
                reach: machine.amplitude,
            },
        ],
    );
    let share = 0.9 * strength * sign(random);
    let level = if matches!(along, Along::Multiplied(_)) {
        share
    } else {
        share * machine.coulomb
    };
    Law::PositionDependentFriction { level, along }
}

fn of_motor(random: &mut Random, effect: Effect, scene: &Scene, strength: f64) -> Law {
    let machine = scene.machine;
    let stall = machine.limit / machine.resistance.max(1e-300);
    // Current of an ordinary motion.
    let load = machine.coulomb + 0.2 * machine.torque;
    let current = load / machine.torque_constant.max(1e-300);
    let knee = stall * log_between(random, 2e-3, 2e-2);
    match effect {
        "supply_sag" => Law::SupplySag {
            resistance: machine.resistance * 1.2 * strength,
            voltage: machine.limit,
            lag: if chance(random, 0.5) {
                0.0
            } else {
                (10.0 * finest_step(scene.seconds))
                    .max(machine.cycle * log_between(random, 1e-3, 1e-2))
            },
        },
        "brush_drop" => Law::BrushDrop {
            volts: machine.limit * 0.12 * strength,
            knee,
        },
        "dead_time" => Law::DeadTime {
            volts: machine.limit * 0.12 * strength,
            knee,
        },
        "torque_saturation" => Law::TorqueSaturation {
            law: pick(
                random,
                &[Saturation::Froelich, Saturation::Tangent, Saturation::Root],
            ),
            level: load / (0.12 + 1.3 * strength),
            emf: machine.input == InputKind::Voltage && chance(random, 0.5),
        },
        _ => {
            let winding = scene.seconds * log_between(random, 0.25, 3.0);
            // What is reached in the end of the log, under the usual current.
            let risen = 1.0 - (-scene.seconds / winding).exp();
            Law::ThermalDrift {
                rate: 0.7 * strength / (current.powi(2) * winding * risen),
                winding,
                growing: chance(random, 0.5),
            }
        }
    }
}

fn of_outside(random: &mut Random, effect: Effect, scene: &Scene, strength: f64) -> Law {
    let machine = scene.machine;
    let usual = machine.coulomb + 0.15 * machine.torque;
    let strength = 0.25 + 0.75 * strength;
    let place = machine.centre + machine.amplitude * between(random, -0.5, 0.5);
    match effect {
        "(hysteresis)" => Law::Hysteresis {
            torque: strength * usual,
            reach: machine.amplitude * log_between(random, 0.08, 0.4),
        },
        "(cubic_spring)" => Law::CubicSpring {
            torque: 1.2 * strength * usual,
            reach: machine.amplitude,
            rest: machine.centre + machine.amplitude * between(random, -0.3, 0.3),
        },
        "(current_limit)" => Law::CurrentLimit {
            torque: machine.coulomb
                + (machine.torque - machine.coulomb) * between(random, 0.08, 0.4),
        },
        "(crank_inertia)" => Law::CrankInertia {
            share: 0.7 * strength,
            period: machine.amplitude * between(random, 0.8, 3.0),
            phase: between(random, 0.0, TAU),
        },
        "(rough_spot)" => Law::RoughSpot {
            torque: 1.2 * strength * machine.coulomb,
            centre: place,
            width: machine.amplitude * between(random, 0.04, 0.2),
        },
        "(speed_band)" => Law::SpeedBand {
            torque: 1.2 * strength * machine.coulomb,
            centre: machine.speed() * between(random, 0.2, 0.6),
            width: machine.speed() * between(random, 0.04, 0.12),
        },
        _ => Law::WarmUp {
            share: 0.7 * strength,
            seconds: scene.seconds * between(random, 0.08, 0.35),
        },
    }
}
