//! Piecewise affine models from logs, as the throttle paper makes them (its section PWA modeling,
//! eqs. 21 and 22), to be evaluated by [`model_core::plant::piecewise_affine`].
//!
//! The way, a file each: `series` the logs at the model's sample time, `reading` what the regressor is
//! and in which space it is partitioned, `k_means` the clusters and so the partition, `series_parallel`
//! least squares in each, `parallel` the free-run error minimised by `levenberg_marquardt`, with the
//! derivatives of `sensitivity` and the `penalty` of large errors; `borders` the partition moved to the
//! same end, `search` the whole with its ten starts for every number of clusters; [`figure`] the partition
//! as a drawing, `file` the model as text.
//!
//! # How the paper is read
//!
//! It clusters in y(k−1) − y(k−2) and u(k−1), and leaves y(k−1) out "because location-dependent
//! effects were not observed". What else it predicts from is not said. [`Reading`] explains each way to
//! read it. Measured on the logs of the throttle's reproduction, NRMSE and largest error in free run, by
//! `cargo test --release --test models readings -- --nocapture`:
//!
//! | reading | borders | cells | identification | validation |
//! |---|---|---|---|---|
//! | `output` | k-means | 2 | 1.494, 90.0° | 1.449, 90.0° |
//! | `output` | moved | 2 | 1.494, 90.0° | 1.449, 90.0° |
//! | `growth` | k-means | 2 | 0.620, 34.6° | 0.597, 42.4° |
//! | `growth` | moved | 6 | 0.634, 36.3° | 0.759, 41.6° |
//! | `velocity` | k-means | 8 | 0.093, 10.1° | 0.140, 10.5° |
//! | `velocity` | moved | 8 | 0.027, 2.3° | 0.051, 5.6° |
//! | `position` | k-means | 8 | 0.125, 11.8° | 0.159, 12.6° |
//! | `position` | moved | 8 | 0.081, 8.3° | 0.130, 13.6° |
//! | `balance` | k-means | 9 | 0.029, 2.8° | 0.046, 4.2° |
//! | `balance` | moved | 10 | 0.019, 1.9° | 0.038, 3.0° |
//!
//! A model without y(k−1) knows no place: it integrates, and nothing tells it where the spring
//! balances the motor. With y(k−1) in the sub-models it rests in the right places, and with the spring
//! in the partition too, "held by friction" becomes a polyhedron: the band of inputs that hold the
//! plate moves along with it. Clusters alone put borders midway between heaps of samples and not where
//! friction lets go; moved borders do: with them even the paper's plane, y(k−1) in the sub-models alone,
//! comes near to the paper's errors. What is left is the gear's cogging, which lets the plate stop in one
//! notch or the next, and for which ten polyhedra are too few.

mod borders;
pub mod figure;
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

pub use file::{read, write};
pub use reading::Reading;
pub use run::positions;
pub use search::{Candidate, Identified, Options, identify};
