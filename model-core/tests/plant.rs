//! The plant against closed forms, at its events and at its edges.

mod machines;

use machines::{MOTOR, energy};
use model_core::plant::actuator::{Actuator, INPUT_LIMIT};
use model_core::plant::borello::{self, Borello};
use model_core::plant::karnopp::{self, Karnopp};
use model_core::plant::parameters::{Drive, Parameters};
use model_core::plant::{Directional, InputRefused, Motion, State};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;

const PERIOD: f32 = 1e-3;

/// A mass of 2 kg or kg·m² under a torque or force, without friction, spring or stop.
const BARE: Parameters = Parameters::free(2.0);

/// A throttle plate between its stops, with a spring that starts with a step (limp-home).
const THROTTLE: Parameters = Parameters {
    drive: Drive::Voltage {
        resistance: 2.0,
        inductance: 1.2e-3,
        torque_constant: 0.38,
    },
    inertia: 1.6e-3,
    viscous: Directional::both(8e-3),
    coulomb: Directional::both(0.24),
    breakaway: Directional::both(0.28),
    spring: 0.25,
    spring_rest: 0.2,
    spring_preload: 0.3,
    lower_stop: 0.02,
    upper_stop: 1.57,
    ..BARE
};

fn build(parameters: Parameters) -> Actuator {
    Actuator::build(&parameters, PERIOD).unwrap()
}

fn run(actuator: &Actuator, state: &mut State, input: f32, steps: usize) {
    for _ in 0..steps {
        actuator.step(state, input).unwrap();
    }
}

/// Within some roundings of a number of that size.
#[track_caller]
fn assert_close(ours: f32, exact: f64, size: f64) {
    let error = f64::from(ours) - exact;
    let bound = 8.0 * 2f64.powi(-24) * size;
    assert!(
        error.abs() <= bound,
        "{ours} instead of {exact}: off by {error:e}, not {bound:e}"
    );
}

#[test]
fn spins_up_exponentially_against_its_back_emf() {
    // J dω/dt = k (u − k ω)/R − b ω − F: an exponential towards ω∞ with τ = J/(b + k²/R).
    let actuator = build(MOTOR.reduced());
    let damping = 2e-4 + 0.06 * 0.06;
    let tau = 1.2e-4 / damping;
    let last = (0.06 * 12.0 - 0.12) / damping;
    let mut state = State::new(0.0, 0.0);
    for step in 1..=1000 {
        actuator.step(&mut state, 12.0).unwrap();
        let time = f64::from(step) * 1e-3;
        let decay = (-time / tau).exp();
        let velocity = last * (1.0 - decay);
        let position = last * (time - tau * (1.0 - decay));
        assert_close(state.velocity.value(), velocity, last);
        assert_close(state.position.value(), position, last * time);
        assert_close(state.current, 12.0 - 0.06 * velocity, 12.0);
    }
}

#[test]
fn current_of_a_held_motor_rises_with_the_electrical_time_constant() {
    let actuator = build(Parameters {
        breakaway: Directional::both(10.0),
        ..MOTOR
    });
    let mut state = State::new(0.0, 0.0);
    for step in 1..=20 {
        actuator.step(&mut state, 12.0).unwrap();
        let exact = 12.0 * (1.0 - (-f64::from(step)).exp());
        assert_close(state.current, exact, 12.0);
    }
    assert_eq!(state.motion, Motion::Rest);
}

#[test]
fn coasts_down_under_coulomb_friction_in_time_and_distance() {
    // t = J ω/F, s = J ω²/(2 F), forwards as backwards.
    for (speed, friction) in [(3.0, 7.0), (-3.0, 7.0), (0.01, 0.3), (-250.0, 913.0)] {
        let actuator = build(Parameters {
            coulomb: Directional::both(friction),
            ..BARE
        });
        let (speed, friction) = (f64::from(speed as f32), f64::from(friction));
        let time = 2.0 * speed.abs() / friction;
        let distance = speed * time / 2.0;
        let whole = (time / 1e-3).floor() as usize;
        let mut state = State::new(0.0, speed as f32);
        run(&actuator, &mut state, 0.0, whole);
        assert_eq!(state.motion, Motion::of(speed as f32), "stands too early");
        run(&actuator, &mut state, 0.0, 1);
        assert_eq!((state.motion, state.velocity.value()), (Motion::Rest, 0.0));
        assert_close(state.position.value(), distance, distance.abs());
    }
}

#[test]
fn turns_round_within_a_step_under_the_input_of_that_step() {
    // 6 N onwards, then 40 N against it: at rest after t = J ω/(40 N + F), and back under
    // 40 N − F. The force that was before the step has no part in the decision to turn.
    for sign in [1.0, -1.0] {
        let actuator = build(Parameters {
            coulomb: Directional::both(5.0),
            breakaway: Directional::both(16.0),
            ..BARE
        });
        let mut state = State::new(0.0, sign * 0.01);
        run(&actuator, &mut state, sign * 6.0, 1);
        let start = 0.01 + 1e-3 * (6.0 - 5.0) / 2.0;
        let before = 1e-3 * (0.01 + start) / 2.0;
        run(&actuator, &mut state, sign * -40.0, 1);
        let time = 2.0 * start / 45.0;
        let left = 1e-3 - time;
        assert!(left > 4e-4, "it turns well inside the step");
        let sign = f64::from(sign);
        let velocity = -left * 35.0 / 2.0;
        assert_close(state.velocity.value(), sign * velocity, start);
        let position = before + start * time / 2.0 + velocity * left / 2.0;
        assert_close(state.position.value(), sign * position, before);
    }
}

