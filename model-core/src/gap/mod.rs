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
//! * [`held_out`]: errors on data that a fit has not seen, and whether a model is better there;
//! * [`workbench`]: data, schedule and declared model, as the steps below use them;
//! * [`select`]: rounds of screening, refitting and judging, to the verdict;
//! * [`unknown`]: which variable carries what no effect of the catalogue explains.

pub mod fit;
pub mod held_out;
pub mod log;
pub mod model;
pub mod replay;
pub mod screen;
pub mod select;
pub mod unknown;
pub mod workbench;
