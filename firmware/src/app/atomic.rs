//! The atomic words of what interrupts share, by one name: a test that tries every order in which they may run has others
//! in their place.

pub use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
