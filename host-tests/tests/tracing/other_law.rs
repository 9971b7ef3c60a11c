//! A mechanism whose law is not quite the catalogue's. Gear teeth whose torque over one tooth is no sine: what the sine
//! leaves repeats twice and three times a tooth and reads like a second effect, an encoder that is not centred; it is none.
//! And a friction that falls with the speed as a bell curve does, not as an exponential.

use std::f64::consts::PI;

use host_tests::gap::engine;
use host_tests::gap::outcome::{Estimate, FoundEffect};
use host_tests::log::Log;

use crate::stepped::{COUNTS, GEARMOTOR, Stepped, gearmotor, torque_driven};

/// The machine that it is, in steps of 0.5 ms.
const TOOTHED: Stepped<4> = Stepped {
    inertia: 3.4e-3,
    viscous: 1.42e-2,
    coulomb: 1.4e-3,
    breakaway: 1.6e-3,
    count: 6.0e-6,
    period: 0.02,
    steps: 40,
    rows: 5000,
    frequencies: [0.15, 0.37, 0.81, 1.43],
    amplitudes: [0.3, 0.2, 0.1, 0.05],
    gains: [0.5, 0.6, 0.02],
    limit: 0.126,
};

/// Teeth a turn, and amplitude of the torque's first harmonic, N·m.
const TEETH: f64 = 9.0;
const AMPLITUDE: f64 = 8.4e-3;

/// `harmonics`: amplitudes of the second and the third one, as shares of the first; `spring`: N·m/rad.
fn log(harmonics: [f64; 2], spring: f64, phases: [f64; 4]) -> Log {
    let [second, third] = harmonics;
    TOOTHED.log_of_position("teeth.csv", phases, |acting, position, _| {
        let tooth = TEETH * position;
        let law = tooth.sin() + second * (2.0 * tooth + 0.9).sin() + third * (3.0 * tooth).sin();
        acting - AMPLITUDE * law - spring * position
    })
}

/// What is found, in the alphabetical order of the names.
fn found(harmonics: [f64; 2], spring: f64) -> Vec<FoundEffect> {
    let fit = ["inertia", "viscous", "coulomb", "static"];
    let machine = torque_driven([4.5e-3, 1.1e-2], [1.0e-3, 2.0e-3], TOOTHED.count, &fit);
    let train = log(harmonics, spring, [0.3, 1.9, 4.0, 5.5]);
    let other = log(harmonics, spring, [2.2, 0.4, 5.1, 1.0]);
    let report = engine::run(&machine, &[train], || Ok(vec![other]), |_| ()).unwrap();
    let mut effects = report.outcome.effects;
    effects.sort_by(|a, b| a.id.cmp(&b.id));
    effects
}

fn names(effects: &[FoundEffect]) -> Vec<&str> {
    effects.iter().map(|effect| &*effect.id).collect()
}

/// A number of a found effect.
fn number(effect: &FoundEffect, name: &str) -> Estimate {
    let mut parameters = effect.parameters.iter();
    parameters.find(|it| it.name == name).unwrap().clone()
}

fn overtones_are_found(overtones: &[[f64; 2]]) {
    for &harmonics in overtones {
        let effects = found(harmonics, 0.0);
        assert_eq!(names(&effects), ["cogging"], "{harmonics:?}");
        let tooth = 2.0 * PI / TEETH;
        let period = number(&effects[0], "period").value;
        assert!((period / tooth - 1.0).abs() < 0.01, "{period}");
        let overtones = ["second_harmonic", "third_harmonic"];
        for (name, share) in overtones.into_iter().zip(harmonics) {
            let (found, there) = (number(&effects[0], name), share * AMPLITUDE);
            // Four standard deviations, which one estimate in sixteen thousand is beyond.
            assert!(
                (found.value - there).abs() < 4.0 * found.std,
                "{name}: {} ± {} N·m where there are {there}",
                found.value,
                found.std
            );
            assert!(found.std < 0.1 * there, "{name}: ± {} N·m", found.std);
        }
    }
}

#[test]
fn overtones_of_a_cogging_are_no_second_effect_and_are_found() {
    overtones_are_found(&[[0.5, 0.2]]);
}

#[test]
#[ignore = "other cases"]
fn weaker_overtones_of_a_cogging_are_no_second_effect_and_are_found() {
    overtones_are_found(&[[0.24, 0.09], [0.35, 0.12]]);
}

#[test]
fn a_cogging_without_overtones_has_none() {
    let effects = found([0.0; 2], 0.0);
    assert_eq!(names(&effects), ["cogging"]);
    assert_eq!(
        effects[0].parameters.len(),
        3,
        "{:?}",
        effects[0].parameters
    );
    assert!(
        !effects[0].declare.contains("sine_2"),
        "{}",
        effects[0].declare
    );
}

#[test]
fn a_spring_beside_them_is() {
    let effects = found([0.24, 0.09], 0.02);
    // Over 0.6 rad either way a load that hangs pulls all but as a spring does.
    let [cogging, returning] = names(&effects)[..] else {
        panic!("{:?}", names(&effects));
    };
    assert_eq!(cogging, "cogging");
    assert!(["gravity", "spring"].contains(&returning), "{returning}");
}

/// What friction at a crawl has beyond that in fast motion, N·m, and the speed at which 1/e of that is left, rad/s.
const DROP: f64 = 0.2;
const STRIBECK_SPEED: f64 = 0.5;

/// B. Armstrong-Hélouvry's Gaussian Stribeck curve (*Control of Machines with Friction*, 1991), on a geared motor.
fn log_of_bell(phases: [f64; 4]) -> Log {
    let [resistance, torque_constant] = [4.0, 1.482];
    let machine = Stepped {
        breakaway: GEARMOTOR.coulomb + DROP,
        ..GEARMOTOR
    };
    machine.log("bell.csv", phases, 0, |volts, _, velocity| {
        let current = (volts - torque_constant * velocity) / resistance;
        let share = velocity / STRIBECK_SPEED;
        let direction = if velocity == 0.0 {
            0.0
        } else {
            velocity.signum()
        };
        let drop = DROP * (-share * share).exp() * direction;
        (torque_constant * current - drop, current)
    })
}

#[test]
fn a_friction_that_falls_with_the_speed_has_its_name_by_any_law() {
    let machine = gearmotor([4.0, 0.0, 1.482], COUNTS, "");
    let train = log_of_bell([0.3, 1.9, 4.0, 5.5]);
    let other = log_of_bell([2.2, 0.4, 5.1, 1.0]);
    let report = engine::run(&machine, &[train], || Ok(vec![other]), |_| ()).unwrap();
    let outcome = report.outcome;
    assert_eq!(names(&outcome.effects), ["stribeck"], "{outcome:?}");
    let remaining = outcome.errors.validate.unwrap().remaining();
    assert!(remaining < 0.5, "{remaining} of the error is left");
    // Where the law was learned, it is the bell curve, beyond what is the same at all speeds.
    if let Some(law) = &outcome.effects[0].law {
        let bell = |speed: f64| DROP * (-(speed / STRIBECK_SPEED).powi(2)).exp();
        let fast = law.values.last().unwrap();
        for (speed, friction) in law.at.iter().zip(&law.values) {
            let there = bell(*speed) - bell(*law.at.last().unwrap());
            assert!(
                (friction - fast - there).abs() < 0.2 * DROP,
                "{friction} N·m at {speed} rad/s"
            );
        }
    }
}
