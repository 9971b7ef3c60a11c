//! The prognostics paper's servo and its friction schemes, against closed forms and against the
//! `f64` bench.

use host_tests::reproduce::prognostics::anti_windup::{self, BAND, Response, SECONDS, STEP_M};
use host_tests::reproduce::prognostics::{COMMAND, command_file};
use host_tests::workspace;
use model_core::control::pid::AntiWindup;
use model_core::plant::State;
use model_core::plant::actuator::Actuator;
use model_core::plant::borello::{self, Borello};
use model_core::plant::ema::friction::{self, Scheme};
use model_core::plant::ema::{BuildError, Command, Ema, Parameters};
use model_core::plant::karnopp::{self, Karnopp};
use model_core::signal::{aprts, ramp, sine, step, sweep};
use rig::{Machine, Plant, Servo, ServoSample};

/// Half the width of Karnopp's band: a thousandth of the top speed of the examples' motor, rad/s.
const HALF_BAND: f32 = 0.15;

const SCHEMES: [Scheme; 3] = [
    Scheme::Karnopp { band: HALF_BAND },
    Scheme::Borello,
    Scheme::Exact,
];

/// The paper's servo with a scheme; Euler's rule takes steps of 10 µs, the exact one of 100 µs.
fn with_scheme(scheme: Scheme) -> Parameters {
    Parameters {
        scheme,
        steps: if scheme == Scheme::Exact { 160 } else { 1600 },
        ..Parameters::ALI_2
    }
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| {
        (sum + value * value, count + 1.0)
    });
    f64::sqrt(sum / count)
}

/// A voltage that sticks and slips: 4 V from 0.5 to 8 Hz over 8 s, where 2.5 V break away.
#[test]
fn every_scheme_sticks_and_slips_as_the_bench_does() {
    const HOLD: f32 = 1e-3;
    let voltage = sweep::Parameters {
        offset: 0.0,
        amplitude: 4.0,
        initial_frequency: 0.5,
        final_frequency: 8.0,
        duration: 8.0,
    }
    .build(HOLD)
    .unwrap();
    let plant = Parameters {
        ball_screw: model_core::plant::ema::ball_screw::Parameters {
            lower_end: -100.0,
            upper_end: 100.0,
            ..Parameters::ALI_2.ball_screw
        },
        ..Parameters::ALI_2
    }
    .plant();
    let band = Karnopp::build(&plant, 1e-5, HALF_BAND).unwrap();
    let crossing = Borello::build(&plant, 1e-5).unwrap();
    let exact = Actuator::build(&plant, HOLD).unwrap();
    let mut banded = karnopp::State::default();
    let mut crossed = borello::State::default();
    let mut stepped = State::new(0.0, 0.0);
    let mut bench = Plant::new(&Machine::rotary_ema(), &[]);
    let mut errors = Vec::new();
    let (mut stuck, mut largest) = (0, 0.0_f64);
    for tick in 0..8000 {
        let input = voltage.at(tick);
        for _ in 0..100 {
            band.step(&mut banded, input).unwrap();
            crossing.step(&mut crossed, input).unwrap();
        }
        exact.step(&mut stepped, input).unwrap();
        bench.advance(input.into(), 1e-3);
        stuck += u32::from(bench.is_stuck());
        let truth = bench.state().position;
        largest = largest.max(truth.abs());
        errors.push([
            f64::from(banded.position) - truth,
            f64::from(crossed.position) - truth,
            f64::from(stepped.position.value()) - truth,
        ]);
    }
    // A second of each at least.
    assert!((1000..7000).contains(&stuck), "{stuck}");
    let [by_karnopp, by_borello, by_exact] =
        [0, 1, 2].map(|scheme| rms(errors.iter().map(|row| row[scheme])));
    println!(
        "of {largest:.2} rad: Karnopp {by_karnopp:.1e}, Borello {by_borello:.1e}, \
         exact {by_exact:.1e} rad rms; stuck {stuck} of 8000 ms"
    );
    assert!(by_karnopp < 1e-2 * largest, "{by_karnopp}");
    assert!(by_borello < 1e-4 * largest, "{by_borello}");
    assert!(by_exact < 1e-6 * largest, "{by_exact}");
}

/// A command as a function of the drive's period.
type Input = Box<dyn Fn(u32) -> f32>;

