//! One harmonic over the position, which several effects add to what they act on, and its overtones.

use super::{Active, Bounds, MOST_PARAMETERS, Parameter, Role, padded};
use crate::numeric::sine::ripple;
use crate::unit::Dimension;
use core::f32::consts::TAU;

/// Far below any sensor's count, rad or m: it keeps the phase finite.
const LEAST_PERIOD: f32 = 1e-9;

/// Beyond so many cycles a phase has long lost its meaning; it stays a number.
const MOST_CYCLES: f32 = 1e30;

/// Share of the fundamental that each number of its overtones starts from in a fit; 0 would leave it out.
const START: f32 = 0.05;

/// Harmonics above the first: the second and the third.
const OVERTONES: usize = 2;

/// An effect that may have overtones as a fit with them starts; `None` if it may have none, or has some.
///
/// ```
/// use model_core::effect::{Active, Id, harmonic::with_overtones};
/// let cogging = Active::new(Id::Cogging, [0.2, 0.0, 0.6]);
/// let started = with_overtones(&cogging).unwrap();
/// assert!(started.values[3] > 0.0 && started.values[5] > 0.0);
/// assert!(with_overtones(&started).is_none());
/// assert!(with_overtones(&Active::new(Id::Spring, [0.5, 0.1])).is_none());
/// ```
pub fn with_overtones(effect: &Active) -> Option<Active> {
    let overtones = effect.overtones();
    if overtones.is_empty() || overtones.iter().any(|&value| value != 0.0) {
        return None;
    }
    let end = effect.id.description().parameters.len();
    let [sine, cosine, ..] = effect.values;
    let mut started = *effect;
    started.values[end - overtones.len()..end].fill(START * libm::hypotf(sine, cosine));
    Some(started)
}

/// Σ aₙ sin(2π n θ / P) + bₙ cos(2π n θ / P), n from 1 to 3.
///
/// ```
/// use model_core::effect::harmonic::Harmonic;
/// // 0.02 at a quarter of the period of 2 rad, and as much less half a period further on.
/// let harmonic = Harmonic::new([0.02, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0]);
/// assert!((harmonic.at(0.5) - 0.02).abs() < 1e-6);
/// assert!((harmonic.at(1.5) + 0.02).abs() < 1e-6);
/// // A second harmonic of 0.01 has its own quarter of a period at 0.25 rad, a third of 0.005 at 1/6 rad.
/// let second = Harmonic::new([0.0, 0.0, 2.0, 0.01, 0.0, 0.0, 0.0]);
/// assert!((second.at(0.25) - 0.01).abs() < 1e-6);
/// let third = Harmonic::new([0.0, 0.0, 2.0, 0.0, 0.0, 0.005, 0.0]);
/// assert!((third.at(1.0 / 6.0) - 0.005).abs() < 1e-6);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Harmonic {
    sine: f32,
    cosine: f32,
    wavenumber: f32,
    overtones: [[f32; 2]; OVERTONES],
}

impl Harmonic {
    /// The parameters of an effect that is one with overtones, whose strengths have this dimension.
    pub(super) const fn parameters_with_overtones(strength: Dimension) -> [Parameter; 7] {
        let [sine, cosine, period] = Self::parameters(strength);
        [
            sine,
            cosine,
            period,
            Self::overtone("sine_2", strength),
            Self::overtone("cosine_2", strength),
            Self::overtone("sine_3", strength),
            Self::overtone("cosine_3", strength),
        ]
    }

    const fn overtone(name: &'static str, strength: Dimension) -> Parameter {
        Parameter {
            name,
            dimension: strength,
            role: Role::Overtone,
            bounds: Bounds::Any,
        }
    }

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

    /// What is reported of such an effect with overtones: the amplitudes of these too.
    pub(super) const fn reported_with_overtones(
        strength: Dimension,
    ) -> [(&'static str, Dimension); 5] {
        let [amplitude, phase, period] = Self::reported(strength);
        let second = ("second_harmonic", strength);
        [
            amplitude,
            phase,
            period,
            second,
            ("third_harmonic", strength),
        ]
    }

    /// From the two components of the first harmonic, the period, and the components of the second and the third.
    pub fn new([sine, cosine, period, overtones @ ..]: [f32; MOST_PARAMETERS]) -> Self {
        let [sine_2, cosine_2, sine_3, cosine_3] = overtones;
        Self {
            sine,
            cosine,
            wavenumber: 1.0 / period.max(LEAST_PERIOD),
            overtones: [[sine_2, cosine_2], [sine_3, cosine_3]],
        }
    }

    /// The same with a slope of no more than `most`. For one without overtones.
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
        let mut value = ripple(self.sine, cycles) + ripple(self.cosine, cycles + 0.25);
        for (order, [sine, cosine]) in (2_u8..).zip(self.overtones) {
            let cycles = f32::from(order) * cycles;
            value += ripple(sine, cycles) + ripple(cosine, cycles + 0.25);
        }
        value
    }

    /// Its slope over the position. For one without overtones.
    pub fn slope(&self, position: f32) -> f32 {
        let cycles = self.cycles(position);
        let slope = ripple(self.sine, cycles + 0.25) - ripple(self.cosine, cycles);
        TAU * self.wavenumber * slope
    }

    /// Amplitude, phase and period, and the amplitudes of the overtones.
    pub(super) fn report(&self) -> [f32; MOST_PARAMETERS] {
        let [second, third] = self
            .overtones
            .map(|[sine, cosine]| libm::hypotf(sine, cosine));
        padded([
            libm::hypotf(self.sine, self.cosine),
            libm::atan2f(self.cosine, self.sine),
            1.0 / self.wavenumber,
            second,
            third,
        ])
    }
}
