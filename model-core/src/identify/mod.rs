//! Search for the parameters that fit a cost.
//!
//! A search never calls the cost: it proposes a candidate and waits for the report, so that an
//! embedded task can simulate, sleep or serve others in between.

pub mod annealing;
pub mod characteristic;
pub mod friction;
pub mod golden_section;
pub mod line;
pub mod polished;
pub mod position_error;
