//! The bench paper's test bench against closed forms, its datasheets, and an integration in `f64`
//! that is written out here.

use core::f64::consts::{PI, SQRT_2, TAU};

use model_core::plant::bench::acquisition::LowPass;
use model_core::plant::bench::averaged::Averaged;
use model_core::plant::bench::back_emf::{self, Shape};
use model_core::plant::bench::control::Hold;
use model_core::plant::bench::electrics::{Electrics, Rotor};
use model_core::plant::bench::encoder::{self, Encoder};
use model_core::plant::bench::hysteresis::Relays;
use model_core::plant::bench::mechanics::Scheme;
use model_core::plant::bench::park::{Rotation, clarke, inverse_clarke};
use model_core::plant::bench::tooth_contact::{self, ToothContact};
use model_core::plant::bench::torque::sum_of_phases;
use model_core::plant::bench::{
    AveragedBench, Bench, BuildError, Parameters, Sample, SwitchingBench, brake, commissioning,
    control, datasheet, electrics, mechanics, torque,
};

/// Nominal torque constant, N·m per A rms, and coefficient of a phase, V·s/rad.
const TORQUE_CONSTANT: f64 = 1.91;
const COEFFICIENT: f64 = TORQUE_CONSTANT / (1.5 * SQRT_2);
const RATIO: f64 = 120.0;
const CONTROL_PERIOD: f64 = 125e-6;

fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values.into_iter().fold((0.0, 0.0), |(sum, count), value| {
        (sum + value * value, count + 1.0)
    });
    f64::sqrt(sum / count)
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values
        .into_iter()
        .fold(0.0, |most, value| value.abs().max(most))
}

/// 10° at 0.1 Hz of the slow shaft at a period of the control, rad.
fn sine(period: usize) -> f64 {
    10.0_f64.to_radians() * f64::sin(0.1 * TAU * period as f64 * CONTROL_PERIOD)
}

fn with_backlash(parameters: Parameters, degrees: f64) -> Parameters {
    Parameters {
        encoder: encoder::Parameters {
            backlash: degrees.to_radians() as f32,
            ..parameters.encoder
        },
        ..parameters
    }
}

fn bench<E: Electrics>(parameters: &Parameters, friction: f64) -> Bench<E> {
    let mut bench = Bench::build(parameters).unwrap();
    bench.set_brake(friction as f32);
    bench
}

fn follow<E: Electrics>(bench: &mut Bench<E>, periods: usize) -> Vec<Sample> {
    (0..periods)
        .map(|period| bench.step(sine(period) as f32).unwrap())
        .collect()
}

#[test]
fn datasheet_agrees_with_itself() {
    use datasheet::motor::{
        ELECTRICAL_TIME_CONSTANT, INDUCTANCE, INERTIA, MECHANICAL_TIME_CONSTANT, RESISTANCE,
        VOLTAGE_CONSTANT,
    };
    // Resistance and inductance are those of one phase.
    assert!((INDUCTANCE / RESISTANCE / ELECTRICAL_TIME_CONSTANT - 1.0).abs() < 0.001);
    // And the torque constant is that of rms current: 3 R J/k_T².
    let mechanical = 3.0 * RESISTANCE * INERTIA / (1.91 * 1.91);
    assert!((mechanical / MECHANICAL_TIME_CONSTANT - 1.0).abs() < 0.006);
    // A terminal voltage of 121 V rms is a phase's peak of 121 √2/√3 V: the voltage constant is
    // larger by what the magnets lose when warm.
    let cold = f64::from(VOLTAGE_CONSTANT) * f64::sqrt(2.0 / 3.0);
    let coefficient = f64::from(Parameters::AVERAGED.electrics.torque.coefficient());
    println!("coefficient {coefficient:.4}, by the voltage constant {cold:.4} V·s/rad");
    assert!((coefficient - COEFFICIENT).abs() < 1e-6);
    assert!((1.0..1.06).contains(&(cold / coefficient)));
}

#[test]
fn brake_gives_the_paper_s_torque() {
    // Rows of Table 5.1; the last digit printed is the fifth.
    for (force, printed) in [
        (43.6995, 0.067569),
        (209.0598, 0.32325),
        (453.3086, 0.70092),
    ] {
        assert!((brake::friction(force) - printed).abs() < 2e-5 * printed.max(1.0));
    }
}

