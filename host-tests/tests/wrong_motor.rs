//! A motor whose numbers are wrong in the machine file: refitted where the file says so, and else named
//! beside what it may have been taken for.

use host_tests::gap::engine;
use host_tests::gap::outcome::Outcome;
use host_tests::gap_benchmark::cases::{Case, Group, Motion};
use host_tests::machine::Machine;
use model_core::gap::select::Verdict;
use rig::{Effect, EffectKind, Motor};
use std::fs;

/// Numbers of the motor for `[fit]`.
const MOTOR: &str = "\"resistance\", \"torque_constant\", ";

/// A log of a rotary actuator, traced with the declared one, whose `[fit]` has these numbers besides.
fn trace(rig: rig::Machine, effects: Vec<Effect>, seed: u64, fit: &str) -> Outcome {
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
    let text = rig::Machine::rotary_ema().to_toml();
    assert_eq!(text.matches("parameters = [").count(), 1, "{text}");
    let listed = format!("parameters = [{fit}");
    fs::write(&path, text.replace("parameters = [", &listed)).unwrap();
    let machine = Machine::read(&path).unwrap();
    let report = engine::run(&machine, &[case.log()], || Ok(Vec::new()), |_| ()).unwrap();
    report.outcome
}

#[test]
fn a_wrong_motor_is_refitted_where_it_may_be() {
    let mut rig = rig::Machine::rotary_ema();
    if let Motor::Winding {
        resistance,
        torque_constant,
        ..
    } = &mut rig.motor
    {
        *resistance *= 1.2;
        *torque_constant *= 0.9;
    }
    for seed in 72_800..72_804 {
        let outcome = trace(rig.clone(), Vec::new(), seed, MOTOR);
        assert_eq!(outcome.verdict, Verdict::NoMissingEffect, "{outcome:?}");
        let fitted = |name| outcome.fit.iter().find(|fit| fit.name == name).unwrap();
        let (resistance, constant) = (fitted("resistance"), fitted("torque_constant"));
        assert!((resistance.fitted / resistance.declared - 1.2).abs() < 0.01);
        assert!((constant.fitted / constant.declared - 0.9).abs() < 0.02);
    }
}

#[test]
fn else_what_may_be_the_motor_says_so() {
    let rig = rig::Machine::rotary_ema();
    let brushes = Effect::nominal(EffectKind::BrushDrop, &rig);
    for (fit, presumed) in [("", &["resistance", "torque_constant"][..]), (MOTOR, &[])] {
        let outcome = trace(rig.clone(), vec![brushes], 72_810, fit);
        let [found] = &outcome.effects[..] else {
            panic!("{outcome:?}");
        };
        assert_eq!(&*found.id, "brush_drop");
        assert_eq!(found.presumes, presumed);
    }
}