#[test]
fn breaks_away_at_the_static_level_in_either_direction() {
    let actuator = build(Parameters {
        coulomb: Directional {
            forward: 0.12,
            backward: 0.09,
        },
        breakaway: Directional {
            forward: 0.15,
            backward: 0.21,
        },
        ..MOTOR
    });
    // k u/R = breakaway; the current approaches u/R to f32's rounding.
    for (voltage, motion) in [
        (0.15 / 0.06 * (1.0 - 1e-5), Motion::Rest),
        (0.15 / 0.06 * (1.0 + 1e-5), Motion::Forward),
        (-0.21 / 0.06 * (1.0 - 1e-5), Motion::Rest),
        (-0.21 / 0.06 * (1.0 + 1e-5), Motion::Backward),
    ] {
        let mut state = State::new(0.0, 0.0);
        run(&actuator, &mut state, voltage, 100);
        assert_eq!(state.motion, motion, "{voltage} V");
        // Once it slides, friction is Coulomb's: 0.03 and 0.12 N·m are left, (b + k²/R) ω∞.
        run(&actuator, &mut state, voltage, 2000);
        let exact = match motion {
            Motion::Rest => 0.0,
            Motion::Forward => 0.03 / 3.8e-3,
            Motion::Backward => -0.12 / 3.8e-3,
        };
        let velocity = f64::from(state.velocity.value());
        assert!((velocity - exact).abs() <= 1e-3 * exact.abs(), "{velocity}");
    }
}

#[test]
fn breakaway_is_never_below_coulomb() {
    let actuator = build(Parameters {
        breakaway: Directional::both(0.0),
        ..MOTOR
    });
    assert_eq!(actuator.load().breakaway, Directional::both(0.12));
    let mut state = State::new(0.0, 0.0);
    run(&actuator, &mut state, 1.99, 1000);
    assert_eq!((state.motion, state.position.value()), (Motion::Rest, 0.0));
}

#[test]
fn friction_can_be_set_without_rebuilding() {
    let mut set = build(MOTOR);
    for (coulomb, breakaway, declared) in [
        (0.2, 0.3, (0.2, 0.3)),
        (0.2, 0.1, (0.2, 0.2)),
        (-1.0, f32::NAN, (0.0, 0.0)),
        (f32::INFINITY, -2.0, (0.0, 0.0)),
    ] {
        set.set_friction(coulomb, breakaway);
        let built = build(Parameters {
            coulomb: Directional::both(declared.0),
            breakaway: Directional::both(declared.1),
            ..MOTOR
        });
        assert_eq!(set, built);
    }
}

#[test]
fn rests_for_a_million_steps_without_a_bit_of_drift() {
    // At the end of a long way, so that nothing small is left that could hide in a sum.
    for (parameters, input) in [(MOTOR, 2.4), (THROTTLE, 0.5), (MOTOR.reduced(), 2.4)] {
        let actuator = build(parameters);
        let mut state = State::new(0.7, 0.0);
        run(&actuator, &mut state, 8.0, 500);
        run(&actuator, &mut state, 0.0, 2000);
        run(&actuator, &mut state, input, 100);
        assert_eq!(state.motion, Motion::Rest);
        let settled = state;
        run(&actuator, &mut state, input, 1_000_000);
        assert_eq!(state, settled);
    }
}

#[test]
fn limp_home_holds_up_to_preload_and_static_friction() {
    // k u/R = 0.3 + 0.28 N·m on the rest; on either side the spring's step helps or hinders.
    let actuator = build(THROTTLE);
    let held = 0.58 * 2.0 / 0.38;
    for direction in [1.0, -1.0] {
        let mut state = State::new(0.2, 0.0);
        run(&actuator, &mut state, direction * held * (1.0 - 1e-5), 1000);
        assert_eq!((state.motion, state.position.value()), (Motion::Rest, 0.2));
        run(&actuator, &mut state, direction * held * (1.0 + 1e-5), 20);
        assert_eq!(state.motion, Motion::of(direction));
        // Without voltage the step of the spring beats friction and brings it back, for good.
        run(&actuator, &mut state, 0.0, 2000);
        assert_eq!(
            (state.motion, state.position.from(0.2)),
            (Motion::Rest, 0.0)
        );
    }
}

