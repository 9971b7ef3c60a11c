//! Values that no machine has, in every input and every parameter: what is refused leaves its bits as
//! they were, what is taken leaves nothing but numbers, both within the tick in which they come.

use heapless::Vec;
use model_core::control::pid::{self, AntiWindup};
use model_core::effect::{Active, Id};
use model_core::gap::model::Model;
use model_core::gap::simulator::{Course, Given};
use model_core::plant::actuator::{Actuator, External, INPUT_LIMIT, Load};
use model_core::plant::bench::electrics::Electrics;
use model_core::plant::bench::{self, Bench};
use model_core::plant::borello::{self, Borello};
use model_core::plant::bridge::Bridge;
use model_core::plant::ema::{self, Command, Ema};
use model_core::plant::inter_sample::InterSample;
use model_core::plant::karnopp::{self, Karnopp};
use model_core::plant::parameters::{Drive, Parameters};
use model_core::plant::piecewise_affine::{self, Affine, Cell, PiecewiseAffine};
use model_core::plant::potentiometer::{Track, TrackFault};
use model_core::plant::throttle::{Fault, Settings, Side, Throttle};
use model_core::plant::{Directional, State};
use model_core::signal::{aprts, growing_triangle, ramp, sine, step, sweep, triangle};
use proptest::prelude::*;

/// What a spoilt memory, a division by zero, a wrong unit or an overflow leaves behind.
const HOSTILE: [f32; 22] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    1e30,
    -1e30,
    1e19,
    -1e19,
    1e12,
    -1e12,
    1_000_000.06,
    INPUT_LIMIT,
    -INPUT_LIMIT,
    1.0,
    -1.0,
    1e-12,
    f32::MIN_POSITIVE,
    // The smallest number of all, either way.
    f32::from_bits(1),
    -f32::from_bits(1),
    0.0,
    -0.0,
];

/// Any of them, or a number of any size.
fn hostile() -> impl Strategy<Value = f32> {
    prop_oneof![
        prop::sample::select(&HOSTILE[..]),
        any::<u32>().prop_map(f32::from_bits),
        (-12.0_f32..12.0).prop_map(|exponent| 10_f32.powf(exponent)),
    ]
}

/// A sound value three times out of four, else a hostile one.
fn perhaps(sound: f32) -> impl Strategy<Value = f32> {
    prop_oneof![3 => Just(sound), 1 => hostile()]
}

fn directional(sound: f32) -> impl Strategy<Value = Directional> {
    (perhaps(sound), perhaps(sound))
        .prop_map(|(forward, backward)| Directional { forward, backward })
}

const DRIVE: Drive = Drive::Voltage {
    resistance: 2.0,
    inductance: 1.2e-3,
    torque_constant: 0.38,
};

/// A throttle plate between its stops, with a spring that starts with a step.
const THROTTLE: Parameters = Parameters {
    drive: DRIVE,
    viscous: Directional::both(8e-3),
    coulomb: Directional::both(0.24),
    breakaway: Directional::both(0.28),
    spring: 0.25,
    spring_rest: 0.2,
    spring_preload: 0.3,
    lower_stop: 0.02,
    upper_stop: 1.57,
    ..Parameters::free(1.6e-3)
};

/// A motor with friction and nothing else.
const MOTOR: Parameters = Parameters {
    inertia: 1.2e-4,
    viscous: Directional::both(2e-4),
    coulomb: Directional::both(0.12),
    breakaway: Directional::both(0.15),
    spring: 0.0,
    spring_rest: 0.0,
    spring_preload: 0.0,
    lower_stop: f32::NEG_INFINITY,
    upper_stop: f32::INFINITY,
    ..THROTTLE
};

fn drives() -> impl Strategy<Value = Drive> {
    prop_oneof![
        Just(Drive::Torque),
        (
            perhaps(2.0),
            prop_oneof![perhaps(1.2e-3), Just(0.0)],
            perhaps(0.38)
        )
            .prop_map(|(resistance, inductance, torque_constant)| Drive::Voltage {
                resistance,
                inductance,
                torque_constant,
            }),
    ]
}