/// The commands of the paper, all in both loops; its random sequence is the core's APRTS.
fn inputs(scale: f32) -> [(&'static str, Input); 6] {
    const PERIOD: f32 = 0.016;
    let step = step::Parameters {
        initial_value: 0.0,
        final_value: scale,
        time: 0.1,
    }
    .build(PERIOD)
    .unwrap();
    let ramp = ramp::Parameters {
        initial_value: 0.0,
        final_value: scale,
        start: 0.1,
        duration: 4.0,
    }
    .build(PERIOD)
    .unwrap();
    let sine = sine::Parameters {
        offset: 0.0,
        amplitude: scale,
        frequency: 0.5,
        phase: 0.0,
    }
    .build(PERIOD)
    .unwrap();
    let sweep = sweep::Parameters {
        offset: 0.0,
        amplitude: scale,
        initial_frequency: 0.2,
        final_frequency: 2.0,
        duration: 5.0,
    }
    .build(PERIOD)
    .unwrap();
    let random = aprts::Parameters {
        lower: -scale,
        upper: scale,
        shortest_hold: 0.1,
        longest_hold: 0.5,
        seed: 3,
    }
    .build(PERIOD)
    .unwrap();
    // The campaign's external file, as a share of its largest position.
    let file = command_file::read(
        &workspace::root().join(COMMAND),
        1.0 / f64::from(PERIOD),
        5.0,
    );
    let file = file.unwrap();
    let largest = file.iter().fold(0.0_f64, |l, p| l.max(p.abs()));
    let file: Vec<f32> = file.iter().map(|p| (p / largest) as f32 * scale).collect();
    [
        ("step", Box::new(move |tick| step.at(tick))),
        ("ramp", Box::new(move |tick| ramp.at(tick))),
        ("sine", Box::new(move |tick| sine.at(tick))),
        ("sweep", Box::new(move |tick| sweep.at(tick))),
        ("random", Box::new(move |tick| random.at(tick))),
        ("file", Box::new(move |tick| file[tick as usize])),
    ]
}

fn servo(anti_windup: bool) -> Servo {
    Servo::new((300.0, 300.0), anti_windup, (0.12, 0.15))
}

#[test]
fn servo_follows_the_bench_under_every_input() {
    for scheme in SCHEMES {
        for (closed, scale) in [(true, 0.01), (false, 0.5)] {
            for (name, input) in inputs(scale) {
                let mut ema = Ema::build(&with_scheme(scheme)).unwrap();
                let mut bench = servo(true);
                let mut positions = Vec::new();
                for tick in 0..312 {
                    let value = input(tick);
                    let (command, _): (_, ServoSample) = if closed {
                        (Command::Position(value), bench.follow(value.into()))
                    } else {
                        (Command::Duty(value), bench.drive(value.into()))
                    };
                    ema.step(command).unwrap();
                    positions.push((f64::from(ema.position()), bench.position()));
                }
                let error = rms(positions.iter().map(|(ours, theirs)| ours - theirs));
                let largest = positions.iter().fold(0.0_f64, |l, (_, p)| l.max(p.abs()));
                println!("{scheme:?} closed {closed} {name}: {error:.1e} of {largest:.1e} m");
                // The loop sees an encoder's count of 2 µm; a band of velocities costs travel each
                // time that it is crossed.
                let allowed = match scheme {
                    Scheme::Karnopp { .. } => 5e-3 * largest,
                    Scheme::Borello => 4e-6,
                    Scheme::Exact => 2e-6,
                };
                assert!(error < allowed, "{scheme:?} {name}: {error}");
            }
        }
    }
}

/// The bench's response to the large step.
fn bench_response(anti_windup: bool) -> Response {
    let mut bench = servo(anti_windup);
    let rows = (SECONDS / 0.016).round() as usize;
    Response {
        time: (0..rows).map(|row| row as f64 * 0.016).collect(),
        position: (0..rows).map(|_| bench.follow(STEP_M).position).collect(),
    }
}

#[test]
fn anti_windup_overshoots_less_and_settles_sooner() {
    let ours = [AntiWindup::ConditionalIntegration, AntiWindup::None]
        .map(|anti_windup| anti_windup::response(anti_windup).unwrap());
    let bench = [true, false].map(bench_response);
    for responses in [&ours, &bench] {
        let [with, without] = responses.each_ref().map(|response| {
            println!(
                "overshoot {:.2} mm, settled after {:?} s",
                1e3 * response.overshoot(),
                response.settling_time()
            );
            (response.overshoot(), response.settling_time().unwrap())
        });
        assert!(with.0 < 0.5 * without.0);
        assert!(with.1 < 0.7 * without.1);
    }
    for (ours, bench) in ours.iter().zip(&bench) {
        // A tenth of the band within which a response is settled; a period of the drive.
        assert!((ours.overshoot() - bench.overshoot()).abs() < 0.1 * BAND * STEP_M);
        let [ours, bench] = [ours, bench].map(|response| response.settling_time().unwrap());
        assert!((ours - bench).abs() < 0.017, "{ours} {bench}");
    }
}

#[test]
fn ends_of_travel_hold_the_rod_and_the_current_limit_the_current() {
    for scheme in SCHEMES {
        let mut parameters = with_scheme(scheme);
        parameters.drive.current_limit = 12.0;
        let mut ema = Ema::build(&parameters).unwrap();
        for sign in [1.0, -1.0] {
            for _ in 0..600 {
                ema.step(Command::Duty(sign)).unwrap();
            }
            let sample = ema.step(Command::Duty(sign)).unwrap();
            assert!((ema.position() - sign * 0.1).abs() < 1e-7);
            assert_eq!(sample.speed, 0.0);
            // 24 V would drive 24 A through 1 Ω.
            assert!((sample.current - sign * 12.0).abs() < 0.01, "{sample:?}");
            assert!((sample.duty - sign * 0.5).abs() < 0.001, "{sample:?}");
        }
    }
}

#[test]
fn torque_saturates_at_its_peak() {
    for scheme in SCHEMES {
        let mut parameters = with_scheme(scheme);
        parameters.motor.peak_torque = 0.2;
        parameters.motor.viscous = 0.0;
        let mut ema = Ema::build(&parameters).unwrap();
        let mut run = |duty: f32, periods: u32| {
            for _ in 1..periods {
                ema.step(Command::Duty(duty)).unwrap();
            }
            f64::from(ema.step(Command::Duty(duty)).unwrap().speed)
        };
        // Once the current has risen: (0.2 − 0.12)/J for 16 ms.
        let second = run(0.5, 2);
        let gained = run(0.5, 1) - second;
        let expected = 0.08 / 1.2e-4 * 0.016;
        assert!((gained / expected - 1.0).abs() < 1e-3, "{gained}");
        // Far below the peak the final speed is the motor's: (k u − R F)/k², u of 13 counts.
        let last = run(0.1, 200);
        let expected = (0.06 * 24.0 * 13.0 / 127.0 - 0.12) / 3.6e-3;
        assert!((last / expected - 1.0).abs() < 1e-3, "{last}");
    }
}

#[test]
fn friction_can_be_set_in_place() {
    for scheme in SCHEMES {
        let raised = friction::Parameters {
            coulomb: 0.779,
            breakaway: 0.779,
        };
        let mut set = Ema::build(&with_scheme(scheme)).unwrap();
        set.set_friction(raised);
        let mut built = Ema::build(&Parameters {
            friction: raised,
            ..with_scheme(scheme)
        })
        .unwrap();
        for tick in 0..200 {
            let command = Command::Duty(if tick < 100 { 0.8 } else { -0.7 });
            assert_eq!(set.step(command), built.step(command));
        }
        set.reset();
        assert_eq!(set.position(), 0.0);
    }
}

#[test]
fn what_is_no_command_is_refused_and_leaves_the_servo_alone() {
    let mut ema = Ema::build(&Parameters::ALI_2).unwrap();
    ema.step(Command::Position(0.01)).unwrap();
    let before = ema.clone();
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert!(ema.step(Command::Position(value)).is_err());
        assert!(ema.step(Command::Duty(value)).is_err());
        assert_eq!(ema, before);
    }
}

