//! Any bytes as a machine file.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| fuzz::exercise::machine(bytes));