/// Actuators any number of whose parameters are hostile; most builds take about half of them.
fn spoilt() -> impl Strategy<Value = Parameters> {
    prop_oneof![Just(THROTTLE), Just(MOTOR)].prop_flat_map(|sound| {
        let levels = (
            directional(sound.viscous.forward),
            directional(sound.coulomb.forward),
            directional(sound.breakaway.forward),
        );
        let rest = (
            perhaps(sound.spring),
            perhaps(sound.spring_rest),
            perhaps(sound.spring_preload),
            perhaps(sound.offset),
            perhaps(sound.lower_stop),
            perhaps(sound.upper_stop),
        );
        (drives(), perhaps(1.0), perhaps(sound.inertia), levels, rest).prop_map(
            |(drive, gain, inertia, (viscous, coulomb, breakaway), rest)| Parameters {
                drive,
                gain,
                inertia,
                viscous,
                coulomb,
                breakaway,
                spring: rest.0,
                spring_rest: rest.1,
                spring_preload: rest.2,
                offset: rest.3,
                lower_stop: rest.4,
                upper_stop: rest.5,
            },
        )
    })
}

fn periods() -> impl Strategy<Value = f32> {
    prop_oneof![
        Just(1e-3),
        hostile(),
        (-7.0_f32..1.0).prop_map(|exponent| 10_f32.powf(exponent)),
    ]
}

fn inputs() -> impl Strategy<Value = std::vec::Vec<f32>> {
    prop::collection::vec(hostile(), 40)
}

fn is_finite(state: &State) -> bool {
    let finite = |value: f32| value.is_finite();
    finite(state.current)
        && finite(state.velocity.value())
        && finite(state.velocity.from(0.0))
        && finite(state.position.value())
        && finite(state.position.from(0.0))
}

