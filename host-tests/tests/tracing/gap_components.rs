//! What the report draws of a found effect, against the law that the rig has: what was fitted, and
//! what the data say once the rest of the model is taken out of them.

use host_tests::gap::component::{Component, Quantity, Variable};
use host_tests::gap::engine;
use host_tests::log::Log;
use host_tests::machine::Machine;
use rig::{Effect, EffectKind, Experiment, Machine as RigMachine, Trajectory};

const SECONDS: f64 = 10.0;

/// The only component of the rotary actuator's log with this effect, and the effect.
fn drawn(kind: EffectKind, seed: u64) -> (Component, Effect) {
    let machine = RigMachine::rotary_ema();
    let effect = Effect::nominal(kind, &machine);
    let recording = Experiment::tracking(machine.clone(), Trajectory::sweep(&machine, SECONDS))
        .with_effects(&[effect])
        .lasting(SECONDS)
        .seeded(seed)
        .run();
    let directory = tempfile::tempdir().unwrap();
    let (file, log) = ("machine.toml", "log.csv");
    let [file, log] = [file, log].map(|name| directory.path().join(name));
    std::fs::write(&file, machine.to_toml()).unwrap();
    std::fs::write(&log, recording.to_csv()).unwrap();
    let machine = Machine::read(&file).unwrap();
    let train = [Log::read(&log).unwrap()];
    let report = engine::run(&machine, &train, || Ok(Vec::new()), |_| ()).unwrap();
    let [component] = &report.train[0].components[..] else {
        panic!("{:?}", report.outcome.effects);
    };
    assert_eq!(component.id, kind.id().unwrap());
    (component.clone(), effect)
}

/// The fitted effect is the law within a tenth of it, and so are the data along it.
fn is_the_law(component: &Component, law: impl Fn(f64) -> f64) {
    let samples = component.x.len();
    assert!(samples > 100, "{samples}");
    let (mut error, mut square, mut along) = (0.0, 0.0, 0.0);
    for index in 0..samples {
        let truth = law(f64::from(component.x[index]));
        error += (f64::from(component.component[index]) - truth).powi(2);
        along += f64::from(component.partial_residual[index]) * truth;
        square += truth * truth;
    }
    let (error, along) = ((error / square).sqrt(), along / square);
    assert!(error < 0.1, "the fitted effect is {error} off the law");
    assert!((along - 1.0).abs() < 0.1, "the data are {along} of the law");
}

#[test]
fn drag_is_drawn_over_velocity() {
    let (component, effect) = drawn(EffectKind::QuadraticDrag, 7101);
    let Effect::QuadraticDrag { coefficient } = effect else {
        unreachable!()
    };
    let shown = (component.variable, component.quantity);
    assert_eq!(shown, (Variable::Velocity, Quantity::Torque));
    is_the_law(&component, |velocity| {
        coefficient * velocity * velocity.abs()
    });
}

#[test]
fn friction_that_grows_with_load_is_drawn_over_the_load() {
    let (component, effect) = drawn(EffectKind::LoadDependentFriction, 7201);
    let Effect::LoadDependentFriction { ratio } = effect else {
        unreachable!()
    };
    let shown = (component.variable, component.quantity);
    assert_eq!(shown, (Variable::MotorTorque, Quantity::Friction));
    is_the_law(&component, |load| ratio * load.abs());
}

#[test]
fn a_reading_error_is_drawn_over_a_period() {
    let (component, effect) = drawn(EffectKind::EncoderEccentricity, 7301);
    let Effect::EncoderEccentricity {
        amplitude,
        period,
        phase,
    } = effect
    else {
        unreachable!()
    };
    assert_eq!(component.quantity, Quantity::Reading);
    is_the_law(&component, |position| {
        amplitude * (std::f64::consts::TAU * position / period + phase).sin()
    });
}

#[test]
fn lost_motion_is_drawn_over_the_travel_since_a_turn() {
    let (component, effect) = drawn(EffectKind::Backlash, 7401);
    let Effect::Backlash { width } = effect else {
        unreachable!()
    };
    let shown = (component.variable, component.quantity);
    assert_eq!(shown, (Variable::TravelSinceTurn, Quantity::LostMotion));
    is_the_law(&component, |travel| travel.min(width) - 0.5 * width);
}