#[test]
fn clarke_and_park_go_there_and_back() {
    for step in 0..100 {
        let cycles = step as f32 * 0.037 - 1.5;
        let rotation = Rotation::new(cycles);
        let [direct, quadrature] = [3.0, -1.25];
        let phases = inverse_clarke(rotation.inverse_park([direct, quadrature]));
        assert!((phases[0] + phases[1] + phases[2]).abs() < 1e-6);
        let back = rotation.park(clarke(phases));
        assert!((back[0] - direct).abs() < 1e-6 && (back[1] - quadrature).abs() < 1e-6);
        // A quadrature current of peak 1 is a sine of peak 1 in each phase.
        let phases = inverse_clarke(rotation.inverse_park([0.0, 1.0]));
        for (phase, current) in phases.into_iter().enumerate() {
            let angle = TAU * f64::from(cycles) - TAU / 3.0 * phase as f64;
            assert!((f64::from(current) + angle.sin()).abs() < 2e-6);
        }
    }
}

/// Currents of 1 A rms in quadrature, and the coefficients, over a turn of the motor.
fn turn(shapes: back_emf::Parameters) -> Vec<([f32; 3], [f32; 3])> {
    (0..3600)
        .map(|step| {
            let mechanical = step as f32 / 3600.0;
            let electrical = (4.0 * mechanical).fract();
            let rotation = Rotation::new(electrical);
            let currents = inverse_clarke(rotation.inverse_park([0.0, SQRT_2 as f32]));
            let nominal = Parameters::AVERAGED.electrics.torque.coefficient();
            let coefficients = shapes
                .coefficients(electrical, mechanical, &rotation)
                .map(|share| share * nominal);
            (currents, coefficients)
        })
        .collect()
}

fn torques(shapes: back_emf::Parameters) -> (f64, f64) {
    let torques: Vec<f64> = turn(shapes)
        .into_iter()
        .map(|(currents, coefficients)| sum_of_phases(currents, coefficients).into())
        .collect();
    let mean = torques.iter().sum::<f64>() / torques.len() as f64;
    (mean, largest(torques.iter().map(|torque| torque - mean)))
}

#[test]
fn every_shape_gives_the_torque_constant() {
    let sound = back_emf::Parameters::SOUND;
    let (mean, ripple) = torques(sound);
    assert!((mean - TORQUE_CONSTANT).abs() < 1e-5 && ripple < 1e-5);
    let (mean, ripple) = torques(back_emf::Parameters {
        shape: Shape::Trapezoidal,
        ..sound
    });
    assert!((mean - TORQUE_CONSTANT).abs() < 1e-3);
    // Largest where a phase passes its peak: there the two others have half its current and the
    // trapezoid's whole height, π²/12, too.
    let peak = 2.0 * PI * PI / 12.0 / 1.5;
    assert!(
        (ripple - (peak - 1.0) * TORQUE_CONSTANT).abs() < 1e-3,
        "{ripple}"
    );
    // The gap's offset turns with the rotor once in four cycles of the currents: its mean is zero.
    let (mean, ripple) = torques(back_emf::Parameters {
        static_eccentricity: 0.2,
        ..sound
    });
    assert!(
        (mean - TORQUE_CONSTANT).abs() < 1e-4 && ripple > 0.01,
        "{mean}"
    );
    // A tenth of a phase's turns shorted: a third of a tenth of the torque.
    let (mean, _) = torques(back_emf::Parameters {
        turns: [0.9, 1.0, 1.0],
        ..sound
    });
    assert!((mean / TORQUE_CONSTANT - (1.0 - 0.1 / 3.0)).abs() < 1e-5);
}

#[test]
fn averaged_torque_is_that_of_the_phases() {
    let shapes = back_emf::Parameters {
        shape: Shape::Trapezoidal,
        static_eccentricity: 0.15,
        turns: [1.0, 0.8, 0.95],
    };
    let parameters = electrics::Parameters {
        back_emf: shapes,
        ..Parameters::AVERAGED.electrics
    };
    let mut averaged = Averaged::build(&parameters, 25e-6).unwrap();
    for (step, (currents, coefficients)) in turn(shapes).into_iter().enumerate() {
        let mechanical = step as f32 / 3600.0;
        let rotor = Rotor {
            electrical: (4.0 * mechanical).fract(),
            mechanical,
            velocity: 0.0,
        };
        // Until the current is there.
        for _ in 0..if step == 0 { 100 } else { 1 } {
            averaged.step(1.0, &rotor);
        }
        let drive = averaged.step(1.0, &rotor);
        assert!((drive.torque - sum_of_phases(currents, coefficients)).abs() < 1e-5);
        assert!((drive.quadrature - 1.0).abs() < 1e-6 && drive.direct.abs() < 1e-6);
    }
}

