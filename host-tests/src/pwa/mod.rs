//! Piecewise affine models from logs: the throttle paper's second kind of model (its eqs. 21 and 22).
//!
//! Source: *On Semi-Automated Modeling of Systems with Friction for HiL-Simulation and Application to
//! Electromechanical Actuators of Passenger Car*. The regressor is clustered by k-means (`k_means`), for 2 to
//! 10 clusters from ten starts each; clusters become polyhedra, the cells of
//! [`model_core::plant::piecewise_affine`]. Least squares on measured positions gives the first
//! sub-models (`series_parallel`), Levenberg–Marquardt on free runs the next (`parallel`). The number
//! of clusters is the one with the least error in free run on data that was held out. Beyond the paper, the
//! boundaries are fitted after k-means drew them (`soft`).
//!
//! What the paper leaves open is which part of the regressor loses y(k−1), see [`reading::Reading`].
//! Measured, on the reproduction's logs: NRMSE and largest error in free run,
//!
//! | reading | boundaries | cells | identification | validation |
//! |---|---|---|---|---|
//! | `output` | k-means | 2 | 1.476, 89.9° | 1.447, 90.0° |
//! | `output` | fitted | 6 | 1.414, 89.9° | 1.390, 90.0° |
//! | `growth` | k-means | 8 | 0.804, 53.3° | 1.037, 71.5° |
//! | `growth` | fitted | 10 | 0.546, 34.0° | 0.825, 46.5° |
//! | `velocity` | k-means | 10 | 0.081, 8.8° | 0.153, 11.1° |
//! | `velocity` | fitted | 10 | 0.033, 4.8° | 0.111, 23.2° |
//! | `position` | k-means | 9 | 0.114, 13.3° | 0.170, 18.9° |
//! | `position` | fitted | 6 | 0.094, 14.2° | 0.131, 13.3° |
//! | `balance` | k-means | 9 | 0.030, 3.4° | 0.045, 4.2° |
//! | `balance` | fitted | 5 | 0.018, 1.9° | 0.030, 3.1° |
//!
//! by `cargo test --release --test pwa readings -- --nocapture`. Without y(k−1) a model does not know how
//! far the spring is wound and drifts away. With it in the sub-models alone, one boundary stands for all
//! places of the plate, and only the balance of spring and motor removes the place from the plane.

pub mod figure;
pub mod file;
pub mod identify;
mod k_means;
mod levenberg_marquardt;
mod model;
mod parallel;
pub mod reading;
pub mod run;
mod sampled;
mod sensitivity;
mod series_parallel;
mod soft;
