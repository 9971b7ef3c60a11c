//! Between SI values and the counts of a converter: what quantises the sensors and the bridge.

/// A linear converter of up to 16 bits: a value is its counts times a unit.
///
/// ```
/// use firmware::app::conversion::Converter;
///
/// let encoder = Converter::new(0.001, 4000);
/// assert_eq!(encoder.counts(0.5004), Some(500));
/// assert_eq!(encoder.value(500), 0.5);
/// assert_eq!(encoder.value(70_000), 70.0);
/// assert_eq!(encoder.counts(-77.0), Some(-4000));
/// assert_eq!(encoder.counts(f32::NAN), None);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Converter {
    unit: f32,
    inverse: f32,
    most: i16,
}

impl Converter {
    /// A converter whose count is worth `unit`, above 0, and which saturates at `most` counts,
    /// 0 or more, either way.
    pub const fn new(unit: f32, most: i16) -> Self {
        Self {
            unit,
            inverse: 1.0 / unit,
            most,
        }
    }

    /// The same with another unit, above 0.
    #[must_use]
    pub const fn with_unit(self, unit: f32) -> Self {
        Self::new(unit, self.most)
    }

    /// The same, saturating at other counts, 0 or more.
    #[must_use]
    pub const fn saturating_at(self, most: i16) -> Self {
        Self { most, ..self }
    }

    /// What one count is worth.
    pub const fn unit(&self) -> f32 {
        self.unit
    }

    /// The nearest count, saturated; none for a value that is not finite.
    pub fn counts(&self, value: f32) -> Option<i16> {
        if !value.is_finite() {
            return None;
        }
        let counts = value * self.inverse;
        // The cast cuts the fraction off and saturates.
        let nearest = (counts + 0.5f32.copysign(counts)) as i32;
        let most = i32::from(self.most);
        Some(nearest.max(-most).min(most) as i16)
    }

    /// The value of a count, beyond saturation too: exactly the product, so that a log of counts and a log of values are
    /// the same log.
    pub fn value(&self, counts: impl Into<i32>) -> f32 {
        // Exact up to 2²⁴ counts, a thousand turns of a fine encoder.
        counts.into() as f32 * self.unit
    }
}

/// The converters of one actuator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Converters {
    /// Position sensor, rad.
    pub position: Converter,
    /// Current sensor, A.
    pub current: Converter,
    /// Duty of the bridge, V.
    pub bridge: Converter,
}
