//! Any bytes as a CSV log.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| fuzz::exercise::log(bytes));
