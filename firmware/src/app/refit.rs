//! The friction estimated anew from the onboard log, as an early warning of wear.

use model_core::gap::log::Log;
use model_core::identify::friction::{Estimate, Refit, Refusal, Task};
use model_core::numeric::invalid_parameter::InvalidParameter;

use super::machine::Machine;

/// One seed, so that a log has one estimate.
const SEED: u64 = 1;

/// Why there is no estimate: the machine keeps the friction that it has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "tasks", derive(defmt::Format))]
pub enum Failed {
    /// The machine's numbers are out of range.
    Machine(InvalidParameter),
    /// The log does not give one.
    Log(Refusal),
}

impl core::fmt::Display for Failed {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Machine(invalid) => invalid.fmt(formatter),
            Self::Log(refusal) => refusal.fmt(formatter),
        }
    }
}

impl From<InvalidParameter> for Failed {
    fn from(error: InvalidParameter) -> Self {
        Self::Machine(error)
    }
}

/// Estimates the Coulomb friction from a log, starting at the machine's own.
///
/// # Errors
/// A machine or a log that gives no estimate.
pub fn refit(machine: &Machine, log: Log) -> Result<Estimate, Failed> {
    let refit = Refit::new(&Task {
        declared: machine.plant,
        log,
        resolution: machine.converters.position.unit(),
        present: machine.plant.coulomb.forward,
        seed: SEED,
    })?;
    refit.run().map_err(Failed::Log)
}
