//! The models beside references that share no code with them, and the figures of the papers.

use std::collections::BTreeMap;
use std::sync::{Mutex, OnceLock, PoisonError};

use host_tests::reproduce::throttle::stand::{self, Logs};

mod ema;
mod pwa;
mod reference_traces;
mod reproduce_bench;
mod reproduce_prognostics;
mod reproduce_throttle;
mod throttle;

/// The logs of the throttle stand with this seed, recorded once for all tests that look at them.
fn throttle_logs(seed: u64) -> &'static Logs {
    static RECORDED: Mutex<BTreeMap<u64, &OnceLock<Logs>>> = Mutex::new(BTreeMap::new());
    let mut recorded = RECORDED.lock().unwrap_or_else(PoisonError::into_inner);
    let logs: &'static OnceLock<Logs> = recorded
        .entry(seed)
        .or_insert_with(|| Box::leak(Box::default()));
    drop(recorded);
    logs.get_or_init(|| {
        let directory = tempfile::tempdir().unwrap();
        stand::record(directory.path(), seed).unwrap()
    })
}
