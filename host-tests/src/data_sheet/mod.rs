//! `cargo hil machine`: a machine file from what a data sheet says.
//!
//! `sheet` reads the options, `derive` makes the numbers of the model of them, each with where it comes
//! from and how sure it is, `agreement` refuses numbers that contradict each other, and `text` writes the
//! file.
//!
//! # Through the gear
//! Everything is referred to the coordinate `q`, the angle or stroke behind gear and screw. With `n` turns of
//! the motor for one of the coordinate (along a stroke: radians for a metre)
//!
//! ```text
//! k_q = n k      J_q = n² J      b_q = n² b
//! ```
//!
//! so that voltage, current and power are the same on both sides. What a gear of the efficiency η loses is no
//! part of the torque constant, for the back-EMF does not know of it: it is the effect
//! `load_dependent_friction` with the share 1 − η of the motor's torque. Then both lines of a data sheet
//! hold, with the no-load point (I₀, ω₀) and the stall point (I_s = V/R, τ_s):
//!
//! ```text
//! V = R I + k_q ω                k_q = (V − R I₀) / ω₀
//! τ = η k_q I − c − b ω          c + b ω₀ = η k_q I₀,    τ_s = η k_q I_s − c
//! ```
//!
//! This is the line of speed over torque, drawn to standstill, as makers extrapolate it. That loss stands in the file as a
//! comment, and is left for `cargo hil gap` to find: no fit changes what is declared, and beside a wrong loss it finds
//! other numbers wrong.

mod agreement;
pub mod command;
mod derive;
mod friction;
mod measure;
mod rules;
mod sheet;
mod text;

pub(crate) use self::text::{UNSURE, WITHIN};
