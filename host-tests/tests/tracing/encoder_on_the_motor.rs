//! A reading that errs once a turn of the output: an encoder there may do that, one on the motor in front of a gear may not.

use std::f64::consts::TAU;
use std::path::Path;

use host_tests::gap::engine;
use host_tests::gap::outcome::FoundEffect;
use host_tests::log::Log;
use host_tests::machine::Machine;
use rig::{Effect, EffectKind, Experiment, Machine as RigMachine, Trajectory};

/// Turns of the motor for one behind the gear.
const RATIO: f64 = 5.0;

/// Length of the log, s.
const SECONDS: f64 = 10.0;

#[test]
fn a_period_that_its_disc_cannot_have_is_not_named() {
    let machine = RigMachine::rotary_ema();
    let effect = Effect::nominal(EffectKind::EncoderEccentricity, &machine).scaled(0.7);
    let recording = Experiment::tracking(machine.clone(), Trajectory::sweep(&machine, SECONDS))
        .with_effects(&[effect])
        .lasting(SECONDS)
        .seeded(5401)
        .run();
    let log = Log::of_bytes(Path::new("log.csv"), recording.to_csv().into_bytes()).unwrap();
    // Period of the disc that is named, if one is.
    let named = |side: &str| {
        let sensor = format!("[sensor]\nside = \"{side}\"\ngear_ratio = {RATIO:?}\n");
        let text = machine.to_toml().replace("[sensor]\n", &sensor);
        let machine = Machine::of_bytes(Path::new("machine.toml"), text.into_bytes()).unwrap();
        assert_eq!(machine.gear_ratio, Some(RATIO));
        let logs = [log.clone()];
        let report = engine::run(&machine, &logs, || Ok(Vec::new()), |_| ()).unwrap();
        let is_disc = |effect: &&FoundEffect| effect.id == "encoder_eccentricity";
        let disc = report.outcome.effects.iter().find(is_disc)?;
        let period = disc.parameters.iter().find(|it| it.name == "period");
        Some(period.unwrap().value)
    };
    let period = named("load").expect("the disc of an encoder on the output");
    assert!((period / TAU - 1.0).abs() < 0.05, "{period}");
    let period = named("motor");
    assert!(
        period.is_none_or(|period| period < 1.001 * TAU / RATIO),
        "{period:?}"
    );
}
