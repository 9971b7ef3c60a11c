//! The plant against solutions on paper.

use rig::{Effect, Machine, Motor, Plant, ReturnSpring, Stops};
use std::f64::consts::{PI, TAU};

/// A slide of 2 kg under unit gain, without friction, spring or stop.
fn bare_slide() -> Machine {
    Machine {
        motor: Motor::Direct { gain: 1.0 },
        inertia: 2.0,
        viscous: 0.0,
        coulomb: 0.0,
        static_friction: 0.0,
        resolution: 0.0,
        ..Machine::force_slide()
    }
}

fn assert_close(ours: f64, exact: f64, tolerance: f64) {
    assert!(
        (ours - exact).abs() <= tolerance,
        "{ours} instead of {exact}, off by {:e}",
        ours - exact
    );
}

/// J dω/dt = k (U − k ω)/R − b ω − F: an exponential towards ω∞ with τ = J / (b + k²/R).
#[test]
fn motor_without_inductance_spins_up_exponentially() {
    let mut machine = Machine::rotary_ema();
    let (resistance, constant, voltage) = (1.0, 0.06, 12.0);
    machine.motor = Motor::Winding {
        resistance,
        inductance: 0.0,
        torque_constant: constant,
    };
    let damping = machine.viscous + constant * constant / resistance;
    let tau = machine.inertia / damping;
    let terminal = (constant * voltage / resistance - machine.coulomb) / damping;
    let mut plant = Plant::new(&machine, &[]);
    for k in 1..=20 {
        plant.advance(voltage, 5e-3);
        let t = 5e-3 * f64::from(k);
        let decay = (-t / tau).exp();
        let state = plant.state();
        assert_close(state.velocity, terminal * (1.0 - decay), 1e-6);
        assert_close(state.position, terminal * (t - tau * (1.0 - decay)), 1e-7);
        assert_close(
            plant.current(voltage),
            (voltage - constant * state.velocity) / resistance,
            1e-12,
        );
    }
}

/// With inductance and ω held by a huge inertia, i = (U/R)(1 − e^(−Rt/L)).
#[test]
fn current_rises_with_the_electrical_time_constant() {
    let machine = Machine {
        inertia: 1e9,
        ..Machine::rotary_ema()
    };
    let mut plant = Plant::new(&machine, &[]);
    plant.advance(12.0, 1.5e-3);
    assert_close(plant.current(12.0), 12.0 * (1.0 - (-1.5_f64).exp()), 1e-5);
}

/// J dv/dt = −F − b v stops after (J/b) ln(1 + b v₀/F), having gone J v₀/b − F t/b.
#[test]
fn coasting_ends_when_and_where_it_should() {
    let machine = Machine::force_slide();
    let (mass, viscous, coulomb) = (machine.inertia, machine.viscous, machine.coulomb);
    let speed = -0.2_f64;
    let time = mass / viscous * (viscous * speed.abs() / coulomb).ln_1p();
    let distance = (mass * speed.abs() - coulomb * time) / viscous;

    let mut plant = Plant::new(&machine, &[]);
    plant.place(0.0, speed);
    plant.advance(0.0, time - 1e-5);
    assert!(!plant.is_stuck());
    plant.advance(0.0, 2e-5);
    assert!(plant.is_stuck());
    assert_eq!(plant.state().velocity, 0.0);
    assert_close(plant.state().position, -distance, 1e-10);
    plant.advance(0.0, 1.0);
    assert_close(plant.state().position, -distance, 1e-10);
}

/// A locked rotor breaks away at U = Fs R / k, and at the load Fs of a direct drive.
#[test]
fn breakaway_needs_the_static_friction() {
    let motor = Machine::rotary_ema();
    let slide = Machine::force_slide();
    for (machine, threshold) in [
        (&motor, motor.static_friction * 1.0 / 0.06),
        (&slide, slide.static_friction / 35.0),
    ] {
        for sign in [1.0, -1.0] {
            let mut plant = Plant::new(machine, &[]);
            plant.advance(sign * 0.9999 * threshold, 0.05);
            assert!(plant.is_stuck());
            assert_eq!(plant.state().position, 0.0);
            plant.advance(sign * 1.0001 * threshold, 0.05);
            assert!(!plant.is_stuck());
            assert!(plant.state().position * sign > 0.0);
        }
    }
}

