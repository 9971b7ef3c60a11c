//! The plant against closed forms.

use std::f64::consts::{PI, TAU};

use crate::world::forces::{CURRENT, LOAD, MOTOR};
use crate::world::{InputKind, Joint, Law, Machine, Plant, Side, State};

/// A torque-driven axis without any friction.
pub(super) fn axis() -> Machine {
    Machine {
        linear: false,
        input: InputKind::Torque,
        gain: 1.0,
        limit: 10.0,
        resistance: 0.0,
        inductance: 0.0,
        torque_constant: 0.0,
        inertia: 0.01,
        viscous: 0.0,
        coulomb: 0.0,
        breakaway: 0.0,
        spring: 0.0,
        spring_rest: 0.0,
        gravity: 0.0,
        gravity_rest: 0.0,
        stops: None,
        gear: 1.0,
        resolution: 1e-4,
        centre: 0.0,
        amplitude: 2.0,
        cycle: 1.0,
        torque: 10.0,
    }
}

fn plant(machine: &Machine, laws: &[Law]) -> Plant {
    Plant::new(machine, laws, 2.0, 1e-3)
}

fn moving(plant: &Plant, position: f64, velocity: f64) -> State {
    let mut state = plant.at_rest(position);
    for place in [MOTOR, LOAD] {
        state.values[place + 1] = velocity;
    }
    state.directions[0] = velocity.signum();
    state
}

#[test]
fn viscous_friction_lets_the_speed_decay_exponentially() {
    let machine = Machine {
        viscous: 0.05,
        ..axis()
    };
    let plant = plant(&machine, &[]);
    let mut state = moving(&plant, 0.0, 8.0);
    plant.advance(&mut state, 0.0, 0.5);
    // v₀ exp(−b t/J), and the way v₀ J/b (1 − exp(−b t/J)).
    let left = (-0.05_f64 / 0.01 * 0.5).exp();
    assert!((state.motor_velocity() - 8.0 * left).abs() < 1e-7);
    assert!((state.motor_position() - 8.0 * 0.2 * (1.0 - left)).abs() < 1e-7);
}

#[test]
fn dry_friction_stops_it_where_its_energy_is_spent_and_holds_it_there() {
    let machine = Machine {
        coulomb: 0.4,
        breakaway: 0.5,
        ..axis()
    };
    let plant = plant(&machine, &[]);
    let mut state = moving(&plant, 1.0, 6.0);
    plant.advance(&mut state, 0.0, 1.0);
    // J v²/2 = F s.
    let way = 0.5 * 0.01 * 36.0 / 0.4;
    assert!((state.motor_position() - 1.0 - way).abs() < 1e-9);
    assert_eq!(state.motor_velocity(), 0.0);
    assert!(state.is_stuck());
    let place = state.motor_position();
    plant.advance(&mut state, 0.499, 1.5);
    assert_eq!(state.motor_position(), place);
    plant.advance(&mut state, 0.501, 1.6);
    // (T − F_C) t²/(2 J)
    let way = (0.501 - 0.4) * 0.1 * 0.1 / 0.02;
    assert!((state.motor_position() - place - way).abs() < 1e-6);
}

#[test]
fn a_push_against_the_motion_turns_it_without_a_rest() {
    let machine = Machine {
        coulomb: 0.4,
        breakaway: 0.5,
        ..axis()
    };
    let plant = plant(&machine, &[]);
    let mut state = moving(&plant, 0.0, 1.0);
    plant.advance(&mut state, -1.0, 0.1);
    // (T + F_C)/J until it rests, (T − F_C)/J from there on.
    let rests = 1.0 / 140.0;
    let velocity = -60.0 * (0.1 - rests);
    assert!((state.motor_velocity() - velocity).abs() < 1e-9);
}

