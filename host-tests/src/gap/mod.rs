//! `cargo hil gap`: measured log in, missing effects out, errors before and after.

pub(crate) mod answer;
mod between_logs;
pub mod catalogue;
pub mod command;
pub mod component;
pub mod declared;
pub mod demand;
pub mod disagreement;
pub mod effect_words;
pub mod engine;
mod evidence;
pub mod experiment;
pub mod headline;
mod learned_law;
mod machine_out;
pub mod metrics;
pub mod numbers;
pub mod outcome;
pub mod report;
mod series;
mod short_logs;
mod spread;
pub mod table;
pub(crate) mod terminal;
mod whiteness;
pub mod zero_phase;