/// Below static friction a machine under an alternating load does not creep.
#[test]
fn a_stuck_machine_stays_where_it_is() {
    let mut plant = Plant::new(&Machine::force_slide(), &[]);
    plant.place(0.0321, 0.0);
    for k in 0..2000 {
        plant.advance(0.68 * (f64::from(k) * 0.1).sin(), 1e-3);
        assert_eq!(plant.state().position, 0.0321);
        assert_eq!(plant.state().velocity, 0.0);
    }
}

/// ∫u i dt = ∫R i² dt + friction work + kinetic + magnetic energy, through reversals and rests.
#[test]
fn energy_is_accounted_for() {
    let machine = Machine::rotary_ema();
    let mut plant = Plant::new(&machine, &[]);
    let dt = 2e-6;
    let (mut supplied, mut lost, mut rests, mut reversals) = (0.0, 0.0, 0, 0);
    let mut last_direction = 0.0;
    let power = |input: f64, plant: &Plant| {
        let state = plant.state();
        let friction = machine.coulomb * state.velocity.abs();
        (
            input * state.current,
            state.current.powi(2) + friction + machine.viscous * state.velocity.powi(2),
        )
    };
    for millisecond in 0..1000 {
        let input = 8.0 * (f64::from(millisecond) * 0.02).sin();
        for _ in 0..500 {
            let before = power(input, &plant);
            plant.advance(input, dt);
            let after = power(input, &plant);
            supplied += 0.5 * dt * (before.0 + after.0);
            lost += 0.5 * dt * (before.1 + after.1);
        }
        rests += i32::from(plant.is_stuck());
        let direction = plant.state().velocity.signum();
        if !plant.is_stuck() && direction != last_direction {
            reversals += 1;
            last_direction = direction;
        }
    }
    let state = plant.state();
    let stored = 0.5 * machine.inertia * state.velocity.powi(2) + 0.5e-3 * state.current.powi(2);
    assert!(rests > 20 && reversals > 5, "{rests} {reversals}");
    assert!(supplied > 5.0, "{supplied}");
    assert_close(lost + stored, supplied, 1e-6 * supplied);
}

/// Halving the step divides the error by four, through stick-slip, rest crossings and impacts.
#[test]
fn the_integrator_converges_with_second_order() {
    for machine in [Machine::rotary_ema(), Machine::throttle()] {
        let end = |step: f64| {
            let mut plant = Plant::new(&machine, &[]).with_step(step);
            plant.place(machine.spring.map_or(0.0, |s| s.rest), 0.0);
            let mut stuck = 0;
            let mut track = Vec::new();
            for k in 0..400 {
                plant.advance(6.0 * (f64::from(k) * 0.05).sin(), 1e-3);
                stuck += i32::from(plant.is_stuck());
                track.push(plant.state().position);
            }
            assert!(stuck > 5 && stuck < 390, "{stuck}");
            track
        };
        let worst = |a: &[f64], b: &[f64]| {
            a.iter()
                .zip(b)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max)
        };
        let (coarse, middle, fine, finest) = (end(4e-5), end(2e-5), end(1e-5), end(2e-6));
        let order = (worst(&coarse, &finest) / worst(&middle, &finest)).log2();
        let finer = (worst(&middle, &finest) / worst(&fine, &finest)).log2();
        assert!(
            order > 1.6 && finer > 1.6,
            "{}: {order} {finer}",
            machine.name
        );
        // At the step in use, 25 times less than at 10 µs.
        assert!(
            worst(&fine, &finest) / 25.0 < 1e-8,
            "{}",
            worst(&fine, &finest)
        );
    }
}

/// An impact is inelastic, the stop holds against it and lets go at once.
#[test]
fn a_stop_takes_the_speed_and_gives_nothing_back() {
    let machine = Machine {
        stops: Some(Stops {
            lower: -1.0,
            upper: 0.5,
        }),
        ..bare_slide()
    };
    let mut plant = Plant::new(&machine, &[]);
    // a = 1 m/s²: 0.5 m after 1 s.
    plant.advance(2.0, 0.9999);
    assert!(plant.state().velocity > 0.99);
    plant.advance(2.0, 0.0002);
    assert_eq!((plant.state().position, plant.state().velocity), (0.5, 0.0));
    plant.advance(2.0, 1.0);
    assert_eq!((plant.state().position, plant.state().velocity), (0.5, 0.0));
    plant.advance(-2.0, 1.0);
    assert_close(plant.state().position, 0.0, 1e-9);
    plant.advance(-2.0, 1.0);
    assert_eq!(
        (plant.state().position, plant.state().velocity),
        (-1.0, 0.0)
    );
}

