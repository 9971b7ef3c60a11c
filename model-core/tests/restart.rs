//! What a replay starts from in the middle of a log, against the closed form of a winding that drives a free
//! inertia. Its torque constant is so small that the back-EMF is nothing, so that current, velocity and angle are
//! polynomials and one exponential.

use model_core::gap::log::{Channel, Log};
use model_core::gap::model::Model;
use model_core::gap::replay::{Row, Runner, Settings, WindowStart};
use model_core::plant::parameters::{Drive, Parameters};

const PERIOD: f32 = 1e-3;
const RESISTANCE: f64 = 1.0;
/// H: twenty periods of time constant.
const INDUCTANCE: f64 = 20e-3;
const TORQUE_CONSTANT: f64 = 1e-3;
const INERTIA: f64 = 1e-3;
const VOLTAGE: f64 = 5.0;

/// s: when the voltage is applied, and how long the log lasts.
const APPLIED: f64 = 0.1;
const SAMPLES: u16 = 300;

const TIME_CONSTANT: f64 = INDUCTANCE / RESISTANCE;
const STEADY_CURRENT: f64 = VOLTAGE / RESISTANCE;
const ACCELERATION: f64 = TORQUE_CONSTANT * STEADY_CURRENT / INERTIA;

/// Seconds since the voltage is there.
fn since(sample: u16) -> f64 {
    (f64::from(sample) * f64::from(PERIOD) - APPLIED).max(0.0)
}

fn current(sample: u16) -> f64 {
    STEADY_CURRENT * -(-since(sample) / TIME_CONSTANT).exp_m1()
}

fn position(sample: u16) -> f64 {
    let (time, constant) = (since(sample), TIME_CONSTANT);
    let lag = constant * (time + constant * (-time / constant).exp_m1());
    ACCELERATION * (0.5 * time * time - lag)
}

/// How far the angle of a replay is off after so many samples if its current begins this far off.
fn displaced(error: f64, samples: u16) -> f64 {
    let (time, constant) = (f64::from(samples) * f64::from(PERIOD), TIME_CONSTANT);
    let away = constant * (time + constant * (-time / constant).exp_m1());
    TORQUE_CONSTANT * error / INERTIA * away
}

/// Angle at the end of a replay of so many samples, model less log.
fn replayed(noise: Option<f64>, start: u16, samples: u16) -> f64 {
    let mut plant = Parameters::free(INERTIA as f32);
    plant.drive = Drive::Voltage {
        resistance: RESISTANCE as f32,
        inductance: INDUCTANCE as f32,
        torque_constant: TORQUE_CONSTANT as f32,
    };
    let model = Model::new(plant);
    let simulator = model.build(PERIOD).unwrap();
    let input: Vec<f32> = (0..SAMPLES)
        .map(|sample| {
            if f64::from(sample) * f64::from(PERIOD) >= APPLIED - 1e-9 {
                VOLTAGE as f32
            } else {
                0.0
            }
        })
        .collect();
    let positions: Vec<f32> = (0..SAMPLES).map(|sample| position(sample) as f32).collect();
    let currents: Option<Vec<f32>> = noise.map(|noise| {
        let one = |sample: u16| {
            let sign = if sample.is_multiple_of(2) { 1.0 } else { -1.0 };
            (current(sample) + sign * noise) as f32
        };
        (0..SAMPLES).map(one).collect()
    });
    let log = Log {
        current: currents.as_deref().map(Channel::Values),
        ..Log::new(PERIOD, Channel::Values(&input), Channel::Values(&positions))
    };
    let settings = Settings::new(PERIOD, 0.0);
    let mut runner = Runner::new(&simulator, &log, usize::from(start), &settings);
    let samples = usize::from(start)..usize::from(start + samples);
    let ends = samples.map(|index| runner.advance(&Row::new(&log, index)).0);
    ends.last().map(f64::from).unwrap()
}

