//! The throttle body: bridge, tracks, limp-home position, faults, rise time. References are closed
//! forms, or an integration in `f64` that is written out here.

use firmware::app::machine::THROTTLE;
use model_core::plant::bridge::Bridge;
use model_core::plant::parameters::{Drive, Parameters};
use model_core::plant::potentiometer::{Potentiometer, Pull, Track, TrackFault};
use model_core::plant::rise_time::{RiseTimeError, with_rise_time};
use model_core::plant::throttle::{BuildError, Fault, Settings, Side, Throttle};
use model_core::plant::{Directional, Motion};

const PERIOD: f32 = 50e-6;
const SUPPLY: f32 = 12.0;
const DROP: f32 = 0.7;

fn body(actuator: Parameters) -> Settings {
    Settings {
        actuator,
        tracks: [Track::rising(0.02, 1.57), Track::complementary(0.02, 1.57)],
        diode_drop: DROP,
        seed: 1,
    }
}

fn throttle(actuator: Parameters) -> Throttle {
    Throttle::build(&body(actuator), PERIOD).unwrap()
}

/// The same throttle with a spring that holds it at its upper stop: it has no limp-home position of
/// its own.
fn held_open() -> Parameters {
    Parameters {
        spring_rest: THROTTLE.plant.upper_stop,
        spring_preload: 0.4,
        ..THROTTLE.plant
    }
}

fn run(throttle: &mut Throttle, bridge: Bridge, seconds: f32) {
    for _ in 0..(seconds / PERIOD).round() as u32 {
        throttle.step(bridge, SUPPLY).unwrap();
    }
}

fn drive(volts: f32) -> Bridge {
    Bridge::Drive {
        duty: volts / SUPPLY,
    }
}

/// i, ω, q of a throttle that slides one way above its limp-home position, in `f64`.
#[derive(Clone, Copy)]
struct Reference {
    state: [f64; 3],
    /// Of the motion: 1 or −1.
    sign: f64,
}

/// What the winding sees in the reference.
#[derive(Clone, Copy)]
enum Winding {
    At(f64),
    Open,
}

impl Reference {
    fn of(throttle: &Throttle) -> Self {
        let state = throttle.state();
        Self {
            state: [
                state.current.into(),
                state.velocity.value().into(),
                state.position.value().into(),
            ],
            sign: if state.motion == Motion::Forward {
                1.0
            } else {
                -1.0
            },
        }
    }

    fn slope(&self, [current, velocity, position]: [f64; 3], winding: Winding) -> [f64; 3] {
        // The numbers of THROTTLE.
        let (resistance, inductance, constant) = (2.0, 1.2e-3, 0.38);
        let friction = 0.24 * self.sign + 8e-3 * velocity;
        let spring = 0.3 + 0.25 * (position - 0.2);
        let (current, rate) = match winding {
            Winding::At(volts) => (
                current,
                (volts - resistance * current - constant * velocity) / inductance,
            ),
            Winding::Open => (0.0, 0.0),
        };
        let torque = constant * current - friction - spring;
        [rate, torque / 1.6e-3, velocity]
    }

    /// The classical Runge-Kutta step.
    fn step(&mut self, winding: Winding, h: f64) {
        let start = self.state;
        let along = |slope: [f64; 3], share: f64| {
            let mut to = start;
            for (to, slope) in to.iter_mut().zip(slope) {
                *to += share * h * slope;
            }
            to
        };
        let k1 = self.slope(start, winding);
        let k2 = self.slope(along(k1, 0.5), winding);
        let k3 = self.slope(along(k2, 0.5), winding);
        let k4 = self.slope(along(k3, 1.0), winding);
        for (index, value) in self.state.iter_mut().enumerate() {
            *value += h / 6.0 * (k1[index] + 2.0 * k2[index] + 2.0 * k3[index] + k4[index]);
        }
    }
}

fn assert_near(what: &str, ours: f32, reference: f64, tolerance: f64) {
    let error = (f64::from(ours) - reference).abs();
    assert!(
        error <= tolerance,
        "{what}: {ours} for {reference}, off by {error:e}"
    );
}

/// In full swing towards open: 60 ms at 12 V from the limp-home position.
fn swinging() -> Throttle {
    let mut throttle = throttle(THROTTLE.plant);
    run(&mut throttle, drive(12.0), 0.06);
    assert!(throttle.state().velocity.value() > 10.0);
    throttle
}

