//! Piecewise affine models from logs, as the throttle paper makes them (its section PWA modeling,
//! eqs. 21 and 22), to be evaluated by [`model_core::plant::piecewise_affine`].
//!
//! The way, a file each: [`series`] the logs at the model's sample time, [`reading`] what the
//! regressor is and in which space it is partitioned, [`k_means`] the clusters and so the partition,
//! [`series_parallel`] least squares in each, [`parallel`] the free-run error minimised by
//! Levenberg-Marquardt, [`borders`] the partition moved to the same end, [`search`] the whole with its
//! ten starts for every number of clusters, [`table`] what came of each, [`file`] the model as text.
//!
//! # How the paper is read
//!
//! It clusters in y(k−1) − y(k−2) and u(k−1), and leaves y(k−1) out "because location-dependent
//! effects were not observed". What else it predicts from is not said. Measured on the rig's intake
//! throttle ([`Reading`] explains each; `cargo test --release --test pwa -- --ignored --nocapture`
//! prints the table, errors in free run, validation logs unseen):
//!
//! TABLE
//!
//! A model without y(k−1) knows no place: it integrates, and nothing tells it where the spring
//! balances the motor. With y(k−1) in the sub-models it rests in the right places, and with the spring
//! in the partition too, "held by friction" becomes a polyhedron: the band of inputs that hold the
//! plate moves along with it. Clusters alone put borders midway between heaps of samples and not where
//! friction lets go; moved borders do. What is left is the gear's cogging, which lets the plate stop in
//! one notch or the next, and for which ten polyhedra are too few.

mod borders;
mod file;
mod k_means;
mod levenberg_marquardt;
mod model;
mod parallel;
mod penalty;
mod reading;
mod run;
mod search;
mod sensitivity;
mod series;
mod series_parallel;
mod table;

pub use file::{read, write};
pub use reading::Reading;
pub use run::positions;
pub use search::{Candidate, Identified, Options, identify};
