//! The models beside references that share no code with them, and the figures of the papers.

mod ema;
mod pwa;
mod reference_traces;
mod reproduce_bench;
mod reproduce_prognostics;
mod reproduce_throttle;
mod throttle;