#[test]
fn branches_in_star_follow_their_closed_form() {
    let windings = Parameters::AVERAGED.electrics.windings;
    let (resistance, inductance) = (2.75, 30.5e-3);
    for period in [1e-6_f32, 1e-4] {
        let star = windings.build(period).unwrap();
        let mut currents = [0.0; 3];
        for step in 1..=(0.02 / period) as u32 {
            star.step(&mut currents, [100.0, 0.0, 0.0], [10.0, 4.0, 4.0]);
            // 90 V through a phase and two in parallel, less the 4 V of those.
            let rise =
                1.0 - f64::exp(-f64::from(step) * f64::from(period) * resistance / inductance);
            let expected = 94.0 / (1.5 * resistance) * rise;
            let wanted = [expected, -0.5 * expected, -0.5 * expected];
            for (current, wanted) in currents.into_iter().zip(wanted) {
                assert!((f64::from(current) - wanted).abs() < 2e-5 * 22.8, "{step}");
            }
        }
    }
}

/// What the bus feeds in is the copper's loss, the magnetic energy and the shaft's work.
#[test]
fn energy_of_the_switched_motor_balances() {
    let electrics = Parameters::SWITCHING.electrics;
    for shapes in [
        back_emf::Parameters::SOUND,
        back_emf::Parameters {
            shape: Shape::Trapezoidal,
            static_eccentricity: 0.1,
            turns: [0.9, 1.0, 1.0],
        },
    ] {
        let period = 1e-6;
        let star = electrics.windings.build(period).unwrap();
        let mut relays = Relays::default();
        let mut currents = [0.0_f32; 3];
        let (mut fed, mut lost, mut work) = (0.0, 0.0, 0.0);
        let velocity = 100.0_f32;
        let mut switched = 0;
        let mut last = [false; 3];
        for step in 0..100_000 {
            let mechanical = (step as f32 * period * velocity) / TAU as f32;
            let electrical = (4.0 * mechanical).fract();
            let rotation = Rotation::new(electrical);
            let wanted = inverse_clarke(rotation.inverse_park([0.0, 4.0]));
            let errors = [0, 1, 2].map(|phase| wanted[phase] - currents[phase]);
            let on = relays.switch(errors, electrics.inverter.band);
            switched += usize::from(on[0] != last[0]);
            last = on;
            let terminals = electrics.inverter.terminals(on);
            let coefficients = shapes
                .coefficients(electrical, mechanical.fract(), &rotation)
                .map(|share| share * electrics.torque.coefficient());
            let before = currents;
            star.step(&mut currents, terminals, coefficients.map(|k| k * velocity));
            let mean = [0, 1, 2].map(|phase| 0.5 * (before[phase] + currents[phase]));
            let power = |a: [f32; 3], b: [f32; 3]| {
                (0..3)
                    .map(|phase| f64::from(a[phase]) * f64::from(b[phase]))
                    .sum::<f64>()
            };
            fed += power(terminals, mean) * f64::from(period);
            lost += 2.75 * power(mean, mean) * f64::from(period);
            work += f64::from(sum_of_phases(mean, coefficients) * velocity) * f64::from(period);
        }
        let stored = 0.5 * 30.5e-3 * currents.iter().map(|&i| f64::from(i).powi(2)).sum::<f64>();
        println!(
            "fed {fed:.4} J, lost {lost:.4}, stored {stored:.4}, work {work:.4}; \
             {:.1} kHz",
            switched as f64 / 2.0 / 0.1 / 1e3
        );
        assert!((lost + stored + work - fed).abs() < 1e-4 * fed);
        // The current is in its band most of the time, and its torque is the wanted one.
        assert!(work > 0.0 && switched > 100);
    }
}