/// The preload holds the plate at its rest, and brings it back there from either side.
#[test]
fn the_preload_is_a_limp_home() {
    let machine = Machine::throttle();
    let spring = machine.spring.unwrap();
    let Motor::Winding {
        resistance,
        torque_constant,
        ..
    } = machine.motor
    else {
        panic!("the throttle has a winding");
    };
    let holding = (machine.static_friction + spring.preload) * resistance / torque_constant;
    let mut plant = Plant::new(&machine, &[]);
    plant.place(spring.rest, 0.0);
    plant.advance(0.999 * holding, 0.2);
    assert_eq!(plant.state().position, spring.rest);
    plant.advance(1.001 * holding, 0.2);
    assert!(plant.state().position > spring.rest);
    for from in [0.05, 1.0] {
        plant.place(from, 0.0);
        plant.advance(0.0, 2.0);
        assert!(plant.is_stuck());
        assert_eq!(plant.state().position, spring.rest);
    }
}

/// m x'' = −c x from x₀ with Coulomb friction F: each half swing loses 2 F / c.
#[test]
fn a_spring_swings_down_by_two_friction_widths_each_half_period() {
    let (stiffness, coulomb) = (800.0, 8.0);
    let machine = Machine {
        coulomb,
        static_friction: coulomb,
        spring: Some(ReturnSpring {
            stiffness,
            rest: 0.0,
            preload: 0.0,
        }),
        ..bare_slide()
    };
    let mut plant = Plant::new(&machine, &[]);
    let half = PI * (2.0 / stiffness).sqrt();
    plant.place(0.095, 0.0);
    // From 95 mm to −75, 55, −35, 15 and, about a centre 10 mm out, 5 mm: there the spring is
    // weaker than friction.
    for turn in [-0.075, 0.055, -0.035, 0.015, 0.005] {
        plant.advance(0.0, half);
        assert_close(plant.state().position, turn, 1e-8);
    }
    plant.advance(0.0, 10.0 * half);
    assert_close(plant.state().position, 0.005, 1e-8);
}

/// Terminal speed of each load: where it balances a constant force of 50 N.
#[test]
fn every_steady_load_balances_the_force_at_its_own_speed() {
    let machine = Machine {
        inertia: 0.5,
        viscous: 100.0,
        coulomb: 10.0,
        static_friction: 10.0,
        ..bare_slide()
    };
    let force = 50.0;
    // For each effect the residual of its force balance at speed v in the direction of the force.
    type Balance = fn(f64, f64) -> f64;
    let cases: [(Effect, Balance); 7] = [
        (Effect::AsymmetricCoulomb { ratio: 0.3 }, |v, s| {
            50.0 - 100.0 * v - 10.0 * (1.0 + 0.3 * s)
        }),
        (
            Effect::AsymmetricViscous {
                forward: 30.0,
                backward: -20.0,
            },
            |v, s| 50.0 - (105.0 + 25.0 * s) * v - 10.0,
        ),
        (Effect::OffsetTorque { torque: 4.0 }, |v, s| {
            50.0 + 4.0 * s - 100.0 * v - 10.0
        }),
        (
            Effect::Stribeck {
                drop: 6.0,
                speed: 0.2,
            },
            |v, _| 50.0 - 100.0 * v - 10.0 - 6.0 * (-v / 0.2).exp(),
        ),
        (Effect::QuadraticDrag { coefficient: 80.0 }, |v, _| {
            50.0 - 100.0 * v - 10.0 - 80.0 * v * v
        }),
        (Effect::LoadDependentFriction { ratio: 0.12 }, |v, _| {
            50.0 - 100.0 * v - 10.0 - 6.0
        }),
        (
            Effect::SpeedBand {
                torque: 5.0,
                centre: 0.3,
                width: 0.1,
            },
            |v, _| 50.0 - 100.0 * v - 10.0 - 5.0 * (-((v - 0.3) / 0.1).powi(2)).exp(),
        ),
    ];
    for (effect, balance) in cases {
        for sign in [1.0, -1.0] {
            let mut plant = Plant::new(&machine, &[effect]);
            plant.advance(sign * force, 0.5);
            let speed = plant.state().velocity * sign;
            assert!(speed > 0.1, "{effect:?}");
            assert_close(balance(speed, sign), 0.0, 1e-6);
        }
    }
}

