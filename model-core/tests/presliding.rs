//! Bristles in steps of a millisecond against the equations themselves, in `f64` and steps of a
//! microsecond.

use model_core::effect::{Active, Id};
use model_core::gap::model::Model;
use model_core::gap::simulator::{Course, Given};
use model_core::plant::actuator::External;
use model_core::plant::parameters::Parameters;
use model_core::plant::{Directional, State};

const PERIOD: f32 = 1e-3;
const COULOMB: f32 = 1.0;

/// An inertia of 1 that a torque drives.
fn model(breakaway: f32, effect: [f32; 3]) -> Model {
    Model {
        effects: [Active::new(Id::Presliding, effect)].into_iter().collect(),
        ..Model::new(Parameters {
            viscous: Directional::both(0.5),
            coulomb: Directional::both(COULOMB),
            breakaway: Directional::both(breakaway),
            ..Parameters::free(1.0)
        })
    }
}

/// Positions and velocities after each step.
fn simulate(model: &Model, inputs: impl Iterator<Item = f32>) -> Vec<(f32, f32)> {
    let simulator = model.build(PERIOD).unwrap();
    let mut course = Course::new(State::new(0.0, 0.0));
    inputs
        .enumerate()
        .map(|(index, input)| {
            let given = Given {
                input,
                previous: input,
                external: External::NONE,
                index,
            };
            simulator.step(&mut course, &given).unwrap();
            let State {
                position, velocity, ..
            } = course.state;
            (position.value(), velocity.value())
        })
        .collect()
}

/// The same from the equations of LuGre, with bristles half critically damped.
fn integrate(breakaway: f64, [compliance, speed]: [f64; 2], inputs: &[f32]) -> Vec<f64> {
    const PARTS: u32 = 1000;
    let dt = f64::from(PERIOD) / f64::from(PARTS);
    let stiffness = 1.0 / compliance;
    let damping = stiffness.sqrt();
    let (mut position, mut velocity, mut deflection) = (0.0_f64, 0.0_f64, 0.0_f64);
    inputs
        .iter()
        .map(|input| {
            for _ in 0..PARTS {
                let coulomb = f64::from(COULOMB);
                let level = coulomb + (breakaway - coulomb) * (-(velocity / speed).powi(2)).exp();
                let rate = velocity - stiffness * velocity.abs() * deflection / level;
                let friction = stiffness * deflection + damping * rate + 0.5 * velocity;
                deflection += dt * rate;
                velocity += dt * (f64::from(*input) - friction);
                position += dt * velocity;
            }
            position
        })
        .collect()
}

/// Pushed to and fro below the breakaway level, and beyond it.
#[test]
fn bristles_yield_and_slide_as_the_equations_say() {
    for (breakaway, compliance, speed, push, tolerance) in [
        (1.0, 2e-4, 0.01, 0.7, 0.01),
        (1.0, 2e-4, 0.01, 1.6, 0.01),
        (1.0, 2e-3, 0.05, 0.9, 0.01),
        (1.3, 2e-3, 0.05, 1.2, 0.02),
        (1.3, 2e-3, 0.05, 2.5, 0.02),
    ] {
        let inputs: Vec<f32> = (0..2000_u16)
            .map(|k| push * (f32::from(k) * PERIOD * 2.0 * std::f32::consts::PI).sin())
            .collect();
        let model = model(breakaway, [compliance, speed, 0.0]);
        let ours = simulate(&model, inputs.iter().copied());
        let shape = [f64::from(compliance), f64::from(speed)];
        let exact = integrate(f64::from(breakaway), shape, &inputs);
        let largest = exact.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        for (index, ((position, _), exact)) in ours.iter().zip(&exact).enumerate() {
            let error = (f64::from(*position) - exact).abs();
            assert!(
                error < tolerance * largest,
                "{position} instead of {exact} after {index} ms: push {push}, compliance {compliance}"
            );
        }
    }
}

/// A millisecond is some thirty radians of the inertia's swing on its bristles: it stands where it
/// was pushed to, and slides as with rigid friction.
#[test]
fn bristles_far_stiffer_than_a_step_resolves_are_rigid_friction() {
    let model = model(COULOMB, [1e-9, 0.01, 0.0]);
    let held = simulate(&model, (0..1000).map(|_| 0.6));
    // Bristles of 1 nm/N that slide at 1 N are bent by less than 2 nm at 0.6 N, however it swung.
    for (position, _) in &held {
        assert!((0.0..2e-9).contains(position), "{position}");
    }
    let (_, velocity) = held[999];
    assert!(velocity.abs() < 1e-9, "{velocity}");
    // B = 0.5: v = 2 (1 − e^(−t/2)).
    let slid = simulate(&model, (0..1000).map(|_| 2.0));
    let exact = 2.0 * (1.0 - (-0.5_f32).exp());
    // What damps their swing takes half of friction more for the half millisecond of the first step.
    let lost = 0.5 * COULOMB * 0.5 * PERIOD;
    assert!((slid[999].1 - exact).abs() < lost, "{}", slid[999].1);
}

/// Without compliance it is the model without the effect, to the bit.
#[test]
fn without_compliance_friction_is_rigid() {
    let inputs = || (0..2000).map(|k| if k / 250 % 2 == 0 { 2.0 } else { -1.4 });
    let mut plain = model(1.2, [0.0, 0.01, 0.0]);
    let with = simulate(&plain, inputs());
    plain.effects.clear();
    assert_eq!(with, simulate(&plain, inputs()));
}
