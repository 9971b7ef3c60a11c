//! The refit and the check: long work, done below everything else.
//!
//! The log goes along with the job and comes back with its result, so nothing is locked; meanwhile
//! nothing is recorded for the next one.

use core::fmt;

use model_core::identify::friction::Estimate;

use crate::app::check::{self, BASE, Finding};
use crate::app::machine::Machine;
use crate::app::memory::Memory;
use crate::app::refit;

/// What is asked of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Question {
    /// What its friction is.
    Refit,
    /// What the machine lacks.
    Check,
}

/// Work to be done.
#[derive(Debug)]
pub struct Job {
    /// What is asked.
    pub question: Question,
    /// The machine as it is believed to be.
    pub machine: Machine,
    /// The log.
    pub memory: &'static mut Memory,
}

/// Work that is done.
#[derive(Debug)]
pub struct Done {
    /// The log.
    pub memory: &'static mut Memory,
    /// What came of it.
    pub answer: Answer,
}

/// What came of a log.
#[expect(clippy::large_enum_variant, reason = "there is no allocation")]
#[derive(Debug, Clone, PartialEq)]
pub enum Answer {
    /// The friction, or why there is none.
    Refit(Result<Estimate, refit::Failed>),
    /// What the machine lacks, or why that is not known.
    Check(Result<Finding, check::Failed>),
}

impl Job {
    /// Does it.
    pub fn run(self) -> Done {
        let log = self.memory.log(&self.machine.converters);
        let answer = match self.question {
            Question::Refit => Answer::Refit(refit::refit(&self.machine, log)),
            Question::Check => Answer::Check(check::check(&self.machine, log)),
        };
        Done {
            memory: self.memory,
            answer,
        }
    }
}

impl fmt::Display for Answer {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refit(Ok(estimate)) => write!(
                formatter,
                "refit: coulomb {:?} N·m, static {:?} N·m; cost {:e}, before {:e}",
                estimate.coulomb, estimate.breakaway, estimate.cost, estimate.present_cost
            ),
            Self::Refit(Err(failed)) => write!(formatter, "no refit: {failed}"),
            Self::Check(Ok(finding)) => finding.fmt(formatter),
            Self::Check(Err(failed)) => write!(formatter, "no check: {failed}"),
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            formatter,
            "check: {}; position error {:e} rad rms, with what was found {:e}",
            self.verdict.name(),
            self.before,
            self.after
        )?;
        for found in &self.effects {
            let description = found.effect.id.description();
            write!(formatter, "\n{}:", description.id)?;
            for ((name, _), value) in found.effect.reported().iter().zip(found.reported) {
                write!(formatter, " {name} {value:?}")?;
            }
        }
        if let Some(variable) = self.unknown {
            write!(formatter, "\nunknown, depends on {variable}")?;
        }
        for (parameter, fitted) in &self.fitted {
            let declared = if BASE.contains(parameter) {
                ""
            } else {
                ", declared wrong"
            };
            write!(
                formatter,
                "\nfitted {} {fitted:?}{declared}",
                parameter.name()
            )?;
        }
        Ok(())
    }
}
