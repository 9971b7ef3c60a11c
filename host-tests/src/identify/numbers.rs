//! The six numbers.

use model_core::identify::characteristic::{Estimate, Ratios};
use serde::Serialize;

/// A number with its 95 % confidence interval, value ± half width.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Number {
    /// The number.
    pub value: f64,
    /// Half of the interval's width; infinite (null in JSON) where none is claimed.
    pub half_width: f64,
}

impl From<Estimate> for Number {
    fn from(estimate: Estimate) -> Self {
        Self {
            value: estimate.value,
            half_width: estimate.half_width(),
        }
    }
}

/// The six numbers of eq. 7, five of them over b₀; positive (see
/// [`model_core::identify::characteristic`]).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Numbers {
    /// a₀/b₀, V/rad or V/m.
    pub a0: Number,
    /// a₁/b₀, V·s/rad or V·s/m.
    pub a1: Number,
    /// c₀/b₀, V.
    pub c0: Number,
    /// c₁/b₀, V.
    pub c1: Number,
    /// c_H/b₀, V.
    pub ch: Number,
    /// b₀, rad/(V·s²) or m/(V·s²).
    pub b0: Number,
}

impl Numbers {
    /// The ratios, and a b₀ without an interval.
    pub(super) fn of(ratios: &Ratios, b0: f64) -> Self {
        Self {
            a0: ratios.a0.into(),
            a1: ratios.a1.into(),
            c0: ratios.c0.into(),
            c1: ratios.c1.into(),
            ch: ratios.ch.into(),
            b0: Number {
                value: b0,
                half_width: f64::INFINITY,
            },
        }
    }

    /// From values and half widths in the order of [`Numbers::values`].
    pub(super) fn new(values: [f64; 6], half_widths: [f64; 6]) -> Self {
        let number = |index: usize| Number {
            value: values[index],
            half_width: half_widths[index],
        };
        Self {
            a0: number(0),
            a1: number(1),
            c0: number(2),
            c1: number(3),
            ch: number(4),
            b0: number(5),
        }
    }

    /// All six in the order a₀/b₀, a₁/b₀, c₀/b₀, c₁/b₀, c_H/b₀, b₀.
    pub fn all(&self) -> [Number; 6] {
        [self.a0, self.a1, self.c0, self.c1, self.ch, self.b0]
    }

    /// The values alone, in the same order.
    pub fn values(&self) -> [f64; 6] {
        self.all().map(|number| number.value)
    }
}
