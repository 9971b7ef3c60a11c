//! Long runs and long ways: energy does not drift, no increment of the angle is lost.

mod machines;

use machines::{MOTOR, energy};
use model_core::plant::actuator::Actuator;
use model_core::plant::bridge::Bridge;
use model_core::plant::parameters::{Drive, Parameters};
use model_core::plant::potentiometer::Track;
use model_core::plant::throttle::{Settings, Throttle};
use model_core::plant::{Directional, Motion, State};
use proptest::prelude::*;
use std::f64::consts::TAU;

/// A mass of 2 kg or kg·m² under a torque or force, without friction, spring or stop.
const BARE: Parameters = Parameters::free(2.0);

/// Springs and inertias without any friction: their energy after so many steps, as a share of that at
/// the start, beside the radians of their swing in a step.
fn swing(steps: u64) -> Vec<(f64, f64)> {
    [
        (2.0, 800.0, 1e-3),
        (1.6e-3, 0.25, 1e-3),
        (1e-3, 4.0, 1e-4),
        (0.7, 3.0, 1e-2),
        (3e-4, 0.8, 2e-3),
        (5e-3, 90.0, 1e-3),
    ]
    .into_iter()
    .map(|(inertia, spring, period): (f32, f32, f32)| {
        let parameters = Parameters {
            inertia,
            spring,
            ..BARE
        };
        let actuator = Actuator::build(&parameters, period).unwrap();
        let mut state = State::new(1.0, 0.0);
        let first = energy(&parameters, &state);
        for _ in 0..steps {
            actuator.step(&mut state, 0.0).unwrap();
        }
        let radians = f64::from(period) * (f64::from(spring) / f64::from(inertia)).sqrt();
        let share = energy(&parameters, &state) / first;
        println!(
            "{radians:.4} rad a step: {:+.2e} of the energy in {steps} steps",
            share - 1.0
        );
        (radians, share)
    })
    .collect()
}

/// A motor with friction that a sine turns to and fro: how far it is after so many periods, rad.
fn wander(periods: u64) -> f32 {
    const PERIOD: usize = 2000;
    let actuator = Actuator::build(&MOTOR, 1e-4).unwrap();
    let sine = |step: usize| (12.0 * (TAU * step as f64 / PERIOD as f64).sin()) as f32;
    // To the last bit as far to one side as to the other.
    let half: Vec<f32> = (0..PERIOD / 2).map(sine).collect();
    let inputs: Vec<f32> = half
        .iter()
        .copied()
        .chain(half.iter().map(|input| -input))
        .collect();
    let mut state = State::new(0.0, 0.0);
    let mut period = || {
        for &input in &inputs {
            actuator.step(&mut state, input).unwrap();
        }
        state.position
    };
    for _ in 0..10 {
        period();
    }
    let settled = period().value();
    let mut last = 0.0;
    for _ in 0..periods {
        last = period().from(settled);
    }
    println!("{last:+.2e} rad in {periods} periods of {PERIOD} steps");
    last
}

/// What is left of the energy, and what was not there before.
fn assert_conserved(steps: u64) {
    for (radians, share) in swing(steps) {
        // Rounding of the coefficients can be made up for to about a hundredth of what it is.
        let lost = steps as f64 * radians * radians * 2e-8;
        assert!(share <= 1.0 + 1e-5, "{radians}: {share}");
        assert!(share >= 1.0 - lost, "{radians}: {share}");
    }
}

#[test]
fn a_spring_without_friction_swings_on_for_ten_million_steps() {
    assert_conserved(10_000_000);
}

#[test]
fn a_motor_turned_to_and_fro_for_fifty_million_steps_is_where_it_was() {
    assert!(wander(25_000).abs() < 1e-6);
}

/// Seven thousand million steps: minutes. `cargo test --release --test endurance -- --ignored --nocapture`.
#[test]
#[ignore = "at length"]
fn the_same_for_a_thousand_million_steps() {
    assert_conserved(1_000_000_000);
    assert!(wander(500_000).abs() < 1e-6);
}

#[test]
fn far_from_zero_no_increment_is_lost() {
    // From 10⁴ and 10⁵ turns on, a million steps of 0.1 µrad: plain f32 would not notice one of them.
    let actuator = Actuator::build(&BARE, 1e-4).unwrap();
    for turns in [1e4, -1e4, 1e5] {
        for speed in [1e-3_f32, -1e-3] {
            let start = (turns * TAU) as f32;
            let mut state = State::new(start, speed);
            for _ in 0..1_000_000 {
                actuator.step(&mut state, 0.0).unwrap();
            }
            let exact = f64::from(speed) * f64::from(1e-4_f32) * 1e6;
            let travel = f64::from(state.position.from(start));
            // Value and remainder together have 48 bits.
            let bound = 1e6 * f64::from(start).abs() * 2_f64.powi(-48);
            let error = travel - exact;
            println!("{turns:e} turns: {travel} rad instead of {exact}: {error:+.1e}");
            assert!(error.abs() < bound, "{error:e}, not {bound:e}");
        }
    }
}