#[test]
fn a_spring_and_a_hanging_load_keep_their_energy_and_friction_takes_it() {
    let machine = Machine {
        spring: 0.6,
        spring_rest: 0.3,
        gravity: 0.4,
        gravity_rest: -0.5,
        ..axis()
    };
    let crank = Law::CrankInertia {
        share: 0.5,
        period: 1.5,
        phase: 0.7,
    };
    for laws in [&[][..], &[crank]] {
        let plant = plant(&machine, laws);
        let mut state = moving(&plant, 1.0, 3.0);
        let before = plant.energy(&state);
        plant.advance(&mut state, 0.0, 5.0);
        assert!((plant.energy(&state) - before).abs() < 1e-6 * before.abs());
    }
    let machine = Machine {
        coulomb: 0.05,
        breakaway: 0.05,
        ..machine
    };
    let plant = plant(&machine, &[]);
    let mut state = moving(&plant, 1.0, 3.0);
    let mut last = plant.energy(&state);
    for tick in 1..500 {
        plant.advance(&mut state, 0.0, 0.01 * f64::from(tick));
        let now = plant.energy(&state);
        assert!(now <= last + 1e-12, "{tick}");
        last = now;
    }
}

#[test]
fn a_spring_yields_by_the_load_over_its_stiffness() {
    let machine = Machine {
        spring: 2.0,
        spring_rest: 0.1,
        viscous: 0.2,
        ..axis()
    };
    let plant = plant(&machine, &[]);
    let mut state = plant.at_rest(0.1);
    plant.advance(&mut state, 0.5, 5.0);
    assert!((state.motor_position() - 0.1 - 0.25).abs() < 1e-9);
}

#[test]
fn the_current_rises_with_the_time_constant_of_the_winding() {
    let machine = Machine {
        input: InputKind::Voltage,
        resistance: 2.0,
        inductance: 4e-3,
        torque_constant: 0.05,
        coulomb: 5.0,
        breakaway: 5.0,
        ..axis()
    };
    let plant = plant(&machine, &[]);
    let mut state = plant.at_rest(0.0);
    plant.advance(&mut state, 12.0, 3e-3);
    let expected = 6.0 * (1.0 - (-1.5_f64).exp());
    assert!((state.values[CURRENT] - expected).abs() < 1e-4);
    assert!(state.is_stuck());
}

#[test]
fn a_stop_takes_all_speed_and_holds_until_the_load_points_back() {
    let machine = Machine {
        stops: Some((-1.0, 0.5)),
        ..axis()
    };
    let plant = plant(&machine, &[]);
    let mut state = plant.at_rest(0.0);
    plant.advance(&mut state, 0.2, 2.0);
    assert_eq!((state.motor_position(), state.motor_velocity()), (0.5, 0.0));
    plant.advance(&mut state, -0.2, 2.1);
    assert!((state.motor_position() - (0.5 - 10.0 * 0.01)).abs() < 1e-6);
}

fn joint(stiffness: f64, damping: f64) -> Joint {
    Joint {
        stiffness,
        damping,
        inertia: 0.3,
        friction: 0.0,
        sensor: Side::Load,
    }
}

#[test]
fn an_elastic_shaft_swings_at_its_frequency_about_a_centre_that_does_not_move() {
    let laws = [Law::Compliance(joint(50.0, 0.0))];
    let plant = plant(&axis(), &laws);
    let mut state = plant.at_rest(0.0);
    state.values[MOTOR] = 0.03;
    state.values[LOAD] = -0.07;
    state.directions = [1.0; 2];
    // √(k (1/J₁ + 1/J₂))
    let rate = (50.0 * (1.0 / 0.007 + 1.0 / 0.003_f64)).sqrt();
    plant.advance(&mut state, 0.0, 10.0 * TAU / rate);
    assert!((state.motor_position() - 0.03).abs() < 2e-5);
    assert!((state.load_position() + 0.07).abs() < 2e-5);
    plant.advance(&mut state, 0.0, 10.5 * TAU / rate);
    assert!((state.motor_position() + 0.03).abs() < 3e-5);
}

