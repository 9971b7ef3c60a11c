//! Controllers and their anti-windups.

pub mod pid;
