//! Parts of laws that are drawn: ripples, courses, joints.

use std::f64::consts::TAU;

use super::dice::{between, chance, log_between, pick};
use super::laws::Joint;
use super::machine::{Machine, Side};
use super::plant::finest_step;
use super::shapes::{Course, Ripple};
use super::strength::Scene;
use crate::random::Random;

/// A ripple of one to four hundred a turn of the motor, or the same number on a screw.
pub(super) fn fine_ripple(random: &mut Random, scene: &Scene) -> Ripple {
    let machine = scene.machine;
    let turn = if machine.linear {
        // A screw or a pole pair.
        machine.amplitude * log_between(random, 0.1, 2.0)
    } else {
        TAU / machine.gear
    };
    let count = log_between(random, 1.0, 400.0).round();
    // What passes faster than the log's rows at half the top speed is nobody's to find, and what is far
    // finer than the sensor's counts neither.
    let finest = (1.5 * machine.speed() / scene.rate)
        .max(4.0 * machine.resolution)
        .max(0.5 * 50.0 * machine.speed() * finest_step(scene.seconds));
    let mut period = turn / count;
    if period < finest {
        period = turn / (turn / finest).floor().max(1.0);
    }
    let period = period.max(finest);
    ripple(random, period.min(1.5 * machine.amplitude))
}

/// A ripple of a fifth of the stroke to three strokes, or of a turn where that is within.
pub(super) fn coarse_ripple(random: &mut Random, machine: &Machine) -> Ripple {
    let stroke = 2.0 * machine.amplitude;
    let turn = TAU;
    let period = if !machine.linear && turn < 2.0 * stroke && turn > 0.05 * stroke {
        turn
    } else {
        stroke * log_between(random, 0.2, 2.5)
    };
    ripple(random, period)
}

fn ripple(random: &mut Random, period: f64) -> Ripple {
    let harmonics = if chance(random, 0.5) {
        [0.0; 2]
    } else {
        [between(random, 0.0, 0.4), between(random, 0.0, 0.3)]
    };
    Ripple {
        period,
        phase: between(random, 0.0, TAU),
        harmonics,
    }
}

pub(super) fn course(random: &mut Random, scene: &Scene) -> Course {
    let seconds = scene.seconds;
    match pick(random, &[0, 0, 1, 2]) {
        0 => {
            let duration = seconds * between(random, 0.08, 0.4);
            Course::Pulse {
                begin: between(random, 0.05 * seconds, 0.95 * seconds - duration),
                duration,
                edge: 0.02 * duration,
            }
        }
        1 => Course::Periodic {
            period: seconds / between(random, 1.5, 6.0),
            phase: random.uniform(),
        },
        _ => {
            let begin = seconds * between(random, 0.0, 0.5);
            Course::Ramp {
                begin,
                end: begin + seconds * between(random, 0.2, 0.5),
            }
        }
    }
}

/// What is behind a gap, whose contact is stiff, or behind an elastic shaft, which swings.
pub(super) fn joint(random: &mut Random, scene: &Scene, contact: bool) -> Joint {
    let machine = scene.machine;
    let inertia = between(random, 0.05, 0.75);
    let both = machine.inertia * inertia * (1.0 - inertia);
    // Angular frequency of the two masses against each other: within what the log shows and the plant resolves.
    let fastest = 0.15 / finest_step(scene.seconds);
    let motion = TAU / machine.cycle;
    let rate = if contact {
        (600.0 * motion).max(TAU * scene.rate / 3.0)
    } else {
        log_between(
            random,
            12.0 * motion,
            (0.15 * TAU * scene.rate).max(24.0 * motion),
        )
    };
    let rate = rate.min(fastest);
    let stiffness = both * rate * rate;
    let ratio = if contact {
        between(random, 0.2, 0.8)
    } else {
        log_between(random, 0.01, 0.2)
    };
    Joint {
        stiffness,
        damping: 2.0 * ratio * (stiffness * both).sqrt(),
        inertia,
        friction: if chance(random, 0.3) {
            0.0
        } else {
            between(random, 0.05, 0.6)
        },
        sensor: if chance(random, 0.5) {
            Side::Load
        } else {
            Side::Motor
        },
    }
}
