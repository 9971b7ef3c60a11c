//! What the machine file of a world says.

use super::dice::{between, chance, log_between, pick};
use super::draw::Kind;
use super::laws::Law;
use super::machine::{Declaration, InputKind, Machine, Side};
use crate::random::Random;

/// What the machine file says: numbers of `[fit]` at half to twice the truth, the others as they are, but
/// for one of a misdeclared world.
pub(super) fn declaration(
    random: &mut Random,
    kind: Kind,
    machine: &Machine,
    laws: &[Law],
) -> Declaration {
    let mut fit = vec!["inertia", "viscous", "coulomb", "static"];
    if chance(random, 0.15) {
        let place = (random.uniform() * 3.99) as usize;
        fit.remove(place.min(3));
    }
    let winding = machine.input == InputKind::Voltage;
    if winding && chance(random, 0.15) {
        fit.push("resistance");
    }
    if winding && chance(random, 0.15) {
        fit.push("torque_constant");
    }
    if machine.spring > 0.0 && chance(random, 0.3) {
        fit.push("spring");
    }
    let mut factors = Vec::new();
    if kind == Kind::Misdeclared {
        let wrong = wrong_number(random, machine);
        fit.retain(|name| *name != wrong);
        if wrong == "coulomb" && !fit.contains(&"static") {
            // Else the file could not say it.
            fit.push("static");
        }
        let size = between(random, 0.15, 0.6);
        let factor = if chance(random, 0.5) {
            1.0 + size
        } else {
            1.0 - size
        };
        factors.push((wrong, factor));
    }
    for &name in &fit {
        factors.push((name, log_between(random, 0.5, 2.0)));
    }
    keep_order(&mut factors, machine);
    let joint = laws.iter().find_map(Law::joint);
    Declaration {
        fit,
        factors,
        resolution: chance(random, 0.8),
        side: joint.map(|(joint, _)| -> Side { joint.sensor }),
    }
}

/// The same with other guesses for what `[fit]` names: each a third of to three times the truth.
pub(super) fn guessed(
    random: &mut Random,
    machine: &Machine,
    declaration: &Declaration,
) -> Declaration {
    let mut guessed = declaration.clone();
    for (name, factor) in &mut guessed.factors {
        if declaration.fit.contains(name) {
            *factor = log_between(random, 1.0 / 3.0, 3.0);
        }
    }
    keep_order(&mut guessed.factors, machine);
    guessed
}

/// Keeps the declared breakaway level from falling below the Coulomb level, which no file may say: of the two
/// the one that is fitted gives way.
fn keep_order(factors: &mut [(&'static str, f64)], machine: &Machine) {
    let ratio = machine.breakaway / machine.coulomb;
    let of = |factors: &[(&str, f64)], wanted: &str| {
        let known = factors.iter().find(|(name, _)| *name == wanted);
        known.map_or(1.0, |(_, factor)| *factor)
    };
    let (coulomb, breakaway) = (of(factors, "coulomb"), of(factors, "static"));
    if coulomb > breakaway * ratio {
        for (name, factor) in factors {
            match *name {
                "static" => *factor = coulomb / ratio * (1.0 + 1e-9),
                "coulomb" if breakaway == 1.0 => *factor = ratio,
                _ => {}
            }
        }
    }
}

/// A number that matters.
fn wrong_number(random: &mut Random, machine: &Machine) -> &'static str {
    let mut names = vec!["inertia", "coulomb"];
    if machine.input == InputKind::Voltage {
        names.extend([
            "resistance",
            "resistance",
            "torque_constant",
            "torque_constant",
        ]);
    }
    if machine.spring > 0.0 {
        names.push("spring");
    }
    if machine.gravity > 0.0 {
        names.push("gravity_torque");
    }
    pick(random, &names)
}