/// What the current is at a constant speed: friction and viscous friction over the torque constant.
#[test]
fn quadrature_current_is_what_friction_asks_for() {
    fn steady<E: Electrics>(parameters: &Parameters, friction: f64) -> (f64, f64, f64) {
        let mut bench: Bench<E> = bench(parameters, friction);
        let mut means = [0.0; 3];
        let speed = 0.1;
        for period in 0..16_000 {
            let command = speed * period as f64 * CONTROL_PERIOD;
            let sample = bench.step(command as f32).unwrap();
            if period >= 8000 {
                means[0] += f64::from(sample.quadrature_current) / 8000.0;
                means[1] += (command - f64::from(sample.position)) / 8000.0;
                means[2] += f64::from(sample.velocity) / 8000.0;
            }
        }
        (means[0], means[1], means[2])
    }
    for friction in [0.0, 0.32325, 0.70092] {
        let expected = (0.05 + friction + 2e-3 * 12.0) / TORQUE_CONSTANT;
        let averaged = steady::<Averaged>(&Parameters::AVERAGED, friction);
        let switching = steady::<model_core::plant::bench::switching::Switching>(
            &Parameters::SWITCHING,
            friction,
        );
        println!("{friction}: {expected:.5} A, averaged {averaged:.5?}, switching {switching:.5?}");
        assert!((averaged.0 - expected).abs() < 2e-4, "{averaged:?}");
        assert!((switching.0 - expected).abs() < 2e-3, "{switching:?}");
        for (_, lag, velocity) in [averaged, switching] {
            // The position loop's lag: speed over gain; half a count of the encoder.
            assert!((lag - 0.1 / 20.0).abs() < 6e-5, "{lag}");
            assert!((velocity - 12.0).abs() < 1e-2, "{velocity}");
        }
    }
    // Beyond the paper: a share of the torque lost, a torque constant that falls.
    let expected = (0.05 + 0.70092 + 0.024) / TORQUE_CONSTANT;
    let lossy = Parameters {
        mechanics: mechanics::Parameters {
            load_share: 0.3,
            ..Parameters::AVERAGED.mechanics
        },
        ..Parameters::AVERAGED
    };
    let (current, ..) = steady::<Averaged>(&lossy, 0.70092);
    assert!((current - expected / 0.7).abs() < 3e-4, "{current}");
    let lossy = Parameters {
        mechanics: mechanics::Parameters {
            transmission_loss: 0.5,
            ..Parameters::AVERAGED.mechanics
        },
        ..Parameters::AVERAGED
    };
    let (current, ..) = steady::<Averaged>(&lossy, 0.70092);
    let passed_on = 0.5 * 0.70092 / TORQUE_CONSTANT;
    assert!((current - expected - passed_on).abs() < 3e-4, "{current}");
    let saturated = Parameters {
        electrics: electrics::Parameters {
            torque: torque::Parameters {
                saturation: 0.5,
                ..Parameters::AVERAGED.electrics.torque
            },
            ..Parameters::AVERAGED.electrics
        },
        ..Parameters::AVERAGED
    };
    let (current, ..) = steady::<Averaged>(&saturated, 0.70092);
    assert!(
        (current - expected / (1.0 - 0.5 * expected)).abs() < 3e-4,
        "{current}"
    );
}

/// The bench in `f64`: a current loop of 5 µs within the bus's voltage in the rotor's frame, one
/// inertia with dry friction, a play and a counter, in Euler steps of 1 µs.
struct Reference {
    current: [f64; 2],
    velocity: f64,
    angle: f64,
    encoder: f64,
    half_play: f64,
    friction: (f64, f64),
    integral: f64,
    derivative: f64,
    last_error: Option<f64>,
}

impl Reference {
    const INERTIA: f64 = 7.7e-4 + 0.59e-4 + 4e-6 * (62.0 / 15.0 / RATIO) * (62.0 / 15.0 / RATIO);

    fn new(backlash_degrees: f64, brake: f64) -> Self {
        Self {
            current: [0.0; 2],
            velocity: 0.0,
            angle: 0.0,
            encoder: 0.0,
            half_play: 0.5 * backlash_degrees.to_radians(),
            friction: (0.05 + brake, 0.06 + brake),
            integral: 0.0,
            derivative: 0.0,
            last_error: None,
        }
    }

    fn position(&self) -> f64 {
        let count = TAU / 40_000.0 / (62.0 / 15.0);
        (self.encoder / count).floor() * count
    }

    /// One period; the reference current, A rms.
    fn step(&mut self, command: f64) -> f64 {
        let wanted = (20.0 * RATIO * (command - self.position())).clamp(-100.0, 100.0);
        let error = wanted - self.velocity;
        let change = error - self.last_error.unwrap_or(error);
        self.last_error = Some(error);
        self.derivative = (50e-6 * self.derivative + 0.1 * 0.5e-3 * change) / (50e-6 + 125e-6);
        let torque = 0.1 * error + self.integral + self.derivative;
        let limit = TORQUE_CONSTANT * 10.7;
        let limited = torque.clamp(-limit, limit);
        self.integral += CONTROL_PERIOD * (error + (limited - torque) / 10e-3);
        let reference = limited / TORQUE_CONSTANT;
        for _ in 0..125 {
            self.advance(reference, 1e-6);
        }
        reference
    }