#[test]
fn far_from_zero_a_machine_moves_as_it_does_at_zero() {
    // Breaks away, slides, stands and turns back, for 20 s; the reference is a sum in f64 of what the
    // machine at zero does in each step.
    let actuator = Actuator::build(&MOTOR, 1e-4).unwrap();
    let input = |step: usize| (9.0 * (TAU * 0.7e-4 * step as f64).sin()) as f32;
    for turns in [1e4, -3e4, 1e5] {
        let start = (turns * TAU) as f32;
        let (mut near, mut far) = (State::new(0.0, 0.0), State::new(start, 0.0));
        let (mut stood, mut worst) = (0, 0.0_f64);
        for step in 0..200_000 {
            actuator.step(&mut near, input(step)).unwrap();
            actuator.step(&mut far, input(step)).unwrap();
            stood += usize::from(far.motion == Motion::Rest);
            let apart = far.position.from(start) - near.position.from(0.0);
            worst = worst.max(f64::from(apart).abs());
            // What does not depend on the position is the same to the bit.
            assert_eq!((near.velocity, near.current), (far.velocity, far.current));
        }
        assert!(stood > 1000, "{stood}");
        println!("{turns:e} turns: {worst:.1e} rad apart");
        assert!(
            worst < 2e5 * f64::from(start).abs() * 2_f64.powi(-48),
            "{worst:e}"
        );
    }
}

/// A number between two powers of ten, each decade as likely as another, or nothing.
fn decades(lowest: f32, highest: f32) -> impl Strategy<Value = f32> {
    (lowest..highest).prop_map(|exponent| 10_f32.powf(exponent))
}

fn or_zero(strategy: impl Strategy<Value = f32>) -> impl Strategy<Value = f32> {
    (any::<bool>(), strategy).prop_map(|(there, value)| if there { value } else { 0.0 })
}

prop_compose! {
    /// Throttle bodies with any of their parts: spring, preload, dry and viscous friction, stops near
    /// and far, a winding with or without inductance.
    fn bodies()(
        (resistance, inductance, torque_constant) in (decades(-1.0, 1.0), or_zero(decades(-4.0, -2.0)), decades(-2.0, 0.0)),
        inertia in decades(-4.0, -1.0),
        viscous in or_zero(decades(-4.0, -1.0)),
        coulomb in or_zero(decades(-3.0, 0.0)),
        breakaway in or_zero(decades(-3.0, 0.0)),
        spring in or_zero(decades(-2.0, 1.0)),
        spring_preload in or_zero(decades(-2.0, 0.0)),
        spring_rest in -0.5_f32..0.5,
        stop in prop_oneof![Just(f32::INFINITY), 0.6_f32..2.0],
    ) -> Parameters {
        Parameters {
            drive: Drive::Voltage { resistance, inductance, torque_constant },
            inertia,
            viscous: Directional::both(viscous),
            coulomb: Directional::both(coulomb),
            breakaway: Directional::both(breakaway),
            spring,
            spring_rest,
            spring_preload,
            lower_stop: -stop,
            upper_stop: stop,
            ..BARE
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(1000) })]

    #[test]
    fn a_throttle_that_brakes_gains_no_energy(
        actuator in bodies(),
        supply in 0.0_f32..24.0,
        duty in -1.0_f32..1.0,
    ) {
        let track = Track::rising(-2.0, 2.0);
        let settings = Settings { actuator, tracks: [track; 2], diode_drop: 0.7, seed: 1 };
        let mut throttle = Throttle::build(&settings, 5e-5).unwrap();
        for _ in 0..2000 {
            throttle.step(Bridge::Drive { duty }, supply).unwrap();
        }
        let first = energy(&actuator, throttle.state());
        let mut before = first;
        for step in 0..2000 {
            throttle.step(Bridge::Brake, supply).unwrap();
            let now = energy(&actuator, throttle.state());
            // Roundings of the state, and of the energy that changes its form.
            prop_assert!(now <= before * (1.0 + 2e-6) + 1e-9 * first, "{step}: {before:e} to {now:e}");
            before = now;
        }
    }
}