#[test]
fn swings_over_the_rest_of_a_preloaded_spring() {
    // Constant torque towards the rest: a period of 4 √(2 J q/p), 0.4 s, to q again.
    let (preload, amplitude) = (1.6, 4e-3);
    for rest in [0.0, 0.3] {
        let actuator = build(Parameters {
            spring_preload: preload,
            spring_rest: rest,
            ..BARE
        });
        let mut state = State::new(rest + amplitude, 0.0);
        let origin = f64::from(rest + amplitude) - f64::from(rest);
        let period = 4.0 * (2.0 * 2.0 * origin / f64::from(preload)).sqrt();
        for step in 1..=4000 {
            actuator.step(&mut state, 0.0).unwrap();
            let phase = (f64::from(step) * 1e-3 / period).fract();
            let from_top = 4.0 * (0.5 - (phase - 0.5).abs());
            // Falls over a quarter, mirrors over a half.
            let exact = if from_top <= 1.0 {
                origin * (1.0 - from_top * from_top)
            } else {
                -origin * (1.0 - (2.0 - from_top) * (2.0 - from_top))
            };
            let error = (f64::from(state.position.from(rest)) - exact).abs();
            // Each crossing and each turn may round the speed, and so all later times.
            let events = f64::from(step) * 4e-3 / period + 1.0;
            let bound = origin * events * events * 2f64.powi(-24);
            assert!(error < bound, "step {step}: {error:e}, not {bound:e}");
        }
    }
}

#[test]
fn bounces_about_the_rest_infinitely_often_and_then_lies_on_it() {
    // Torque p − F on the way to the rest, p + F beyond it: speeds fall by r = √((p − F)/(p + F))
    // with each crossing, and the times between them sum to a finite one (Zeno).
    let (preload, friction, start) = (0.3_f64, 0.24_f64, 0.5_f64);
    for direction in [1.0, -1.0] {
        let actuator = build(Parameters {
            inertia: 1.6e-3,
            spring_preload: preload as f32,
            spring_rest: 0.2,
            coulomb: Directional::both(friction as f32),
            breakaway: Directional::both(0.28),
            ..BARE
        });
        let (to, from) = ((preload - friction) / 1.6e-3, (preload + friction) / 1.6e-3);
        // A bounce that turns back within a sixteenth of the step is not waited for.
        let mut speed = (2.0 * to * start).sqrt();
        let mut end = (2.0 * start / to).sqrt();
        while speed / from >= 1.0e-3 / 16.0 {
            end += speed / from + speed / (to * from).sqrt();
            speed *= (to / from).sqrt();
        }
        let mut state = State::new((0.2 + direction * start) as f32, 0.0);
        let mut steps = 0;
        while state.motion != Motion::Rest || steps == 0 {
            actuator.step(&mut state, 0.0).unwrap();
            steps += 1;
            assert!(steps < 10_000, "{state:?}");
        }
        assert_eq!(state.position.from(0.2), 0.0);
        assert_eq!(steps, (end / 1e-3).ceil() as usize);
        let settled = state;
        run(&actuator, &mut state, 0.0, 1000);
        assert_eq!(state, settled);
    }
}

#[test]
fn bounces_faster_than_the_step_gain_no_energy() {
    // Without friction, a crossing or a turn each √(2 J q/p): from less than 8 nm a step holds more
    // of them than the eight that it follows.
    let actuator = build(Parameters {
        spring_preload: 1.6,
        ..BARE
    });
    for start in [1e-10, 1e-9, 3e-9, 6e-9] {
        let mut state = State::new(start, 0.0);
        let mut energy = f64::from(1.6 * start);
        for _ in 0..100 {
            actuator.step(&mut state, 0.0).unwrap();
            let (q, v) = (
                f64::from(state.position.value()),
                f64::from(state.velocity.value()),
            );
            let now = 1.6 * q.abs() + v * v;
            assert!(now <= energy * (1.0 + 1e-5), "{start}: {now:e} {energy:e}");
            energy = now;
        }
    }
}

#[test]
fn inelastic_stops_catch_hold_and_let_go() {
    for direction in [1.0, -1.0] {
        let actuator = build(Parameters {
            coulomb: Directional::both(2.0),
            breakaway: Directional::both(3.0),
            lower_stop: -0.5,
            upper_stop: 0.5,
            ..BARE
        });
        // 10 N less 2 N on 2 kg: 0.5 m after √(2 · 0.5/4) = 0.5 s.
        let mut state = State::new(0.0, 0.0);
        run(&actuator, &mut state, direction * 10.0, 499);
        assert_eq!(state.motion, Motion::of(direction));
        assert!(state.position.value().abs() < 0.5);
        run(&actuator, &mut state, direction * 10.0, 2);
        let caught = |state: &State| {
            assert_eq!((state.motion, state.velocity.value()), (Motion::Rest, 0.0));
            assert_eq!(state.position.from(direction * 0.5), 0.0);
        };
        caught(&state);
        // It stays under any push against the stop, and under a pull that friction holds.
        for force in [10.0, 1e6, 0.0, -2.9] {
            run(&actuator, &mut state, direction * force, 100);
            caught(&state);
        }
        // And leaves under more: 6 N less 2 N on 2 kg for 0.1 s.
        run(&actuator, &mut state, direction * -6.0, 100);
        assert_close(state.velocity.value(), f64::from(-direction) * 0.2, 0.2);
        assert_close(state.position.value(), f64::from(direction) * 0.49, 0.5);
    }
}