    fn advance(&mut self, reference: f64, step: f64) {
        self.feed(reference, step);
        self.turn(step);
    }

    /// The current's part of a step.
    fn feed(&mut self, reference: f64, step: f64) {
        let [direct, quadrature] = self.current;
        let turning = 4.0 * self.velocity * 30.5e-3;
        let voltage = [
            2.75 * direct - turning * quadrature - 30.5e-3 * direct / 5e-6,
            2.75 * quadrature
                + turning * direct
                + COEFFICIENT * self.velocity
                + 30.5e-3 * (SQRT_2 * reference - quadrature) / 5e-6,
        ];
        let limit = 380.0 * f64::sqrt(2.0 / 3.0);
        let scale = (limit / voltage[0].hypot(voltage[1])).min(1.0);
        self.current[0] +=
            (scale * voltage[0] - 2.75 * direct + turning * quadrature) / 30.5e-3 * step;
        self.current[1] += (scale * voltage[1]
            - 2.75 * quadrature
            - turning * direct
            - COEFFICIENT * self.velocity)
            / 30.5e-3
            * step;
    }

    /// The motion's part of a step.
    fn turn(&mut self, step: f64) {
        let drive = 1.5 * COEFFICIENT * self.current[1] - 2e-3 * self.velocity;
        let before = self.velocity;
        if before == 0.0 {
            let excess = drive.abs() - self.friction.1;
            if excess > 0.0 {
                let net = drive - self.friction.0 * drive.signum();
                self.velocity = net / Self::INERTIA * step;
            }
        } else {
            let net = drive - self.friction.0 * before.signum();
            self.velocity += net / Self::INERTIA * step;
            if self.velocity * before < 0.0 {
                self.velocity = 0.0;
            }
        }
        self.angle += 0.5 * (before + self.velocity) * step;
        let slow = self.angle / RATIO;
        self.encoder = self
            .encoder
            .clamp(slow - self.half_play, slow + self.half_play);
    }
}

#[test]
fn averaged_bench_follows_an_integration_in_f64() {
    for (degrees, friction) in [(0.0, 0.0), (1.97918, 0.70092)] {
        for scheme in [Scheme::Exact, Scheme::Borello] {
            let parameters = Parameters {
                mechanics: mechanics::Parameters {
                    scheme,
                    ..Parameters::AVERAGED.mechanics
                },
                ..with_backlash(Parameters::AVERAGED, degrees)
            };
            let mut ours: AveragedBench = bench(&parameters, friction);
            let mut reference = Reference::new(degrees, friction);
            let mut errors = Vec::new();
            for period in 0..48_000 {
                let truth = (reference.position(), reference.velocity);
                let current = reference.step(sine(period));
                let sample = ours.step(sine(period) as f32).unwrap();
                errors.push([
                    f64::from(sample.position) - truth.0,
                    f64::from(sample.velocity) - truth.1,
                    f64::from(sample.reference_current) - current,
                ]);
            }
            let [position, velocity, current] =
                [0, 1, 2].map(|column| rms(errors.iter().map(|row| row[column])));
            println!(
                "{degrees}°, {friction} N·m, {scheme:?}: {position:.1e} rad, {velocity:.1e} rad/s, \
                 {current:.1e} A rms"
            );
            // A count of the encoder is 38 µrad; the velocity runs to 13 rad/s, the current to
            // 0.4 A.
            assert!(position < 2e-5 && velocity < 0.05 && current < 5e-3);
        }
    }
}

/// A step of the command so far that the speed runs into its limit.
#[test]
fn speed_is_limited_as_in_f64() {
    let mut ours: AveragedBench = bench(&Parameters::AVERAGED, 0.0);
    let mut reference = Reference::new(0.0, 0.0);
    let mut errors = Vec::new();
    let mut fastest = 0.0_f64;
    for _ in 0..12_000 {
        reference.step(0.7);
        let sample = ours.step(0.7).unwrap();
        fastest = fastest.max(sample.velocity.into());
        errors.push(f64::from(ours.motor().velocity.value()) - reference.velocity);
    }
    let error = rms(errors);
    println!("{fastest:.1} rad/s; off by {error:.1e} rad/s rms");
    // It passes the limit by what the integral has to give back.
    assert!((100.0..110.0).contains(&fastest), "{fastest}");
    assert!(error < 0.02, "{error}");
    assert!((reference.position() - 0.7).abs() < 1e-3);
}