/// A winding at standstill under 6 V of a 12 V drive, once its current is steady.
#[test]
fn what_a_winding_loses_at_standstill_has_a_closed_form() {
    let machine = Machine {
        inertia: 1e9,
        static_friction: 1e9,
        coulomb: 1e9,
        ..Machine::throttle()
    };
    let (resistance, input) = (2.0, 6.0);
    // Each gives the voltage that is missing at a current, from the law alone.
    type Missing = fn(f64) -> f64;
    let cases: [(Effect, Missing); 4] = [
        (
            // Half the supply's drop under half the current.
            Effect::SupplySag {
                voltage: 12.0,
                resistance: 0.4,
                capacity: 1e-3,
            },
            |i| 0.5 * 0.4 * 0.5 * i,
        ),
        (
            Effect::BrushDrop {
                drop: 0.5,
                knee: 2.0,
            },
            |i| 0.5 * (1.0 - (-i / 2.0).exp()),
        ),
        (
            Effect::DeadTime {
                loss: 0.5,
                ripple: 0.1,
            },
            |_| 0.5,
        ),
        (
            // Steady: the heat of the winding passes to the housing, a tenth of its rate there.
            Effect::ThermalDrift {
                rate: 0.5,
                winding: 0.02,
                housing: 0.05,
            },
            |i| {
                let share = 0.5 * i * i * (0.02 + 0.1 * 0.05);
                2.0 * i * share / (1.0 - share)
            },
        ),
    ];
    for (effect, missing) in cases {
        for sign in [1.0, -1.0] {
            let mut plant = Plant::new(&machine, &[effect]);
            plant.place(0.5, 0.0);
            plant.advance(sign * input, 2.0);
            let current = sign * plant.current(sign * input);
            assert!(current > 1.0, "{effect:?}");
            assert_close(input - resistance * current, missing(current), 1e-6);
        }
    }
}

/// A drive told less than the dead time takes gives nothing.
#[test]
fn pulses_shorter_than_the_dead_time_are_swallowed() {
    let machine = Machine {
        static_friction: 1e9,
        ..Machine::throttle()
    };
    let effect = Effect::DeadTime {
        loss: 0.5,
        ripple: 1e-3,
    };
    let mut plant = Plant::new(&machine, &[effect]);
    plant.place(0.5, 0.0);
    plant.advance(0.3, 0.1);
    assert!(plant.current(0.3).abs() < 1e-3);
}

/// Without friction, ½ m v² is what the field of the effect has given.
#[test]
fn loads_of_position_are_conservative() {
    /// Work done by the effect between 0 and x.
    type Work = fn(f64) -> f64;
    let cases: [(Effect, Work); 3] = [
        (
            Effect::Cogging {
                amplitude: 3.0,
                period: 0.02,
                phase: 0.4,
            },
            |x| 3.0 * 0.02 / TAU * (0.4_f64.cos() - (TAU * x / 0.02 + 0.4).cos()),
        ),
        (
            Effect::Spring {
                stiffness: 40.0,
                rest: 0.1,
            },
            |x| 0.5 * 40.0 * (0.1_f64.powi(2) - (x - 0.1).powi(2)),
        ),
        (
            Effect::Gravity {
                torque: 4.0,
                rest: -0.6,
            },
            |x| 4.0 * ((x + 0.6).cos() - 0.6_f64.cos()),
        ),
    ];
    for (effect, work) in cases {
        let mut plant = Plant::new(&bare_slide(), &[effect]);
        for _ in 0..50 {
            plant.advance(5.0, 3e-3);
            let state = plant.state();
            assert_close(
                0.5 * 2.0 * state.velocity.powi(2),
                5.0 * state.position + work(state.position),
                1e-8,
            );
        }
    }
}

