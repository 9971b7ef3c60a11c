//! The prognostics paper's servo on the host.

pub mod anti_windup;