/// One time constant after the step a steady current would be 37 % too large.
#[test]
fn a_current_that_was_not_measured_is_followed_up_to_the_restart() {
    for late in [10, 20, 40] {
        let start = (APPLIED / f64::from(PERIOD)) as u16 + late;
        let error = replayed(None, start, 100);
        let steady = displaced(STEADY_CURRENT - current(start), 100);
        assert!(
            error.abs() < 0.05 * steady,
            "{late}: {error:e} of {steady:e} rad"
        );
    }
}

/// From one sample alone the whole noise would stay in the current for a time constant.
#[test]
fn the_noise_of_a_measured_current_is_averaged_over_the_winding() {
    let noise = 0.5;
    for late in [60, 61, 100, 101] {
        let start = (APPLIED / f64::from(PERIOD)) as u16 + late;
        let error = replayed(Some(noise), start, 80);
        let single = displaced(noise, 80);
        assert!(
            error.abs() < 0.2 * single,
            "{late}: {error:e} of {single:e} rad"
        );
    }
}

/// A motor whose speed follows its voltage with a time constant of half a sample: behind a step of the voltage no
/// slope over samples is its velocity.
#[test]
fn a_velocity_that_the_model_comes_to_is_that_of_a_fast_motor() {
    const BACK_EMF: f64 = 0.05;
    const FASTER_INERTIA: f64 = 1.25e-6;
    let constant = FASTER_INERTIA * RESISTANCE / (BACK_EMF * BACK_EMF);
    let speed = VOLTAGE / BACK_EMF;
    let step = (APPLIED / f64::from(PERIOD)) as u16;
    // From one steady speed to the other.
    let position = |sample: u16| {
        let time = (f64::from(sample) - f64::from(step)) * f64::from(PERIOD);
        if time <= 0.0 {
            speed * time
        } else {
            -speed * time + 2.0 * speed * constant * -(-time / constant).exp_m1()
        }
    };
    let mut plant = Parameters::free(FASTER_INERTIA as f32);
    plant.drive = Drive::Voltage {
        resistance: RESISTANCE as f32,
        inductance: 0.0,
        torque_constant: BACK_EMF as f32,
    };
    let model = Model::new(plant);
    let simulator = model.build(PERIOD).unwrap();
    let voltage = |sample| if sample < step { VOLTAGE } else { -VOLTAGE };
    let input: Vec<f32> = (0..SAMPLES).map(|sample| voltage(sample) as f32).collect();
    let positions: Vec<f32> = (0..SAMPLES).map(|sample| position(sample) as f32).collect();
    let log = Log::new(PERIOD, Channel::Values(&input), Channel::Values(&positions));
    for late in [0, 1, 2] {
        let start = usize::from(step + late);
        let [slope, simulated] = [WindowStart::Slope, WindowStart::Simulated].map(|window_start| {
            let settings = Settings {
                window_start,
                half_width: 4,
                ..Settings::new(PERIOD, 0.0)
            };
            let mut runner = Runner::new(&simulator, &log, start, &settings);
            let ends = (start..start + 50).map(|index| runner.advance(&Row::new(&log, index)).0);
            ends.last().map_or(f32::NAN, f32::abs)
        });
        assert!(
            simulated < 0.02 * slope,
            "{late}: {simulated:e} of {slope:e} rad"
        );
    }
}