#[test]
fn a_spring_pulls_from_the_stop_at_once() {
    // The impact takes the speed; 20 N of spring and preload less 2 N push back in the same step.
    let actuator = build(Parameters {
        coulomb: Directional::both(2.0),
        breakaway: Directional::both(3.0),
        spring: 10.0,
        spring_preload: 15.0,
        upper_stop: 0.5,
        ..BARE
    });
    let mut state = State::new(0.4999, 1.0);
    run(&actuator, &mut state, 0.0, 1);
    assert_eq!(state.motion, Motion::Backward);
    // At rest on the stop after 0.1 ms and a little, 0.9 ms of 9 m/s² are left.
    assert!((state.velocity.value() + 9.0 * 0.9e-3).abs() < 1e-5);
    assert!(state.position.value() < 0.5);
}

#[test]
fn a_torque_input_is_a_winding_without_back_emf() {
    // k u/R = g u, b + k²/R = b′: the same motion.
    let winding = build(MOTOR.reduced());
    let torque = build(Parameters {
        drive: Drive::Torque,
        gain: 0.06,
        viscous: Directional::both(2e-4 + 0.06 * 0.06),
        ..MOTOR
    });
    let (mut a, mut b) = (State::new(0.0, 0.0), State::new(0.0, 0.0));
    for step in 0..5000 {
        let input = 12.0 * (step as f32 * 3e-3).sin();
        winding.step(&mut a, input).unwrap();
        torque.step(&mut b, input).unwrap();
        assert_close(a.velocity.value(), f64::from(b.velocity.value()), 160.0);
        assert_close(b.current, f64::from(0.06 * input), 0.72);
    }
    assert_close(a.position.value(), f64::from(b.position.value()), 160.0);
}

#[test]
fn a_small_inductance_tends_to_none() {
    let none = build(MOTOR.reduced());
    let errors = [1e-5, 1e-6, 1e-7].map(|inductance| {
        let small = build(Parameters {
            drive: Drive::Voltage {
                resistance: 1.0,
                inductance,
                torque_constant: 0.06,
            },
            ..MOTOR
        });
        let (mut a, mut b) = (State::new(0.0, 0.0), State::new(0.0, 0.0));
        let mut largest = 0.0_f32;
        for step in 0..2000 {
            let input = 12.0 * (step as f32 * 3e-3).sin();
            none.step(&mut a, input).unwrap();
            small.step(&mut b, input).unwrap();
            largest = largest.max((a.velocity.value() - b.velocity.value()).abs());
        }
        largest
    });
    // The current lags by L/R, which is worth L/R times 500 rad/s² of acceleration at the most.
    // Breaking away under a winding faster than a sixteenth of the step may come that much later,
    // with (0.15 − 0.12)/J of acceleration missed.
    let late = 0.03 / 1.2e-4 * PERIOD / 16.0;
    for (error, inductance) in errors.into_iter().zip([1e-5, 1e-6, 1e-7]) {
        assert!(error < 500.0 * inductance + late, "{errors:?}");
    }
}

#[test]
fn ten_short_steps_are_a_long_one() {
    for (parameters, motion) in [
        (MOTOR, 40.0),
        (MOTOR, -40.0),
        (MOTOR.reduced(), 40.0),
        (THROTTLE, 5.0),
        (BARE, 5.0),
    ] {
        let long = build(parameters);
        let short = Actuator::build(&parameters, 1e-4).unwrap();
        let mut a = State::new(0.7, motion);
        a.current = 0.5;
        let mut b = a;
        for _ in 0..20 {
            run(&long, &mut a, motion.signum() * 6.0, 1);
            run(&short, &mut b, motion.signum() * 6.0, 10);
            assert_eq!(
                (a.motion, b.motion),
                (Motion::of(motion), Motion::of(motion))
            );
            assert_close(a.current, f64::from(b.current), 6.0);
            let (velocity, position) = (b.velocity.value(), b.position.value());
            assert_close(a.velocity.value(), f64::from(velocity), 50.0);
            assert_close(a.position.value(), f64::from(position), 1.6);
        }
    }
}

#[test]
fn friction_differs_with_the_direction() {
    // ω∞ = (f − F)/B on either way.
    let actuator = build(Parameters {
        viscous: Directional {
            forward: 4.0,
            backward: 9.0,
        },
        coulomb: Directional {
            forward: 2.0,
            backward: 5.0,
        },
        ..BARE
    });
    for (force, exact) in [(12.0, 2.5), (-12.0, -7.0 / 9.0)] {
        let mut state = State::new(0.0, 0.0);
        run(&actuator, &mut state, force, 20_000);
        assert_close(state.velocity.value(), exact, 2.5);
    }
}

#[test]
fn an_input_that_is_no_number_or_too_large_is_refused() {
    let actuator = build(THROTTLE);
    for motion in [0.0, 3.0, -3.0] {
        let mut state = State::new(0.7, motion);
        state.current = 1.5;
        let before = state;
        for input in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e7, -1e7] {
            assert_eq!(actuator.step(&mut state, input), Err(InputRefused));
            assert_eq!(state, before);
        }
        assert_eq!(actuator.step(&mut state, INPUT_LIMIT), Ok(()));
        assert_eq!(actuator.step(&mut state, -INPUT_LIMIT), Ok(()));
    }
}

