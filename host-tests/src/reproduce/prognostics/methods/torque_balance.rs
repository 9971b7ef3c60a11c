//! Recursive least squares on the torque balance, and the breakaway level read off the current.
//!
//! k i − J α − B ω = F sgn ω while the machine slides, with velocity ω and acceleration α from
//! differences of the measured position. No simulation, one pass over the log: what the paper
//! compares annealing with.

use model_core::plant::parameters::Parameters;

use super::super::stand::{RESOLUTION, Recorded, SAMPLE_RATE};
use super::super::statistics::quantile;

/// Samples on either side that velocity and acceleration are taken over: 16 ms for the latter.
const HALF_WIDTH: usize = 8;

/// Speed from which the machine slides for certain, rad/s.
const SLIDING: f64 = 2.0;

/// Samples in a row that make a rest.
const REST: usize = 20;

/// Counts of the position that rest may show: noise tips the sensor over by one.
const QUIET: f64 = 1.5;

/// Coulomb and breakaway level, N·m. Either is `None` where the machine never slid, or never broke
/// away.
pub fn estimate(model: &Parameters, log: &Recorded) -> (Option<f64>, Option<f64>) {
    let torque =
        |sample: usize| f64::from(model.torque_per_current()) * f64::from(log.current[sample]);
    let position = |sample: usize| f64::from(log.position[sample]);
    (
        coulomb(model, log.position.len(), position, torque),
        breakaway(log.position.len(), position, torque),
    )
}

fn coulomb(
    model: &Parameters,
    samples: usize,
    position: impl Fn(usize) -> f64,
    torque: impl Fn(usize) -> f64,
) -> Option<f64> {
    let width = HALF_WIDTH as f64 / SAMPLE_RATE;
    // The estimate and its variance, of a start that is not known.
    let (mut level, mut variance) = (0.0, 1e6);
    let mut slid = false;
    for sample in HALF_WIDTH..samples.saturating_sub(HALF_WIDTH) {
        let (before, now, after) = (
            position(sample - HALF_WIDTH),
            position(sample),
            position(sample + HALF_WIDTH),
        );
        let velocity = (after - before) / (2.0 * width);
        if velocity.abs() < SLIDING {
            continue;
        }
        slid = true;
        let acceleration = (after - 2.0 * now + before) / (width * width);
        let friction = torque(sample)
            - f64::from(model.inertia) * acceleration
            - f64::from(model.viscous.forward) * velocity;
        let direction = velocity.signum();
        let gain = variance * direction / (1.0 + variance);
        level += gain * (friction - direction * level);
        variance -= gain * direction * variance;
    }
    slid.then_some(level)
}

/// The torque in the last sample before the position leaves a rest, the median of all.
fn breakaway(
    samples: usize,
    position: impl Fn(usize) -> f64,
    torque: impl Fn(usize) -> f64,
) -> Option<f64> {
    let (mut at, mut still) = (position(0), 0);
    let mut seen = Vec::new();
    for sample in 1..samples {
        if (position(sample) - at).abs() <= QUIET * RESOLUTION {
            still += 1;
        } else {
            if still >= REST {
                seen.push(torque(sample - 1).abs());
            }
            at = position(sample);
            still = 0;
        }
    }
    (!seen.is_empty()).then(|| quantile(&seen, 0.5))
}
