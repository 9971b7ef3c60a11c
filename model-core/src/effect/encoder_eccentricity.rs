//! `encoder_eccentricity`: a reading error periodic in position.
//!
//! ```text
//! θ_reported = θ + a sin(2π θ / P) + b cos(2π θ / P)
//! ```
//!
//! Source: a disc that turns about a point beside its centre errs by e/r once a turn, e the distance
//! and r the radius of the track (X.-D. Lu, D. L. Trumper, *Self-calibration of on-axis rotary encoders*,
//! CIRP Annals 56, 2007). The period is scanned: a turn and its parts, and, for an encoder behind a gear,
//! in cycles a stroke.
//!
//! The machine moves at the true position: its back-EMF, springs and stops do not know the error. A
//! replay starts from the true position and velocity that belong to the measured ones. A velocity with
//! its own sensor is left as it is.
//!
//! Told from [`cogging`](super::cogging) by several speeds: a ripple of the reading is as large at any
//! speed, one of the torque moves the inertia the less the faster it passes. An error that does not come
//! once round on the stroke is a scale that is off, and nothing in the log shows that.

use super::{Chain, Description, Effect, MOST_PARAMETERS, Parameter, Role, Scope};
use crate::numeric::sine::ripple;
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;
use core::f32::consts::TAU;

/// A turn and its parts that are tried on a rotary actuator.
const TURN_TRIES: usize = 8;

/// Cycles over the stroke that the scan starts from, and the step between two tries, as for a cogging.
const FIRST_CYCLES: f32 = 1.5;
const CYCLES_STEP: f32 = 0.5;
const STROKE_TRIES: usize = 32;

/// Far below any sensor's count, rad or m: it keeps the phase finite.
const LEAST_PERIOD: f32 = 1e-9;

/// Largest slope of the error: beyond 1 a position would be reported twice.
const MOST_SLOPE: f32 = 0.5;

/// The two components and the period.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EncoderEccentricity {
    sine: f32,
    cosine: f32,
    wavenumber: f32,
}

impl EncoderEccentricity {
    /// Whether it reports what is there.
    #[inline]
    pub fn is_nothing(&self) -> bool {
        self.sine == 0.0 && self.cosine == 0.0
    }

    /// What is reported beyond a true position, rad or m.
    #[inline]
    pub fn error(&self, position: f32) -> f32 {
        let cycles = position * self.wavenumber;
        ripple(self.sine, cycles) + ripple(self.cosine, cycles + 0.25)
    }

    /// Reported velocity for a true one of 1 at a true position.
    pub fn gain(&self, position: f32) -> f32 {
        let cycles = position * self.wavenumber;
        let slope = ripple(self.sine, cycles + 0.25) - ripple(self.cosine, cycles);
        1.0 + TAU * self.wavenumber * slope
    }

    /// The true position behind a reported one.
    ///
    /// ```
    /// use model_core::effect::{Effect, encoder_eccentricity::EncoderEccentricity};
    /// let turn = core::f32::consts::TAU;
    /// let effect = EncoderEccentricity::new([0.02, 0.01, turn]);
    /// // The sine errs most a quarter turn from zero, the cosine at zero.
    /// assert!((effect.error(0.25 * turn) - 0.02).abs() < 1e-6);
    /// assert!((effect.error(0.0) - 0.01).abs() < 1e-6);
    /// // And back.
    /// let there = effect.position_behind(1.0);
    /// assert!((there + effect.error(there) - 1.0).abs() < 1e-6);
    /// ```
    pub fn position_behind(&self, reported: f32) -> f32 {
        let mut position = reported - self.error(reported);
        // Newton: each step squares an error that starts below a tenth of the ripple.
        for _ in 0..2 {
            let beyond = (position - reported) + self.error(position);
            position -= beyond / self.gain(position);
        }
        position
    }
}

impl Effect for EncoderEccentricity {
    const DESCRIPTION: Description = Description {
        id: "encoder_eccentricity",
        summary: "a reading error periodic in position",
        source: "Lu, Trumper 2007",
        parameters: &[
            Parameter {
                name: "sine",
                dimension: Dimension::Position,
                role: Role::SignedStrength,
            },
            Parameter {
                name: "cosine",
                dimension: Dimension::Position,
                role: Role::SignedStrength,
            },
            Parameter {
                name: "period",
                dimension: Dimension::Position,
                role: Role::Shape,
            },
        ],
        reported: &[
            ("amplitude", Dimension::Position),
            ("phase", Dimension::Phase),
            ("period", Dimension::Position),
        ],
        rotary_only: false,
    };
    const MISREADS: bool = true;

    fn new([sine, cosine, period]: [f32; MOST_PARAMETERS]) -> Self {
        let wavenumber = 1.0 / period.max(LEAST_PERIOD);
        let slope = TAU * wavenumber * libm::hypotf(sine, cosine);
        let share = if slope > MOST_SLOPE {
            MOST_SLOPE / slope
        } else {
            1.0
        };
        Self {
            sine: share * sine,
            cosine: share * cosine,
            wavenumber,
        }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        5e-3 * scope.stroke
    }

    fn shape(scope: &Scope, index: usize) -> Option<f32> {
        let at = |tries: usize| scope.stroke / (FIRST_CYCLES + CYCLES_STEP * tries as f32);
        if index < STROKE_TRIES {
            return Some(at(index));
        }
        if !scope.rotary {
            return None;
        }
        // The turn and its parts, where they lie outside the stroke's scan.
        (1..=TURN_TRIES)
            .map(|cycles| TAU / cycles as f32)
            .filter(|&period| period > at(0) || period < at(STROKE_TRIES - 1))
            .nth(index - STROKE_TRIES)
    }

    fn bind(&self, _plant: &mut Parameters, chain: &mut Chain) {
        chain.reading = *self;
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        [
            libm::hypotf(self.sine, self.cosine),
            libm::atan2f(self.cosine, self.sine),
            1.0 / self.wavenumber,
        ]
    }
}
