//! One harmonic over the position, which several effects add to what they act on.

use super::{Active, Bounds, MOST_PARAMETERS, Parameter, Role};
use crate::numeric::sine::ripple;
use crate::unit::Dimension;
use core::f32::consts::TAU;

/// Far below any sensor's count, rad or m: it keeps the phase finite.
const LEAST_PERIOD: f32 = 1e-9;

/// Beyond so many cycles a phase has long lost its meaning; it stays a number.
const MOST_CYCLES: f32 = 1e30;

/// Share of the fundamental that its overtones start from in a fit: not none, for the period of nothing has no slope.
const OVERTONE: f32 = 0.05;

/// Where a fit of the second and the third harmonic of an effect starts, beside the first, which it has; `None` if it is
/// not a periodic torque or friction.
///
/// ```
/// use model_core::effect::{Active, Id, harmonic::overtones};
/// let cogging = Active { id: Id::Cogging, values: [0.2, 0.0, 0.6] };
/// let [second, third] = overtones(&cogging).unwrap();
/// assert!((second.values[2] - 0.3).abs() < 1e-6 && (third.values[2] - 0.2).abs() < 1e-6);
/// assert!(overtones(&Active { id: Id::Spring, values: [0.5, 0.1, 0.0] }).is_none());
/// ```
pub fn overtones(effect: &Active) -> Option<[Active; 2]> {
    let [sine, cosine, period] = effect.values;
    let overtone = |order: f32| Active {
        id: effect.id,
        values: [OVERTONE * sine, OVERTONE * cosine, period / order],
    };
    effect
        .id
        .has_overtones()
        .then(|| [overtone(2.0), overtone(3.0)])
}

/// a sin(2π θ / P) + b cos(2π θ / P).
///
/// ```
/// use model_core::effect::harmonic::Harmonic;
/// // 0.02 at a quarter of the period of 2 rad, and as much less half a period further on.
/// let harmonic = Harmonic::new([0.02, 0.0, 2.0]);
/// assert!((harmonic.at(0.5) - 0.02).abs() < 1e-6);
/// assert!((harmonic.at(1.5) + 0.02).abs() < 1e-6);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Harmonic {
    sine: f32,
    cosine: f32,
    wavenumber: f32,
}

impl Harmonic {
    /// The parameters of an effect that is one, whose strengths have this dimension.
    pub(super) const fn parameters(strength: Dimension) -> [Parameter; 3] {
        [
            Parameter {
                name: "sine",
                dimension: strength,
                role: Role::Strength,
                bounds: Bounds::Any,
            },
            Parameter {
                name: "cosine",
                dimension: strength,
                role: Role::Strength,
                bounds: Bounds::Any,
            },
            Parameter {
                name: "period",
                dimension: Dimension::Position,
                role: Role::Shape,
                bounds: Bounds::Positive,
            },
        ]
    }

    /// What is reported of such an effect.
    pub(super) const fn reported(strength: Dimension) -> [(&'static str, Dimension); 3] {
        [
            ("amplitude", strength),
            ("phase", Dimension::Phase),
            ("period", Dimension::Position),
        ]
    }

    /// From the two components and the period.
    pub fn new([sine, cosine, period]: [f32; MOST_PARAMETERS]) -> Self {
        Self {
            sine,
            cosine,
            wavenumber: 1.0 / period.max(LEAST_PERIOD),
        }
    }

    /// The same with a slope of no more than `most`.
    pub fn with_slope_within(self, most: f32) -> Self {
        let slope = TAU * self.wavenumber * libm::hypotf(self.sine, self.cosine);
        let share = if slope > most { most / slope } else { 1.0 };
        Self {
            sine: share * self.sine,
            cosine: share * self.cosine,
            ..self
        }
    }

    /// Whether it is zero everywhere.
    #[inline(always)]
    pub fn is_nothing(&self) -> bool {
        self.sine == 0.0 && self.cosine == 0.0
    }

    #[inline(always)]
    fn cycles(&self, position: f32) -> f32 {
        (position * self.wavenumber).clamp(-MOST_CYCLES, MOST_CYCLES)
    }

    /// Its value at a position.
    #[inline(always)]
    pub fn at(&self, position: f32) -> f32 {
        let cycles = self.cycles(position);
        ripple(self.sine, cycles) + ripple(self.cosine, cycles + 0.25)
    }

    /// Its slope over the position.
    pub fn slope(&self, position: f32) -> f32 {
        let cycles = self.cycles(position);
        let slope = ripple(self.sine, cycles + 0.25) - ripple(self.cosine, cycles);
        TAU * self.wavenumber * slope
    }

    /// Amplitude, phase and period.
    pub(super) fn report(&self) -> [f32; MOST_PARAMETERS] {
        [
            libm::hypotf(self.sine, self.cosine),
            libm::atan2f(self.cosine, self.sine),
            1.0 / self.wavenumber,
        ]
    }
}