/// A coasting slide loses to a rough spot what its bell holds: torque · width · √π.
#[test]
fn a_rough_spot_takes_the_work_of_its_bell() {
    let spot = Effect::RoughSpot {
        torque: 20.0,
        centre: 0.5,
        width: 0.05,
    };
    for sign in [1.0, -1.0] {
        let mut plant = Plant::new(&bare_slide(), &[spot]);
        plant.place(0.5 - sign * 0.5, sign * 3.0);
        plant.advance(0.0, 0.5);
        let work = 20.0 * 0.05 * PI.sqrt();
        let speed = (3.0_f64.powi(2) - 2.0 * work / 2.0).sqrt();
        assert_close(plant.state().velocity, sign * speed, 1e-8);
    }
}

/// A slide that is thrown forward and pulled back loses what the spring takes either way, from where it
/// turned on.
#[test]
fn a_hysteresis_remembers_where_it_turned() {
    let (torque, reach) = (3.0, 0.2);
    let mut plant = Plant::new(&bare_slide(), &[Effect::Hysteresis { torque, reach }]);
    plant.place(0.0, 2.0);
    let decay = |way: f64| (-way / reach).exp();
    let mut turn: f64 = 0.0;
    for _ in 0..2000 {
        plant.advance(-4.0, 1e-3);
        let (velocity, position) = (plant.state().velocity, plant.state().position);
        turn = turn.max(position);
        let at_turn = -torque * (1.0 - decay(turn));
        let ahead = torque * (turn - reach * (1.0 - decay(turn)));
        let back = turn - position;
        let behind = torque * back - (torque - at_turn) * reach * (1.0 - decay(back));
        let kinetic = 0.5 * 2.0 * (2.0_f64.powi(2) - velocity.powi(2));
        // At the turn itself 1 ms is a micrometre.
        assert_close(kinetic - 4.0 * position, ahead + behind, 1e-4);
    }
    assert!(plant.state().position < 0.0);
}

/// A coasting slide whose friction grows: v = v₀ − F/m (t + r t²/2).
#[test]
fn friction_that_drifts_brakes_ever_more() {
    let machine = Machine {
        coulomb: 2.0,
        static_friction: 2.0,
        ..bare_slide()
    };
    let mut plant = Plant::new(&machine, &[Effect::FrictionDrift { rate: 0.4 }]);
    plant.place(0.0, 5.0);
    for k in 1..=10 {
        plant.advance(0.0, 0.2);
        let t = 0.2 * f64::from(k);
        assert_close(plant.state().velocity, 5.0 - (t + 0.2 * t * t), 1e-5);
    }
}

/// It loses to friction that varies along its way what that does over the way, whichever way it goes.
#[test]
fn friction_along_the_stroke_takes_its_work() {
    let machine = Machine {
        coulomb: 2.0,
        static_friction: 2.0,
        ..bare_slide()
    };
    let effect = Effect::PositionDependentFriction {
        ratio: 0.5,
        period: 3.0,
        phase: 0.6,
    };
    for sign in [1.0, -1.0] {
        let mut plant = Plant::new(&machine, &[effect]);
        plant.place(0.0, sign * 3.0);
        plant.advance(0.0, 1.0);
        let state = plant.state();
        let waves = 0.6_f64.cos() - (TAU * state.position / 3.0 + 0.6).cos();
        let work = 2.0 * (state.position + 0.5 * 3.0 / TAU * waves) * sign;
        assert_close(state.velocity.powi(2), 9.0 - work, 1e-8);
    }
}

/// What comes and goes leaves its impulse: torque · duration.
#[test]
fn an_external_load_leaves_its_impulse() {
    let load = Effect::ExternalLoad {
        torque: 3.0,
        begin: 0.5,
        duration: 0.25,
        ramp: 0.1,
    };
    let mut plant = Plant::new(&bare_slide(), &[load]);
    plant.advance(0.0, 0.4);
    assert_eq!(plant.state().velocity, 0.0);
    plant.advance(0.0, 0.1);
    assert_close(plant.state().velocity, 3.0 / 2.0 * 0.05 / 4.0, 1e-7);
    plant.advance(0.0, 0.5);
    assert_close(plant.state().velocity, 3.0 * 0.25 / 2.0, 1e-7);
}