#[test]
fn brake_damps_by_the_back_emf() {
    let mut throttle = swinging();
    let mut reference = Reference::of(&throttle);
    let before = throttle.state().velocity.value();
    let mut most: f32 = 0.0;
    for _ in 0..300 {
        throttle.step(Bridge::Brake, SUPPLY).unwrap();
        for _ in 0..50 {
            reference.step(Winding::At(0.0), 1e-6);
        }
        let [current, velocity, position] = reference.state;
        let state = throttle.state();
        assert_near("current", throttle.current(), current, 2e-5);
        assert_near("velocity", state.velocity.value(), velocity, 2e-5);
        assert_near("position", state.position.value(), position, 1e-6);
        most = most.max(-throttle.current());
    }
    // The winding short-circuits what it generates: some 0.38 ω / 2 Ω against the motion.
    assert!(most > 1.0, "{most} A");
    assert!(throttle.state().velocity.value() < 0.6 * before);
}

#[test]
fn freewheel_ends_the_current_through_the_diodes_and_then_does_not_damp() {
    let mut throttle = swinging();
    let mut reference = Reference::of(&throttle);
    let current = f64::from(throttle.current());
    assert!(current > 1.0);
    // The current falls under supply, two drops, resistance and back-EMF: to first order in it.
    let against = 12.0 + 2.0 * 0.7 + 2.0 * current / 2.0 + 0.38 * reference.state[1];
    let estimate = 1.2e-3 * current / against;
    let mut dead_after = None;
    for tick in 1..=300 {
        throttle.step(Bridge::Freewheel, SUPPLY).unwrap();
        for _ in 0..500 {
            let winding = if reference.state[0] > 0.0 {
                Winding::At(-13.4)
            } else {
                reference.state[0] = 0.0;
                Winding::Open
            };
            reference.step(winding, 1e-7);
        }
        if throttle.current() == 0.0 {
            dead_after.get_or_insert(tick);
        } else {
            assert_near("current", throttle.current(), reference.state[0], 1e-4);
        }
        let state = throttle.state();
        // The step in which the current ends spreads what is left of it. Where a step's fall is
        // (13.4 V + 0.38 · 19 V) / 1.2 mH · 50 µs = 0.86 A, the charge is at most 0.86 A · 50 µs / 8
        // too much, whose torque is worth 1.3 mrad/s, and over 15 ms 20 µrad.
        assert_near(
            "velocity",
            state.velocity.value(),
            reference.state[1],
            1.3e-3,
        );
        assert_near("position", state.position.value(), reference.state[2], 2e-5);
    }
    let dead_after = f64::from(dead_after.unwrap()) * f64::from(PERIOD);
    assert!(
        dead_after >= estimate && dead_after < estimate + 2.0 * f64::from(PERIOD),
        "{dead_after} s for {estimate} s"
    );
}

#[test]
fn let_go_at_its_open_stop_the_plate_falls_once_the_current_no_longer_holds_it() {
    let mut throttle = throttle(THROTTLE.plant);
    run(&mut throttle, drive(12.0), 0.5);
    assert_eq!(throttle.state().position.value(), 1.57);
    let mut reference = Reference {
        sign: -1.0,
        ..Reference::of(&throttle)
    };
    let mut held = true;
    loop {
        throttle.step(Bridge::Freewheel, SUPPLY).unwrap();
        for _ in 0..500 {
            let [before, _, position] = reference.state;
            let winding = if before > 0.0 {
                Winding::At(-13.4)
            } else {
                reference.state[0] = 0.0;
                Winding::Open
            };
            reference.step(winding, 1e-7);
            if held {
                let current = reference.state[0];
                reference.state = [current, 0.0, position];
                held = 0.38 * current - 0.3 - 0.25 * (position - 0.2) > -0.28;
            }
        }
        let [current, velocity, position] = reference.state;
        if position < 0.2 {
            break;
        }
        let state = throttle.state();
        // The current's last step as above: 1.3 mrad/s, and that over the 0.13 s of the fall.
        assert_near("current", throttle.current(), current.max(0.0), 1e-4);
        assert_near("velocity", state.velocity.value(), velocity, 1.3e-3);
        assert_near("position", state.position.value(), position, 1.7e-4);
    }
    assert!(!held);
    // Through its limp-home position, and back to it.
    assert!(throttle.state().velocity.value() < -1.0);
    run(&mut throttle, Bridge::Freewheel, 1.0);
    assert_eq!(throttle.state().position.value(), 0.2);
}