#[test]
fn each_parameter_is_checked() {
    type Spoil<'a> = &'a dyn Fn(&mut Parameters, f32);
    let winding = |parameters: &mut Parameters, index: usize, value: f32| {
        if let Drive::Voltage {
            resistance,
            inductance,
            torque_constant,
        } = &mut parameters.drive
        {
            *[resistance, inductance, torque_constant][index] = value;
        }
    };
    let not_numbers = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 2e12, -2e12];
    let positive: [(&str, Spoil); 3] = [
        ("resistance", &|p, value| winding(p, 0, value)),
        ("torque_constant", &|p, value| winding(p, 2, value)),
        ("inertia", &|p, value| p.inertia = value),
    ];
    let non_negative: [(&str, Spoil); 9] = [
        ("inductance", &|p, value| winding(p, 1, value)),
        ("viscous", &|p, value| p.viscous.forward = value),
        ("viscous", &|p, value| p.viscous.backward = value),
        ("coulomb", &|p, value| p.coulomb.forward = value),
        ("coulomb", &|p, value| p.coulomb.backward = value),
        ("breakaway", &|p, value| p.breakaway.forward = value),
        ("breakaway", &|p, value| p.breakaway.backward = value),
        ("spring", &|p, value| p.spring = value),
        ("spring_preload", &|p, value| p.spring_preload = value),
    ];
    let finite: [(&str, Spoil); 2] = [
        ("spring_rest", &|p, value| p.spring_rest = value),
        ("offset", &|p, value| p.offset = value),
    ];
    let assert_refused = |name: &str, spoil: Spoil, value: f32| {
        let mut parameters = THROTTLE;
        spoil(&mut parameters, value);
        let error = Actuator::build(&parameters, PERIOD).unwrap_err();
        assert_eq!(error.parameter, name, "{value}");
        assert!(error.to_string().starts_with(&format!("{name} must be ")));
    };
    for value in not_numbers {
        for (name, spoil) in positive.iter().chain(&non_negative).chain(&finite) {
            assert_refused(name, *spoil, value);
        }
        assert_refused("gain", &|p, value| p.gain = value, value);
    }
    for (name, spoil) in positive {
        assert_refused(name, spoil, 0.0);
        assert_refused(name, spoil, -1.0);
    }
    for (name, spoil) in non_negative {
        assert_refused(name, spoil, -1e-6);
        let mut zero = THROTTLE;
        spoil(&mut zero, 0.0);
        assert_eq!(zero.check(), Ok(()), "{name}");
    }
    assert_refused("gain", &|p, value| p.gain = value, 0.0);
    for value in [1.57, 2.0, f32::INFINITY, f32::NAN] {
        assert_refused("lower_stop", &|p, value| p.lower_stop = value, value);
    }
    for value in [0.02, -1.0, f32::NEG_INFINITY, f32::NAN] {
        assert_refused("lower_stop", &|p, value| p.upper_stop = value, value);
    }
    for period in [0.0, -1e-3, f32::NAN, f32::INFINITY, 10.1] {
        let error = Actuator::build(&THROTTLE, period).unwrap_err();
        assert_eq!(error.parameter, "period", "{period}");
    }
}

#[test]
fn parameters_too_far_apart_for_f32_are_refused() {
    // Each is allowed, but B/J overflows.
    let parameters = Parameters {
        inertia: 1e-30,
        viscous: Directional::both(1e12),
        ..BARE
    };
    assert_eq!(parameters.check(), Ok(()));
    let error = Actuator::build(&parameters, PERIOD).unwrap_err();
    assert_eq!(error.parameter, "inertia");
}

/// Euler steps that resolve the winding, and a band of a hundredth of a radian a second.
fn karnopp(parameters: &Parameters) -> Karnopp {
    Karnopp::build(parameters, 1e-5, 0.01).unwrap()
}

#[test]
fn karnopp_holds_breaks_away_and_slides() {
    let scheme = karnopp(&Parameters {
        upper_stop: 3.0,
        ..MOTOR
    });
    let mut state = karnopp::State::default();
    let mut hold = |voltage: f32, seconds: f32| {
        for _ in 0..(seconds / 1e-5) as usize {
            scheme.step(&mut state, voltage).unwrap();
        }
        state
    };
    // k u/R against 0.15 N·m.
    assert_eq!(hold(2.45, 0.5).position, 0.0);
    // (k u/R − F)/(b + k²/R), but for what Euler's rule and f32 lose.
    let velocity = f64::from(hold(2.55, 0.3).velocity);
    assert!(
        (velocity / (0.033 / 3.8e-3) - 1.0).abs() < 1e-3,
        "{velocity}"
    );
    // The stop ends the way.
    let stopped = hold(2.55, 0.7);
    assert_eq!((stopped.position, stopped.velocity), (3.0, 0.0));
}

#[test]
fn karnopp_breakaway_is_never_below_coulomb() {
    let low = Parameters {
        breakaway: Directional::both(0.0),
        ..MOTOR
    };
    let level = Parameters {
        breakaway: MOTOR.coulomb,
        ..MOTOR
    };
    assert_eq!(karnopp(&low), karnopp(&level));
}