#[test]
fn a_gap_is_lost_at_a_reversal() {
    let machine = Machine {
        viscous: 0.02,
        coulomb: 0.3,
        breakaway: 0.3,
        ..axis()
    };
    let width = 0.2;
    let behind = Joint {
        friction: 0.5,
        ..joint(2e4, 8.0)
    };
    let laws = [Law::Backlash {
        width,
        joint: behind,
    }];
    let plant = plant(&machine, &laws);
    let mut state = plant.at_rest(0.0);
    // Forwards until the load moves, then to rest, slowly backwards: the load waits for the gap.
    plant.advance(&mut state, 0.4, 0.6);
    assert!((state.motor_position() - state.load_position() - 0.5 * width).abs() < 1e-3);
    plant.advance(&mut state, 0.0, 2.0);
    assert!(state.is_stuck());
    let (motor, load) = (state.motor_position(), state.load_position());
    let mut time = 2.0;
    while (state.load_position() - load).abs() < 1e-9 {
        time += 1e-3;
        plant.advance(&mut state, -0.16, time);
        assert!(time < 4.0);
    }
    let lost = motor - state.motor_position();
    assert!((lost - width).abs() < 0.02 * width, "{lost}");
}

#[test]
fn bristles_yield_by_the_load_over_their_stiffness() {
    let machine = Machine {
        coulomb: 0.4,
        breakaway: 0.4,
        ..axis()
    };
    let laws = [Law::Presliding {
        stiffness: 20.0,
        damping: 0.9,
        speed: 0.1,
    }];
    let plant = plant(&machine, &laws);
    let mut state = plant.at_rest(0.0);
    // Slowly, so that it does not swing: Dahl's path is −g/σ ln(1 − T/g).
    for tick in 1..=2000 {
        let time = 1e-3 * f64::from(tick);
        plant.advance(&mut state, 0.2 * (time / 1.5).min(1.0), time);
    }
    let path = -0.4 / 20.0 * (1.0_f64 - 0.5).ln();
    assert!((state.motor_position() - path).abs() < 0.01 * path);
}

#[test]
fn a_finer_step_changes_hardly_anything() {
    let machine = Machine {
        input: InputKind::Voltage,
        limit: 24.0,
        resistance: 1.0,
        inductance: 1e-3,
        torque_constant: 0.06,
        inertia: 1.2e-4,
        viscous: 2e-4,
        coulomb: 0.12,
        breakaway: 0.15,
        torque: 1.44,
        cycle: 2.0,
        ..axis()
    };
    let end = |divisor: f64| {
        let plant = Plant::new(&machine, &[], 2.0, 1e-3 / divisor);
        let mut state = plant.at_rest(0.0);
        for tick in 1..=2000 {
            let time = 1e-3 * f64::from(tick);
            plant.advance(&mut state, 8.0 * (PI * time).sin(), time);
        }
        state.motor_position()
    };
    let (coarse, fine) = (end(1.0), end(16.0));
    assert!(
        (coarse - fine).abs() < 2e-4 * fine.abs().max(1.0),
        "{coarse} {fine}"
    );
}

/// Breakaway is where the rising current makes it, not where the next step begins.
#[test]
fn a_winding_that_fills_lets_go_in_time() {
    let machine = Machine {
        input: InputKind::Voltage,
        limit: 24.0,
        resistance: 2.0,
        inductance: 20e-3,
        torque_constant: 0.05,
        coulomb: 0.2,
        breakaway: 0.2,
        inertia: 10.0,
        torque: 0.6,
        ..axis()
    };
    let plant = Plant::new(&machine, &[], 20.0, 20e-3);
    assert!(plant.step() > 2e-3);
    let mut state = plant.at_rest(0.0);
    plant.advance(&mut state, 12.0, 20e-3);
    // k i = F_C after −τ ln(1 − F_C R/(k u)); from there on ∫ (k i − F_C) dt / J, no back-EMF to speak of.
    let (tau, full) = (10e-3, 0.05 * 12.0 / 2.0);
    let start = -tau * (1.0 - 0.2_f64 / full).ln();
    let filled = |time: f64| full * (time + tau * (-time / tau).exp());
    let impulse = filled(20e-3) - filled(start) - 0.2 * (20e-3 - start);
    let velocity = impulse / 10.0;
    assert!((state.motor_velocity() - velocity).abs() < 1e-3 * velocity);
}