/// The current turns from one limit to the other at speed, as fast as the bus allows.
#[test]
fn voltage_is_limited_as_in_f64() {
    for velocity in [-80.0, 0.0, 80.0] {
        let mut averaged = Averaged::build(&Parameters::AVERAGED.electrics, 25e-6).unwrap();
        let mut reference = Reference::new(0.0, 0.0);
        reference.velocity = velocity;
        let rotor = Rotor {
            electrical: 0.0,
            mechanical: 0.0,
            velocity: velocity as f32,
        };
        let mut errors = Vec::new();
        let mut limited = 0;
        for step in 0..800 {
            let wanted = if step < 300 { -10.7 } else { 10.7 };
            for _ in 0..100 {
                reference.feed(wanted, 0.25e-6);
            }
            let drive = averaged.step(wanted as f32, &rotor);
            let direct = f64::from(drive.direct) - reference.current[0] / SQRT_2;
            let quadrature = f64::from(drive.quadrature) - reference.current[1] / SQRT_2;
            errors.push(direct.hypot(quadrature));
            limited += usize::from((f64::from(drive.quadrature) - wanted).abs() > 0.1);
        }
        let (error, steps) = (rms(errors.iter().copied()), errors.len());
        println!("{velocity} rad/s: {error:.3} A rms, limited in {limited} of {steps} steps");
        assert!(limited > 50, "{limited}");
        assert!(error < 0.05, "{error}");
    }
}

/// How far the averaged fidelity is from the switching one.
#[test]
fn averaged_electrics_are_near_the_switching_ones() {
    for (degrees, friction) in [
        (0.0, 0.0),
        (0.92764, 0.32325),
        (1.97918, 0.0),
        (1.97918, 0.70092),
    ] {
        let mut switching: SwitchingBench =
            bench(&with_backlash(Parameters::SWITCHING, degrees), friction);
        let mut averaged: AveragedBench =
            bench(&with_backlash(Parameters::AVERAGED, degrees), friction);
        let switched = follow(&mut switching, 80_000);
        let mean = follow(&mut averaged, 80_000);
        let distance = |value: fn(&Sample) -> f32| {
            let pairs = switched.iter().zip(&mean);
            rms(pairs.map(|(a, b)| f64::from(value(a)) - f64::from(value(b))))
        };
        let position = distance(|sample| sample.position);
        let velocity = distance(|sample| sample.velocity);
        let current = distance(|sample| sample.quadrature_current);
        println!(
            "{degrees}°, {friction} N·m: {position:.1e} rad, {velocity:.2} rad/s, \
             {:.0} mA rms",
            1e3 * current
        );
        // Of 0.35 rad, 26 rad/s; the band of the relays is ±100 mA of a phase's peak.
        assert!(position < 1.5e-4, "{position}");
        assert!(velocity < 0.35, "{velocity}");
        assert!(current < 0.02, "{current}");
    }
}

#[test]
fn cost_is_linear_in_simulated_time() {
    fn steps<E: Electrics>(parameters: &Parameters, seconds: usize) -> u64 {
        let mut bench: Bench<E> = bench(parameters, 0.3);
        follow(&mut bench, seconds * 8000);
        bench.steps_done()
    }
    for seconds in [1, 2, 4] {
        let parameters = with_backlash(Parameters::AVERAGED, 1.0);
        assert_eq!(
            steps::<Averaged>(&parameters, seconds),
            seconds as u64 * 40_000
        );
    }
    let parameters = Parameters::SWITCHING;
    let mut bench: SwitchingBench = bench(&parameters, 0.3);
    follow(&mut bench, 800);
    assert_eq!(bench.steps_done(), 100_000);
}

#[test]
fn end_stops_reset_the_velocity_and_let_go() {
    let stop = (commissioning::END_STOP * 120.0, commissioning::END_STOP);
    fn against<E: Electrics>(parameters: &Parameters, stop: (f32, f32)) {
        for sign in [1.0, -1.0] {
            let mut bench: Bench<E> = bench(parameters, 0.0);
            for _ in 0..20_000 {
                bench.step(sign * 2.0).unwrap();
            }
            assert_eq!(bench.motor().position.value(), sign * stop.0);
            assert_eq!(bench.motor().velocity.value(), 0.0);
            assert!(bench.drive().torque * sign > 1.0, "it pushes into the stop");
            for _ in 0..30_000 {
                bench.step(0.0).unwrap();
            }
            assert!(bench.encoder().position().abs() < 1e-3);
        }
    }
    against::<Averaged>(&Parameters::AVERAGED, stop);
    let coarse = Parameters {
        mechanics: Parameters::SWITCHING.mechanics,
        ..Parameters::AVERAGED
    };
    against::<Averaged>(&coarse, stop);
}

