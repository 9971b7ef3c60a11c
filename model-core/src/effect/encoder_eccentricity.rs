//! `encoder_eccentricity`: a reading error periodic in position.
//!
//! ```text
//! θ_reported = θ + a sin(2π θ / P) + b cos(2π θ / P)
//! ```
//!
//! Source: a disc that turns about a point beside its centre errs by e/r once a turn, e the distance
//! and r the radius of the track (X.-D. Lu, D. L. Trumper, *Self-calibration of on-axis rotary
//! encoders*, CIRP Annals 56, 2007). The period is scanned in cycles a stroke, and over the disc's turn and its parts.
//! None is longer than that turn: of the coordinate, or, for an encoder on a motor whose gear is known, of the motor.
//!
//! The machine moves at the true position: its back-EMF, springs and stops do not know the error. A
//! replay starts from the true position and velocity that belong to the measured ones. A velocity with
//! its own sensor is left as it is.
//!
//! Told from [`cogging`](super::cogging) by several speeds: a ripple of the reading is as large at any
//! speed, one of the torque moves the inertia the less the faster it passes. An error that does not come
//! once round on the stroke is a scale that is off, and nothing in the log shows that.

use super::harmonic::Harmonic;
use super::{Chain, Description, Effect, MOST_PARAMETERS, Scope, Summary};
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// The disc's turn and its parts that are tried.
const TURN_TRIES: usize = 8;

/// Cycles over the stroke that the scan starts from, and the step between two tries, as for a cogging.
const FIRST_CYCLES: f32 = 1.5;
const CYCLES_STEP: f32 = 0.5;
const STROKE_TRIES: usize = 32;

/// Largest slope of the error: beyond 1 a position would be reported twice.
const MOST_SLOPE: f32 = 0.5;

/// What is reported beyond the true position.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EncoderEccentricity(Harmonic);

impl EncoderEccentricity {
    /// Whether it reports what is there.
    #[inline(always)]
    pub fn is_nothing(&self) -> bool {
        self.0.is_nothing()
    }

    /// What is reported beyond a true position, rad or m.
    #[inline(always)]
    pub fn error(&self, position: f32) -> f32 {
        self.0.at(position)
    }

    /// Reported velocity for a true one of 1 at a true position.
    pub fn gain(&self, position: f32) -> f32 {
        1.0 + self.0.slope(position)
    }

    /// The true position behind a reported one.
    ///
    /// ```
    /// use model_core::effect::{Effect, encoder_eccentricity::EncoderEccentricity, padded};
    /// let turn = core::f32::consts::TAU;
    /// let effect = EncoderEccentricity::new(padded([0.02, 0.01, turn]));
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
        summary: Summary::Same("a reading error periodic in position"),
        source: "Lu, Trumper 2007",
        parameters: &Harmonic::parameters(Dimension::Position),
        reported: &Harmonic::reported(Dimension::Position),
        rotary_only: false,
    };
    const MISREADS: bool = true;

    fn new(values: [f32; MOST_PARAMETERS]) -> Self {
        Self(Harmonic::new(values).with_slope_within(MOST_SLOPE))
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        5e-3 * scope.stroke
    }

    fn largest_shape(scope: &Scope) -> f32 {
        scope.encoder_turn
    }

    fn shape(scope: &Scope, index: usize) -> Option<f32> {
        let at = |tries: usize| scope.stroke / (FIRST_CYCLES + CYCLES_STEP * tries as f32);
        let turn = scope.encoder_turn;
        // The turn, and its parts where they lie outside the stroke's scan.
        let is_scanned = |period: f32| (at(STROKE_TRIES - 1)..=at(0)).contains(&period);
        let parts = (1..=TURN_TRIES)
            .map(|cycles| turn / cycles as f32)
            .filter(|&period| period == turn || !is_scanned(period));
        (0..STROKE_TRIES)
            .map(at)
            .filter(|&period| period <= turn)
            .chain(parts.filter(|period| period.is_finite()))
            .nth(index)
    }

    fn bind(&self, _plant: &mut Parameters, chain: &mut Chain) {
        chain.reading = *self;
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        self.0.report()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f32::consts::TAU;

    /// A disc that sits on a motor behind a gear of 10, on the coordinate, and on something along a stroke.
    #[test]
    fn no_period_is_longer_than_the_discs_turn() {
        for stroke in [0.1, 3.0, 60.0, 2000.0] {
            for turn in [TAU / 10.0, TAU, f32::INFINITY] {
                let scope = Scope {
                    friction: 0.1,
                    torque: 0.2,
                    voltage: 6.0,
                    current: 3.0,
                    speed: 10.0,
                    stroke,
                    period: 1e-3,
                    seconds: 10.0,
                    rotary: turn.is_finite(),
                    encoder_turn: turn,
                };
                let shape = |index| EncoderEccentricity::shape(&scope, index);
                let mut tried = (0..).map_while(shape);
                assert!(tried.all(|period| period <= turn && period.is_finite()));
                assert_eq!(EncoderEccentricity::largest_shape(&scope), turn);
                let mut tried = (0..).map_while(shape);
                assert!(turn.is_infinite() || tried.any(|period| period == turn));
            }
        }
    }
}