#[test]
fn karnopp_refuses_what_it_cannot_step() {
    let scheme = karnopp(&MOTOR);
    let mut state = karnopp::State {
        current: 1.0,
        velocity: 2.0,
        position: 3.0,
    };
    let before = state;
    for input in [f32::NAN, f32::INFINITY, 1e7, -1e7] {
        assert_eq!(scheme.step(&mut state, input), Err(InputRefused));
        assert_eq!(state, before);
    }
    let refused = |parameters: &Parameters, period: f32, band: f32| {
        Karnopp::build(parameters, period, band)
            .unwrap_err()
            .parameter
    };
    for value in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert_eq!(refused(&MOTOR, value, 0.1), "period");
        assert_eq!(refused(&MOTOR, 1e-5, value), "band");
    }
    // The winding's time constant is 1 ms.
    assert_eq!(refused(&MOTOR, 2.1e-3, 0.1), "period");
    let spoilt = Parameters {
        inertia: 0.0,
        ..MOTOR
    };
    assert_eq!(refused(&spoilt, 1e-5, 0.1), "inertia");
}

#[test]
fn what_is_let_go_one_way_can_turn_within_a_cell() {
    // The spring's step pushes forwards at once, the voltage backwards some microseconds later.
    let parameters = Parameters {
        drive: Drive::Voltage {
            resistance: 0.2,
            inductance: 2e-4,
            torque_constant: 6.4,
        },
        inertia: 69.0,
        coulomb: Directional::both(0.022),
        spring_rest: 0.5,
        spring_preload: 0.08,
        ..BARE
    };
    let speed = |period: f32, steps: usize| {
        let actuator = Actuator::build(&parameters, period).unwrap();
        let mut state = State::new(0.0, 0.0);
        run(&actuator, &mut state, -5.4, steps);
        f64::from(state.velocity.value())
    };
    let (long, short) = (speed(1e-3, 1), speed(1e-5, 100));
    assert!(short < -8e-4, "{short}");
    assert!((long / short - 1.0).abs() < 0.01, "{long} {short}");
}

/// A number between two powers of ten, each decade as likely as another.
fn decades(lowest: f32, highest: f32) -> impl Strategy<Value = f32> {
    (lowest..highest).prop_map(|exponent| 10f32.powf(exponent))
}

fn or_zero(strategy: impl Strategy<Value = f32>) -> impl Strategy<Value = f32> {
    (any::<bool>(), strategy).prop_map(|(there, value)| if there { value } else { 0.0 })
}

fn drives() -> impl Strategy<Value = Drive> {
    prop_oneof![
        Just(Drive::Torque),
        (
            decades(-2.0, 2.0),
            or_zero(decades(-5.0, 0.0)),
            decades(-2.0, 2.0)
        )
            .prop_map(|(resistance, inductance, torque_constant)| Drive::Voltage {
                resistance,
                inductance,
                torque_constant,
            }),
    ]
}

fn directional(lowest: f32, highest: f32) -> impl Strategy<Value = Directional> {
    let level = || or_zero(decades(lowest, highest));
    prop_oneof![
        level().prop_map(Directional::both),
        (level(), level()).prop_map(|(forward, backward)| Directional { forward, backward }),
    ]
}

/// Actuators over many decades, about a position of zero.
fn machines() -> impl Strategy<Value = Parameters> {
    let mechanics = (
        decades(-5.0, 2.0),
        directional(-4.0, 2.0),
        directional(-3.0, 2.0),
        directional(-3.0, 2.0),
        or_zero(decades(-2.0, 3.0)),
        prop::option::weighted(0.8, -0.5_f32..0.5),
        or_zero(decades(-2.0, 2.0)),
        prop_oneof![Just(f32::INFINITY), 0.1_f32..2.0],
    );
    (drives(), mechanics).prop_map(
        |(drive, (inertia, viscous, coulomb, breakaway, spring, rest, preload, stop))| Parameters {
            drive,
            inertia,
            viscous,
            coulomb,
            breakaway,
            spring,
            // Else on the very stop.
            spring_rest: rest.unwrap_or(stop.min(1.0)),
            spring_preload: preload,
            lower_stop: -stop,
            upper_stop: stop,
            ..BARE
        },
    )
}

/// The highest angular frequency or inverse time constant of the mechanics, 1/s.
fn mechanical_rate(parameters: &Parameters) -> f32 {
    let (swing, back_emf) = match parameters.drive {
        Drive::Voltage {
            resistance,
            inductance,
            torque_constant,
        } => {
            let square = torque_constant * torque_constant;
            if inductance > 0.0 {
                (square / inductance, 0.0)
            } else {
                (0.0, square / resistance)
            }
        }
        Drive::Torque => (0.0, 0.0),
    };
    let viscous = parameters.viscous.forward.max(parameters.viscous.backward);
    let rate = ((parameters.spring + swing) / parameters.inertia).sqrt();
    rate.max((viscous + back_emf) / parameters.inertia)
}