#[test]
fn without_inductance_freewheel_is_open_at_once_and_brake_follows_the_back_emf() {
    let mut throttle = throttle(THROTTLE.plant.reduced());
    run(&mut throttle, drive(12.0), 0.06);
    let mut braked = throttle.clone();
    throttle.step(Bridge::Freewheel, SUPPLY).unwrap();
    assert_eq!(throttle.current(), 0.0);
    braked.step(Bridge::Brake, SUPPLY).unwrap();
    let velocity = f64::from(braked.state().velocity.value());
    assert_near("current", braked.current(), -0.38 * velocity / 2.0, 1e-5);
}

#[test]
fn the_switched_off_bridge_clamps_what_the_motor_generates_beyond_its_rails() {
    let mut throttle = throttle(Parameters {
        lower_stop: f32::NEG_INFINITY,
        upper_stop: f32::INFINITY,
        spring: 0.0,
        spring_preload: 0.0,
        ..THROTTLE.plant
    });
    // At 24 V to some 55 rad/s: 21 V of back-EMF. Then a supply of 6 V, whose diodes conduct.
    for _ in 0..20_000 {
        throttle.step(Bridge::Drive { duty: 1.0 }, 24.0).unwrap();
    }
    let generated = 0.38 * f64::from(throttle.state().velocity.value());
    assert!(generated > 19.0);
    for _ in 0..80 {
        throttle.step(Bridge::Freewheel, 6.0).unwrap();
    }
    let generated = 0.38 * f64::from(throttle.state().velocity.value());
    assert!(generated > 7.4, "still beyond 6 V and two drops");
    // Five time constants of the winding after the change; the speed falls meanwhile.
    assert_near(
        "current",
        throttle.current(),
        (7.4 - generated) / 2.0,
        0.05 * generated / 2.0,
    );
}

#[test]
fn the_current_at_steady_speed_is_what_resistance_and_friction_ask_for() {
    for model in [THROTTLE.plant, THROTTLE.plant.reduced()] {
        let endless = Parameters {
            lower_stop: f32::NEG_INFINITY,
            upper_stop: f32::INFINITY,
            spring: 0.0,
            spring_preload: 0.0,
            ..model
        };
        for volts in [-12.0, -6.0, 3.0, 9.0] {
            let mut throttle = throttle(endless);
            run(&mut throttle, drive(volts), 1.0);
            let sign = f64::from(volts).signum();
            // k i = F + B ω and i = (u − k ω) / R.
            let speed = (0.38 * f64::from(volts) / 2.0 - 0.24 * sign) / (8e-3 + 0.38 * 0.38 / 2.0);
            let state = throttle.state();
            assert_near("speed", state.velocity.value(), speed, 1e-4);
            let current = (f64::from(volts) - 0.38 * speed) / 2.0;
            assert_near("current", throttle.current(), current, 2e-5);
        }
    }
}

/// Where the plate comes to lie when the power goes at this position.
fn let_go(parameters: Parameters, from: f32) -> f32 {
    let mut throttle = throttle(parameters);
    // Driven there from limp-home.
    let volts = if from > parameters.spring_rest {
        12.0
    } else {
        -12.0
    };
    while (throttle.state().position.value() - from) * volts < 0.0 {
        throttle.step(drive(volts), SUPPLY).unwrap();
    }
    run(&mut throttle, Bridge::Freewheel, 2.0);
    assert_eq!(throttle.state().motion, Motion::Rest);
    throttle.state().position.value()
}

#[test]
fn without_power_the_plate_goes_to_its_limp_home_position() {
    // The preload exceeds static friction: nothing holds the plate elsewhere.
    for parameters in [THROTTLE.plant, THROTTLE.plant.reduced()] {
        for from in [0.02, 0.05, 0.15, 0.25, 0.6, 1.1, 1.57] {
            assert_eq!(let_go(parameters, from), 0.2, "from {from}");
        }
    }
    for from in [0.02, 0.1, 0.8, 1.5] {
        assert_eq!(let_go(held_open(), from), 1.57, "from {from}");
    }
}

