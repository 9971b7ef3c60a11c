//! What physics lets a parameter of an effect be.

use core::fmt;

/// The values that a parameter may have, in the unit of its dimension.
///
/// ```
/// use model_core::effect::Bounds;
/// let share = Bounds::Share;
/// assert!(share.contains(0.0) && share.contains(0.99) && !share.contains(1.0));
/// assert_eq!(share.to_string(), "0 or more and below 1");
/// assert_eq!((Bounds::UpTo(0.25).lower(), Bounds::UpTo(0.25).upper()), (0.0, 0.25));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bounds {
    /// Any number: what it adds has a direction.
    Any,
    /// 0 or more.
    NotNegative,
    /// More than 0: what is divided by it.
    Positive,
    /// 0 to this.
    UpTo(f32),
    /// 0 or more and below 1: a part that leaves something.
    Share,
}

impl Bounds {
    /// The smallest value, −∞ where there is none.
    pub const fn lower(self) -> f32 {
        match self {
            Self::Any => f32::NEG_INFINITY,
            Self::NotNegative | Self::UpTo(_) | Self::Share => 0.0,
            Self::Positive => f32::MIN_POSITIVE,
        }
    }

    /// The largest value, ∞ where there is none.
    pub const fn upper(self) -> f32 {
        match self {
            Self::Any | Self::NotNegative | Self::Positive => f32::INFINITY,
            Self::UpTo(most) => most,
            // The largest number below 1.
            Self::Share => 1.0 - 0.5 * f32::EPSILON,
        }
    }

    /// Whether they let either sign be.
    pub const fn are_signed(self) -> bool {
        matches!(self, Self::Any)
    }

    /// Whether a parameter may have this value.
    pub fn contains(self, value: f32) -> bool {
        value.is_finite() && (self.lower()..=self.upper()).contains(&value)
    }
}

impl fmt::Display for Bounds {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Any => formatter.write_str("any number"),
            Self::NotNegative => formatter.write_str("0 or more"),
            Self::Positive => formatter.write_str("more than 0"),
            Self::UpTo(most) => write!(formatter, "0 to {most}"),
            Self::Share => formatter.write_str("0 or more and below 1"),
        }
    }
}