/// Where an actuator may start: within its stops.
fn start(parameters: &Parameters, velocity: f32) -> State {
    let position = 0.2_f32
        .max(parameters.lower_stop)
        .min(parameters.upper_stop);
    State::new(position, velocity)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(20_000) })]

    #[test]
    fn the_exact_step_is_contained(
        parameters in spoilt(),
        period in periods(),
        velocity in prop::sample::select(vec![0.0_f32, 3.0, -3.0]),
        inputs in inputs(),
    ) {
        let Ok(actuator) = Actuator::build(&parameters, period) else { return Ok(()) };
        let mut state = start(&parameters, velocity);
        for input in inputs {
            let before = state;
            match actuator.step(&mut state, input) {
                Ok(()) => {
                    prop_assert!(is_finite(&state), "{before:?} to {state:?} by {input}");
                    let position = state.position.value();
                    prop_assert!((parameters.lower_stop..=parameters.upper_stop).contains(&position));
                }
                Err(_) => prop_assert_eq!(state, before),
            }
        }
    }

    #[test]
    fn a_hostile_load_is_contained(
        parameters in prop::sample::select(vec![THROTTLE, MOTOR, MOTOR.reduced()]),
        velocity in prop::sample::select(vec![0.0_f32, 3.0, -3.0]),
        loads in prop::collection::vec((perhaps(0.1), directional(0.1), directional(0.2)), 20),
    ) {
        let actuator = Actuator::build(&parameters, 1e-3).unwrap();
        let mut state = start(&parameters, velocity);
        for (torque, coulomb, breakaway) in loads {
            let before = state;
            match actuator.step_under(&mut state, 1.0, &Load { torque, coulomb, breakaway }) {
                Ok(()) => prop_assert!(is_finite(&state), "{before:?} to {state:?}"),
                Err(_) => prop_assert_eq!(state, before),
            }
        }
    }

    #[test]
    fn the_published_schemes_are_contained(
        parameters in spoilt(),
        period in prop_oneof![3 => Just(1e-5_f32), 1 => hostile()],
        band in perhaps(0.01),
        limit in hostile(),
        inputs in inputs(),
    ) {
        let finite = |state: &karnopp::State| {
            state.current.is_finite() && state.velocity.is_finite() && state.position.is_finite()
        };
        if let Ok(scheme) = Karnopp::build(&parameters, period, band) {
            let scheme = scheme.with_torque_limit(limit).unwrap_or(scheme);
            let mut state = karnopp::State::default();
            for &input in &inputs {
                let before = state;
                match scheme.step(&mut state, input) {
                    Ok(()) => prop_assert!(finite(&state), "{before:?} to {state:?} by {input}"),
                    Err(_) => prop_assert_eq!(state, before),
                }
            }
        }
        if let Ok(scheme) = Borello::build(&parameters, period) {
            let scheme = scheme.with_torque_limit(limit).unwrap_or(scheme);
            let mut state = borello::State::default();
            for input in inputs {
                let before = state;
                match scheme.step(&mut state, input) {
                    Ok(()) => prop_assert!(finite(&state), "{before:?} to {state:?} by {input}"),
                    Err(_) => prop_assert_eq!(state, before),
                }
            }
        }
    }

    #[test]
    fn the_controller_is_contained(
        gains in (perhaps(2.0), perhaps(10.0), perhaps(0.1), perhaps(1e-3)),
        weights in (perhaps(1.0), perhaps(0.0)),
        limits in (perhaps(-24.0), perhaps(24.0)),
        tracking in prop::option::of(perhaps(0.1)),
        period in periods(),
        inputs in prop::collection::vec((hostile(), hostile(), any::<bool>()), 40),
    ) {
        let built = pid::Parameters {
            proportional: gains.0,
            integral: gains.1,
            derivative: gains.2,
            derivative_filter_time: gains.3,
            set_point_weight: weights.0,
            derivative_set_point_weight: weights.1,
            output_minimum: limits.0,
            output_maximum: limits.1,
            anti_windup: tracking.map_or(AntiWindup::ConditionalIntegration, |tracking_time| {
                AntiWindup::BackCalculation { tracking_time }
            }),
        }
        .build(period);
        let Ok(controller) = built else { return Ok(()) };
        let mut state = pid::State::default();
        for (set_point, measurement, integrates) in inputs {
            let before = state;
            let output = if integrates {
                controller.step(&mut state, set_point, measurement)
            } else {
                controller.step_holding_integral(&mut state, set_point, measurement)
            };
            match output {
                Ok(output) => {
                    prop_assert!((limits.0..=limits.1).contains(&output));
                    let terms = state.terms();
                    for term in [terms.proportional, terms.integral, terms.derivative, terms.unsaturated] {
                        prop_assert!(term.is_finite(), "{terms:?}");
                    }
                }
                Err(_) => prop_assert_eq!(state, before),
            }
        }
    }

    #[test]
    fn the_piecewise_affine_model_is_contained(
        numbers in prop::collection::vec(perhaps(0.1), 16),
        limits in (perhaps(0.0), perhaps(1.5)),
        period in periods(),
        position in hostile(),
        inputs in inputs(),
    ) {
        let affine = |at: usize| Affine {
            position: numbers[at],
            change: numbers[at + 1],
            input: numbers[at + 2],
            constant: numbers[at + 3],
        };
        let cells = [0, 8].map(|at| Cell { region: affine(at), growth: affine(at + 4) });
        let built = PiecewiseAffine::build(piecewise_affine::Parameters {
            period,
            lower_limit: limits.0,
            upper_limit: limits.1,
            cells: cells.into_iter().collect(),
        });
        let Ok(model) = built else { return Ok(()) };
        let Ok(mut state) = model.rest(position) else {
            prop_assert!(!position.is_finite());
            return Ok(());
        };
        let within = |position: f32| (limits.0..=limits.1).contains(&position);
        prop_assert!(within(state.position()));
        let mut ticking = InterSample::new(model.clone(), position, period / 4.0);
        for input in inputs {
            let before = state;
            match model.step(&mut state, input) {
                Ok(position) => prop_assert!(within(position), "{position}"),
                Err(_) => prop_assert_eq!(state, before),
            }
            if let Ok(ticking) = &mut ticking {
                let before = ticking.clone();
                match ticking.tick(input) {
                    Ok(position) => prop_assert!(within(position), "{position}"),
                    Err(_) => prop_assert_eq!(&*ticking, &before),
                }
            }
        }
    }

    #[test]
    fn signals_are_numbers_at_every_tick(
        levels in (perhaps(1.0), perhaps(12.0)),
        rates in (perhaps(0.5), perhaps(5.0)),
        times in (perhaps(0.1), perhaps(2.0)),
        phase in perhaps(0.0),
        cycles in (0_u32..2000, 0_u32..2000),
        seed in any::<u64>(),
        period in periods(),
        ticks in prop::collection::vec(any::<u32>(), 20),
    ) {
        let sine = sine::Parameters { offset: levels.0, amplitude: levels.1, frequency: rates.0, phase }
            .build(period);
        let triangle =
            triangle::Parameters { offset: levels.0, amplitude: levels.1, frequency: rates.0, phase }
                .build(period);
        let sweep = sweep::Parameters {
            offset: levels.0,
            amplitude: levels.1,
            initial_frequency: rates.0,
            final_frequency: rates.1,
            duration: times.1,
        }
        .build(period);
        let ramp = ramp::Parameters {
            initial_value: levels.0,
            final_value: levels.1,
            start: times.0,
            duration: times.1,
        }
        .build(period);
        let step = step::Parameters { initial_value: levels.0, final_value: levels.1, time: times.0 }
            .build(period);
        let random = aprts::Parameters {
            lower: levels.0,
            upper: levels.1,
            shortest_hold: times.0,
            longest_hold: times.1,
            seed,
        }
        .build(period);
        let growing = growing_triangle::Parameters {
            offset: levels.0,
            amplitude: levels.1,
            first: cycles.0,
            last: cycles.1,
            duration: times.1,
        }
        .build(period);
        for tick in ticks.into_iter().chain([0, 1, u32::MAX]) {
            let values = [
                sine.as_ref().map(|signal| signal.at(tick)),
                triangle.as_ref().map(|signal| signal.at(tick)),
                sweep.as_ref().map(|signal| signal.at(tick)),
                ramp.as_ref().map(|signal| signal.at(tick)),
                step.as_ref().map(|signal| signal.at(tick)),
                random.as_ref().map(|signal| signal.at(tick)),
                growing.as_ref().map(|signal| signal.at(tick)),
            ];
            for (number, value) in values.into_iter().enumerate() {
                prop_assert!(value.is_err() || value.is_ok_and(f32::is_finite), "{number}: {value:?}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(4000) })]

    #[test]
    fn the_throttle_is_contained(
        actuator in spoilt(),
        tracks in prop::collection::vec((perhaps(0.5), perhaps(2.0), perhaps(0.01)), 2),
        diode_drop in perhaps(0.7),
        fault in hostile(),
        steps in prop::collection::vec((0_u8..12, hostile(), perhaps(12.0)), 60),
    ) {
        let [first, second] = [0, 1].map(|index: usize| Track {
            offset: tracks[index].0,
            gain: tracks[index].1,
            noise: tracks[index].2,
            ..Track::rising(0.0, 1.0)
        });
        let actuator = Parameters { gain: 1.0, ..actuator };
        let settings = Settings { actuator, tracks: [first, second], diode_drop, seed: 1 };
        let Ok(mut throttle) = Throttle::build(&settings, 1e-4) else { return Ok(()) };
        for (kind, value, supply) in steps {
            let bridge = match kind {
                0..=3 => Bridge::Drive { duty: value },
                4..=5 => Bridge::Brake,
                6..=8 => Bridge::Freewheel,
                _ => {
                    let faults = [
                        Fault::FrictionRaised(fault),
                        Fault::MotorShorted(fault),
                        Fault::Track(Side::First, TrackFault::Offset(fault)),
                        Fault::Track(Side::Second, TrackFault::Noisy(fault)),
                        Fault::PlateJammed,
                        Fault::SpringBroken,
                        Fault::MotorOpen,
                    ];
                    let before = throttle.clone();
                    let chosen = faults[value.to_bits() as usize % faults.len()];
                    if throttle.inject(chosen).is_err() {
                        prop_assert_eq!(&throttle, &before);
                    }
                    continue;
                }
            };
            let before = throttle.clone();
            match throttle.step(bridge, supply) {
                Ok(()) => {
                    prop_assert!(is_finite(throttle.state()), "{bridge:?} {supply} {before:?}");
                    prop_assert!(throttle.current().is_finite());
                }
                Err(_) => prop_assert_eq!(&throttle, &before, "{:?} {}", bridge, supply),
            }
            prop_assert!(throttle.shares().iter().all(|share| (0.0..=1.0).contains(share)));
        }
    }

    #[test]
    fn the_servo_is_contained(
        gains in (perhaps(300.0), perhaps(300.0), perhaps(0.1)),
        motor in (perhaps(1.0), perhaps(1e-3), perhaps(0.06), perhaps(1.48), perhaps(1.2e-4), perhaps(2e-4)),
        transmission in (perhaps(6.25), perhaps(5e-3), perhaps(0.0), perhaps(-0.1), perhaps(0.1)),
        drive in (perhaps(0.016), perhaps(24.0), perhaps(30.0)),
        friction in (perhaps(0.12), perhaps(0.15)),
        scheme in prop_oneof![
            Just(ema::friction::Scheme::Exact),
            Just(ema::friction::Scheme::Borello),
            perhaps(0.1).prop_map(|band| ema::friction::Scheme::Karnopp { band }),
        ],
        commands in prop::collection::vec((any::<bool>(), hostile()), 20),
    ) {
        let mut parameters = ema::Parameters { scheme, ..ema::Parameters::ALI_2 };
        (parameters.controller.proportional, parameters.controller.integral, parameters.controller.derivative) = gains;
        let of = &mut parameters.motor;
        (of.resistance, of.inductance, of.torque_constant, of.peak_torque, of.inertia, of.viscous) = motor;
        parameters.gearbox.ratio = transmission.0;
        let of = &mut parameters.ball_screw;
        (of.lead, of.mass, of.lower_end, of.upper_end) =
            (transmission.1, transmission.2, transmission.3, transmission.4);
        let of = &mut parameters.drive;
        (of.period, of.supply, of.current_limit) = drive;
        (parameters.friction.coulomb, parameters.friction.breakaway) = friction;
        let Ok(mut servo) = Ema::build(&parameters) else { return Ok(()) };
        for (closed, value) in commands {
            let command = if closed { Command::Position(value) } else { Command::Duty(value) };
            let before = servo.clone();
            match servo.step(command) {
                Ok(sample) => {
                    prop_assert!(is_finite(servo.state()), "{command:?} {:?}", servo.state());
                    for value in [sample.position, sample.speed, sample.current, sample.duty] {
                        prop_assert!(value.is_finite(), "{sample:?}");
                    }
                }
                Err(_) => prop_assert_eq!(&servo, &before),
            }
        }
    }
}

/// Commands to a bench of which any number of parameters are hostile.
fn command<E: Electrics + Clone + PartialEq + std::fmt::Debug>(
    parameters: &bench::Parameters,
    brake: f32,
    commands: &[f32],
) -> Result<(), TestCaseError> {
    let Ok(mut bench) = Bench::<E>::build(parameters) else {
        return Ok(());
    };
    bench.set_brake(brake);
    for &command in commands {
        let before = bench.clone();
        match bench.step(command) {
            Ok(sample) => {
                prop_assert!(is_finite(bench.motor()), "{command} {:?}", bench.motor());
                prop_assert!(
                    bench.drive().torque.is_finite() && bench.encoder().angle().is_finite()
                );
                for value in [
                    sample.position,
                    sample.motor_position,
                    sample.velocity,
                    sample.quadrature_current,
                    sample.reference_current,
                ] {
                    prop_assert!(value.is_finite(), "{sample:?}");
                }
            }
            Err(_) if command.is_finite() => {
                // In the middle of the period: the motor is where it was when its torque was refused.
                prop_assert!(is_finite(bench.motor()), "{before:?} by {command}");
            }
            // As it is printed: a bench that came to no number once compares unequal to itself.
            Err(_) => prop_assert_eq!(format!("{bench:?}"), format!("{before:?}")),
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(500) })]

    #[test]
    fn the_bench_is_contained(
        spoilt in prop::collection::vec((0_usize..24, hostile()), 0..4),
        brake in hostile(),
        commands in prop::collection::vec(hostile(), 8),
    ) {
        for sound in [bench::Parameters::AVERAGED, bench::Parameters::SWITCHING] {
            let mut parameters = sound;
            for &(index, value) in &spoilt {
                let p = &mut parameters;
                *[
                    &mut p.control.position_gain,
                    &mut p.control.speed_limit,
                    &mut p.control.speed_gain,
                    &mut p.control.integral_time,
                    &mut p.control.derivative_time,
                    &mut p.control.derivative_filter,
                    &mut p.control.tracking_time,
                    &mut p.control.torque_constant,
                    &mut p.control.current_limit,
                    &mut p.electrics.windings.resistance,
                    &mut p.electrics.windings.inductance,
                    &mut p.electrics.torque.torque_constant,
                    &mut p.electrics.torque.saturation,
                    &mut p.electrics.inverter.bus_voltage,
                    &mut p.electrics.inverter.band,
                    &mut p.mechanics.motor_inertia,
                    &mut p.mechanics.motor_viscous,
                    &mut p.mechanics.tare.coulomb,
                    &mut p.mechanics.tare.breakaway,
                    &mut p.mechanics.load_share,
                    &mut p.mechanics.transmission_loss,
                    &mut p.gearbox.ratio,
                    &mut p.encoder.backlash,
                    &mut p.current_cut_off,
                ][index] = value;
            }
            if sound == bench::Parameters::AVERAGED {
                command::<bench::averaged::Averaged>(&parameters, brake, &commands)?;
            } else {
                command::<bench::switching::Switching>(&parameters, brake, &commands)?;
            }
        }
    }

    #[test]
    fn a_model_with_any_effect_is_contained(
        id in prop::sample::select(Id::ALL),
        values in [hostile(), hostile(), hostile()]
            .prop_filter("finite", |values| values.iter().all(|value| value.is_finite())),
        velocity in prop::sample::select(vec![0.0_f32, 3.0, -3.0]),
        steps in prop::collection::vec((hostile(), hostile(), perhaps(0.0), perhaps(0.0), any::<bool>()), 20),
    ) {
        let mut effects = Vec::new();
        effects.push(Active::new(id, values)).unwrap();
        let model = Model { effects, ..Model::new(MOTOR) };
        let Ok(simulator) = model.build(1e-3) else { return Ok(()) };
        let mut course = Course::new(State::new(0.2, velocity));
        for (index, (input, previous, brake, load, released)) in steps.into_iter().enumerate() {
            let before = course;
            match simulator.step(&mut course, &Given { input, previous, external: External { brake, load, released }, index }) {
                Ok(current) => {
                    prop_assert!(is_finite(&course.state), "{before:?} to {course:?}");
                    prop_assert!(current.is_finite());
                    prop_assert!(simulator.reported(&course).is_finite());
                }
                // Its first part may have been taken, and the second refused.
                Err(_) => prop_assert!(is_finite(&course.state), "{before:?} to {course:?}"),
            }
        }
    }
}
