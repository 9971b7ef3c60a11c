//! A motor whose numbers are wrong in the machine file is refitted, whether `[fit]` names them or not, and
//! not called an effect.

use host_tests::gap::engine;
use host_tests::gap::outcome::{FreeMotor, Outcome, Report};
use host_tests::gap_benchmark::cases::{Case, Group, Motion};
use host_tests::machine::Machine;
use model_core::gap::verdict::Verdict;
use rig::{Effect, EffectKind, Motor};
use std::fs;
use std::ops::Range;

/// Numbers of the motor for `[fit]`.
const MOTOR: &str = "\"resistance\", \"torque_constant\", ";

/// What is found in a log of a machine with the one that is declared, whose `[fit]` has these numbers besides.
fn trace(
    machines: (rig::Machine, &rig::Machine),
    effects: Vec<Effect>,
    seed: u64,
    fit: &str,
) -> Outcome {
    report(machines, effects, seed, fit).outcome
}

fn report(
    (rig, declared): (rig::Machine, &rig::Machine),
    effects: Vec<Effect>,
    seed: u64,
    fit: &str,
) -> Report {
    let case = Case {
        group: Group::WrongNumbers,
        rig,
        declared: None,
        effects,
        strength: 1.0,
        motion: Motion::Sines,
        seed,
    };
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("machine.toml");
    let text = declared.to_toml();
    assert_eq!(text.matches("parameters = [").count(), 1, "{text}");
    let listed = format!("parameters = [{fit}");
    fs::write(&path, text.replace("parameters = [", &listed)).unwrap();
    let machine = Machine::read(&path).unwrap();
    engine::run(&machine, &[case.log()], || Ok(Vec::new()), |_| ()).unwrap()
}

/// The machine with another motor, as shares of its own.
fn with_motor(rig: &rig::Machine, resistance: f64, torque_constant: f64) -> rig::Machine {
    let mut changed = rig.clone();
    let Motor::Winding {
        resistance: own,
        torque_constant: constant,
        ..
    } = &mut changed.motor
    else {
        panic!("{} has no winding", rig.name);
    };
    *own *= resistance;
    *constant *= torque_constant;
    changed
}

/// How a fitted number compares with its declared one.
fn change(outcome: &Outcome, name: &str) -> Option<f64> {
    let fitted = outcome.fit.iter().find(|fit| fit.name == name)?;
    Some(fitted.fitted / fitted.declared)
}

fn a_wrong_motor_is_refitted(seeds: Range<u64>) {
    let declared = rig::Machine::rotary_ema();
    for seed in seeds {
        let rig = with_motor(&declared, 1.2, 0.9);
        let outcome = trace((rig, &declared), Vec::new(), seed, MOTOR);
        assert_eq!(outcome.verdict, Verdict::NoMissingEffect, "{outcome:?}");
        assert!((change(&outcome, "resistance").unwrap() - 1.2).abs() < 0.01);
        assert!((change(&outcome, "torque_constant").unwrap() - 0.9).abs() < 0.02);
        assert_eq!(outcome.freed().count(), 0);
    }
}

#[test]
fn a_wrong_motor_is_refitted_where_it_may_be() {
    a_wrong_motor_is_refitted(72_800..72_801);
}

#[test]
#[ignore = "other cases"]
fn a_wrong_motor_is_refitted_from_other_logs() {
    a_wrong_motor_is_refitted(72_801..72_804);
}