/// A fast log of a coarse sensor: 33 samples are 1.65 ms, in which the motor moves by a few counts. What a slope over them is off by is
/// rounding; the model's own course over 16 ms leaves a tenth of it.
#[test]
fn a_fast_log_does_not_round_the_velocity() {
    const FAST: f64 = 5e-5;
    const BACK_EMF: f64 = 0.05;
    const COUNT: f64 = 1e-3;
    let inertia = 1.25e-4;
    let constant = inertia * RESISTANCE / (BACK_EMF * BACK_EMF);
    let speed = 0.1 * VOLTAGE / BACK_EMF;
    let position = |sample: u16| {
        let time = f64::from(sample) * FAST;
        speed * (time + constant * (-time / constant).exp_m1())
    };
    let mut plant = Parameters::free(inertia as f32);
    plant.drive = Drive::Voltage {
        resistance: RESISTANCE as f32,
        inductance: 0.0,
        torque_constant: BACK_EMF as f32,
    };
    let simulator = Model::new(plant).build(FAST as f32).unwrap();
    let samples = 4000;
    let input = vec![(0.1 * VOLTAGE) as f32; usize::from(samples)];
    let counted = |sample: u16| (COUNT * (position(sample) / COUNT).round()) as f32;
    let positions: Vec<f32> = (0..samples).map(counted).collect();
    let log = Log::new(
        FAST as f32,
        Channel::Values(&input),
        Channel::Values(&positions),
    );
    let rms = [WindowStart::Slope, WindowStart::Simulated].map(|window_start| {
        let settings = Settings {
            window_start,
            half_width: 16,
            ..Settings::new(FAST as f32, COUNT as f32)
        };
        let starts = (1000..samples).step_by(101);
        let squares = starts.map(|start| {
            let runner = Runner::new(&simulator, &log, usize::from(start), &settings);
            let time = f64::from(start) * FAST;
            let velocity = speed * -(-time / constant).exp_m1();
            (f64::from(runner.drive_velocity()) - velocity).powi(2)
        });
        let squares: Vec<f64> = squares.collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    });
    assert!(rms[1] < 0.1 * rms[0], "{rms:?} rad/s");
}

/// The current at a restart is what the model comes to from a measured one: its noise has gone with the winding's time
/// constant, and the velocity that it left is seen in the positions.
#[test]
fn the_noise_of_a_measured_current_is_forgotten_on_the_way_to_a_restart() {
    const RUN_IN: usize = 16;
    const WINDOW: usize = 80;
    // The run-in lasts n = 8 time constants of the winding. A straight line fitted to the course takes away all but 6/n², less
    // than a tenth, of the velocity that a wrong current leaves.
    let constant = 2.0 * f64::from(PERIOD);
    let mut plant = Parameters::free(INERTIA as f32);
    plant.drive = Drive::Voltage {
        resistance: RESISTANCE as f32,
        inductance: (RESISTANCE * constant) as f32,
        torque_constant: TORQUE_CONSTANT as f32,
    };
    let simulator = Model::new(plant).build(PERIOD).unwrap();
    let input = [VOLTAGE as f32; SAMPLES as usize];
    // It accelerates with a steady current, that is measured with a noise that no short average removes.
    let position =
        |sample: u16| 0.5 * ACCELERATION * (f64::from(sample) * f64::from(PERIOD)).powi(2);
    let positions: Vec<f32> = (0..SAMPLES).map(|sample| position(sample) as f32).collect();
    let noise = |sample: u16| {
        if (sample / 40).is_multiple_of(2) {
            0.5
        } else {
            -0.5
        }
    };
    let currents: Vec<f32> = (0..SAMPLES)
        .map(|sample| (STEADY_CURRENT + noise(sample)) as f32)
        .collect();
    let log = Log {
        current: Some(Channel::Values(&currents)),
        ..Log::new(PERIOD, Channel::Values(&input), Channel::Values(&positions))
    };
    for start in [90, 130, 170] {
        let settings = Settings {
            window_start: WindowStart::Simulated,
            half_width: RUN_IN,
            ..Settings::new(PERIOD, 0.0)
        };
        let mut runner = Runner::new(&simulator, &log, start, &settings);
        let ends = (start..start + WINDOW).map(|index| runner.advance(&Row::new(&log, index)).0);
        let away = f64::from(ends.last().unwrap()).abs();
        // A wrong start of the current goes on for a time constant, and leaves a velocity.
        let duration = WINDOW as f64 * f64::from(PERIOD);
        let displaced = TORQUE_CONSTANT * 0.5 / INERTIA * constant * (duration - constant);
        assert!(
            away < 0.1 * displaced,
            "{start}: {away:e} of {displaced:e} rad"
        );
    }
}