/// A name, and what makes the parameter of that name wrong.
type Case = (&'static str, fn(&mut Parameters));

#[test]
fn parameters_out_of_range_are_refused_by_name() {
    let cases: [Case; 12] = [
        ("drive period", |p| p.drive.period = 0.0),
        ("full command", |p| p.drive.full_command = 0),
        ("supply", |p| p.drive.supply = f32::NAN),
        ("current limit", |p| p.drive.current_limit = -1.0),
        ("gear ratio", |p| p.gearbox.ratio = 0.0),
        ("lead", |p| p.ball_screw.lead = f32::INFINITY),
        ("mass", |p| p.ball_screw.mass = -1.0),
        ("lower end", |p| p.ball_screw.lower_end = 0.01),
        ("upper end", |p| p.ball_screw.upper_end = f32::NAN),
        ("counts per turn", |p| p.encoder.counts_per_turn = 0),
        ("controller output", |p| p.controller.output_maximum = 1.5),
        ("steps", |p| p.steps = 0),
    ];
    for (name, spoil) in cases {
        let mut parameters = Parameters::ALI_2;
        spoil(&mut parameters);
        let Err(BuildError::Settings(error)) = Ema::build(&parameters) else {
            panic!("{name} is taken");
        };
        assert_eq!(error.name, name);
    }
    let cases: [Case; 4] = [
        ("resistance", |p| p.motor.resistance = 0.0),
        ("torque limit", |p| p.motor.peak_torque = 0.0),
        ("coulomb", |p| p.friction.coulomb = -0.1),
        ("band", |p| p.scheme = Scheme::Karnopp { band: 0.0 }),
    ];
    for (name, spoil) in cases {
        let mut parameters = with_scheme(Scheme::Borello);
        spoil(&mut parameters);
        let Err(BuildError::Plant(error)) = Ema::build(&parameters) else {
            panic!("{name} is taken");
        };
        assert_eq!(error.parameter, name);
    }
}
