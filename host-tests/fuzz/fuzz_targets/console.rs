//! Any bytes to the console.
#![no_main]

use libfuzzer_sys::fuzz_target;

// By itself, so that nothing else of the host's is built.
#[expect(dead_code, reason = "what tests look at, a fuzzer does not")]
#[path = "../../src/console_on_host.rs"]
mod console_on_host;

fuzz_target!(|bytes: &[u8]| console_on_host::exercise(bytes));
