//! The test stand: a rig in double precision plays the measured throttle, which is not public.
//!
//! The throttle has what neither model knows: cogging of its gear, bristles that yield before they
//! slide (LuGre), friction that differs by direction. Its potentiometer is noisy and read by a 12-bit
//! converter, its motor by a shunt. The strengths are half of the rig's nominal ones: in full the
//! cogging alone moves the plate's rest against the weak return spring by 8°, and no model without
//! it could keep the paper's 5°; the paper's throttle showed no effect of the place.

use std::path::Path;

use model_core::numeric::invalid_parameter::InvalidParameter;
use model_core::signal::{aprts, growing_triangle};
use rig::{Effect, EffectKind, Experiment, Machine, Noise};

use crate::failure::Failure;
use crate::log::Log;
use crate::outputs::write_own;

/// Rows a second.
pub const SAMPLE_RATE: f64 = 1000.0;

/// What the throttle has beyond its machine file.
const EFFECTS: [EffectKind; 3] = [
    EffectKind::Cogging,
    EffectKind::Presliding,
    EffectKind::AsymmetricCoulomb,
];

/// Their share of the rig's nominal strengths.
const SHARE: f64 = 0.5;

/// Static friction, N·m, a twelfth above Coulomb friction's 0.24. A breakaway that only one of throttle
/// and model has moves the plate by (static − Coulomb)/spring: 4.6°, and 9° with the 0.28 of the
/// machine file. The paper's throttle cannot have had more than the former, for no error exceeds 4.93°.
const STATIC_FRICTION: f64 = 0.26;

/// Noise of potentiometer and shunt: two thirds of a count of the 12-bit converter, and 20 mA.
const NOISE: Noise = Noise {
    position: 3.2e-4,
    current: 0.02,
};

/// The triangles: around the input that holds the spring in the middle of the stroke, from those that
/// just overcome friction up to those that reach both ends, slowly enough that inertia does not show.
const SLOW: growing_triangle::Parameters = growing_triangle::Parameters {
    offset: -3.15,
    amplitude: 2.4,
    first: 14,
    last: 24,
    duration: 60.0,
};

/// Levels a fifth beyond those that reach both ends, held long enough for the plate to arrive at some of
/// them.
const fn steps(seed: u64) -> aprts::Parameters {
    aprts::Parameters {
        lower: -6.0,
        upper: -0.25,
        shortest_hold: 0.1,
        longest_hold: 0.6,
        seed,
    }
}

/// Length of a log of steps, s.
const STEPS_LAST: f32 = 40.0;

/// The logs of the stand.
#[derive(Debug, Clone)]
pub struct Logs {
    /// Slow triangles.
    pub slow: Log,
    /// Steps to identify on.
    pub fast: Log,
    /// Steps that nothing is fitted to.
    pub validate: Log,
}

/// The throttle, without what it has beyond the declared physics.
pub fn throttle() -> Machine {
    Machine {
        static_friction: STATIC_FRICTION,
        ..Machine::intake_throttle()
    }
}

/// What it has beyond that.
pub fn effects() -> Vec<Effect> {
    EFFECTS
        .iter()
        .map(|&kind| Effect::nominal(kind, &throttle()).scaled(SHARE))
        .collect()
}

/// The six numbers of the rig in the order of [`crate::identify::Numbers::all`], as far as its
/// machine file says them: its friction also depends on direction, place and speed.
pub fn numbers() -> [f64; 6] {
    let machine = throttle();
    let rig::Motor::Winding {
        resistance,
        torque_constant,
        ..
    } = machine.motor
    else {
        unreachable!("a throttle has a winding");
    };
    let torque_per_volt = torque_constant / resistance;
    let spring = machine.spring.unwrap_or(rig::ReturnSpring {
        stiffness: 0.0,
        rest: 0.0,
        preload: 0.0,
    });
    [
        spring.stiffness / torque_per_volt,
        machine.viscous / torque_per_volt + torque_constant,
        spring.preload / torque_per_volt,
        machine.coulomb / torque_per_volt,
        machine.static_friction / torque_per_volt,
        torque_per_volt / machine.inertia,
    ]
}

/// Records the three logs with noise that follows from `seed`, into CSV files in a directory.
///
/// # Errors
/// A file that cannot be written.
pub fn record(directory: &Path, seed: u64) -> Result<Logs, Failure> {
    let period = 1.0 / SAMPLE_RATE as f32;
    let rows = (STEPS_LAST * SAMPLE_RATE as f32) as u32;
    let input = || -> Result<[Vec<f64>; 3], InvalidParameter> {
        let slow = SLOW.build(period)?;
        let slow_rows = (SLOW.duration * SAMPLE_RATE as f32) as u32;
        let [fast, validate] = [steps(seed), steps(seed + 1)].map(|steps| steps.build(period));
        let (fast, validate) = (fast?, validate?);
        let series = |rows: u32, at: &dyn Fn(u32) -> f32| {
            (0..rows).map(|tick| f64::from(at(tick))).collect()
        };
        Ok([
            series(slow_rows, &|tick| slow.at(tick)),
            series(rows, &|tick| fast.at(tick)),
            series(rows, &|tick| validate.at(tick)),
        ])
    };
    let [slow, fast, validate] = input().map_err(|error| Failure::other(error.to_string()))?;
    let recorded = |name: &str, input: Vec<f64>, seed: u64| -> Result<Log, Failure> {
        let recording = Experiment::replaying(throttle(), input, SAMPLE_RATE)
            .with_effects(&effects())
            .with_noise(NOISE)
            .seeded(seed)
            .run();
        let path = directory.join(name).with_extension("csv");
        write_own(&path, recording.to_csv())?;
        Ok(Log::read(&path)?)
    };
    Ok(Logs {
        slow: recorded("slow", slow, 3 * seed)?,
        fast: recorded("fast", fast, 3 * seed + 1)?,
        validate: recorded("validate", validate, 3 * seed + 2)?,
    })
}