/// Stribeck and load raise the breakaway: the slide sticks until gain · u exceeds both.
#[test]
fn effects_of_friction_hold_at_standstill_too() {
    let machine = Machine {
        coulomb: 10.0,
        static_friction: 11.0,
        ..bare_slide()
    };
    let stribeck = Effect::Stribeck {
        drop: 3.0,
        speed: 0.01,
    };
    let load = Effect::LoadDependentFriction { ratio: 0.2 };
    let lopsided = Effect::AsymmetricCoulomb { ratio: 0.5 };
    for (effects, forward, backward) in [
        (vec![stribeck], 13.0, 13.0),
        (vec![load], 11.0 / 0.8, 11.0 / 0.8),
        (vec![lopsided], 16.5, 5.5),
        (vec![stribeck, load], 13.0 / 0.8, 13.0 / 0.8),
        (vec![Effect::OffsetTorque { torque: 2.0 }], 9.0, 13.0),
    ] {
        for (sign, threshold) in [(1.0, forward), (-1.0, backward)] {
            let mut plant = Plant::new(&machine, &effects);
            plant.advance(sign * 0.999 * threshold, 0.1);
            assert!(plant.is_stuck(), "{effects:?}");
            plant.advance(sign * 1.001 * threshold, 0.1);
            assert!(!plant.is_stuck(), "{effects:?}");
        }
    }
}

/// Bristles pushed one way, overdamped: dz/dx = 1 − σ₀ z/g, so that σ₀ z holds the load at
/// x = −(g/σ₀) ln(1 − load/g); unloaded, dz/dx = 1 + σ₀ z/g the other way.
#[test]
fn presliding_yields_by_its_compliance_and_springs_back() {
    let machine = Machine {
        coulomb: 12.0,
        static_friction: 12.0,
        ..bare_slide()
    };
    let bristles = Effect::Presliding {
        compliance: 1e-4,
        damping: 1000.0,
        speed: 1e-3,
    };
    let mut plant = Plant::new(&machine, &[bristles]);
    plant.advance(5.0, 3.0);
    let pushed = -12.0 * 1e-4 * (1.0_f64 - 5.0 / 12.0).ln();
    assert_close(plant.state().position, pushed, 1e-9);
    plant.advance(0.0, 3.0);
    let back = 12.0 * 1e-4 * (1.0_f64 + 5.0 / 12.0).ln();
    assert_close(plant.state().position, pushed - back, 1e-9);
}

/// Far above v_s bristles slide with Coulomb friction: (13 − 10)/2 m/s².
#[test]
fn presliding_slides_with_coulomb_friction() {
    let machine = Machine {
        coulomb: 10.0,
        static_friction: 12.0,
        ..bare_slide()
    };
    let bristles = Effect::Presliding {
        compliance: 1e-5,
        damping: 300.0,
        speed: 1e-3,
    };
    let mut plant = Plant::new(&machine, &[bristles]);
    for load in 0..1100 {
        plant.advance(0.01 * f64::from(load), 2e-3);
    }
    assert!(plant.state().position < 1e-3, "holds below F_s");
    plant.advance(13.0, 0.5);
    let start = plant.state().velocity;
    plant.advance(13.0, 1.0);
    assert_close(plant.state().velocity - start, 1.5, 1e-4);
}

/// Bristles know stops and the preload: the intake throttle rests open, closes, and opens again.
#[test]
fn presliding_respects_stops_and_preload() {
    let machine = Machine::intake_throttle();
    let bristles = Effect::nominal(rig::EffectKind::Presliding, &machine);
    let mut plant = Plant::new(&machine, &[bristles]);
    plant.place(1.57, 0.0);
    plant.advance(12.0, 0.2);
    assert_eq!(plant.state().position, 1.57);
    // 2 V are 0.38 N·m, below the preload of 0.4 N·m.
    plant.advance(-2.0, 0.2);
    assert_eq!(plant.state().position, 1.57);
    plant.advance(-12.0, 0.5);
    assert_eq!(plant.state().position, 0.0);
    plant.advance(0.0, 2.0);
    assert_eq!(plant.state().position, 1.57);
    assert!(plant.is_stuck());
}