#[test]
fn without_power_a_weak_spring_ends_where_friction_holds_it() {
    // Without viscous friction the plate slides from its upper stop on half a swing around the place
    // where spring and Coulomb friction balance, d = (F − P) / K from the rest, and lies there: it
    // is held, as P + K d is below the static friction.
    for (preload, coulomb) in [(0.05_f32, 0.24_f32), (0.10, 0.30), (0.0, 0.22)] {
        let parameters = Parameters {
            viscous: Directional::both(0.0),
            coulomb: Directional::both(coulomb),
            breakaway: Directional::both(coulomb + 0.04),
            spring_preload: preload,
            ..THROTTLE.plant
        };
        let stroke = f64::from(parameters.upper_stop) - 0.2;
        let balance = f64::from(coulomb - preload) / 0.25;
        let end = 2.0 * balance - stroke;
        assert!(end > 0.0 && 0.25 * end < f64::from(coulomb - preload));
        let expected = 0.2 + end;
        let mut throttle = throttle(parameters);
        run(&mut throttle, drive(12.0), 0.5);
        assert_eq!(throttle.state().position.value(), parameters.upper_stop);
        run(&mut throttle, Bridge::Freewheel, 2.0);
        assert_near("at rest", throttle.state().position.value(), expected, 2e-4);
    }
}

#[test]
fn the_tracks_are_straight_lines_of_their_own() {
    let first = Track::rising(0.02, 1.57);
    let complementary = Track::complementary(0.02, 1.57);
    let half = Track::half_slope(0.02, 1.57);
    for step in 0..=10 {
        let share = f64::from(step) / 10.0;
        let position = 0.02 + 1.55 * share;
        for (track, at_lower, span) in [
            (first, 0.5, 4.0),
            (complementary, 4.5, -4.0),
            (half, 0.5, 2.0),
        ] {
            for reference in [4.8_f32, 5.0] {
                let read = Potentiometer::build(track, 1)
                    .unwrap()
                    .read(position as f32, reference);
                let volts = (at_lower + span * share) * f64::from(reference) / 5.0;
                assert_near("track", read, volts, 1e-6);
            }
        }
    }
    // A gain and an offset of its own, up to the rails.
    let steep = Track {
        offset: 1.0,
        gain: 3.0,
        ..first
    };
    let mut steep = Potentiometer::build(steep, 1).unwrap();
    assert_eq!(steep.read(1.0, 5.0), 4.0);
    assert_eq!(steep.read(2.0, 5.0), 5.0);
    assert_eq!(steep.read(-2.0, 5.0), 0.0);
    assert_eq!(steep.read(f32::NAN, 5.0), 0.0);
}

#[test]
fn the_tracks_noises_are_white_of_their_size_and_independent() {
    const READINGS: usize = 40_000;
    let mut settings = body(THROTTLE.plant);
    settings.tracks[0].noise = 0.02;
    settings.tracks[1].noise = 0.05;
    let mut throttle = Throttle::build(&settings, PERIOD).unwrap();
    let lines = settings.tracks.map(|track| 5.0 * track.share(0.2));
    let noise: Vec<[f64; 2]> = (0..READINGS)
        .map(|_| {
            let read = throttle.tracks(5.0);
            [0, 1].map(|side| f64::from(read[side] - lines[side]))
        })
        .collect();
    let mean =
        |of: &dyn Fn(usize) -> f64| (0..READINGS - 1).map(of).sum::<f64>() / (READINGS - 1) as f64;
    let error = 5.0 / (READINGS as f64).sqrt();
    for (side, deviation) in [(0, 0.02), (1, 0.05)] {
        let unit = |at: usize| noise[at][side] / deviation;
        assert!(mean(&|at| unit(at)).abs() < error);
        // The variance of a square of a triangular variable is 7/5.
        assert!((mean(&|at| unit(at) * unit(at)) - 1.0).abs() < 1.2 * error);
        assert!(mean(&|at| unit(at) * unit(at + 1)).abs() < error);
    }
    assert!(mean(&|at| noise[at][0] * noise[at][1] / (0.02 * 0.05)).abs() < error);
}