/// Against its stop the bench winds up, or does not.
#[test]
fn each_anti_windup_holds_the_integral() {
    let integral = |hold: Hold, periods: usize| {
        let parameters = Parameters {
            control: control::Parameters {
                hold,
                ..Parameters::AVERAGED.control
            },
            ..Parameters::AVERAGED
        };
        let mut bench: AveragedBench = bench(&parameters, 0.0);
        // It reaches the stop within 3 s and has stood there since.
        for _ in 0..24_000 {
            bench.step(1.6).unwrap();
        }
        let before = bench.terms().integral;
        for _ in 0..periods {
            bench.step(1.6).unwrap();
        }
        (f64::from(before), f64::from(bench.terms().integral))
    };
    let (before, after) = integral(Hold::AtStandstill, 1000);
    assert_eq!(before, after);
    let (before, after) = integral(Hold::BeyondPositionError(0.02), 1000);
    assert_eq!(before, after);
    // The third alone: the integral settles where K_i e = (v − u)/T_t.
    let (_, after) = integral(Hold::Never, 1000);
    let error = 20.0 * RATIO * (1.6 - PI / 2.0);
    let limit = TORQUE_CONSTANT * 10.7;
    let expected = limit + error * 10e-3 - 0.1 * error;
    println!("integral {after:.4}, expected {expected:.4} N·m");
    assert!((after - expected).abs() < 0.02 * expected.abs());
}

#[test]
fn encoder_counts_behind_its_play() {
    let parameters = encoder::Parameters {
        backlash: 0.02,
        ..Parameters::AVERAGED.encoder
    };
    let mut encoder = Encoder::build(&parameters, 25e-6).unwrap();
    let count = TAU / (40_000.0 * 62.0 / 15.0);
    let mut read = |angle: f32| {
        encoder.step(angle, 0.0);
        f64::from(encoder.position())
    };
    assert_eq!(read(0.009), 0.0);
    for (angle, expected) in [(0.05, 0.04), (0.031, 0.04), (0.0, 0.01), (-0.05, -0.04)] {
        let error = expected - read(angle);
        assert!((-1e-7..count + 1e-7).contains(&error), "{angle}: {error}");
    }
}

#[test]
fn stiff_teeth_are_nearly_a_play() {
    let rigid = with_backlash(Parameters::AVERAGED, 1.4);
    let (stiffness, drag) = (1000.0_f64, 0.025 * 62.0 / 15.0);
    let elastic = rigid.with_elastic_teeth(stiffness as f32, 0.5);
    let mut play: AveragedBench = bench(&rigid, 0.3);
    let mut teeth: AveragedBench = bench(&elastic, 0.3);
    let (by_play, by_teeth) = (follow(&mut play, 80_000), follow(&mut teeth, 80_000));
    // Before they push the encoder on they give by its drag over their stiffness.
    let deflection = |samples: &[Sample]| {
        largest(
            samples
                .iter()
                .map(|sample| f64::from(sample.motor_position) - f64::from(sample.position)),
        )
    };
    let more = deflection(&by_teeth) - deflection(&by_play);
    println!("{more:.2e} rad more, {:.2e} expected", drag / stiffness);
    assert!((more - drag / stiffness).abs() < 4e-5);
    let apart = by_play.iter().zip(&by_teeth);
    let apart = rms(apart.map(|(a, b)| f64::from(a.position) - f64::from(b.position)));
    assert!(apart < 4e-4, "{apart}");
}

