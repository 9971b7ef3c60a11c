//! Tracing the gap between a measured log and the model to the physical effect that causes it.
//!
//! Data flows down this list once:
//!
//! * [`log`]: the measured log, and the smoothed state that a replay restarts from;
//! * [`model`]: the declared actuator with its effects, bound into a simulator;
//! * [`replay`]: windows of the log simulated with the measured input, in lockstep with copies whose
//!   parameters are perturbed, into the sums of a least-squares problem;
//! * [`fit`]: Levenberg–Marquardt on these sums;
//! * [`screen`]: score, identifiability and equivalence of the candidates, base projected out;
//! * [`select`]: refits the best on one half of the log and judges on the other; the verdict.

pub mod fit;
pub mod log;
pub mod model;
pub mod replay;
pub mod screen;
pub mod select;
