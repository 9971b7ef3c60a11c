//! What a replay starts from in the middle of a log, against the closed form of a winding that drives a free
//! inertia. Its torque constant is so small that the back-EMF is nothing, so that current, velocity and angle are
//! polynomials and one exponential.

use model_core::gap::log::{Channel, Log};
use model_core::gap::model::Model;
use model_core::gap::replay::{Row, Runner, Settings, Velocity};
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
        let [slope, simulated] = [Velocity::Slope, Velocity::Simulated].map(|velocity| {
            let settings = Settings {
                velocity,
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
