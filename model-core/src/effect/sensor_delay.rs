//! `sensor_delay`: the sensor reports late.
//!
//! ```text
//! θ_measured(t) = θ(t − τ)
//! ```
//!
//! Source: conversion, filtering and bus latencies of the position sensor; the current is measured
//! without it. A replay that starts from the measured position starts from a state of τ ago, and
//! must take the inputs of τ ago: without a measured current it equals
//! [`input_delay`](super::input_delay).

use super::{Bounds, Chain, Description, Effect, LONGEST_DELAY, MOST_PARAMETERS, Parameter, Role, Scope, delay_start, Summary, padded};
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Time by which the sensor reports late.
///
/// ```
/// use model_core::effect::{Chain, Effect, sensor_delay::SensorDelay, padded};
/// use model_core::plant::parameters::Parameters;
/// let mut chain = Chain::default();
/// SensorDelay::new(padded([2e-3])).bind(&mut Parameters::free(1e-4), &mut chain);
/// assert_eq!((chain.input_delay, chain.sensor_delay), (0.0, 2e-3));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorDelay {
    delay: f32,
}

impl Effect for SensorDelay {
    const DESCRIPTION: Description = Description {
        id: "sensor_delay",
        summary: Summary::Same("the sensor reports late"),
        source: "transport delay",
        parameters: &[Parameter {
            name: "delay",
            dimension: Dimension::Time,
            role: Role::Strength,
            bounds: Bounds::UpTo(LONGEST_DELAY),
        }],
        reported: &[("delay", Dimension::Time)],
        rotary_only: false,
    };

    const BIASES_BASE: bool = true;

    fn new([delay, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self { delay }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        scope.period
    }

    /// A delay of many samples is as likely as one of a few.
    fn reach(_scope: &Scope, _index: usize) -> f32 {
        f32::INFINITY
    }

    fn start(scope: &Scope, index: usize) -> Option<[f32; MOST_PARAMETERS]> {
        delay_start(scope, index)
    }

    fn bind(&self, _plant: &mut Parameters, chain: &mut Chain) {
        chain.sensor_delay += self.delay;
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        padded([self.delay])
    }
}
