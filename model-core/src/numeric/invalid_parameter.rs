//! The error of every `build`: which parameter, and what it has to be.

use core::fmt;

/// A parameter outside its valid range.
///
/// ```
/// use model_core::numeric::invalid_parameter::InvalidParameter;
///
/// let error = InvalidParameter { name: "period", requirement: "must be positive and finite" };
/// assert_eq!(error.to_string(), "period must be positive and finite");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct InvalidParameter {
    /// Name of the field or argument.
    pub name: &'static str,
    /// What it must be, as a phrase that follows the name.
    pub requirement: &'static str,
}

impl fmt::Display for InvalidParameter {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} {}", self.name, self.requirement)
    }
}

impl core::error::Error for InvalidParameter {}

/// Refuses the parameter `name` unless `valid` holds. Write `valid` as a condition that NaN fails.
pub(crate) fn require(
    valid: bool,
    name: &'static str,
    requirement: &'static str,
) -> Result<(), InvalidParameter> {
    if valid {
        Ok(())
    } else {
        Err(InvalidParameter { name, requirement })
    }
}

/// Refuses a value that is not a finite number above zero.
pub(crate) fn require_positive(value: f32, name: &'static str) -> Result<(), InvalidParameter> {
    require(
        value > 0.0 && value.is_finite(),
        name,
        "must be positive and finite",
    )
}

/// Refuses NaN and the infinities.
pub(crate) fn require_finite(value: f32, name: &'static str) -> Result<(), InvalidParameter> {
    require(value.is_finite(), name, "must be finite")
}
