//! Any bytes to the console.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| fuzz::console_on_host::exercise(bytes));
