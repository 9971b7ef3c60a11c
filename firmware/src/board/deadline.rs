//! Whether an interrupt that is due once a period came in time.

/// Compares the times of successive ticks on a free-running counter.
///
/// A tick that lies half a period late has been held up by more than any critical section may
/// take, and the next one is in danger.
#[derive(Debug, Clone)]
pub struct Deadline {
    longest: u32,
    last: Option<u32>,
}

impl Deadline {
    /// For a period in counts, less than half of what the counter holds.
    pub const fn new(period: u32) -> Self {
        Self {
            longest: period + period / 2,
            last: None,
        }
    }

    /// Takes the time of a tick. True if it is more than one and a half periods after the one
    /// before; the first tick is never late.
    pub fn missed(&mut self, now: u32) -> bool {
        self.last
            .replace(now)
            .is_some_and(|last| now.wrapping_sub(last) > self.longest)
    }
}
