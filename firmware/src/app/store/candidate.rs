//! Values that a refit proposes, and why they may not be taken over.

use core::fmt;

use heapless::Vec;
use model_core::identify::friction::Estimate;

use super::StoreError;
use super::field::{FIELDS, Field, OutOfBounds, Values};

/// New values for some fields, and what they are better at.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Fields and their new values, SI.
    pub changes: Vec<(Field, f32), FIELDS>,
    /// Cost of the values in use, on the log that the new ones are from.
    pub present_cost: f64,
    /// Cost of the new ones, on the same log.
    pub cost: f64,
}

/// The friction, estimated anew.
impl From<&Estimate> for Candidate {
    fn from(estimate: &Estimate) -> Self {
        Self {
            changes: Vec::from_iter([
                (Field::Coulomb, estimate.coulomb),
                (Field::Static, estimate.breakaway),
            ]),
            present_cost: estimate.present_cost.into(),
            cost: estimate.cost.into(),
        }
    }
}

impl Candidate {
    /// The values in use with the new ones in their places.
    ///
    /// # Errors
    /// A cost that did not go down or is not finite, or a value outside its bounds.
    pub fn applied_to(&self, present: &Values) -> Result<Values, Rejected> {
        // Not for NaN.
        if !(self.cost < self.present_cost && self.present_cost.is_finite()) {
            return Err(Rejected::Cost {
                present: self.present_cost,
                new: self.cost,
            });
        }
        let mut values = *present;
        for (field, value) in &self.changes {
            values.set(*field, *value).map_err(Rejected::Bounds)?;
        }
        Ok(values)
    }
}

/// Why the values in use stay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rejected {
    /// The new ones are no better.
    Cost {
        /// Of the values in use.
        present: f64,
        /// Of the new ones.
        new: f64,
    },
    /// One of the new ones cannot be meant.
    Bounds(OutOfBounds),
    /// They could not be stored.
    Store(StoreError),
}

impl fmt::Display for Rejected {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cost { present, new } => write!(
                formatter,
                "the cost must go down from {present:e}, not to {new:e}"
            ),
            Self::Bounds(out) => out.fmt(formatter),
            Self::Store(error) => error.fmt(formatter),
        }
    }
}

impl core::error::Error for Rejected {}