#[test]
fn a_long_step_goes_where_short_ones_go() {
    const PARTS: usize = 32;
    let mut runner = TestRunner::deterministic();
    let inputs = prop::collection::vec(-1.0_f32..1.0, 40);
    let cases = (machines(), -0.1_f32..0.1, inputs, decades(-1.0, 1.5));
    let (mut compared, mut apart) = (0, 0);
    while compared < 2000 {
        let (parameters, start, inputs, amplitude) = cases.new_tree(&mut runner).unwrap().current();
        let winding = match parameters.drive {
            Drive::Voltage {
                resistance,
                inductance,
                ..
            } if inductance > 0.0 => resistance / inductance,
            _ => 0.0,
        };
        // A spring that beats friction bounces about its rest ever faster.
        let friction = parameters.coulomb.forward.min(parameters.coulomb.backward);
        if mechanical_rate(&parameters).max(winding) * PERIOD > 1.0
            || parameters.spring_preload > friction
        {
            continue;
        }
        compared += 1;
        let long = build(parameters);
        let short = Actuator::build(&parameters, PERIOD / PARTS as f32).unwrap();
        let (mut a, mut b) = (State::new(start, 0.0), State::new(start, 0.0));
        let (mut error, mut scale) = (0.0_f32, 1e-3_f32);
        for step in 0..400 {
            let input = amplitude * inputs[step / 10];
            run(&long, &mut a, input, 1);
            run(&short, &mut b, input, PARTS);
            scale = scale.max(b.position.value().abs());
            error = error.max((a.position.value() - b.position.value()).abs());
        }
        assert!(error < 0.02 * scale, "{error} of {scale}: {parameters:?}");
        if error > 1e-4 * scale {
            apart += 1;
            println!("{error} of {scale}");
        }
    }
    // Swings of up to a radian a step, and what stands at the very edge of breaking away.
    assert!(apart <= 20, "{apart}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(2000) })]

    #[test]
    fn nothing_leaves_the_numbers_the_stops_or_rest(
        parameters in machines(),
        period in decades(-6.0, -1.0),
        start in (-0.1_f32..0.1, -100.0_f32..100.0),
        amplitude in decades(-3.0, 6.0),
        inputs in prop::collection::vec(-1.0_f32..1.0, 50),
    ) {
        let actuator = Actuator::build(&parameters, period).unwrap();
        let mut state = State::new(start.0, start.1);
        // Each input is held over many steps, so that standing still and stops are met.
        for step in 0..50 * 60 {
            actuator.step(&mut state, amplitude * inputs[step / 60]).unwrap();
            let (position, velocity) = (state.position.value(), state.velocity.value());
            prop_assert!(position.is_finite() && velocity.is_finite() && state.current.is_finite());
            prop_assert!((parameters.lower_stop..=parameters.upper_stop).contains(&position));
            match state.motion {
                Motion::Rest => prop_assert_eq!(velocity, 0.0),
                Motion::Forward => prop_assert!(velocity >= 0.0),
                Motion::Backward => prop_assert!(velocity <= 0.0),
            }
        }
    }

    #[test]
    fn energy_never_grows_without_input(
        parameters in machines(),
        fineness in 0.01_f32..0.5,
        start in (-0.1_f32..0.1, -10.0_f32..10.0),
    ) {
        // Steps of a part of the shortest swing and of the mechanical time constant, and of the first
        // stop under friction and preload.
        let mut state = State::new(start.0, start.1);
        let first = energy(&parameters, &state);
        let momentum_of = |energy: f64| (2.0 * energy * f64::from(parameters.inertia)).sqrt();
        let friction = parameters.coulomb.forward.max(parameters.coulomb.backward);
        let stop = momentum_of(first) as f32 / (friction + parameters.spring_preload);
        let period = (fineness / mechanical_rate(&parameters)).min(stop).clamp(1e-9, 1e-2);
        let actuator = Actuator::build(&parameters, period).unwrap();
        let (mut least, mut crossings) = (first, 0.0);
        for step in 0..3000_u32 {
            actuator.step(&mut state, 0.0).unwrap();
            let now = energy(&parameters, &state);
            // Roundings of the state, and of the energy that changes its form, walk at random by about a
            // unit in the last place a step; that of the speed at each crossing of a preloaded spring's
            // rest goes one way. Of those there are several a step where a stop has left a small swing.
            let walk = 2e-7 * f64::from(step).sqrt();
            let quarter_swing = momentum_of(least) / f64::from(parameters.spring_preload);
            crossings += (f64::from(period) / quarter_swing).min(8.0);
            let bound = least * (1.0 + 4e-6 + walk + 2e-7 * crossings) + 1e-9 * first;
            prop_assert!(now <= bound, "{step}: {least:e} to {now:e}");
            least = least.min(now);
        }
    }
}

/// Steps that lead from a velocity under a torque for so many seconds: velocity and position by
/// Karnopp's, by Borello's and by the exact scheme, each over 10 µs.
fn three_schemes(parameters: &Parameters, from: f32, torque: f32, seconds: f32) -> [(f32, f32); 3] {
    const STEP: f32 = 1e-5;
    let band = karnopp(parameters);
    let crossing = Borello::build(parameters, STEP).unwrap();
    let exact = Actuator::build(parameters, STEP).unwrap();
    let at_start = karnopp::State {
        velocity: from,
        ..karnopp::State::default()
    };
    let (mut banded, mut crossed, mut stepped) = (at_start, at_start, State::new(0.0, from));
    for _ in 0..(seconds / STEP).round() as u32 {
        band.step(&mut banded, torque).unwrap();
        crossing.step(&mut crossed, torque).unwrap();
        exact.step(&mut stepped, torque).unwrap();
    }
    [
        (banded.velocity, banded.position),
        (crossed.velocity, crossed.position),
        (stepped.velocity.value(), stepped.position.value()),
    ]
}

/// 1.2e-4 kg·m² under Coulomb friction of 0.12 N·m, 0.15 N·m at rest.
const DRY: Parameters = Parameters {
    drive: Drive::Torque,
    viscous: Directional::both(0.0),
    ..MOTOR
};

#[test]
fn every_scheme_stays_at_rest_below_the_breakaway_level() {
    for torque in [0.0, 0.149, -0.149] {
        for scheme in three_schemes(&DRY, 0.0, torque, 0.1) {
            assert_eq!(scheme, (0.0, 0.0), "{torque}");
        }
    }
}

#[test]
fn every_scheme_starts_above_the_breakaway_level() {
    for sign in [1.0_f32, -1.0] {
        for (velocity, position) in three_schemes(&DRY, 0.0, sign * 0.18, 0.1) {
            // (0.18 − 0.12)/J = 500 rad/s². Euler's rule is off by a step of it in the position, and
            // the published schemes by the breakaway level in the first step or in the band.
            assert!((velocity * sign - 50.0).abs() < 0.03, "{velocity}");
            assert!((position * sign - 2.5).abs() < 0.003, "{position}");
        }
    }
}

#[test]
fn every_scheme_keeps_moving_where_rest_would_hold() {
    for sign in [1.0_f32, -1.0] {
        // The Coulomb level balances the drive: no change, though it is below the breakaway level.
        for (velocity, position) in three_schemes(&DRY, sign * 50.0, sign * 0.12, 0.1) {
            assert_eq!(velocity * sign, 50.0);
            // The plain f32 position may lose half an ulp, 0.24 µrad, in each of 10000 steps.
            assert!((position * sign - 5.0).abs() < 2.4e-3, "{position}");
        }
        // (0.06 − 0.12)/J = −500 rad/s²
        for (velocity, position) in three_schemes(&DRY, sign * 60.0, sign * 0.06, 0.1) {
            assert!((velocity * sign - 10.0).abs() < 0.01, "{velocity}");
            assert!((position * sign - 3.5).abs() < 0.001, "{position}");
        }
    }
}

#[test]
fn every_scheme_stops_and_stays() {
    for sign in [1.0_f32, -1.0] {
        // −1000 rad/s² stop 50 rad/s after 50 ms and 1.25 rad; a drive below the breakaway level
        // then holds.
        for (velocity, position) in three_schemes(&DRY, sign * 50.0, 0.0, 0.1) {
            assert!(velocity.abs() < 0.01, "{velocity}");
            assert!((position * sign - 1.25).abs() < 5e-4, "{position}");
        }
    }
    let [_, crossed, exact] = three_schemes(&DRY, 50.0, -0.02, 0.1);
    assert_eq!((crossed.0, exact.0), (0.0, 0.0));
}

#[test]
fn every_scheme_turns_back_where_friction_does_not_hold() {
    // −(0.18 + 0.12)/J = −2500 rad/s² stop 50 rad/s in 20 ms and 0.5 rad, −500 rad/s² follow.
    for (velocity, position) in three_schemes(&DRY, 50.0, -0.18, 0.1) {
        assert!((velocity + 40.0).abs() < 0.05, "{velocity}");
        assert!((position - (0.5 - 1.6)).abs() < 0.003, "{position}");
    }
}

#[test]
fn borello_refuses_what_it_cannot_step() {
    let refused =
        |parameters: &Parameters, period: f32| Borello::build(parameters, period).unwrap_err();
    for value in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert_eq!(refused(&MOTOR, value).parameter, "period");
        let scheme = Borello::build(&MOTOR, 1e-5).unwrap();
        let limited = scheme.with_torque_limit(value).unwrap_err();
        assert_eq!(limited.parameter, "torque limit");
    }
    // The winding's time constant is 1 ms.
    assert_eq!(refused(&MOTOR, 2.1e-3).parameter, "period");
    let scheme = Borello::build(&MOTOR, 1e-5).unwrap();
    let mut state = borello::State {
        current: 1.0,
        velocity: 2.0,
        position: 3.0,
    };
    let before = state;
    for input in [f32::NAN, f32::NEG_INFINITY, 1e7] {
        assert_eq!(scheme.step(&mut state, input), Err(InputRefused));
        assert_eq!(state, before);
    }
}

#[test]
fn torque_of_a_saturated_motor_is_its_limit() {
    let frictionless = Parameters {
        coulomb: Directional::both(0.0),
        breakaway: Directional::both(0.0),
        ..DRY
    };
    let scheme = Borello::build(&frictionless, 1e-5)
        .unwrap()
        .with_torque_limit(0.3)
        .unwrap();
    let mut state = borello::State::default();
    for _ in 0..1000 {
        scheme.step(&mut state, -2.0).unwrap();
    }
    // −0.3/J for 10 ms
    assert!((state.velocity + 25.0).abs() < 1e-3, "{}", state.velocity);
}