/// Teeth from stiff to soft and creeping, in steps far above J/D, against steps of 0.2 µs in `f64`.
#[test]
fn teeth_follow_an_integration_in_f64() {
    const PARTS: u32 = 125;
    let (inertia, drag, half) = (6.8e-5, 0.1, 5e-3);
    for (stiffness, damping) in [(1000.0, 0.05), (64.0, 6.4), (7.3, 0.73), (7.3, 0.02)] {
        let parameters = tooth_contact::Parameters {
            stiffness: stiffness as f32,
            damping: damping as f32,
            inertia: inertia as f32,
            drag: drag as f32,
        };
        let mut teeth = ToothContact::build(&parameters, half as f32, 25e-6).unwrap();
        let (mut position, mut velocity) = (0.0_f64, 0.0_f64);
        let drive = |time: f64| (0.05 * (TAU * time).sin(), 0.05 * TAU * (TAU * time).cos());
        let mut errors = Vec::new();
        for step in 1..=80_000_u32 {
            for part in 1..=PARTS {
                let fine = 25e-6 / f64::from(PARTS);
                let time = f64::from(step - 1) * 25e-6 + f64::from(part) * fine;
                let (angle, speed) = drive(time);
                let lead = angle - position;
                let torque = if lead > half {
                    (stiffness * (lead - half) + damping * (speed - velocity)).max(0.0)
                } else if lead < -half {
                    (stiffness * (lead + half) + damping * (speed - velocity)).min(0.0)
                } else {
                    0.0
                };
                let free = velocity + torque / inertia * fine;
                let most = drag / inertia * fine;
                velocity = free - free.clamp(-most, most);
                position += velocity * fine;
            }
            let (angle, speed) = drive(f64::from(step) * 25e-6);
            teeth.step(angle as f32, speed as f32);
            errors.push(f64::from(teeth.angle()) - position);
        }
        let error = rms(errors);
        println!("{stiffness} N·m/rad, {damping} N·m·s/rad: {error:.1e} rad rms");
        // A count of the encoder is 3.8e-5 rad.
        assert!(error < 2e-5, "{error}");
    }
}

#[test]
fn current_filter_is_a_first_order_low_pass() {
    let mut filter = LowPass::build(100.0, 1e-6).unwrap();
    for step in 1..=5000 {
        filter.step(3.0);
        let expected = 3.0 * (1.0 - f64::exp(-TAU * 100.0 * f64::from(step) * 1e-6));
        assert!((f64::from(filter.output()) - expected).abs() < 3e-6);
    }
}

#[test]
fn what_is_no_command_is_refused_and_leaves_the_bench_alone() {
    let mut bench: AveragedBench = bench(&Parameters::AVERAGED, 0.1);
    follow(&mut bench, 100);
    let before = bench.clone();
    for command in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert!(bench.step(command).is_err());
        assert_eq!(bench, before);
    }
}

#[test]
fn parameters_out_of_range_are_refused_by_name() {
    type Case = (&'static str, fn(&mut Parameters));
    let cases: [Case; 16] = [
        ("steps", |p| p.steps = 0),
        ("gear ratio", |p| p.gearbox.ratio = 0.0),
        ("period", |p| p.control.period = f32::NAN),
        ("position gain", |p| p.control.position_gain = 0.0),
        ("speed limit", |p| p.control.speed_limit = f32::INFINITY),
        ("tracking_time", |p| p.control.tracking_time = 0.0),
        ("current limit", |p| p.control.current_limit = -1.0),
        ("position error threshold", |p| {
            p.control.hold = Hold::BeyondPositionError(f32::NAN);
        }),
        ("resistance", |p| p.electrics.windings.resistance = 0.0),
        ("inductance", |p| p.electrics.windings.inductance = f32::NAN),
        ("static eccentricity", |p| {
            p.electrics.back_emf.static_eccentricity = 1.0;
        }),
        ("turns", |p| p.electrics.back_emf.turns[1] = 1.1),
        ("saturation", |p| p.electrics.torque.saturation = -0.1),
        ("bus voltage", |p| p.electrics.inverter.bus_voltage = 0.0),
        ("backlash", |p| p.encoder.backlash = -0.1),
        ("tooth stiffness", |p| {
            *p = p.with_elastic_teeth(-1.0, 0.0);
        }),
    ];
    for (name, spoil) in cases {
        let mut parameters = Parameters::AVERAGED;
        spoil(&mut parameters);
        let Err(BuildError::Settings(error)) = AveragedBench::build(&parameters) else {
            panic!("{name} is taken");
        };
        assert_eq!(error.name, name);
    }
    let cases: [Case; 4] = [
        ("transmission_loss", |p| {
            p.mechanics.transmission_loss = -0.1;
        }),
        ("inertia", |p| p.mechanics.motor_inertia = 0.0),
        ("coulomb", |p| p.mechanics.tare.coulomb = -0.1),
        ("load_share", |p| p.mechanics.load_share = f32::NAN),
    ];
    for (name, spoil) in cases {
        let mut parameters = Parameters::AVERAGED;
        parameters.mechanics.load_inertia = 0.0;
        spoil(&mut parameters);
        let Err(BuildError::Plant(error)) = AveragedBench::build(&parameters) else {
            panic!("{name} is taken");
        };
        assert_eq!(error.parameter, name);
    }
}
