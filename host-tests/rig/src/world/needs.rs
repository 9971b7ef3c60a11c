//! What effects need of the machine and of the loop.

use super::dice::{between, log_between};
use super::laws::Law;
use super::machine::{InputKind, Machine, supply};
use super::strength::Effect;
use crate::random::Random;

/// Effects of a winding.
const ELECTRIC: [Effect; 4] = ["supply_sag", "brush_drop", "dead_time", "thermal_drift"];

/// Delays in the order of the effects, s; 0 of those that are none.
pub(super) fn delays(random: &mut Random, effects: &[Effect], period: f64) -> Vec<f64> {
    effects
        .iter()
        .map(|effect| {
            if effect.ends_with("_delay") {
                period * log_between(random, 0.25, 8.0)
            } else {
                0.0
            }
        })
        .collect()
}

/// Gives the machine what an effect needs: a winding, an axis.
pub(super) fn fit_machine(random: &mut Random, machine: &mut Machine, effects: &[Effect]) {
    let needs = |ids: &[Effect]| effects.iter().any(|effect| ids.contains(effect));
    if needs(&ELECTRIC) && machine.input != InputKind::Voltage {
        machine.input = InputKind::Voltage;
        machine.gain = 1.0;
        let emf = between(random, 0.15, 0.3);
        machine.torque *= 1.4;
        machine.limit = supply(random, machine.torque * machine.speed() / emf);
        machine.torque_constant = emf * machine.limit / machine.speed();
        machine.resistance = machine.torque_constant * machine.limit / machine.torque;
        machine.inductance = machine.resistance * 2e-3 * machine.cycle.min(1.0);
    }
    if needs(&["gravity"]) && machine.linear {
        // A linear machine by name alone: the same numbers turn an axis of a few radians.
        let turn = between(random, 0.6, 6.0) / machine.amplitude;
        machine.linear = false;
        turn_into(machine, turn);
    }
    if needs(&["spring", "(cubic_spring)"]) {
        machine.spring = 0.0;
    }
    if needs(&["gravity"]) {
        machine.gravity = 0.0;
    }
}

/// Writes a machine in a coordinate that is `factor` times as large.
fn turn_into(machine: &mut Machine, factor: f64) {
    machine.amplitude *= factor;
    machine.centre *= factor;
    machine.resolution *= factor;
    machine.spring_rest *= factor;
    if let Some((lower, upper)) = &mut machine.stops {
        *lower *= factor;
        *upper *= factor;
    }
    machine.torque_constant /= factor;
    for load in [
        &mut machine.torque,
        &mut machine.coulomb,
        &mut machine.breakaway,
        &mut machine.gravity,
    ] {
        *load /= factor;
    }
    if machine.input != InputKind::Voltage {
        machine.gain /= factor;
    }
    for rate in [
        &mut machine.inertia,
        &mut machine.viscous,
        &mut machine.spring,
    ] {
        *rate /= factor * factor;
    }
}

/// How many times slower a loop has to be for what it cannot feel.
pub(super) fn calm(laws: &[Law], machine: &Machine) -> f64 {
    let mut calm = 1.0;
    for law in laws {
        match law {
            Law::Compliance(joint) | Law::Backlash { joint, .. } => {
                let softest = (joint.stiffness / (machine.inertia * joint.inertia)).sqrt();
                let wanted = 8.0 * machine.speed() / machine.amplitude;
                calm = f64::max(calm, (wanted / (0.2 * softest)).max(1.3));
            }
            Law::EncoderEccentricity { .. } | Law::CrankInertia { .. } => calm = calm.max(1.3),
            _ => {}
        }
    }
    calm
}