#[test]
fn a_track_reads_what_its_fault_leaves_of_it() {
    let mut settings = body(THROTTLE.plant);
    settings.tracks[1].pull = Pull::Up;
    let mut throttle = Throttle::build(&settings, PERIOD).unwrap();
    let [first, second] = throttle.tracks(5.0);
    let mut read = |fault| {
        throttle.heal();
        for side in [Side::First, Side::Second] {
            throttle.inject(Fault::Track(side, fault)).unwrap();
        }
        throttle.tracks(5.0)
    };
    assert_eq!(read(TrackFault::Open), [0.0, 5.0]);
    assert_eq!(read(TrackFault::ShortedHigh), [5.0, 5.0]);
    assert_eq!(read(TrackFault::ShortedLow), [0.0, 0.0]);
    let off = read(TrackFault::Offset(0.25));
    for (off, sound) in off.iter().zip([first, second]) {
        assert!((off - sound - 0.25).abs() < 1e-5);
    }
    throttle.heal();
    let before = throttle.tracks(5.0);
    let stuck = Fault::Track(Side::First, TrackFault::Stuck);
    throttle.inject(stuck).unwrap();
    run(&mut throttle, drive(12.0), 0.1);
    let after = throttle.tracks(5.0);
    assert_eq!(after[0], before[0]);
    assert!(after[1] < before[1] - 1.0);
    throttle.heal();
    let [first, second] = throttle.tracks(5.0);
    assert!((first + second - 5.0).abs() < 1e-5, "both are sound again");
}

#[test]
fn the_plate_never_jumps_when_a_fault_comes_or_goes() {
    let faults = [
        Fault::Track(Side::First, TrackFault::Open),
        Fault::PlateJammed,
        Fault::SpringBroken,
        Fault::FrictionRaised(3.0),
        Fault::MotorOpen,
        Fault::MotorShorted(0.1),
    ];
    for parameters in [THROTTLE.plant, THROTTLE.plant.reduced()] {
        for fault in faults {
            let mut throttle = throttle(parameters);
            for tick in 0..40_000 {
                match tick % 1_700 {
                    300 => throttle.inject(fault).unwrap(),
                    1_100 => throttle.heal(),
                    _ => {}
                }
                let bridge = match tick / 900 % 4 {
                    0 => drive(12.0),
                    1 => Bridge::Freewheel,
                    2 => drive(-8.0),
                    _ => Bridge::Brake,
                };
                let before = *throttle.state();
                throttle.step(bridge, SUPPLY).unwrap();
                let after = throttle.state();
                let moved = (after.position.value() - before.position.value()).abs();
                // At most the faster of the two speeds, or 3 N·m on the inertia from rest.
                let speed = before
                    .velocity
                    .value()
                    .abs()
                    .max(after.velocity.value().abs());
                let most = (speed + 3.0 / 1.6e-3 * PERIOD) * PERIOD;
                assert!(moved <= most + 1e-7, "{fault:?} at {tick}: {moved}");
            }
        }
    }
}

#[test]
fn a_jammed_plate_stays_and_a_broken_spring_lets_it_lie() {
    let mut jammed = swinging();
    jammed.inject(Fault::PlateJammed).unwrap();
    jammed.step(drive(12.0), SUPPLY).unwrap();
    let held = jammed.state().position;
    run(&mut jammed, drive(12.0), 0.2);
    assert_eq!(jammed.state().position, held);
    assert_near("stalled", jammed.current(), 6.0, 1e-4);
    run(&mut jammed, drive(-12.0), 0.2);
    assert_eq!(jammed.state().position, held);

    let mut broken = throttle(THROTTLE.plant);
    run(&mut broken, drive(12.0), 0.5);
    broken.inject(Fault::SpringBroken).unwrap();
    run(&mut broken, Bridge::Freewheel, 1.0);
    assert_eq!(broken.state().position.value(), 1.57);
    broken.heal();
    run(&mut broken, Bridge::Freewheel, 1.0);
    assert_eq!(broken.state().position.value(), 0.2);
}

#[test]
fn the_bridge_feeds_nothing_to_an_open_motor_and_the_short_alone_to_a_shorted_one() {
    let mut throttle = swinging();
    throttle.inject(Fault::MotorOpen).unwrap();
    run(&mut throttle, drive(12.0), 1.0);
    assert_eq!(throttle.current(), 0.0);
    assert_eq!(throttle.state().position.value(), 0.2, "nothing holds it");

    throttle.heal();
    throttle.inject(Fault::MotorShorted(0.2)).unwrap();
    run(&mut throttle, drive(3.0), 0.5);
    assert_near("short", throttle.current(), 15.0, 1e-4);
    assert_eq!(throttle.state().position.value(), 0.2, "nothing drives it");
    run(&mut throttle, Bridge::Freewheel, PERIOD);
    assert_eq!(throttle.current(), 0.0);
}

