//! `thermal_drift`: the winding's resistance rises as it heats.
//!
//! ```text
//! dx/dt = r i² (1 + x) − x / τ,  R = R₀ (1 + x)
//! ```
//!
//! x is the share by which the resistance has risen: the temperature coefficient (0.39 % a kelvin for
//! copper) times the winding's temperature over that of the log's first sample. r is how fast the loss
//! i² R₀ of one ampere raises it, the coefficient times R₀ over the heat capacity; τ is the thermal time
//! constant of the winding. Source: the first-order thermal model of motor protection (IEC 60255-149).
//!
//! A measured state has no temperature. So each replay first carries it along the log from its
//! beginning: under the measured current, or, where none was measured, under the winding's steady
//! current of input and speed. A simulated current would do as well, but each window would then have to
//! wait for the one before it. From the restart on the simulated current heats the winding. A log starts
//! cold: what the machine was warmer than its declared resistance is the fit's to find.
//!
//! Told from a wrong resistance by its growth over the log, and from a friction that drifts by the
//! current: a resistance does not change what torque the motion takes. τ is told by a log that lasts as
//! long; a shorter one tells r alone.

use super::{Bounds, Chain, Description, Effect, MOST_PARAMETERS, Middle, Parameter, Role, Scope, Summary, padded};
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Beyond this rise no winding lives; it keeps a wild guess finite.
const MOST_WARMTH: f32 = 10.0;

/// Rate and time constant of the rise.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ThermalDrift {
    rate: f32,
    inverse_time: f32,
}

impl ThermalDrift {
    /// The rise after so many seconds under a current. Of first order in their ratio to the time
    /// constant, and stable at any.
    ///
    /// ```
    /// use model_core::effect::{Effect, thermal_drift::ThermalDrift, padded};
    /// // 1 % a second under 1 A, lost again within 5 s.
    /// let effect = ThermalDrift::new(padded([0.01, 5.0]));
    /// let mut warmth = 0.0;
    /// for _ in 0..100_000 {
    ///     warmth = effect.after(warmth, 2.0, 1e-3);
    /// }
    /// // Steady: r i² (1 + x) = x / τ.
    /// assert!((0.04 * (1.0 + warmth) - warmth / 5.0).abs() < 1e-5);
    /// ```
    #[inline(always)]
    pub fn after(&self, warmth: f32, current: f32, seconds: f32) -> f32 {
        let heating = self.rate * current * current * (1.0 + warmth);
        let rise = seconds * (heating - warmth * self.inverse_time);
        (warmth + rise / (1.0 + seconds * self.inverse_time)).min(MOST_WARMTH)
    }

    /// The same to second order, for steps that are no small part of the time constant: two steps of half the time, by
    /// as much more as they differ from one (L. F. Richardson 1911).
    #[inline]
    pub fn long_after(&self, warmth: f32, current: f32, seconds: f32) -> f32 {
        let half = 0.5 * seconds;
        let twice = self.after(self.after(warmth, current, half), current, half);
        let once = self.after(warmth, current, seconds);
        (2.0 * twice - once).clamp(0.0, MOST_WARMTH)
    }

    /// Thermal time constant of the winding, s.
    #[inline]
    pub fn time_constant(&self) -> f32 {
        1.0 / self.inverse_time
    }
}

impl Effect for ThermalDrift {
    const DESCRIPTION: Description = Description {
        id: "thermal_drift",
        summary: Summary::Same("the winding's resistance rises as it heats"),
        source: "IEC 60255-149",
        parameters: &[
            Parameter {
                name: "rate",
                dimension: Dimension::PerSquaredCurrentTime,
                role: Role::Strength,
                bounds: Bounds::NotNegative,
            },
            Parameter {
                name: "time_constant",
                dimension: Dimension::Time,
                role: Role::Shape,
                bounds: Bounds::Positive,
            },
        ],
        reported: &[
            ("rate", Dimension::PerSquaredCurrentTime),
            ("time_constant", Dimension::Time),
        ],
        rotary_only: false,
    };
    const ELECTRIC: bool = true;
    const NEEDS_WINDING: bool = true;

    fn new([rate, time_constant, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self {
            rate,
            inverse_time: 1.0 / time_constant.max(f32::MIN_POSITIVE),
        }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        0.01 / (scope.current * scope.current)
    }

    fn shape(_scope: &Scope, index: usize) -> Option<f32> {
        const SECONDS: [f32; 4] = [1.5, 5.0, 15.0, 50.0];
        SECONDS.get(index).copied()
    }

    fn bind(&self, _plant: &mut Parameters, chain: &mut Chain) {
        chain.heats = true;
    }

    #[inline(always)]
    fn voltage(&self, middle: &Middle) -> f32 {
        -middle.warmth * middle.resistance * middle.current()
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        padded([self.rate, self.time_constant()])
    }
}