/// Of each machine one motor in five, from one to the other another, or the others.
fn a_wrong_motor_is_no_effect(at_length: bool) {
    let machines = [rig::Machine::rotary_ema(), rig::Machine::throttle()];
    for (machine, declared) in machines.iter().enumerate() {
        for (case, motor) in [(1.2, 1.0), (0.85, 1.0), (1.0, 0.9), (1.2, 0.9), (0.9, 1.15)]
            .into_iter()
            .enumerate()
        {
            if at_length == (case == 3 * machine) {
                continue;
            }
            let (resistance, torque_constant) = motor;
            let seed = 72_820 + 10 * machine as u64 + case as u64;
            let rig = with_motor(declared, resistance, torque_constant);
            let outcome = trace((rig, declared), Vec::new(), seed, "");
            let said = format!("{} {motor:?}: {outcome:?}", declared.name);
            assert_eq!(outcome.verdict, Verdict::NoMissingEffect, "{said}");
            for (name, expected) in [
                ("resistance", resistance),
                ("torque_constant", torque_constant),
            ] {
                // What is right is left alone.
                let is_freed = outcome.freed().any(|freed| freed == name);
                assert_eq!(is_freed, expected != 1.0, "{name} of {said}");
                if is_freed {
                    let change = change(&outcome, name).unwrap();
                    assert!((change - expected).abs() < 0.02, "{name} of {said}");
                }
            }
            // Later rounds, which find nothing more to free, leave that look as it was.
            let mut looks = outcome.candidates.iter();
            let numbers = looks.find(|look| look.id == "numbers").unwrap();
            assert!(numbers.accepted, "{said}");
            let train = &outcome.errors.train;
            assert!(
                train.after.position_rms < train.before.position_rms,
                "{said}"
            );
        }
    }
}

#[test]
fn a_wrong_motor_is_no_effect_though_it_is_not_to_be_fitted() {
    a_wrong_motor_is_no_effect(false);
}

#[test]
#[ignore = "other cases"]
fn other_wrong_motors_are_no_effect_though_they_are_not_to_be_fitted() {
    a_wrong_motor_is_no_effect(true);
}

#[test]
fn an_effect_and_a_wrong_motor_are_told_apart() {
    let declared = rig::Machine::throttle();
    let rig = with_motor(&declared, 1.2, 1.0);
    let cogging = Effect::nominal(EffectKind::Cogging, &rig);
    let outcome = trace((rig, &declared), vec![cogging], 72_850, "");
    let named: Vec<&str> = outcome.effects.iter().map(|found| &*found.id).collect();
    assert_eq!(named, ["cogging"], "{outcome:?}");
    assert_eq!(outcome.freed().collect::<Vec<_>>(), ["resistance"]);
    assert!((change(&outcome, "resistance").unwrap() - 1.2).abs() < 0.02);
}

#[test]
fn else_what_may_be_the_motor_says_so() {
    let rig = rig::Machine::rotary_ema();
    let brushes = Effect::nominal(EffectKind::BrushDrop, &rig);
    for (fit, presumed) in [("", &["resistance", "torque_constant"][..]), (MOTOR, &[])] {
        let report = report((rig.clone(), &rig), vec![brushes], 72_810, fit);
        let outcome = report.outcome;
        let [found] = &outcome.effects[..] else {
            panic!("{outcome:?}");
        };
        // The line to put into the file frees both.
        let free = report.free_motor;
        assert_eq!(free.is_some(), fit.is_empty(), "{free:?}");
        if let Some(FreeMotor { fixed, line }) = free {
            assert_eq!(fixed, ["resistance", "torque_constant"]);
            let lines = rig.to_toml();
            let lines = lines
                .lines()
                .map(|old| match old.starts_with("parameters = [") {
                    true => line.as_str(),
                    false => old,
                });
            let text = lines.collect::<Vec<_>>().join("\n");
            let freed = Machine::of_bytes("machine.toml".as_ref(), text.into_bytes()).unwrap();
            let declared = Machine::of_bytes("machine.toml".as_ref(), rig.to_toml().into_bytes());
            let mut expected = declared.unwrap().fit;
            expected.extend(["resistance", "torque_constant"].map(str::to_owned));
            assert_eq!(freed.fit, expected);
        }
        // In most motions the bridge's dead time takes the same voltage.
        let set: Vec<&str> = [&found.id]
            .into_iter()
            .chain(&found.equivalent)
            .map(|id| &**id)
            .collect();
        assert!(set.contains(&"brush_drop"), "{set:?}");
        assert!(
            set.iter()
                .all(|id| ["brush_drop", "dead_time"].contains(id)),
            "{set:?}"
        );
        assert_eq!(found.presumes, presumed);
        assert_eq!(outcome.freed().count(), 0);
    }
}