/// 10 to 90 % of the stroke at full duty, from what the first track reads: 0.9 to 4.1 V.
fn measured_rise(parameters: Parameters) -> f64 {
    let mut throttle = throttle(parameters);
    run(&mut throttle, drive(-12.0), 2.0);
    assert_eq!(throttle.state().position.value(), parameters.lower_stop);
    run(&mut throttle, Bridge::Brake, 1e-3);
    // The plate is pressed back by its spring's preload alone; it begins at the stop.
    let mut ticks = 0;
    loop {
        throttle.step(drive(12.0), SUPPLY).unwrap();
        let [first, _] = throttle.tracks(5.0);
        if first >= 4.1 {
            return f64::from(ticks) * f64::from(PERIOD);
        }
        if first >= 0.9 {
            ticks += 1;
        }
    }
}

#[test]
fn the_rise_time_is_what_it_is_set_to() {
    for parameters in [THROTTLE.plant, THROTTLE.plant.reduced(), held_open()] {
        for target in [0.07_f32, 0.08, 0.1, 0.15, 0.3] {
            let set = with_rise_time(&parameters, target, SUPPLY, PERIOD).unwrap();
            assert_eq!(
                Parameters {
                    inertia: parameters.inertia,
                    ..set
                },
                parameters
            );
            let rise = measured_rise(set);
            let error = rise / f64::from(target) - 1.0;
            assert!(error.abs() < 0.02, "{rise} s for {target} s");
        }
    }
}

#[test]
fn a_rise_time_out_of_reach_is_refused_with_the_range_that_is_within() {
    let set = |target, volts| with_rise_time(&THROTTLE.plant, target, volts, PERIOD);
    for target in [0.001, -1.0, f32::NAN, 1e3] {
        let Err(RiseTimeError::OutOfRange { shortest, longest }) = set(target, SUPPLY) else {
            panic!("{target} s is taken");
        };
        assert!(shortest < longest);
        assert!(set(1.01 * shortest, SUPPLY).is_ok());
    }
    // The spring holds more than 3 V give.
    assert_eq!(set(0.1, 3.0), Err(RiseTimeError::NotReached));
    let endless = Parameters {
        upper_stop: f32::INFINITY,
        ..THROTTLE.plant
    };
    assert_eq!(
        with_rise_time(&endless, 0.1, SUPPLY, PERIOD),
        Err(RiseTimeError::NotReached)
    );
}

#[test]
fn what_no_throttle_has_is_refused_and_changes_nothing() {
    let sound = body(THROTTLE.plant);
    let torque = Parameters {
        drive: Drive::Torque,
        ..THROTTLE.plant
    };
    let weightless = Parameters {
        inertia: 0.0,
        ..THROTTLE.plant
    };
    let mut noisy = sound;
    noisy.tracks[1].noise = -0.1;
    let mut diode = sound;
    diode.diode_drop = f32::NAN;
    for (settings, said) in [
        (body(torque), "drive must be a voltage"),
        (body(weightless), "inertia must be greater than 0"),
        (noisy, "noise must be 0 to 5 V"),
        (diode, "diode drop must be 0 to 5 V"),
    ] {
        let error: BuildError = Throttle::build(&settings, PERIOD).unwrap_err();
        assert!(error.to_string().starts_with(said), "{error}");
    }
    let mut throttle = swinging();
    let before = throttle.clone();
    for fault in [
        Fault::FrictionRaised(f32::NAN),
        Fault::FrictionRaised(-1.0),
        Fault::MotorShorted(0.0),
        Fault::MotorShorted(2.0),
        Fault::Track(Side::First, TrackFault::Offset(f32::INFINITY)),
        Fault::Track(Side::Second, TrackFault::Noisy(-0.1)),
    ] {
        assert!(throttle.inject(fault).is_err(), "{fault:?}");
    }
    let duty = f32::NAN;
    assert!(throttle.step(Bridge::Drive { duty }, SUPPLY).is_err());
    for supply in [f32::NAN, f32::INFINITY, -1.0] {
        assert!(throttle.step(Bridge::Freewheel, supply).is_err());
    }
    assert_eq!(throttle, before);
}
