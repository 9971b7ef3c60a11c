//! Tracing the gap between a measured log and the model to the physical effect that causes it.
//!
//! Data flows down this list once:
//!
//! * [`criterion`]: the numbers that all of the others decide by;
//! * [`log`]: the measured log, and the smoothed state that a replay restarts from;
//! * [`model`]: the declared actuator with its effects;
//! * [`simulator`]: a model bound for one step period, with what it holds over a step ([`held`]);
//! * [`scope`]: the sizes and ranges that a log says are sensible;
//! * [`ensemble`]: the model with its perturbed copies, which share what they have in common;
//! * [`replay`]: windows of the log simulated with the measured input, in lockstep with copies whose
//!   parameters are perturbed, into the sums of a least-squares problem;
//! * [`fit`]: Levenberg–Marquardt on these sums, and [`covariance`] of what it finds;
//! * [`screen`]: score, identifiability and equivalence of the candidates, base projected out;
//! * [`held_out`]: errors on data that a fit has not seen, and whether a model is better there;
//! * [`span`]: when an effect acts that comes and goes;
//! * [`workbench`]: data, schedule and declared model, as the steps below use them;
//! * [`judging`]: whether a model is better with an effect;
//! * [`found`]: what has been found so far;
//! * [`round`]: one round of screening, refitting and judging ([`refit`]), with what an effect could be else ([`alternatives`]) and
//!   the numbers that are freed instead ([`numbers`]);
//! * [`standing`]: whether what was found may be said;
//! * [`select`]: the rounds, and where none finds anything a [`pair`], to the [`verdict`];
//! * [`unknown`]: which variable carries what no effect of the catalogue explains;
//! * [`lengths`]: what of it is found over predictions of another length too: what is said.
//!
//! Choices that a reader may look for in vain:
//!
//! * No portmanteau test stops the search. Windows that restart from a smoothed state are never
//!   white, so that it would always say *go on*; whether something is missing is decided on held-out
//!   blocks, and an error far beyond the sensor's is never called complete.
//! * Each fit starts from what the declared values come to in short windows too, not only from the fit
//!   before, and keeps the better. A model that lacks something sticks where the machine slides, its base
//!   is biased by that, and no fit comes back. A least-squares start on accelerations would need derivatives
//!   that a coarse encoder does not give.
//! * The signed-rank test, and the t-test beside it where blocks are few, ask whether more than one percent
//!   of the error is gained, not whether anything is: restarts and rounding leave something to every
//!   candidate, and a test for that finds it in one clean log of ten.
//! * Reported p-values are those of these tests; the limit that they must pass is shared among the
//!   candidates of a round and the shapes tried for each, not among rounds.

pub mod alternatives;
pub mod covariance;
pub mod criterion;
pub mod current_sensor;
pub mod ensemble;
pub mod fit;
pub mod found;
pub mod held;
pub mod held_out;
pub mod judging;
pub mod lateness;
pub mod lengths;
pub mod log;
pub mod mechanism;
pub mod model;
pub mod numbers;
pub mod pair;
pub mod refit;
pub mod replay;
pub mod round;
pub mod scope;
pub mod screen;
pub mod select;
pub mod simulator;
pub mod span;
pub mod standing;
pub mod unknown;
pub mod verdict;
pub mod workbench;
